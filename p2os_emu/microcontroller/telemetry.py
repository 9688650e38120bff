"""Packets of the board: the standard SIP, requested packets, and unrequested packets."""

from collections.abc import Callable, Mapping

from geometry import Pose2D
from p2os.accessories.gripper import USER_INPUTS, GripperKind
from p2os.accessory_packets import BatteryReport, GyroReport, JoystickReport
from p2os.configuration import Configuration, GyroKind
from p2os.firmware import BAUD_CODES, FIRMWARES, Family
from p2os.packets import Encoders, IoReport, Packet, PacketType
from p2os.sip import (
    GYRO_FAULT,
    OPEN_INPUTS,
    TABLE_SENSOR_INPUTS,
    UNKNOWN_TEMPERATURE,
    SipFlag,
    StandardSip,
    stall_word,
)
from p2os_emu.body import BodyState
from p2os_emu.microcontroller.board import Board
from p2os_emu.microcontroller.panel import CENTRED

SHOWS = 0.0005
"""m/s of a wheel rim from which the SIP shows it turning: what rounds to 1 mm/s."""
ANALOG_TOP = 5.0
"""V; the converters measure no more."""
BATTERY_DIVIDER = 4
"""Of a 12 V battery's divider to its A/D port; in proportion for others (assumed)."""
PIONEER_BATTERY = 12.0

_BAUD_CODE = {baud: code for code, baud in BAUD_CODES.items()}
_INFRARED_INPUTS = frozenset({Family.ARCOS, Family.UARCS})


def standard_sip(board: Board, state: BodyState) -> StandardSip:
    """The standard SIP of this cycle; takes the sonar readings since the last one."""
    odometry = board.odometry
    panel = board.panel
    stall = board.motors.stall
    left, right = state.left_velocity, state.right_velocity
    voltage = board.battery_voltage
    gripper = board.gripper
    port = board.analog_port
    front, rear = _bumpers(board, state)
    return StandardSip(
        moving=abs(left) >= SHOWS or abs(right) >= SHOWS,
        x=odometry.x,
        y=odometry.y,
        heading=odometry.heading,
        left_velocity=left,
        right_velocity=right,
        battery=voltage,
        stall=stall_word(stall.left, stall.right, front, rear),
        control=board.motion.heading_setpoint,
        flags=_flags(board, state),
        compass=board.compass.byte if board.compass is not None else 0,
        sonar=board.sonar.take(),
        gripper_state=gripper.state,
        analog_port=gripper.second_byte if gripper.kind else port,
        analog=_clip(panel.analog[port]),
        digital_in=_user_inputs(board, state),
        digital_out=board.digital_out,
        battery_fine=voltage,
        charge_state=board.battery.charging,
        rotational_velocity=(right - left) / board.model.wheel_track,
        fault_flags=GYRO_FAULT if panel.gyro_failed and board.gyro is not None else 0,
        temperature=UNKNOWN_TEMPERATURE if board.temperature is None else board.temperature,
    )


def _configuration(board: Board, state: BodyState) -> Configuration:
    """CONFIGpac: working values where commands change them, FLASH for the rest."""
    model, flash = board.model, board.flash
    along = board.motion.translation.limits
    around = board.motion.rotation.limits
    front_arrays, rear_arrays = _sonar_arrays(board)
    return Configuration(
        robot_type=model.robot_class,
        subtype=model.name,
        serial=flash.serial,
        rotation_top=around.top,
        velocity_top=along.top,
        rotational_acceleration_top=around.acceleration_top,
        acceleration_top=along.acceleration_top,
        pwm_max=flash.pwm_max,
        name=board.name,
        sip_cycle=flash.sip_cycle,
        host_baud=_BAUD_CODE[board.host_baud],
        aux1_baud=_BAUD_CODE[board.aux[1].baud],
        gripper=board.gripper.kind,
        front_sonar=front_arrays,
        rear_sonar=rear_arrays,
        low_battery=flash.low_battery * model.battery_nominal,
        rev_count=board.rev_count,
        watchdog=board.watchdog.timeout,
        stall_value=flash.stall_value,
        stall_count=flash.stall_count,
        joystick_velocity=flash.joystick_velocity,
        joystick_rotation=flash.joystick_rotation,
        rotation_max=max(around.forward, around.backward),
        velocity_max=along.forward,
        rotational_acceleration=around.acceleration,
        rotational_deceleration=around.deceleration,
        acceleration=along.acceleration,
        deceleration=along.deceleration,
        **board.gains,
        front_bumpers=model.front_bumpers,
        rear_bumpers=model.rear_bumpers,
        charger=flash.charger,
        sonar_cycle=board.sonar.cycle,
        auto_baud=flash.auto_baud,
        has_gyro=_has_gyro(board),
        drift_factor=board.drift_factor,
        aux2_baud=_BAUD_CODE[board.aux[2].baud],
        aux3_baud=_BAUD_CODE[board.aux[3].baud],
        ticks_per_mm=board.ticks_mm,
        shutdown_voltage=flash.shutdown_battery * model.battery_nominal,
        firmware_version=FIRMWARES[model.firmware].version,
        gyro_cw=board.gyro_cw,
        gyro_ccw=board.gyro_ccw,
        kinematics_delay=flash.kinematics_delay,
    )


def _encoders(board: Board, state: BodyState) -> Encoders:
    """ENCODERpac: ticks since power-on."""
    odometry = board.odometry
    return Encoders(odometry.left_ticks, odometry.right_ticks)


