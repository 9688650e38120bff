"""Messages from what every robot reports: odometry, sonar, bumpers, battery, ports, wheels.

Everything that does not change is built once. Stamps are the wall clock of this computer when the last byte of the
packet came.
"""

from collections.abc import Iterable, Mapping
from math import cos, inf, nan, pi, sin

import numpy as np

from bus.keys import frame
from bus.messages import (
    BatteryState,
    Bumpers,
    InputsOutputs,
    JointState,
    Odometry,
    Point,
    PointCloud2,
    PointField,
    Pose,
    PoseWithCovariance,
    Range,
    RangeArray,
    TFMessage,
    TwistWithCovariance,
    header,
    placed,
    quaternion,
    twist,
)
from gateway.events import SipReceived
from p2os import Encoders, IoReport, RobotModel, StandardSip
from p2os.packets import TICK_RING
from p2os.sip import NO_ECHO, ChargeState

SONAR_RANGE = 0.1, NO_ECHO
"""m; what the discs of these robots measure at the usual firing period of 40 ms. Source: fact sheet section 8."""
SONAR_CONE = pi / 12
"""rad; opening of the cone, assumed."""
FIXED_VARIANCE = 1e-9
"""Of what a robot in the plane cannot do."""
LINEAR_VARIANCE = 1e-4
ANGULAR_VARIANCE = 1e-3
"""(m/s)² and (rad/s)²: about the resolution of wheel speeds, assumed."""
CHARGING, DISCHARGING, FULL = (
    BatteryState.POWER_SUPPLY_STATUS_CHARGING,
    BatteryState.POWER_SUPPLY_STATUS_DISCHARGING,
    BatteryState.POWER_SUPPLY_STATUS_FULL,
)
CHARGE_STATES: Mapping[int, int] = {
    ChargeState.NOT_CHARGING: DISCHARGING,
    ChargeState.BULK: CHARGING,
    ChargeState.OVERCHARGE: CHARGING,
    ChargeState.FLOAT: FULL,
    ChargeState.BALANCE: CHARGING,
}
"""A SIP's charge state to the status of `sensor_msgs/BatteryState`."""


_PLANAR = np.array([0, 1, 5, 6, 7, 11, 30, 31, 35])
"""Elements of a 6 by 6 covariance that belong to x, y and heading."""


