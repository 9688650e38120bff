"""The SICK LMS200 laser scanner: receives commands, sends scans at the rate of its mirror or its line.

It knows no port and no clock, and speaks at the rate it was told, starting from that of its file. A scan is measured
when its telegram begins. Source: accessory sheet, section 1; what that leaves open is said where it is decided.
"""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import cos, inf, nan, radians

import numpy as np
from numpy.typing import NDArray

from p2os import Damage, Damaged, DecodeError, LaserMount
from p2os.accessories.lms import (
    BAUD_MODES,
    MIRROR_PERIOD,
    PASSWORD,
    REFLECTOR_MODE,
    STATUS_OK,
    STATUS_POLLUTED,
    VARIANTS,
    LmsAnswerCode,
    LmsConfiguration,
    LmsMode,
    LmsRequestCode,
    ModeResult,
    Variant,
    read_segment,
)
from p2os.accessories.lms_framing import ACK, NAK, LmsTelegram, LmsTelegramDecoder, encode
from p2os.framing import BITS_PER_BYTE
from p2os_emu.body import Body, Echoes, ScanBeams

_ACK, _NAK = bytes((ACK,)), bytes((NAK,))
_REFLECTING_MODES = frozenset(REFLECTOR_MODE.values())


@dataclass(frozen=True, slots=True)
class ScannerModel:
    """What `configs/accessories/lms200.toml` says; its comments explain each key."""

    type: str
    version: str
    baud: int
    boot_s: float
    angle_deg: int
    resolution_deg: float
    overhead_s: float
    height_m: float
    noise_m: float
    reach_m: float
    reflector_reach_m: float
    reflector_slant_deg: float
    polluted_from: float

    @property
    def variant(self) -> Variant:
        """The beams after the power switch."""
        return Variant(self.angle_deg, round(self.resolution_deg * 100))


@dataclass(frozen=True, slots=True)
class _BeamSegment:
    """The beams that are sent: index of the first, how many; whether as a partial scan."""

    first: int
    count: int
    is_partial: bool


