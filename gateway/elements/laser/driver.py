"""The driver of a SICK LMS 2xx on a cable of its own: bytes and time in, scans and bytes out. No port, no clock.

A laser may be in any state: silent or sending, at any rate, with half a command in its receiver. So at each rate in
turn it receives the request to stop until it acknowledges it. Then its settings are changed where they differ from
those wanted, and the scans are started.

Source: accessory sheet, section 1; the times are those that the clients there allow, or shorter where they only wait
for the human eye.
"""

from collections import Counter
from collections.abc import Generator, Mapping, Sequence
from math import inf
from typing import Any, NamedTuple

from configs import ConfigError
from gateway.events import ElementFound, ElementLost, ElementSilent, Event, LaserScanned
from gateway.settings import LaserSettings, LaserUnit
from p2os import Damaged, DecodeError
from p2os.accessories.lms import (
    ACCEPTED,
    MIRROR_PERIOD,
    MODE_OF_BAUD,
    PASSWORD,
    REFLECTOR_MODE,
    STATUS_POLLUTED,
    VARIANTS,
    LmsAnswerCode,
    LmsConfiguration,
    LmsMode,
    LmsRequestCode,
    Scan,
    Unit,
    Variant,
)
from p2os.accessories.lms_framing import LONGEST_TELEGRAM, LmsTelegram, LmsTelegramDecoder, encode
from p2os.framing import BITS_PER_BYTE

NAME = "laser"
RATES = (9600, 38400, 500000, 19200)
"""bit/s, in the order in which to look for it: after the power switch, and as clients leave it."""
USUAL_BAUD = 38400
"""bit/s; the most that every serial port can do."""
NO_RATE = (0,)

FIRST_WINDOW = 0.3
"""Seconds for the first answer at a rate."""
ANSWER_WINDOW = 3.0
CONFIGURING_WINDOW = 25.0
"""Seconds; the laser writes its settings down for good."""
TRIES = 3
"""Times that a command is sent before the search begins again."""
SETTLING = 0.3
"""Seconds after a change of the rate."""
PAUSE = 0.5
"""Seconds between two searches."""
LEAST_SILENCE = 1.0
SCANS_MISSED = 5
"""Without a scan for so many scans and for at least so many seconds the laser is lost."""
LONGEST_SILENCE = 0.5
"""Seconds between two calls, beyond which what waited on the line is old."""
SMOOTHING = 0.1
"""Part of each new interval in the mean between scans."""

STOP = encode(LmsRequestCode.MODE, bytes((LmsMode.ON_REQUEST,)))
START = encode(LmsRequestCode.MODE, bytes((LmsMode.CONTINUOUS,)))
INSTALL = encode(LmsRequestCode.MODE, bytes((LmsMode.INSTALLATION,)) + PASSWORD)


UNITS: Mapping[LaserUnit, Unit] = {
    LaserUnit.MILLIMETRE: Unit.MILLIMETRE,
    LaserUnit.CENTIMETRE: Unit.CENTIMETRE,
    LaserUnit.DECIMETRE: Unit.DECIMETRE,
}


class _LmsRequest(NamedTuple):
    """A command and what ends the waiting: an answer of this code, or time, s."""

    command: bytes
    answer: int | None
    window: float
    tries: int = TRIES


_Script = Generator[_LmsRequest, LmsTelegram, None]


