"""What every robot has, on the bus: its commands and its part of the description.

`gateway.telemetry` makes the messages, since several elements share one packet.
"""

from typing import Any, Never

from bus import keys
from gateway.commands import BASE, NOTHING, Arguments, CommandRow
from gateway.elements.adapter import BusAdapter, RobotContext
from gateway.elements.standard.element import SonarElement, UserPorts
from gateway.events import MotionEnd
from geometry import wrap_angle


class _BaseAdapter(BusAdapter[Never]):
    """The driven wheels: velocities, long motions, motors, stop and e-stop."""

    name = BASE
    streams = (keys.ODOM, keys.TF, keys.STATE)
    subscriptions = (keys.CMD_VEL, keys.CMD_VEL_STAMPED)

    def halt(self, now: float, end: MotionEnd = MotionEnd.STOPPED) -> None:
        """Stop the wheels, also while the joystick drives them."""
        self._driver.halt_base(now, end)

    def is_moving(self, now: float) -> bool:
        """Return whether the wheels turn."""
        return self._driver.is_moving

    def _drive(self, arguments: Arguments, now: float) -> None:
        self._driver.set_velocity(arguments["linear"], arguments["angular"], now)

    def _enable(self, arguments: Arguments, now: float) -> None:
        self._driver.enable(arguments["on"], now)

    def _stop(self, arguments: Arguments, now: float) -> None:
        self._driver.stop(now)

    def _estop(self, arguments: Arguments, now: float) -> dict[str, Any]:
        self._driver.emergency_stop(arguments["on"], now)
        return {"estop": self._driver.is_estopped}

    def _move(self, arguments: Arguments, now: float) -> dict[str, Any]:
        return {"id": self._driver.move(arguments["distance"], now)}

    def _turn(self, arguments: Arguments, now: float) -> dict[str, Any]:
        return {"id": self._driver.turn(arguments["angle"], now)}

    def _turn_to(self, arguments: Arguments, now: float) -> dict[str, Any]:
        return {"id": self._driver.turn_to(arguments["heading"], now)}

    def _time_to_move(self, arguments: Arguments, now: float) -> float:
        return self._driver.time_to_move(arguments["distance"])

    def _time_to_turn(self, arguments: Arguments, now: float) -> float:
        return self._driver.time_to_turn(arguments["angle"])

    def _time_to_turn_to(self, arguments: Arguments, now: float) -> float:
        return self._driver.time_to_turn(wrap_angle(arguments["heading"] - self._driver.odometry.pose.heading))

    commands = (
        CommandRow(keys.DRIVE, {"linear": float, "angular": float}, _drive, BASE),
        CommandRow(keys.ENABLE, {"on": bool}, _enable, BASE),
        CommandRow(keys.STOP, {}, _stop, NOTHING),  # anyone may stop a robot
        CommandRow(keys.ESTOP, {"on": bool}, _estop, NOTHING),
        CommandRow(keys.MOVE, {"distance": float}, _move, BASE, duration=_time_to_move),
        CommandRow(keys.TURN, {"angle": float}, _turn, BASE, duration=_time_to_turn),
        CommandRow(keys.HEADING, {"heading": float}, _turn_to, BASE, duration=_time_to_turn_to),
    )


class _BatteryAdapter(BusAdapter[Never]):
    """`<robot>/battery`."""

    name = "battery"
    streams = (keys.BATTERY,)


class _UserPortsAdapter(BusAdapter[Never]):
    """`<robot>/io` and `command/output`."""

    name = "io"
    streams = (keys.IO,)

    def _set_outputs(self, arguments: Arguments, now: float) -> None:
        self._driver.element(UserPorts, now).set_outputs(arguments["mask"], arguments["value"])

    commands = (CommandRow(keys.OUTPUT, {"mask": int, "value": int}, _set_outputs, NOTHING),)


class _SonarAdapter(BusAdapter[Never]):
    """`<robot>/sonar` and `command/sonar`."""

    name = "sonar"
    streams = (keys.SONAR, keys.SONAR_POINTS)

    def is_present(self) -> bool:
        """Return whether the robot's model has sonar discs."""
        return bool(self._model.sonar)

    def _switch(self, arguments: Arguments, now: float) -> None:
        self._driver.element(SonarElement, now).switch(arguments["on"])

    commands = (CommandRow(keys.SONAR_POWER, {"on": bool}, _switch, NOTHING),)


class _BumpersAdapter(BusAdapter[Never]):
    """`<robot>/bumpers`."""

    name = "bumpers"
    streams = (keys.BUMPERS,)

    def is_present(self) -> bool:
        """Return whether the robot's model has bumpers."""
        return bool(self._model.front_bumpers or self._model.rear_bumpers)


class _EncodersAdapter(BusAdapter[Never]):
    """The driven wheels among `<robot>/joint_states`, where the settings ask for them."""

    name = "encoders"
    streams = (keys.JOINT_STATES,)

    def __init__(self, robot: RobotContext) -> None:
        super().__init__(robot)
        self._is_wanted = robot.settings.encoders

    def is_present(self) -> bool:
        """Return whether the settings ask for the encoders."""
        return self._is_wanted


ADAPTERS = (_BaseAdapter, _BatteryAdapter, _UserPortsAdapter, _SonarAdapter, _BumpersAdapter, _EncodersAdapter)
