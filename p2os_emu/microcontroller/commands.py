"""Commands: a table from command to handler, and the handlers.

A handler takes the value as `p2os.commands` reads it: SI for quantities, int for counts, bytes for strings, (high, low)
for two bytes. Source: fact sheet sections 4, 8 and 9.
"""

from collections.abc import Callable, Mapping
from typing import Any

from p2os.arguments import PacketRequest, ShutdownStage, SonarSwitch, StallBumpers, signed_byte
from p2os.command_table import Command
from p2os.commands import decode_command
from p2os.configuration import Configuration
from p2os.fields import FIXED_SCALES, Quantity, fields_of
from p2os.firmware import Family
from p2os.packets import PacketType
from p2os.robot_model import SONAR_ARRAYS
from p2os.sip import HIGHEST_TEMPERATURE
from p2os_emu.microcontroller import simulator
from p2os_emu.microcontroller.accessory_commands import ACCESSORY_HANDLERS, Handler, requests
from p2os_emu.microcontroller.board import Board
from p2os_emu.microcontroller.motion import MotionController
from p2os_emu.microcontroller.panel import ANALOG_PORTS
from p2os_emu.microcontroller.telemetry import EXTRAS

_FAKES_BATTERY = frozenset({Family.ARCOS, Family.UARCS})
_VOLTAGE_UNIT = FIXED_SCALES[Quantity.VOLTAGE]
_LOWEST_DRIFT, _HIGHEST_DRIFT = next(field.limits for field in fields_of(Configuration) if field.name == "drift_factor")
WARM = 80.0
"""°C that DIGTEMPTEST pretends (assumed)."""


def execute(board: Board, payload: bytes) -> None:
    """Carry out a command of an open connection, if this firmware knows it and it has a handler."""
    received = decode_command(payload)
    if board.simulator is not None and board.simulator.obeys(received):
        return
    handler = HANDLERS.get(received.number)
    if handler is not None and received.number in board.known:
        handler(board, received.value)


def _moves(act: Callable[[MotionController, Any], None]) -> Handler:
    """A motion command: it has no effect while the motors are disabled."""

    def handle(board: Board, value: Any) -> None:
        if board.motors.enabled:
            act(board.motion, value)

    return handle


def _sets_gain(name: str) -> Handler:
    def handle(board: Board, gain: int) -> None:
        if gain >= 0:
            board.gains[name] = gain

    return handle


def _vel2(board: Board, wheels: tuple[int, int]) -> None:
    if board.motors.enabled:
        left, right = map(signed_byte, wheels)
        board.motion.wheels(left * board.model.vel2_unit, right * board.model.vel2_unit)


def _estop(board: Board, _: None) -> None:
    board.motion.stop(emergency=True)


def _seto(board: Board, _: None) -> None:
    board.odometry.reset()
    board.motion.forget_heading()


def _estall(board: Board, on: int) -> None:
    board.stops_on_button = on != 0


def _bumpstall(board: Board, bumpers: int) -> None:
    if StallBumpers.NONE <= bumpers <= StallBumpers.BOTH:
        board.motors.stall.bumpers = bumpers


def _sonar(board: Board, argument: int) -> None:
    """Switch one array or all of them; P2OS knows only 0 and 1."""
    on, array = SonarSwitch.read(argument)
    if board.model.firmware is Family.P2OS:
        if argument in (0, 1):
            board.sonar.enable(on)
    elif array == 0:
        board.sonar.enable(on)
    elif array <= SONAR_ARRAYS:
        board.sonar.enable(on, array - 1)


def _sonarcycle(board: Board, period: float) -> None:
    board.sonar.cycle = period


def _digout(board: Board, mask_and_levels: tuple[int, int]) -> None:
    mask, levels = mask_and_levels
    board.digital_out = board.digital_out & ~mask | levels & mask


def _adsel(board: Board, port: int) -> None:
    if 0 <= port < ANALOG_PORTS:
        board.analog_port = port


def _ticksmm(board: Board, ticks: int) -> None:
    if ticks > 0:
        board.ticks_mm = ticks
        board.calibrate()


def _revcount(board: Board, ticks: int) -> None:
    if ticks > 0:
        board.rev_count = ticks
        board.calibrate()


def _driftfactor(board: Board, drift: int) -> None:
    if _LOWEST_DRIFT <= drift <= _HIGHEST_DRIFT:
        board.drift_factor = drift
        board.calibrate()


def _battest(board: Board, voltage: float) -> None:
    """BATTEST on ARCOS; on AROS the number means SHUTDOWN."""
    if board.model.firmware in _FAKES_BATTERY:
        board.fake_battery = voltage if voltage > 0 else None
    else:
        _shutdown(board, round(voltage / _VOLTAGE_UNIT))


