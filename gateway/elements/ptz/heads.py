"""The protocols of the two kinds of camera heads: requests, lengths and meanings of the answers."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, Protocol

from gateway.elements.aux_line import AuxExchange
from p2os.accessories import vcc4, visca
from p2os.accessories.head_model import HeadKind, HeadModel
from p2os.accessories.vcc4 import Code, HeadFrame, Status, Vcc4Decoder
from p2os.accessories.visca import Error, ViscaDecoder, ViscaMessage, encode


class Direction(NamedTuple):
    """Direction of a head, rad: to the left, up."""

    pan: float
    tilt: float


class Zoom(NamedTuple):
    """Magnification of a head; 1 at the widest."""

    ratio: float


class _Obeyed(NamedTuple):
    """A head has accepted a command."""


class Declined(NamedTuple):
    """A head has not accepted a command.

    is_busy: it may later. is_asleep: it must be started first.
    """

    is_busy: bool = False
    is_asleep: bool = False


HeadReply = Direction | Zoom | _Obeyed | Declined


class HeadProtocol(Protocol):
    """The protocol of one kind of head.

    probe: harmless, and answered by this kind of head only. start: in order, to make a head obey.
    """

    kind: HeadKind
    model: HeadModel
    probe: AuxExchange
    start: Sequence[AuxExchange]
    ask_direction: AuxExchange
    ask_zoom: AuxExchange
    stop: Sequence[AuxExchange]

    @property
    def pending(self) -> int:
        """Bytes of an answer that is not complete yet."""

    def hear(self, data: bytes) -> list[HeadReply]:
        """Take bytes from the head."""

    def turn(self, pan: float, tilt: float) -> AuxExchange:
        """Return the exchange that turns the head, rad."""

    def zoom(self, ratio: float) -> AuxExchange:
        """Return the exchange that sets the magnification."""


class _Vcc4Protocol:
    """The Canon VC-C4; implements `HeadProtocol`."""

    kind: HeadKind = HeadKind.VCC4

    def __init__(self, model: HeadModel) -> None:
        self.model = model
        self.ask_direction = AuxExchange(vcc4.encode_command(Code.DIRECTION), vcc4.PLAIN_LENGTH, vcc4.DIRECTION_LENGTH)
        self.ask_zoom = AuxExchange(
            vcc4.encode_command(Code.ZOOM_REQUEST, vcc4.START), vcc4.PLAIN_LENGTH, vcc4.ZOOM_LENGTH
        )
        self.probe = self.ask_direction
        self.start: Sequence[AuxExchange] = (
            _plain(Code.POWER, vcc4.ON, patience=5.0),  # answered when it is on; the patience is ARIA's
            _plain(Code.CONTROL_MODE, vcc4.HOST_CONTROL),
            _plain(Code.INITIALISE, vcc4.START, patience=2.5),
            _plain(Code.PAN_SLEW, (model.pan.fastest,)),
            _plain(Code.TILT_SLEW, (model.tilt.fastest,)),
            _plain(Code.TILT_RANGE, (model.tilt.lowest, model.tilt.highest)),
        )
        self.stop: Sequence[AuxExchange] = (_plain(Code.STOP, vcc4.START), _plain(Code.STOP_ZOOM, vcc4.START))
        self._decoder = Vcc4Decoder(from_head=True)

    @property
    def pending(self) -> int:
        """Bytes of an answer that is not complete yet."""
        return self._decoder.pending

    def hear(self, data: bytes) -> list[HeadReply]:
        """Take bytes from the head."""
        return [self._meaning(answer) for answer in self._decoder.receive(data)]

    def turn(self, pan: float, tilt: float) -> AuxExchange:
        """Return the exchange that turns the head, rad."""
        return _plain(Code.MOVE, (self.model.pan.count(pan), self.model.tilt.count(tilt)))

    def zoom(self, ratio: float) -> AuxExchange:
        """Return the exchange that sets the magnification."""
        return _plain(Code.ZOOM, (self.model.lens.count_at(ratio),))

    def _meaning(self, answer: HeadFrame) -> HeadReply:
        if answer.kind != Status.OK:
            return Declined(answer.kind == Status.BUSY, answer.kind == Status.NOT_HOST_CONTROLLED)
        counts = vcc4.read_counts(Code.DIRECTION, answer.data)
        if counts is not None:
            return Direction(self.model.pan.angle(counts[0]), self.model.tilt.angle(counts[1]))
        zoom = vcc4.read_counts(Code.ZOOM_REQUEST, answer.data)
        return _Obeyed() if zoom is None else Zoom(self.model.lens.ratio_at(zoom[0]))


def _plain(code: Code, parameters: bytes | tuple[int, ...], patience: float = 0.5) -> AuxExchange:
    return AuxExchange(vcc4.encode_command(code, parameters), vcc4.PLAIN_LENGTH, vcc4.PLAIN_LENGTH, patience)


class _ViscaProtocol:
    """The Sony EVI-D30; implements `HeadProtocol`."""

    kind: HeadKind = HeadKind.EVID30

    def __init__(self, model: HeadModel) -> None:
        self.model = model
        # The end in front closes what a head may have taken for the beginning of a message.
        set_address = bytes([visca.END]) + encode(visca.SET_ADDRESS, header=visca.BROADCAST)
        self.probe = AuxExchange(set_address, visca.ADDRESS_LENGTH, visca.ADDRESS_LENGTH)
        self.start: Sequence[AuxExchange] = (_command(visca.POWER, visca.ON),)
        self.ask_direction = AuxExchange(encode(visca.ASK_DIRECTION), visca.ERROR_LENGTH, visca.DIRECTION_LENGTH)
        self.ask_zoom = AuxExchange(encode(visca.ASK_ZOOM), visca.ERROR_LENGTH, visca.ZOOM_LENGTH)
        self._speeds = model.pan.fastest, model.tilt.fastest
        self.stop: Sequence[AuxExchange] = (
            _command(visca.DRIVE, *self._speeds, visca.STAY, visca.STAY),
            _command(visca.ZOOM_DRIVE, visca.ZOOM_STOP),
        )
        self._decoder = ViscaDecoder()

    @property
    def pending(self) -> int:
        """Bytes of a message that is not complete yet."""
        return self._decoder.pending

    def hear(self, data: bytes) -> list[HeadReply]:
        """Take bytes from the head."""
        meanings = (self._meaning(message) for message in self._decoder.receive(data))
        return [meaning for meaning in meanings if meaning is not None]

    def turn(self, pan: float, tilt: float) -> AuxExchange:
        """Return the exchange that turns the head, rad."""
        return _command(visca.MOVE, *self._speeds, self.model.pan.count(pan), self.model.tilt.count(tilt))

    def zoom(self, ratio: float) -> AuxExchange:
        """Return the exchange that sets the magnification."""
        return _command(visca.ZOOM_TO, self.model.lens.count_at(ratio))

    def _meaning(self, message: ViscaMessage) -> HeadReply | None:
        """Return the meaning of a message; None for completions and for errors of syntax."""
        header, payload = message
        if header == visca.BROADCAST:
            return _Obeyed() if payload[:1] == visca.ADDRESS_SET else None
        if message.kind == visca.ACK:
            return _Obeyed()
        if message.kind == visca.ERROR and len(payload) > 1:
            return Declined(payload[1] == Error.BUFFER_FULL, payload[1] == Error.NOT_EXECUTABLE)
        counts = message.reply(visca.ASK_DIRECTION)
        if counts is not None:
            return Direction(self.model.pan.angle(counts[0]), self.model.tilt.angle(counts[1]))
        zoom = message.reply(visca.ASK_ZOOM)
        return None if zoom is None else Zoom(self.model.lens.ratio_at(zoom[0]))


def _command(kind: bytes, *values: int) -> AuxExchange:
    return AuxExchange(encode(kind, *values), visca.ACK_LENGTH, visca.ACK_LENGTH)


HEAD_PROTOCOLS: Mapping[HeadKind, Callable[[HeadModel], HeadProtocol]] = {
    HeadKind.VCC4: _Vcc4Protocol,
    HeadKind.EVID30: _ViscaProtocol,
}
"""Makes the protocol of a kind of head from its model."""