def _inputs_outputs(board: Board, state: BodyState) -> IoReport:
    """IOpac: user inputs, bumpers and, on ARCOS, infrared sensors; the battery's A/D port comes last."""
    panel = board.panel
    digital_in = [_user_inputs(board, state), *_bumpers(board, state)]
    if board.model.firmware in _INFRARED_INPUTS or board.model.irs:
        digital_in.append(panel.infrared & state.infrared & OPEN_INPUTS)
    divided = board.battery_voltage * PIONEER_BATTERY / board.model.battery_nominal / BATTERY_DIVIDER
    analog = (*map(_clip, panel.analog), _clip(divided))
    return IoReport(bytes(digital_in), bytes([board.digital_out]), analog)


def _gyro(board: Board, state: BodyState) -> GyroReport:
    """GYROpac: the samples since the last one."""
    return board.gyro.report() if board.gyro is not None else GyroReport(())


def _joystick(board: Board, state: BodyState) -> JoystickReport:
    """JOYSTICKpac."""
    hand = board.panel.joystick or CENTRED
    return JoystickReport(hand.button1, hand.button2, hand.x, hand.y, hand.throttle)


def _battery(board: Board, state: BodyState) -> BatteryReport:
    """Battery packet: one battery, without flags."""
    percent = round(100 * board.battery.charge)
    return BatteryReport(((0, 0, 0, percent, percent),))


def answers(board: Board) -> list[Packet]:
    """Return the packets after this SIP, beside those of `EXTRAS`."""
    said: list[Packet] = []
    for port in board.aux.values():
        answer = port.answer()
        if answer is not None:
            said.append(answer)
    said += board.answers
    board.answers.clear()
    if board.simulator is not None:
        odometry = board.odometry
        said += board.simulator.packets(Pose2D(odometry.x, odometry.y, odometry.heading), board.flash.sip_cycle)
    return said


EXTRAS: Mapping[PacketType, Callable[[Board, BodyState], Packet]] = {
    PacketType.CONFIGURATION: _configuration,
    PacketType.ENCODERS: _encoders,
    PacketType.INPUTS_OUTPUTS: _inputs_outputs,
    PacketType.GYRO: _gyro,
    PacketType.JOYSTICK: _joystick,
    PacketType.BATTERY: _battery,
    PacketType.GRIPPER: lambda board, _: board.gripper.report(),
    PacketType.ARM: lambda board, _: board.arm.report,
    PacketType.ARM_INFO: lambda board, _: board.arm.information,
}
"""Packets that go with a standard SIP when a client has asked for them: after it, but for those in `AHEAD`."""

AHEAD = (PacketType.JOYSTICK, PacketType.ARM, PacketType.ARM_INFO, PacketType.GYRO)
"""Packets right before the SIP, in this order, whatever the family.

That is ARCOS' place for JOYSTICKpac and GYROpac; older firmware is said to have sent everything behind the SIP, but one
well-known driver waits for another packet after a GYROpac, an ARMpac or an ARMINFOpac.
"""


def _has_gyro(board: Board) -> GyroKind:
    if board.gyro is None:
        return GyroKind.NONE
    return GyroKind.INSIDE if board.gyro.inside else GyroKind.PACKETS


def _flags(board: Board, state: BodyState) -> int:
    panel = board.panel
    return (
        (board.motors.enabled and SipFlag.MOTORS_ENABLED.value)
        | SipFlag.of_sonar(board.sonar.firing)
        | (panel.stop_button and SipFlag.STOP_BUTTON.value)
        | (board.e_stalled and SipFlag.E_STALL.value)
        | (state.far_ledge and SipFlag.FAR_LEDGE.value)
        | (state.near_ledge and SipFlag.NEAR_LEDGE.value)
        | (panel.joystick is not None and panel.joystick.button1 and SipFlag.JOYSTICK_BUTTON_1.value)
        | (board.charger.power_good and SipFlag.CHARGER_GOOD.value)
    )


def _user_inputs(board: Board, state: BodyState) -> int:
    """DIGIN: the user's pins, but for those that table sensors or a gripper on the user I/O take."""
    panel = board.panel.digital_in & OPEN_INPUTS
    if board.model.table_sensing_ir and not board.model.new_table_sensing_ir:
        panel &= _old_table_pins(state.infrared & board.panel.infrared)
    taken = USER_INPUTS if board.gripper.kind == GripperKind.PIONEER else 0
    return panel & ~taken | board.gripper.inputs & taken if taken else panel


def _old_table_pins(infrared: int) -> int:
    """Levels of the input pins: low where a table sensor sees something, high elsewhere."""
    seen = sum(1 << pin for sensor, pin in TABLE_SENSOR_INPUTS.items() if not infrared >> sensor & 1)
    return OPEN_INPUTS & ~seen


def _bumpers(board: Board, state: BodyState) -> tuple[int, int]:
    """The pressed segments among those fitted, front and rear."""
    model = board.model
    return state.front_bumpers & (1 << model.front_bumpers) - 1, state.rear_bumpers & (1 << model.rear_bumpers) - 1


def _sonar_arrays(board: Board) -> tuple[int, int]:
    """How many arrays look forward, and how many look back: by where their discs sit."""
    depths: dict[int, float] = {}
    for disc in board.model.sonar:
        depths[disc.array] = depths.get(disc.array, 0.0) + disc.x
    front = sum(1 for depth in depths.values() if depth >= 0.0)
    return front, len(depths) - front


def _clip(voltage: float) -> float:
    return max(0.0, min(ANALOG_TOP, voltage))