class LaserDriver:
    """One scanner; an `ElementDriver`.

    variant, configuration: as the laser has them, once it is set up. type: what it calls itself.
    scan_period: mean time between scans, s; what the mirror and the line allow before the second one.
    """

    def __init__(self, settings: LaserSettings, *, has_rate: bool = True) -> None:
        """Make ready to look for a laser.

        Args:
            settings: How it is to scan.
            has_rate: The port has a rate to set; without one the laser keeps the rate that it has, unless the settings
                name another.
        Raises:
            ConfigError: The settings want what no laser has.
        """
        _check(settings)
        self._settings = settings
        self._variant = _variant(settings)
        self._has_rate = has_rate
        self._wanted_baud = settings.baud or (USUAL_BAUD if has_rate else 0)
        self._decoder = LmsTelegramDecoder(from_laser=True)
        self._events: list[Event] = []
        self._outgoing = b""
        self._plan: list[int] = []
        self._known: int | None = None
        self._script: _Script | None = None
        self._ask = _LmsRequest(b"", None, 0.0)
        self._tries_left = 0
        self._is_at_rate = False  # a sound telegram has come at this rate
        self._waits_for_end = False  # a telegram had begun when an answer was due
        self._last_run: float | None = None
        self._scan_at = 0.0
        self._is_polluted = False
        self._is_sending = False
        self._refused: list[str] = []
        self.baud = RATES[0] if has_rate else 0
        self.deadline = inf
        self.has_port = False
        self.is_connected = False
        self.damaged: Counter[str] = Counter()
        self.lost: Counter[str] = Counter()
        self.type = ""
        self.variant = self._variant
        self.configuration = LmsConfiguration()
        self.scan_period = 0.0

    # The port's side.

    @property
    def is_moving(self) -> bool:
        """Scans still arrive: the closing bytes must wait for the end of the scan on the line."""
        return self._is_sending

    @property
    def stopping_bytes(self) -> bytes:
        """The request that stops the scans."""
        return STOP

    @property
    def closing_bytes(self) -> bytes:
        """The request for the rate after power-on, so that any client finds the laser."""
        return encode(LmsRequestCode.MODE, bytes((MODE_OF_BAUD[RATES[0]],))) if self._has_rate else b""

    def port_opened(self, now: float) -> None:
        """Begin: the port is open."""
        self._last_run = now
        self.has_port = True
        self._search(now)

    def port_lost(self, reason: str, now: float) -> None:
        """Note that the port is lost, and why. `receive` reports what follows."""
        self._last_run = now
        self.has_port = False
        self._lose(reason)
        self._script = None
        self.deadline = inf

    def receive(self, data: bytes, now: float) -> list[Event]:
        """Take bytes as read; none lets time pass. now: steady time, s."""
        if self._last_run is not None and now - self._last_run > LONGEST_SILENCE:
            data = b""  # of unknown age, and would be stamped with the present time
            self._decoder = LmsTelegramDecoder(from_laser=True)
            self._scan_at = 0.0
            if self.is_connected:
                self.deadline = now + self._patience
        self._last_run = now
        for found in self._decoder.receive(data, now):
            if isinstance(found, LmsTelegram):
                self._take(found, now)
            elif isinstance(found, Damaged) and self.is_connected:
                self.damaged[found.reason.value] += 1
        if self.has_port and now >= self.deadline:
            self._run_late(now)
        events = self._events[:]
        self._events.clear()
        return events

    def bytes_due(self, now: float) -> bytes:
        """Take what must be written now."""
        due, self._outgoing = self._outgoing, b""
        return due if self.has_port else b""

    # The bus's side.

    def faults(self) -> Sequence[str]:
        """Return what is wrong with the laser, a sentence each."""
        if not self.is_connected:
            return ["the laser does not answer" if self.has_port else "the laser's port is gone"]
        found = list(self._refused)
        return [*found, "the laser's window is dirty"] if self._is_polluted else found

    def figures(self) -> Mapping[str, Any]:
        """Return the values for diagnostics, beside the counters."""
        rate = 1.0 / self.scan_period if self.is_connected else 0.0
        return {
            "type": self.type,
            "scans per second": round(rate, 2),
            "angle": f"{self.variant.angle_deg} deg",
            "resolution": f"{self.variant.resolution_cdeg / 100:g} deg",
        }

    def halt(self, now: float) -> None:
        """Do nothing: a laser has no dangerous motion."""

    # Inside.

    def _search(self, now: float) -> None:
        """Begin with the rate at which the laser answered last."""
        rates = RATES if self._has_rate else NO_RATE
        self._plan = sorted(rates, key=lambda rate: rate != self._known)
        self._decoder = LmsTelegramDecoder(from_laser=True)
        self._try_next(now)

    def _try_next(self, now: float) -> None:
        if not self._plan:
            self._events.append(ElementSilent(NAME))
            self._script = None
            self.deadline = now + PAUSE
            return
        self.baud = self._plan.pop(0)
        self._is_at_rate = False
        self._script = self._set_up()
        self._put(next(self._script), now)

    def _put(self, ask: _LmsRequest, now: float) -> None:
        self._ask = ask
        self._tries_left = ask.tries
        self._send(now)

    def _send(self, now: float) -> None:
        self._tries_left -= 1
        self._waits_for_end = False
        self._outgoing = self._ask.command
        sending = len(self._ask.command) * BITS_PER_BYTE / self.baud if self.baud else 0.0
        self.deadline = now + sending + self._ask.window

    def _run_late(self, now: float) -> None:
        """Act on a timeout."""
        if self.is_connected:
            self._lose("the laser fell silent")
            self._search(now)
        elif self._script is None:
            self._search(now)
        elif self._ask.answer is None:
            self._go_on(LmsTelegram(0), now)
        elif self._decoder.is_within_telegram and not self._waits_for_end:
            self._waits_for_end = True  # something long may be on the line, and the answer behind it
            self.deadline = now + self._line_time(LONGEST_TELEGRAM) + FIRST_WINDOW
        elif self._tries_left:
            self._send(now)
        else:
            self._try_next(now)

    def _take(self, telegram: LmsTelegram, now: float) -> None:
        if telegram.code == LmsAnswerCode.POWER_ON and self.is_connected:
            self._lose("the laser was switched on again")
            self._known = RATES[0] if self._has_rate else None
            self._search(now)
        elif self.is_connected:
            self._take_scan(telegram, now)
        elif self._script is None:
            return
        elif telegram.code == self._ask.answer:
            self._go_on(telegram, now)
        elif telegram.code == LmsAnswerCode.NOT_UNDERSTOOD:
            self.deadline = now  # the next try at once
        elif not self._is_at_rate:
            # This is the rate. The answer follows the scan that is on the line when the command arrives.
            self._is_at_rate = True
            self._tries_left = TRIES
            self.deadline = max(self.deadline, now + self._line_time(LONGEST_TELEGRAM) + FIRST_WINDOW)

    def _go_on(self, telegram: LmsTelegram, now: float) -> None:
        assert self._script is not None
        try:
            self._put(self._script.send(telegram), now)
        except StopIteration:
            self._script = None
            self.deadline = now + self._patience
        except DecodeError:
            self.damaged["content"] += 1
            self._try_next(now)

    def _set_up(self) -> _Script:
        """Stop the laser's output, set the rate and the settings wanted, and start the scans."""
        # One try more than at a known rate: half a command in its receiver makes it ignore the first.
        yield _LmsRequest(STOP, LmsAnswerCode.MODE, FIRST_WINDOW + self._line_time(len(STOP)), tries=2)
        self._known = self.baud
        if self._wanted_baud not in (self.baud, 0):
            yield _LmsRequest(
                encode(LmsRequestCode.MODE, bytes((MODE_OF_BAUD[self._wanted_baud],))),
                LmsAnswerCode.MODE,
                ANSWER_WINDOW,
            )
            yield _LmsRequest(b"", None, SETTLING)
            if self._has_rate:
                self.baud = self._known = self._wanted_baud
        self.type = (yield _LmsRequest(encode(LmsRequestCode.TYPE), LmsAnswerCode.TYPE, ANSWER_WINDOW)).data.decode(
            "ascii", "replace"
        )
        yield from self._set_variant()
        yield from self._configure()
        yield _LmsRequest(START, LmsAnswerCode.MODE, ANSWER_WINDOW)
        self._is_sending = True
        self.is_connected = True
        self.scan_period = max(self.variant.passes * MIRROR_PERIOD, self._line_time(2 * self.variant.beams))
        self._scan_at = 0.0
        self._events.append(ElementFound(NAME, self.baud))

    def _set_variant(self) -> _Script:
        wanted = self._variant
        self._refused.clear()
        answer = yield _LmsRequest(encode(LmsRequestCode.STATUS), LmsAnswerCode.STATUS, ANSWER_WINDOW)
        self.variant = Variant.read(LmsAnswerCode.STATUS, answer.data)
        if self.variant != wanted:
            answer = yield _LmsRequest(
                encode(LmsRequestCode.VARIANT, wanted.pack()), LmsAnswerCode.VARIANT, ANSWER_WINDOW
            )
            self.variant = Variant.read(LmsAnswerCode.VARIANT, answer.data)
            if answer.data[0] != ACCEPTED:
                degrees = f"{wanted.angle_deg} degrees by {wanted.resolution_cdeg / 100:g}"
                self._refused.append(
                    f"the laser does not scan {degrees}; change angle_deg or resolution_deg in its settings"
                )

    def _configure(self) -> _Script:
        answer = yield _LmsRequest(encode(LmsRequestCode.GET_CONFIGURATION), LmsAnswerCode.CONFIGURATION, ANSWER_WINDOW)
        self.configuration = LmsConfiguration.unpack(answer.data)
        wanted = self.configuration._replace(
            unit=UNITS[self._settings.unit], measuring_mode=REFLECTOR_MODE[self._settings.reflector_bits]
        )
        if wanted != self.configuration:
            yield _LmsRequest(INSTALL, LmsAnswerCode.MODE, ANSWER_WINDOW)
            answer = yield _LmsRequest(
                encode(LmsRequestCode.SET_CONFIGURATION, wanted.pack()), LmsAnswerCode.CONFIGURED, CONFIGURING_WINDOW
            )
            if answer.data[:1] == bytes([ACCEPTED]):
                self.configuration = wanted
            else:
                self._refused.append(
                    "the laser refuses the unit or the reflector bits of its settings, and keeps its own; "
                    "change unit or reflector_bits"
                )

    def _take_scan(self, telegram: LmsTelegram, now: float) -> None:
        if telegram.code == LmsAnswerCode.MODE:
            self._is_sending = False
            return
        if telegram.code not in (LmsAnswerCode.SCAN, LmsAnswerCode.PARTIAL_SCAN):
            return
        try:
            scan = Scan.read(telegram)
        except DecodeError:
            self.damaged["content"] += 1
            return
        if scan.first + len(scan.words) > self.variant.beams:
            self.damaged["content"] += 1
            return
        if self._scan_at:
            self.scan_period += SMOOTHING * (scan.began - self._scan_at - self.scan_period)
        self._scan_at = scan.began
        self._is_polluted = bool(scan.status & STATUS_POLLUTED)
        self.deadline = now + self._patience
        age = now - scan.began
        self._events.append(
            LaserScanned(scan, self.variant, self.configuration, age + self._measuring, self.scan_period)
        )

    @property
    def _measuring(self) -> float:
        """Seconds from the first beam to the first byte: the mirror's turns for one scan."""
        return self.variant.passes * MIRROR_PERIOD

    @property
    def _patience(self) -> float:
        """Seconds without a scan after which the laser is lost."""
        return max(LEAST_SILENCE, SCANS_MISSED * max(self.scan_period, self._line_time(LONGEST_TELEGRAM)))

    def _line_time(self, size: int) -> float:
        """Return the seconds that so many bytes take."""
        return size * BITS_PER_BYTE / self.baud if self.baud else 0.0

    def _lose(self, reason: str) -> None:
        if self.is_connected:
            self.lost[reason] += 1
            self._events.append(ElementLost(NAME, reason))
        self.is_connected = self._is_sending = False
        self._outgoing = b""


def _variant(settings: LaserSettings) -> Variant:
    variant = Variant(settings.angle_deg, round(settings.resolution_deg * 100))
    if variant not in VARIANTS:
        known = ", ".join(f"{each.angle_deg} by {each.resolution_cdeg / 100:g}" for each in VARIANTS)
        raise ConfigError(
            f"a laser has no {settings.angle_deg} degrees by {settings.resolution_deg:g}; in its settings make "
            f"angle_deg and resolution_deg one of {known}"
        )
    return variant


def _check(settings: LaserSettings) -> None:
    if settings.baud is not None and settings.baud not in RATES:
        raise ConfigError(f"a laser has no rate {settings.baud}; make baud one of {', '.join(map(str, sorted(RATES)))}")
    if settings.reflector_bits not in REFLECTOR_MODE:
        raise ConfigError(f"reflector_bits of a laser must be 1, 2 or 3, not {settings.reflector_bits}")