def _shutdown(board: Board, stage: int) -> None:
    """0 calls it off, 1 pretends a low battery, 2 tells the robot's computer to shut down."""
    if stage == ShutdownStage.CANCEL:
        board.fake_battery = None
    elif stage == ShutdownStage.LOW_POWER:
        board.fake_battery = board.flash.low_battery * board.model.battery_nominal - _VOLTAGE_UNIT
    board.shutdown_wanted = stage == ShutdownStage.SHUT_DOWN


def _digtemptest(board: Board, on: int) -> None:
    board.temperature = WARM if on else None


def _spoofanalogtemp(board: Board, celsius: int) -> None:
    """More than the SIP can show ends the pretence (assumed)."""
    board.temperature = float(celsius) if abs(celsius) <= HIGHEST_TEMPERATURE else None


def _maintenance(board: Board, _: None) -> None:
    board.motors.disable()
    board.in_maintenance = True


def _reset(board: Board, _: None) -> None:
    board.reset_due = True


HANDLERS: Mapping[int, Handler] = {
    Command.ENABLE: lambda board, on: board.enable_motors(on != 0),
    # motion
    Command.VEL: _moves(MotionController.translate),
    Command.MOVE: _moves(MotionController.move),
    Command.RVEL: _moves(MotionController.rotate),
    Command.ROTATE: _moves(MotionController.rotate),
    Command.HEAD: _moves(MotionController.head),
    Command.DHEAD: _moves(MotionController.turn),
    Command.DCHEAD: _moves(MotionController.turn_setpoint),
    Command.VEL2: _vel2,
    Command.STOP: lambda board, _: board.motion.stop(),
    Command.ESTOP: _estop,
    Command.ESTOP_ALIAS: _estop,
    # limits of motion
    Command.SETV: lambda board, speed: board.motion.translation.limits.set_fastest(speed),
    Command.SETA: lambda board, change: board.motion.translation.limits.set_acceleration(change),
    Command.SETRV: lambda board, speed: board.motion.rotation.limits.set_fastest(speed),
    Command.SETRVDIR: lambda board, speed: board.motion.rotation.limits.set_fastest_one_way(speed),
    Command.SETRV_DIRECTIONAL: lambda board, speed: board.motion.rotation.limits.set_fastest_one_way(speed),
    Command.SETRA: lambda board, change: board.motion.rotation.limits.set_acceleration(change),
    Command.ESTALL: _estall,
    Command.BUMPSTALL: _bumpstall,
    # odometry
    Command.SETO: _seto,
    Command.TICKSMM: _ticksmm,
    Command.REVCOUNT: _revcount,
    Command.DRIFTFACTOR: _driftfactor,
    # gains
    Command.ROTKP: _sets_gain("rot_kp"),
    Command.ROTKV: _sets_gain("rot_kv"),
    Command.ROTKI: _sets_gain("rot_ki"),
    Command.TRANSKP: _sets_gain("trans_kp"),
    Command.TRANSKV: _sets_gain("trans_kv"),
    Command.TRANSKI: _sets_gain("trans_ki"),
    # sonar
    Command.SONAR: _sonar,
    Command.POLLING: lambda board, sequence: board.sonar.poll(sequence),
    Command.SONARCYCLE: _sonarcycle,
    # inputs, outputs, packets
    Command.DIGOUT: _digout,
    Command.ADSEL: _adsel,
    Command.CONFIG: lambda board, _: board.requests.ask(PacketType.CONFIGURATION, PacketRequest.ONE),
    Command.ENCODER: requests(PacketType.ENCODERS),
    Command.IOREQUEST: requests(PacketType.INPUTS_OUTPUTS),
    **ACCESSORY_HANDLERS,
    # the controller itself
    Command.HOSTBAUD: lambda board, code: board.request_baud(code),
    Command.BATTEST: _battest,
    Command.DIGTEMPTEST: _digtemptest,
    Command.SPOOFANALOGTEMP: _spoofanalogtemp,
    Command.MAINTENANCE: _maintenance,
    Command.RESET: _reset,
}

CONNECTION = frozenset({Command.SYNC0, Command.SYNC1, Command.SYNC2})
"""Handshake, PULSE, OPEN and CLOSE: the connection itself carries them out."""

EMULATED: frozenset[int] = frozenset(HANDLERS) | CONNECTION | simulator.COMMANDS
"""Numbers of the commands that have an effect, for the compliance page; a simulator's only with `--as-simulator`."""

EMULATED_PACKETS: frozenset[PacketType] = (
    frozenset(EXTRAS)
    | simulator.PACKETS
    | {
        PacketType.SYNC0,
        PacketType.SYNC1,
        PacketType.SYNC2,
        PacketType.SIP_STOPPED,
        PacketType.SIP_MOVING,
        PacketType.AUX1,
        PacketType.AUX2,
        PacketType.AUX3,
        PacketType.COMPASS,
        PacketType.PLAYLIST,
        PacketType.RESET_WITH_DATA,
        PacketType.RESET,
    }
)
"""Types of the packets that the microcontroller sends."""