class Lms200:
    """A scanner as it is after the power switch; implements `Device`.

    baud: of its port, bit/s. dirt: the part of the light that the window takes, 0 to 1. configuration, variant: as set.
    """

    def __init__(
        self, model: ScannerModel, mount: LaserMount, body: Body, has_power: Callable[[], bool] = lambda: True
    ) -> None:
        """Mount a scanner on a robot.

        Args:
            model: What it is.
            mount: Where it sits; a flipped one hangs upside down, and its beams come from left to right.
            body: Of the robot.
            has_power: Whether the robot's power output that feeds it is on.
        """
        self.baud = model.baud
        self.dirt = 0.0
        self.configuration = LmsConfiguration()
        self.variant = model.variant
        self._model = model
        self._mount = mount
        self._body = body
        self._has_power = has_power
        self._had_power = True
        self._time = 0.0
        self._decoder = LmsTelegramDecoder(from_laser=False)
        self._ready_at = model.boot_s
        self._is_new = True  # it has not yet said that it is there
        self._is_installing = False
        self._segment: _BeamSegment | None = None  # while scans are sent unasked
        self._scan_at = 0.0
        self._answers: deque[bytes] = deque()
        self._free_at = 0.0  # when the line has taken everything sent so far
        self._next_baud: int | None = None
        self._handlers: Mapping[int, Callable[[bytes], None]] = {
            LmsRequestCode.RESET: self._reset,
            LmsRequestCode.MODE: self._set_mode,
            LmsRequestCode.STATUS: self._answer_status,
            LmsRequestCode.TYPE: self._answer_type,
            LmsRequestCode.VARIANT: self._set_variant,
            LmsRequestCode.GET_CONFIGURATION: self._answer_configuration,
            LmsRequestCode.SET_CONFIGURATION: self._configure,
        }

    @property
    def mount(self) -> LaserMount:
        """Where it sits on the robot, m and rad."""
        return self._mount

    @property
    def height(self) -> float:
        """Of its plane of beams above the floor, m."""
        return self._model.height_m

    @property
    def is_powered(self) -> bool:
        """The robot's power output that feeds it is on."""
        return self._has_power()

    @property
    def is_scanning(self) -> bool:
        """Whether it sends scans continuously."""
        return self._segment is not None and self._time >= self._ready_at and self._has_power()

    @property
    def silence(self) -> float:
        """Time in which it sends nothing unless it or the robot receives something, s."""
        has_power = self._has_power()
        if has_power != self._had_power or self._answers or self._next_baud is not None:
            return 0.0
        if not has_power:
            return inf
        if self._time < self._ready_at:
            return self._ready_at - self._time
        if self._is_new:
            return 0.0
        return inf if self._segment is None else max(self._free_at, self._scan_at) - self._time

    def receive(self, data: bytes) -> None:
        """Take bytes from the line; they are lost without power and while it boots."""
        if self._time < self._ready_at or not self._has_power():
            return
        for found in self._decoder.receive(data, self._time):
            match found:
                case LmsTelegram(code, inside):
                    self._handlers.get(code, self._reject)(inside)
                case Damaged(_, Damage.CHECKSUM):
                    self._answers.append(_NAK)

    def step(self, dt: float) -> bytes:
        """Let time pass, s; returns the telegrams that begin now."""
        self._time += dt
        if not self._has_power():
            self._had_power = False
            return b""
        if not self._had_power:
            self._had_power = True
            self._reset(b"")
        if self._next_baud is not None and not self._answers and self._time >= self._free_at + dt:
            self.baud, self._next_baud = self._next_baud, None
        if self._time < self._ready_at:
            return b""
        if self._is_new:
            self._is_new = False
            self._answer(LmsAnswerCode.POWER_ON, self._model.type.encode())
        sent = b""
        while self._answers and self._time >= self._free_at:
            sent += self._send(self._answers.popleft())
        is_due = self._time >= max(self._free_at, self._scan_at) and self._next_baud is None and not self._answers
        if self._segment is not None and is_due:
            sent += self._send_scan(self._segment)
        return sent

    # Commands.

    def _reset(self, inside: bytes) -> None:
        self.baud = self._model.baud
        self.variant = self._model.variant
        self._segment, self._next_baud, self._is_installing = None, None, False
        self._answers.clear()
        self._is_new = True
        self._ready_at = self._time + self._model.boot_s

    def _set_mode(self, inside: bytes) -> None:
        mode, rest = inside[:1], inside[1:]
        result = ModeResult.FAULT
        if mode == bytes((LmsMode.INSTALLATION,)):
            result = ModeResult.OK if rest == PASSWORD else ModeResult.WRONG_PASSWORD
            if result is ModeResult.OK:
                self._measure(None, is_installing=True)
        elif mode == bytes((LmsMode.CONTINUOUS,)):
            result = ModeResult.OK
            self._measure(_BeamSegment(0, self.variant.beams, is_partial=False))
        elif mode == bytes((LmsMode.ON_REQUEST,)):
            result = ModeResult.OK
            self._measure(None)
        elif mode == bytes((LmsMode.CONTINUOUS_PARTIAL,)):
            segment = read_segment(rest)
            if segment is not None and segment.stop <= self.variant.beams:
                result = ModeResult.OK
                self._measure(_BeamSegment(segment.start, len(segment), is_partial=True))
        elif mode and mode[0] in BAUD_MODES:
            result = ModeResult.OK
            self._next_baud = BAUD_MODES[mode[0]]
        self._answer(LmsAnswerCode.MODE, bytes((result,)))

    def _measure(self, segment: _BeamSegment | None, *, is_installing: bool = False) -> None:
        """Send these beams from now on; whoever asks for scans leaves the installation mode."""
        self._segment = segment
        self._is_installing = is_installing
        self._scan_at = self._time

    def _answer_status(self, inside: bytes) -> None:
        self._answer(LmsAnswerCode.STATUS, self.variant.status_data(self._model.version.encode()))

    def _answer_type(self, inside: bytes) -> None:
        self._answer(LmsAnswerCode.TYPE, self._model.type.encode())

    def _set_variant(self, inside: bytes) -> None:
        wanted = self._wanted_variant(inside)
        if wanted in VARIANTS:
            self.variant = wanted
            if self._segment is not None:
                self._segment = _BeamSegment(0, wanted.beams, is_partial=False)
        self._answer(LmsAnswerCode.VARIANT, bytes((wanted in VARIANTS,)) + self.variant.pack())

    def _wanted_variant(self, inside: bytes) -> Variant:
        """One widespread client sends a resolution of zero and means the one that there is, or one degree."""
        wanted = Variant.read(LmsRequestCode.VARIANT, inside)
        if wanted.resolution_cdeg:
            return wanted
        kept = Variant(wanted.angle_deg, self.variant.resolution_cdeg)
        return kept if kept in VARIANTS else Variant(wanted.angle_deg)

    def _answer_configuration(self, inside: bytes) -> None:
        self._answer(LmsAnswerCode.CONFIGURATION, self.configuration.pack())

    def _configure(self, inside: bytes) -> None:
        if not self._is_installing:
            self._reject(inside)
            return
        try:
            self.configuration = LmsConfiguration.unpack(inside, self.configuration)
        except DecodeError:
            self._answer(LmsAnswerCode.CONFIGURED, self.configuration.answer(accepted=False))
            return
        self._answer(LmsAnswerCode.CONFIGURED, self.configuration.answer(accepted=True))

    def _reject(self, inside: bytes) -> None:
        self._answer(LmsAnswerCode.NOT_UNDERSTOOD, b"")

    # Answers and scans.

    @property
    def _status(self) -> int:
        return STATUS_OK | (STATUS_POLLUTED if self.dirt >= self._model.polluted_from else 0)

    def _answer(self, code: int, data: bytes) -> None:
        """Answer as soon as the line is free; an unasked telegram is not acknowledged before."""
        prefix = b"" if code == LmsAnswerCode.POWER_ON else _ACK
        self._answers.append(prefix + encode(code, data, self._status))

    def _send(self, telegram: bytes) -> bytes:
        self._free_at = max(self._free_at, self._time) + len(telegram) * BITS_PER_BYTE / self.baud
        return telegram

    def _send_scan(self, segment: _BeamSegment) -> bytes:
        values, is_partial = self._values(segment), segment.is_partial
        data = self.configuration.scan_data(values, segment.first if is_partial else None)
        telegram = encode(LmsAnswerCode.PARTIAL_SCAN if is_partial else LmsAnswerCode.SCAN, data, self._status)
        on_the_line = len(telegram) * BITS_PER_BYTE / self.baud
        period = max(self.variant.passes * MIRROR_PERIOD, on_the_line) + self._model.overhead_s
        # The mirror goes on turning: a scan that begins late does not put off the next one.
        self._scan_at = max(self._scan_at + period, self._time)
        return self._send(telegram)

    def _values(self, segment: _BeamSegment) -> bytes:
        """Measure: distances and flags as they are sent."""
        model = self._model
        echoes = self._body.scan(self._beams(segment))
        reach = model.reach_m * np.sqrt(echoes.cosines)
        shines = echoes.reflects & (echoes.cosines >= cos(radians(model.reflector_slant_deg)))
        reach[shines] = model.reflector_reach_m
        ranges = echoes.ranges.copy()
        ranges[ranges > reach * (1.0 - self.dirt)] = inf
        if self.dirt >= 1.0:
            ranges[:] = nan
        return self.configuration.pack_values(ranges, self._flags(echoes, shines))

    def _flags(self, echoes: Echoes, shines: NDArray[np.bool_]) -> NDArray[np.uint16]:
        """How strongly reflectors shine, in as many bits as the measuring mode has."""
        strongest = (1 << self.configuration.flag_bits) - 1
        if self.configuration.measuring_mode not in _REFLECTING_MODES:
            return np.zeros(len(shines), np.uint16)
        return np.where(shines, np.ceil(strongest * echoes.cosines), 0).astype(np.uint16)

    def _beams(self, segment: _BeamSegment) -> ScanBeams:
        mount, variant, model = self._mount, self.variant, self._model
        turn = -1.0 if mount.flipped else 1.0
        first = variant.first_bearing + segment.first * variant.resolution
        return ScanBeams(
            x=mount.x,
            y=mount.y,
            height=model.height_m,
            first=mount.heading + turn * first,
            step=turn * variant.resolution,
            count=segment.count,
            reach=model.reflector_reach_m,
            noise=model.noise_m,
        )