class Telemetry:
    """Builds one robot's messages."""

    def __init__(self, robot: str, model: RobotModel) -> None:
        self._model = model
        self._odom, self._base = frame(robot, "odom"), frame(robot, "base_link")
        self._discs = {disc.number: (disc, frame(robot, f"sonar_{disc.number}")) for disc in model.sonar}
        self._ranges = {number: _sonar_range(name) for number, (_, name) in self._discs.items()}
        self._pose_covariance = np.diag([0.0, 0.0, *[FIXED_VARIANCE] * 3, 0.0]).reshape(36)
        self._twist_covariance = np.diag(
            [LINEAR_VARIANCE, *[FIXED_VARIANCE] * 4, ANGULAR_VARIANCE],
        ).reshape(36)
        self._point_fields = [
            PointField(name=axis, offset=4 * index, datatype=PointField.FLOAT32, count=1)
            for index, axis in enumerate("xyz")
        ]
        self._wheels = [frame(robot, "left_wheel"), frame(robot, "right_wheel")]
        self._ticks: tuple[int, int] | None = None
        self._rolled = [0, 0]
        self._wheel_speeds = 0.0, 0.0
        self._charge = nan

    def odometry(self, event: SipReceived, stamp: int) -> Odometry:
        """Return the pose in `<robot>/odom` and the twist in `<robot>/base_link`."""
        xx, xy, xh, _, yy, yh, _, _, hh = event.covariance
        covariance = self._pose_covariance
        covariance[_PLANAR] = xx, xy, xh, xy, yy, yh, xh, yh, hh
        pose = event.pose
        return Odometry(
            header=header(stamp, self._odom),
            child_frame_id=self._base,
            pose=PoseWithCovariance(
                pose=Pose(position=Point(x=pose.x, y=pose.y, z=0.0), orientation=quaternion(pose.heading)),
                covariance=covariance,
            ),
            twist=TwistWithCovariance(twist=twist(event.linear, event.angular), covariance=self._twist_covariance),
        )

    def transform(self, event: SipReceived, stamp: int) -> TFMessage:
        """Return `<robot>/base_link` in `<robot>/odom`."""
        pose = event.pose
        return TFMessage(transforms=[placed(header(stamp, self._odom), self._base, pose.x, pose.y, pose.heading)])

    def static_transforms(self, stamp: int) -> TFMessage:
        """Return the sonar discs in `<robot>/base_link`."""
        base = header(stamp, self._base)
        return TFMessage(
            transforms=[placed(base, name, disc.x, disc.y, disc.heading) for disc, name in self._discs.values()]
        )

    def sonar(self, sip: StandardSip, stamp: int) -> RangeArray:
        """Return the new readings; infinite where no echo came back (REP 117). Valid until the next call."""
        base = header(stamp, self._base)
        readings = []
        for number, distance in sip.sonar:
            reading = self._ranges.get(number)
            if reading is not None:
                reading.header.stamp = base.stamp  # the same for all: one object serves
                reading.range = distance if distance < reading.max_range else inf
                readings.append(reading)
        return RangeArray(base, readings)

    def sonar_points(self, sip: StandardSip, stamp: int) -> PointCloud2:
        """Return the echoes among the new readings, on the axes of their discs."""
        points = []
        for number, distance in sip.sonar:
            if number in self._discs and distance < SONAR_RANGE[1]:
                disc, _ = self._discs[number]
                points += [disc.x + distance * cos(disc.heading), disc.y + distance * sin(disc.heading), 0.0]
        data = np.array(points, "<f4").view(np.uint8)
        count = len(points) // 3
        return PointCloud2(
            header=header(stamp, self._base),
            height=1,
            width=count,
            fields=self._point_fields,
            is_bigendian=False,
            point_step=12,
            row_step=12 * count,
            data=data,
            is_dense=True,
        )

    def bumpers(self, sip: StandardSip, stamp: int) -> Bumpers:
        """Return the bumper segments that the robot has, and the wheels' stalls."""
        model = self._model
        return Bumpers(
            header(stamp, self._base),
            front=_bits(sip.front_bumpers, model.front_bumpers),
            rear=_bits(sip.rear_bumpers, model.rear_bumpers),
            stall_left=sip.left_stalled,
            stall_right=sip.right_stalled,
        )

    def battery(self, sip: StandardSip, stamp: int) -> BatteryState:
        """Return voltage and charging; NaN for unknown values."""
        status = CHARGE_STATES.get(ChargeState.UNKNOWN if sip.charge_state is None else sip.charge_state)
        if status is None:
            status = CHARGING if sip.charger_good else BatteryState.POWER_SUPPLY_STATUS_UNKNOWN
        return BatteryState(
            header=header(stamp, self._base),
            voltage=sip.best_battery,
            temperature=nan,
            current=nan,
            charge=nan,
            capacity=nan,
            design_capacity=nan,
            percentage=self._charge if sip.state_of_charge is None else sip.state_of_charge,
            power_supply_status=status,
            power_supply_health=BatteryState.POWER_SUPPLY_HEALTH_UNKNOWN,
            power_supply_technology=BatteryState.POWER_SUPPLY_TECHNOLOGY_UNKNOWN,  # ROS knows no lead-acid
            present=True,
            cell_voltage=np.array([], np.float32),
            cell_temperature=np.array([], np.float32),
            location="",
            serial_number="",
        )

    def user_ports(self, sip: StandardSip, stamp: int) -> InputsOutputs:
        """Return the eight digital inputs and outputs that every SIP carries."""
        return InputsOutputs(header(stamp, self._base), _bits(sip.digital_in, 8), _bits(sip.digital_out, 8))

    def inputs_outputs(self, ports: IoReport, stamp: int) -> InputsOutputs:
        """Return all ports of an I/O packet."""
        return InputsOutputs(
            header(stamp, self._base), _all_bits(ports.digital_in), _all_bits(ports.digital_out), ports.analog
        )

    def note_ticks(self, encoders: Encoders) -> None:
        """Keep how far the driven wheels have rolled since the first packet."""
        ticks = encoders.left, encoders.right
        last = self._ticks or ticks
        self._ticks = ticks
        for wheel, (now, before) in enumerate(zip(ticks, last, strict=True)):
            self._rolled[wheel] += TICK_RING.fit(now - before)

    def joints(self, stamp: int) -> JointState:
        """Return angles (rad, from the first packet on) and speeds (rad/s) of the driven wheels."""
        radius = self._model.wheel_diameter / 2.0
        per_tick = 1.0 / (self._model.ticks_per_metre * radius)
        return JointState(
            header=header(stamp, self._base),
            name=self._wheels,
            position=np.array([rolled * per_tick for rolled in self._rolled]),
            velocity=np.array([speed / radius for speed in self._wheel_speeds]),
            effort=np.array([]),
        )

    def note_wheels(self, sip: StandardSip) -> None:
        """Keep the wheel speeds for the encoder packet after the SIP."""
        self._wheel_speeds = sip.left_velocity, sip.right_velocity

    def note_charge(self, fraction: float) -> None:
        """Keep the charge that the batteries report, 0 to 1, for SIPs without it."""
        self._charge = fraction

    def forget_ticks(self) -> None:
        """Forget the counts: the encoders may begin at zero again, and the angles continue."""
        self._ticks = None


def _sonar_range(name: str) -> Range:
    nearest, farthest = SONAR_RANGE
    return Range(
        header=header(0, name),
        radiation_type=Range.ULTRASOUND,
        field_of_view=SONAR_CONE,
        min_range=nearest,
        max_range=farthest,
        range=inf,
        variance=0.0,
    )


def _bits(word: int, count: int) -> list[bool]:
    return [bool(word >> bit & 1) for bit in range(count)]


def _all_bits(data: Iterable[int]) -> list[bool]:
    return [bit for byte in data for bit in _bits(byte, 8)]
