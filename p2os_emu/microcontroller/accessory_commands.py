"""Commands for accessories: gripper, arm, AUX ports, gyro, compass, joystick, sounds, outputs, charger.

Source: fact sheet section 4 and those of the accessories.
"""

from collections.abc import Callable, Mapping
from typing import Any

from p2os.arguments import GyroMode, PacketRequest
from p2os.command_table import Command
from p2os.firmware import BAUD_CODES
from p2os.packets import PacketType
from p2os_emu.microcontroller.board import Board

Handler = Callable[[Board, Any], None]
"""Takes the board and the command's value, as `p2os.commands` reads it."""


def requests(packet: PacketType) -> Handler:
    """Ask for a packet: 0 stops it, 1 asks for one, 2 and more for one with every SIP."""
    return lambda board, count: board.requests.ask(packet, count)


def _writes(port: int) -> Handler:
    return lambda board, data: board.aux[port].write(data)


def _collects(port: int) -> Handler:
    return lambda board, count: board.aux[port].ask(count)


def _sets_aux_baud(port: int) -> Handler:
    def handle(board: Board, code: int) -> None:
        aux = board.aux[port]
        aux.baud = BAUD_CODES.get(code, aux.baud)

    return handle


def _gyro(board: Board, mode: int) -> None:
    if board.gyro is None:
        return
    board.gyro.set_mode(mode)
    if not board.gyro.inside:
        board.requests.ask(PacketType.GYRO, PacketRequest.CONTINUOUS if mode > GyroMode.OFF else PacketRequest.STOP)


def _gyrocalcw(board: Board, value: int) -> None:
    if value >= 0:  # CONFIGpac carries no negative one (assumed: those are ignored)
        board.gyro_cw = value


def _gyrocalccw(board: Board, value: int) -> None:
    if value >= 0:
        board.gyro_ccw = value


def _tcm2(board: Board, mode: int) -> None:
    if board.compass is not None:
        board.compass.command(mode)


def _calcomp(board: Board, on: int) -> None:
    if board.compass is not None:
        board.compass.calibrate(on != 0)


def _joyrequest(board: Board, count: int) -> None:
    """An empty socket has nothing to report (assumed)."""
    if board.panel.joystick is not None:
        board.requests.ask(PacketType.JOYSTICK, count)


def _joydrive(board: Board, on: int) -> None:
    board.joystick.allowed = on != 0


def _soundtog(board: Board, on: int) -> None:
    board.buzzer.on = on != 0


def _dock(board: Board, mode: int) -> None:
    board.charger.docking = mode


def _powers(name: str) -> Handler:
    def handle(board: Board, on: int) -> None:
        board.outputs.power[name] = on != 0

    return handle


def _movingblink(board: Board, on: int) -> None:
    board.outputs.lamp = on != 0


ACCESSORY_HANDLERS: Mapping[int, Handler] = {
    # the gripper
    Command.GRIPPER: lambda board, order: board.gripper.order(order),
    Command.GRIPPERVAL: lambda board, value: board.gripper.value(value),
    Command.GRIPREQUEST: requests(PacketType.GRIPPER),
    # the arm
    Command.ARM_INFO: lambda board, _: board.requests.ask(PacketType.ARM_INFO, PacketRequest.ONE),
    Command.ARM_STATUS: requests(PacketType.ARM),
    Command.ARM_INIT: lambda board, _: board.arm.initialise(),
    Command.ARM_CHECK: lambda board, _: board.arm.check(),
    Command.ARM_POWER: lambda board, on: board.arm.switch(on != 0),
    Command.ARM_HOME: lambda board, joint: board.arm.home(joint),
    Command.ARM_PARK: lambda board, _: board.arm.park(),
    Command.ARM_POS: lambda board, joint_and_tick: board.arm.move(*joint_and_tick),
    Command.ARM_SPEED: lambda board, joint_and_ms: board.arm.set_speed(*joint_and_ms),
    Command.ARM_STOP: lambda board, joint: board.arm.stop(joint),
    Command.ARM_AUTOPARK: lambda board, seconds: board.arm.park_after(seconds),
    Command.ARM_GRIPPARK: lambda board, seconds: board.arm.park_gripper_after(seconds),
    # outputs
    Command.BATTERYINFO: requests(PacketType.BATTERY),
    Command.SETPBIOPORT: lambda board, ports: board.outputs.set_power_port(*ports),
    Command.PTUPOS: lambda board, servo: board.outputs.set_servo(*servo),
    Command.LCDWRITE: lambda board, text: board.outputs.show(text),
    Command.MOVINGBLINK: _movingblink,
    Command.POWER_PC: _powers("pc"),
    Command.POWER_LRF: _powers("lrf"),
    Command.POWER_5V: _powers("5v"),
    Command.POWER_12V: _powers("12v"),
    Command.POWER_AUX_PC: _powers("aux_pc"),
    Command.POWER_TOUCHSCREEN: _powers("touchscreen"),
    Command.POWER_PTZ: _powers("ptz"),
    Command.POWER_AUDIO: _powers("audio"),
    Command.POWER_LRF2: _powers("lrf2"),
    # AUX ports
    Command.TTY2: _writes(1),
    Command.TTY3: _writes(2),
    Command.TTY4: _writes(3),
    Command.GETAUX: _collects(1),
    Command.GETAUX2: _collects(2),
    Command.GETAUX3: _collects(3),
    Command.AUX1BAUD: _sets_aux_baud(1),
    Command.AUX2BAUD: _sets_aux_baud(2),
    Command.AUX3BAUD: _sets_aux_baud(3),
    # gyro, compass, joystick
    Command.GYRO: _gyro,
    Command.GYROCALCW: _gyrocalcw,
    Command.GYROCALCCW: _gyrocalccw,
    Command.TCM2: _tcm2,
    Command.CALCOMP: _calcomp,
    Command.JOYREQUEST: _joyrequest,
    Command.JOYDRIVE: _joydrive,
    # sounds
    Command.SAY: lambda board, pairs: board.buzzer.say(pairs, board.time),
    Command.SOUND: lambda board, number: board.buzzer.sound(number, board.time),
    Command.SOUNDTOG: _soundtog,
    Command.PLAYLIST: lambda board, number: board.answers.extend(board.buzzer.playlist(number)),
    # charger
    Command.CHARGE: lambda board, on: board.charge(on != 0),
    Command.DOCK: _dock,
}
