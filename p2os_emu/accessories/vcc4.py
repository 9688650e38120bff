"""The Canon VC-C4 camera head: commands and answers.

It answers every command at once: one well-known client takes a camera that is silent for 400 ms for one that cannot
answer. Switching on and looking for its zero take their time all the same: the head stands until it is on, and while it
looks for its zero, everything that would move it is answered with BUSY.

Source: fact sheet of accessories, section 3. Where that is silent: without power, and before host control is asked for,
every command but POWER (and CONTROL_MODE, with power) is answered with NOT_HOST_CONTROLLED; what is unknown or outside
its range with BAD_PARAMETER. Two clients' ways of asking for the zoom (0xA4 and 0xB4) are both answered.
"""

from collections.abc import Callable, Mapping

from p2os.accessories.head_model import HeadAxis, HeadModel
from p2os.accessories.vcc4 import (
    HOST_CONTROL,
    NARROW_END,
    OFF,
    ON,
    PRODUCT,
    REMOTE_CONTROL,
    SETTINGS,
    START,
    Code,
    HeadFrame,
    Status,
    Vcc4Decoder,
    encode_answer,
    pack_counts,
    read_counts,
)
from p2os_emu.accessories.head import Head, HeadServo

_Answer = tuple[Status, bytes]
_DONE: _Answer = Status.OK, b""
_BAD: _Answer = Status.BAD_PARAMETER, b""


class Vcc4:
    """A head on a line of 9600 bit/s; implements `Device`.

    head: where it looks. is_on: it has power. is_host_controlled: it obeys the line.
    """

    def __init__(self, model: HeadModel) -> None:
        self.head = Head(model)
        self.is_on = model.starts_on
        self.is_host_controlled = False
        self._model = model
        self._decoder = Vcc4Decoder(from_head=False)
        self._out = bytearray()
        self._powering = 0.0  # s left until the head can move
        self._initialising = 0.0  # s left until it has found its zero
        self._tilt_range = model.tilt.lowest, model.tilt.highest
        self._handlers: Mapping[int, Callable[[bytes], _Answer]] = {
            Code.CONTROL_MODE: self._set_control,
            Code.INITIALISE: self._initialise,
            Code.PAN_SLEW: lambda given: self._set_slew(read_counts(Code.PAN_SLEW, given), self.head.pan, model.pan),
            Code.TILT_SLEW: lambda given: self._set_slew(
                read_counts(Code.TILT_SLEW, given), self.head.tilt, model.tilt
            ),
            Code.MOVE: self._move,
            Code.STOP: self._stop,
            Code.TILT_RANGE: self._set_tilt_range,
            Code.DIRECTION: self._answer_direction,
            Code.ZOOM: self._zoom,
            Code.STOP_ZOOM: self._stop_zoom,
            Code.ZOOM_REQUEST: self._answer_zoom,
            Code.ZOOM_POSITION: self._answer_zoom,
            Code.PRODUCT: lambda given: (Status.OK, PRODUCT),
        }

    @property
    def baud(self) -> int:
        """Rate of its port, bit/s."""
        return self._model.baud

    @property
    def is_initialising(self) -> bool:
        """It looks for its zero, and obeys nothing that would move it."""
        return self._initialising > 0.0

    def receive(self, data: bytes) -> None:
        """Take bytes from the line."""
        for command in self._decoder.receive(data):
            self._take(command)

    def step(self, dt: float) -> bytes:
        """Let time pass, s; returns the answers that are ready."""
        self._powering = max(0.0, self._powering - dt)
        self._initialising = max(0.0, self._initialising - dt)
        if self.is_on and self._powering == 0.0:
            self.head.step(dt)
        out = bytes(self._out)
        self._out.clear()
        return out

    def _answer(self, answer: _Answer) -> None:
        self._out += encode_answer(*answer)

    def _take(self, command: HeadFrame) -> None:
        code, given = command
        if code == Code.POWER:
            self._switch(given)
        elif not self.is_on or not (self.is_host_controlled or code == Code.CONTROL_MODE):
            self._answer((Status.NOT_HOST_CONTROLLED, b""))
        elif code in SETTINGS:
            self._answer(_DONE if given in SETTINGS[code] else _BAD)
        else:
            self._answer(self._handlers[code](given) if code in self._handlers else _BAD)

    def _switch(self, given: bytes) -> None:
        if given == ON and not self.is_on:
            self.is_on = True
            self._powering = self._model.power_on_s
        if given == OFF:
            self.is_on = self.is_host_controlled = False
            self._initialising = 0.0
            self.head.stop()
            self.head.lens.drive(0)
        self._answer(_DONE if given in (ON, OFF) else _BAD)

    def _set_control(self, given: bytes) -> _Answer:
        if given not in (HOST_CONTROL, REMOTE_CONTROL):
            return _BAD
        self.is_host_controlled = given == HOST_CONTROL
        return _DONE

    def _initialise(self, given: bytes) -> _Answer:
        if given != START:
            return _BAD
        if self.is_initialising:
            return _DONE  # one well-known client asks twice, and never gets over a camera that is busy for long
        self._initialising = self._powering + self._model.initialise_s
        self.head.home()
        return _DONE

    def _set_slew(self, speed: tuple[int, ...] | None, servo: HeadServo, axis: HeadAxis) -> _Answer:
        if speed is None or not axis.slowest <= speed[0] <= axis.fastest:
            return _BAD
        if not self.is_initialising:
            servo.speed = axis.speed(speed[0])
        return _DONE

    def _move(self, given: bytes) -> _Answer:
        if self.is_initialising:
            return Status.BUSY, b""
        counts = read_counts(Code.MOVE, given)
        if counts is None or not self._reaches(*counts):
            return _BAD
        self.head.pan.go(self._model.pan.angle(counts[0]))
        self.head.tilt.go(self._model.tilt.angle(counts[1]))
        return _DONE

    def _reaches(self, pan: int, tilt: int) -> bool:
        lowest, highest = self._tilt_range
        return self._model.pan.lowest <= pan <= self._model.pan.highest and lowest <= tilt <= highest

    def _stop(self, given: bytes) -> _Answer:
        if self.is_initialising:
            return Status.BUSY, b""
        self.head.stop()
        return _DONE

    def _set_tilt_range(self, given: bytes) -> _Answer:
        counts = read_counts(Code.TILT_RANGE, given)
        if counts is None:
            return _BAD
        lowest, highest = counts
        if not self._model.tilt.lowest <= lowest <= highest <= self._model.tilt.highest:
            return _BAD
        self._tilt_range = lowest, highest
        return _DONE

    def _answer_direction(self, given: bytes) -> _Answer:
        pan = self._model.pan.count(self.head.pan.position)
        tilt = self._model.tilt.count(self.head.tilt.position)
        return Status.OK, pack_counts(Code.DIRECTION, pan, tilt)

    def _zoom(self, given: bytes) -> _Answer:
        position = read_counts(Code.ZOOM, given)
        if position is None or position[0] > self._model.lens.counts:
            return _BAD
        self.head.lens.go(position[0])
        return _DONE

    def _stop_zoom(self, given: bytes) -> _Answer:
        self.head.lens.drive(0)
        return _DONE

    def _answer_zoom(self, given: bytes) -> _Answer:
        lens = self._model.lens
        position = lens.counts if given == NARROW_END else round(self.head.lens.position)
        return Status.OK, pack_counts(Code.ZOOM_REQUEST, position)
