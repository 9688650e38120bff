"""The Sony EVI-D30 camera head: VISCA commands with acknowledgement and completion, inquiries with replies.

A command that moves something holds one of two sockets until the motion is over; one that moves the same axes takes the
place of the one before, which is completed at once. Inquiries are answered in the same step.

Source: fact sheet of accessories, section 3. Where that is silent: without power everything but the power command and
inquiry is not executable; a value outside its range is a syntax error; commands for another address pass by unheard.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto

from p2os.accessories import visca
from p2os.accessories.head_model import HeadModel
from p2os.accessories.visca import Error, ViscaDecoder, ViscaMessage, encode, pack_values, read_values
from p2os_emu.accessories.head import Head

DIRECTIONS: Mapping[int, int] = {visca.LEFT: 1, visca.RIGHT: -1, visca.STAY: 0}
"""Of a pan drive, as REP 103 has it."""
ELEVATIONS: Mapping[int, int] = {visca.UP: 1, visca.DOWN: -1, visca.STAY: 0}
_ZOOMS: Mapping[int, int] = {visca.ZOOM_STOP: 0, visca.NARROWER: 1, visca.WIDER: -1}


class _Busy(Enum):
    """What a command keeps busy."""

    TURNING = auto()
    ZOOMING = auto()
    SWITCHING = auto()


@dataclass(slots=True)
class _SocketCommand:
    """A command in a socket. time_left: s, where it is not the mechanics that say when it is over."""

    busy: _Busy
    time_left: float


class EviD30:
    """A head on a line of 9600 bit/s; implements `Device`.

    head: where it looks. is_on: it has power.
    """

    def __init__(self, model: HeadModel) -> None:
        self.head = Head(model)
        self.is_on = model.starts_on
        self.has_backlight = False
        self._model = model
        self._decoder = ViscaDecoder()
        self._out = bytearray()
        self._sockets: dict[int, _SocketCommand] = {}
        self._commands: Mapping[bytes, tuple[_Busy, Callable[[bytes], None]]] = {
            visca.MOVE: (_Busy.TURNING, self._move),
            visca.DRIVE: (_Busy.TURNING, self._drive),
            visca.HOME: (_Busy.TURNING, self._home),
            visca.RESET: (_Busy.TURNING, self._home),
            visca.ZOOM_TO: (_Busy.ZOOMING, self._zoom),
            visca.ZOOM_DRIVE: (_Busy.ZOOMING, self._drive_zoom),
            visca.BACKLIGHT: (_Busy.SWITCHING, self._set_backlight),
            visca.POWER: (_Busy.SWITCHING, self._switch),
        }
        self._inquiries: Mapping[bytes, Callable[[], bytes]] = {
            visca.ASK_DIRECTION: self._direction,
            visca.ASK_ZOOM: lambda: pack_values(visca.ASK_ZOOM, round(self.head.lens.position)),
            visca.ASK_VERSION: lambda: visca.D30_VERSION,
            visca.ASK_POWER: lambda: pack_values(visca.ASK_POWER, visca.ON if self.is_on else visca.OFF),
        }

    @property
    def baud(self) -> int:
        """Rate of its port, bit/s."""
        return self._model.baud

    def receive(self, data: bytes) -> None:
        """Take bytes from the line."""
        for message in self._decoder.receive(data):
            self._take(message)

    def step(self, dt: float) -> bytes:
        """Let time pass, s; returns the replies that are ready."""
        if self.is_on:
            self.head.step(dt)
        for socket, motion in list(self._sockets.items()):
            motion.time_left -= dt
            if not self._goes_on(motion):
                self._complete(socket)
        out = bytes(self._out)
        self._out.clear()
        return out

    def _goes_on(self, motion: _SocketCommand) -> bool:
        match motion.busy:
            case _Busy.TURNING:
                return self.head.is_turning
            case _Busy.ZOOMING:
                return self.head.lens.is_moving
            case _Busy.SWITCHING:
                return motion.time_left > 0.0

    def _take(self, message: ViscaMessage) -> None:
        header, payload = message
        if header == visca.BROADCAST:
            self._take_broadcast(message)
        elif header == visca.TO_CAMERA:
            if message.kind == visca.CANCEL and len(payload) == 1:
                self._cancel(message.socket)
            elif payload in self._inquiries:
                self._inquire(payload)
            else:
                self._command(payload)

    def _take_broadcast(self, message: ViscaMessage) -> None:
        if message.payload == visca.CLEAR:
            self._sockets.clear()
            self._out += encode(visca.CLEAR, header=visca.BROADCAST)
        elif (reply := message.address_reply()) is not None:
            self._out += encode(reply, header=visca.BROADCAST)

    def _inquire(self, payload: bytes) -> None:
        if self.is_on or payload == visca.ASK_POWER:
            self._reply(visca.COMPLETION, self._inquiries[payload]())
        else:
            self._reject(Error.NOT_EXECUTABLE)

    def _command(self, payload: bytes) -> None:
        kind, given = payload[: visca.KIND_SIZE], payload[visca.KIND_SIZE :]
        if kind not in self._commands:
            self._reject(Error.SYNTAX)
        elif not self.is_on and kind != visca.POWER:
            self._reject(Error.NOT_EXECUTABLE)
        else:
            self._start(kind, given)

    def _start(self, kind: bytes, given: bytes) -> None:
        busy, execute = self._commands[kind]
        replaced = [socket for socket, motion in self._sockets.items() if motion.busy is busy]
        free = [socket for socket in range(1, visca.SOCKETS + 1) if socket not in self._sockets] + replaced
        if not free:
            self._reject(Error.BUFFER_FULL)
            return
        was_on = self.is_on
        try:
            execute(given)
        except ValueError:
            self._reject(Error.SYNTAX)
            return
        for socket in replaced:
            self._complete(socket)
        self._reply(visca.ACK | free[0])
        self._sockets[free[0]] = _SocketCommand(busy, self._model.power_on_s if self.is_on and not was_on else 0.0)

    def _cancel(self, socket: int) -> None:
        motion = self._sockets.pop(socket, None)
        if motion is None:
            self._reject(Error.NO_SOCKET, socket)
            return
        if motion.busy is _Busy.TURNING:
            self.head.stop()
        elif motion.busy is _Busy.ZOOMING:
            self.head.lens.drive(0)
        self._reject(Error.CANCELLED, socket)

    def _complete(self, socket: int) -> None:
        del self._sockets[socket]
        self._reply(visca.COMPLETION | socket)

    def _reject(self, error: Error, socket: int = 0) -> None:
        self._reply(visca.ERROR | socket, bytes([error]))

    def _reply(self, first: int, data: bytes = b"") -> None:
        self._out += encode(bytes([first]) + data, header=visca.FROM_CAMERA)

    # Each takes what follows the command's three bytes, and raises ValueError where it makes no sense.

    def _set_speeds(self, pan_speed: int, tilt_speed: int) -> None:
        pan, tilt = self._model.pan, self._model.tilt
        if not (pan.slowest <= pan_speed <= pan.fastest and tilt.slowest <= tilt_speed <= tilt.fastest):
            raise ValueError(f"speed {pan_speed} or {tilt_speed} is out of range")
        self.head.pan.speed, self.head.tilt.speed = pan.speed(pan_speed), tilt.speed(tilt_speed)

    def _move(self, given: bytes) -> None:
        move = read_values(visca.MOVE, given)
        if move is None:
            raise ValueError("pan and tilt are four nibbles each")
        pan_speed, tilt_speed, pan, tilt = move
        axes = self._model.pan, self._model.tilt
        if not all(axis.lowest <= count <= axis.highest for axis, count in zip(axes, (pan, tilt), strict=True)):
            raise ValueError(f"pan {pan} or tilt {tilt} is out of range")
        self._set_speeds(pan_speed, tilt_speed)
        self.head.pan.go(axes[0].angle(pan))
        self.head.tilt.go(axes[1].angle(tilt))

    def _drive(self, given: bytes) -> None:
        drive = read_values(visca.DRIVE, given)
        if drive is None or drive[2] not in DIRECTIONS or drive[3] not in ELEVATIONS:
            raise ValueError("a drive has two speeds and two directions")
        pan_speed, tilt_speed, pan, tilt = drive
        self._set_speeds(pan_speed, tilt_speed)
        self.head.pan.drive(DIRECTIONS[pan])
        self.head.tilt.drive(ELEVATIONS[tilt])

    def _home(self, given: bytes) -> None:
        self.head.home()

    def _zoom(self, given: bytes) -> None:
        position = read_values(visca.ZOOM_TO, given)
        if position is None or not 0 <= position[0] <= self._model.lens.counts:
            raise ValueError("there is no such zoom position")
        self.head.lens.go(position[0])

    def _drive_zoom(self, given: bytes) -> None:
        if len(given) != 1 or given[0] not in _ZOOMS:
            raise ValueError("a zoom drive has one direction")
        self.head.lens.drive(_ZOOMS[given[0]])

    def _set_backlight(self, given: bytes) -> None:
        self.has_backlight = _is_on(given)

    def _switch(self, given: bytes) -> None:
        self.is_on = _is_on(given)

    def _direction(self) -> bytes:
        pan = self._model.pan.count(self.head.pan.position)
        return pack_values(visca.ASK_DIRECTION, pan, self._model.tilt.count(self.head.tilt.position))


def _is_on(given: bytes) -> bool:
    if given not in (bytes([visca.ON]), bytes([visca.OFF])):
        raise ValueError("a switch is on or off")
    return given[0] == visca.ON
