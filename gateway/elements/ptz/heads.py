"""How the two kinds of camera heads are talked to: what to send, how much to ask for, and what an answer means."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from gateway.elements.aux_line import AuxExchange
from p2os.accessories import vcc4, visca
from p2os.accessories.head_model import HeadKind, HeadModel
from p2os.accessories.vcc4 import AnswerDecoder, HeadAnswer, Status
from p2os.accessories.visca import Error, ViscaDecoder, ViscaMessage


class Direction(NamedTuple):
    """Where a head looks, rad: to the left, up."""

    pan: float
    tilt: float


class Zoom(NamedTuple):
    """How a head magnifies; 1 at the widest."""

    ratio: float


class Obeyed(NamedTuple):
    """A head has taken a command."""


class Declined(NamedTuple):
    """A head has not.

    is_busy: it may later. is_asleep: it must be started first.
    """

    is_busy: bool = False
    is_asleep: bool = False


Heard = Direction | Zoom | Obeyed | Declined


class HeadTalk(Protocol):
    """One kind of head.

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
        """Bytes that have come of an answer that is not complete yet."""
        ...

    def hear(self, data: bytes) -> list[Heard]:
        """Take bytes from the head."""
        ...

    def turn(self, pan: float, tilt: float) -> AuxExchange:
        """Look somewhere, rad."""
        ...

    def zoom(self, ratio: float) -> AuxExchange:
        """Magnify."""
        ...


class Vcc4Talk:
    """The Canon VC-C4; implements `HeadTalk`."""

    kind: HeadKind = HeadKind.VCC4

    def __init__(self, model: HeadModel) -> None:
        self.model = model
        self.ask_direction = AuxExchange(vcc4.request_direction(), vcc4.PLAIN_LENGTH, vcc4.DIRECTION_LENGTH)
        self.ask_zoom = AuxExchange(vcc4.request_zoom(), vcc4.PLAIN_LENGTH, vcc4.ZOOM_LENGTH)
        self.probe = self.ask_direction
        self.start: Sequence[AuxExchange] = (
            _plain(vcc4.power(True), patience=5.0),  # answered when it is on; the patience is ARIA's
            _plain(vcc4.host_control()),
            _plain(vcc4.initialise(), patience=2.5),
            _plain(vcc4.pan_slew(model.pan.fastest)),
            _plain(vcc4.tilt_slew(model.tilt.fastest)),
            _plain(vcc4.tilt_range(model.tilt.lowest, model.tilt.highest)),
        )
        self.stop: Sequence[AuxExchange] = (_plain(vcc4.stop()), _plain(vcc4.stop_zoom()))
        self._decoder = AnswerDecoder()

    @property
    def pending(self) -> int:
        """Bytes of an answer that is not complete yet."""
        return self._decoder.pending

    def hear(self, data: bytes) -> list[Heard]:
        """Take bytes from the head."""
        return [self._meaning(answer) for answer in self._decoder.receive(data)]

    def turn(self, pan: float, tilt: float) -> AuxExchange:
        """Look somewhere, rad."""
        return _plain(vcc4.move(self.model.pan.count(pan), self.model.tilt.count(tilt)))

    def zoom(self, ratio: float) -> AuxExchange:
        """Magnify."""
        return _plain(vcc4.zoom(self.model.lens.count_at(ratio)))

    def _meaning(self, answer: HeadAnswer) -> Heard:
        if answer.status != Status.OK:
            return Declined(answer.status == Status.BUSY, answer.status == Status.NOT_HOST_CONTROLLED)
        counts = vcc4.read_pair(answer.data)
        if counts is not None:
            return Direction(self.model.pan.angle(counts[0]), self.model.tilt.angle(counts[1]))
        position = vcc4.number(answer.data)
        return Obeyed() if position is None else Zoom(self.model.lens.ratio_at(position))


def _plain(request: bytes, patience: float = 0.5) -> AuxExchange:
    return AuxExchange(request, vcc4.PLAIN_LENGTH, vcc4.PLAIN_LENGTH, patience)


class ViscaTalk:
    """The Sony EVI-D30; implements `HeadTalk`."""

    kind: HeadKind = HeadKind.EVID30

    def __init__(self, model: HeadModel) -> None:
        self.model = model
        # The end in front closes what a head may have taken for the beginning of a message.
        self.probe = AuxExchange(bytes([visca.END]) + visca.set_address(), visca.ADDRESS_LENGTH, visca.ADDRESS_LENGTH)
        self.start: Sequence[AuxExchange] = (_command(visca.power(True)),)
        self.ask_direction = AuxExchange(visca.request_direction(), visca.ERROR_LENGTH, visca.DIRECTION_LENGTH)
        self.ask_zoom = AuxExchange(visca.request_zoom(), visca.ERROR_LENGTH, visca.ZOOM_LENGTH)
        self._speeds = model.pan.fastest, model.tilt.fastest
        self.stop: Sequence[AuxExchange] = (_command(visca.stop(*self._speeds)), _command(visca.stop_zoom()))
        self._decoder = ViscaDecoder()

    @property
    def pending(self) -> int:
        """Bytes of a message that is not complete yet."""
        return self._decoder.pending

    def hear(self, data: bytes) -> list[Heard]:
        """Take bytes from the head."""
        meanings = (self._meaning(message) for message in self._decoder.receive(data))
        return [meaning for meaning in meanings if meaning is not None]

    def turn(self, pan: float, tilt: float) -> AuxExchange:
        """Look somewhere, rad."""
        return _command(visca.move(self.model.pan.count(pan), self.model.tilt.count(tilt), *self._speeds))

    def zoom(self, ratio: float) -> AuxExchange:
        """Magnify."""
        return _command(visca.zoom(self.model.lens.count_at(ratio)))

    def _meaning(self, message: ViscaMessage) -> Heard | None:
        """None for what nobody has asked for: completions, and what the head did not understand."""
        header, payload = message
        if header == visca.BROADCAST:
            return Obeyed() if payload[:1] == visca.ADDRESS_SET else None
        kind, _ = visca.kind_and_socket(payload[0])
        if kind == visca.ACK:
            return Obeyed()
        if kind == visca.ERROR and len(payload) > 1:
            return Declined(payload[1] == Error.BUFFER_FULL, payload[1] == Error.NOT_EXECUTABLE)
        counts, position = visca.read_direction(payload), visca.read_zoom(payload)
        if counts is not None:
            return Direction(self.model.pan.angle(counts[0]), self.model.tilt.angle(counts[1]))
        return None if position is None else Zoom(self.model.lens.ratio_at(position))


def _command(request: bytes) -> AuxExchange:
    return AuxExchange(request, visca.ACK_LENGTH, visca.ACK_LENGTH)
