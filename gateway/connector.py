"""Finds the robot and its rate on a line. No port and no clock.

A robot may have been left in any state: streaming, moving, waiting, at another rate, half a frame in its receiver. Any
packet it hears makes it resume what its watchdog stopped, and SYNC0 is a PULSE to a robot that is open. So each round
on a rate is:

    STOP, CLOSE | silence, longer than a receiver keeps half a frame | STOP, CLOSE, SYNC0 | answers

Whatever state the robot is in, the first command it understands is STOP: if half a frame swallows the first pair, the
silence ends that frame and the second pair is heard. A radio modem is dialled before that, unless it was just in use.

Robot simulators of the MobileSim family take every packet of a new connection for a SYNC: they echo the STOP as
`FA FB 03 1D 00 1D`, obey the CLOSE, and close the connection. So on a line without a rate (TCP), after that echo or a
hang-up that follows CLOSE in an unopened session, the next connection begins with

    silence of our own | SYNC0 | answers

SYNC0 leaves only if nothing at all was received meanwhile. An open robot sends a SIP in every cycle, so a line that is
silent for `LISTENING` leads to a robot that is not open, and to that one SYNC0 is no PULSE. One byte is enough to begin
a round with STOP instead. Lines with a rate (serial ports, adapters, radio modems) are never connected without STOP. If
SYNC0 alone fails, the next attempt is a round with STOP again.
"""

import random
from collections.abc import Sequence
from enum import Enum, auto
from math import inf

from gateway.events import SweepFailed
from gateway.line import CABLE, LineKind, ModemDialler
from gateway.outbox import Outbox
from p2os import PARTIAL_TIMEOUT, Command, HostHandshake, Identity, encode_command

RATES = (9600, 38400, 19200, 115200, 57600)
"""bit/s, in the order in which existing drivers look for a robot. Source: fact sheet section 2."""
AS_IT_IS = 0
"""The rate of a line that has none to set, such as a socket."""

STOP = encode_command(Command.STOP)
CLOSE = encode_command(Command.CLOSE)

ECHO = bytes([Command.STOP])
"""Payload of the frame with which simulators echo STOP; robots send no such frame."""

ROUNDS_AFTER_FRAMES = 3
"""Rounds on a rate at which sound frames come, before the next rate."""
PROBE_AT, PROBE_EVERY = 2, 8
"""Sweep in which other rates are probed for the first time, and sweeps until it is done again."""
REST = 0.5
"""Seconds before an unwanted robot is asked again."""
LISTENING = 0.35
"""Seconds of silence that show that the robot is not open: three SIP cycles and some delay of the network."""
SIMULATOR_WINDOW = 1.0
"""Seconds for each answer to a SYNC after such a silence; these simulators answer between two steps of their world."""


class _ConnectPhase(Enum):
    PAUSED = auto()
    DIALLING = auto()
    SILENT = auto()  # the first STOP and CLOSE are written, and nothing else for a while
    LISTENING = auto()  # nothing has been sent on this connection
    SYNCING = auto()


class Connector:
    """Sweeps the rates until a robot has identified itself.

    baud: bit/s that the line must have now; `AS_IT_IS` where there is nothing to set.
    hangs_up_on_close: the peer closed the connection after CLOSE, or echoed STOP, as some simulators do.
    deadline: when `watch` is due, s.
    """

    def __init__(
        self,
        rates: Sequence[int],
        outbox: Outbox,
        rng: random.Random,
        line: LineKind = CABLE,
        probe_rates: Sequence[int] = (),
    ) -> None:
        """Prepare to look for a robot.

        Args:
            rates: bit/s to try.
            outbox: Takes frames for the robot.
            rng: Of the pauses.
            line: What leads to the robot.
            probe_rates: bit/s at which a robot is not connected, but looked for now and then after the others, so that
                a person can be told.
        """
        self._rates = tuple(rates)
        self._probe_rates = tuple(probe_rates)
        self._sweeps = 0
        self._answers_at: int | None = None
        self._line = line
        self._dialler = ModemDialler(line.dial) if line.dial else None
        self._must_dial = self._dialler is not None
        self._backoff = line.first_backoff
        self._outbox = outbox
        self._rng = rng
        self._known: int | None = None
        self._plan: list[int] = []
        self._handshake = HostHandshake()
        self._phase = _ConnectPhase.PAUSED
        self._window = line.first_window
        self._has_frames = False
        self._rounds_left = 0
        self._bytes_heard = self._frames_heard = 0
        outbox.share = line.share
        self._is_bare = False  # this attempt sends SYNC0 without STOP and CLOSE before it
        self.hangs_up_on_close = False
        self.baud = self._rates[0]
        self.deadline = inf

    def begin(self, now: float, *, is_new_connection: bool = False) -> None:
        """Start a sweep at once; try the rate of the last robot before each other rate.

        Args:
            now: Steady time, s.
            is_new_connection: The port has just been opened, and nothing was sent on it.
        """
        self._bytes_heard = self._frames_heard = 0
        if is_new_connection and self.hangs_up_on_close:
            self._plan = []
            self._listen(now)
            return
        others = [rate for rate in self._rates if rate != self._known]
        if self._known is None:
            self._plan = others
        else:
            self._plan = [rate for other in others for rate in (self._known, other)] or [self._known]
        self._sweeps += 1
        if self._probe_rates and self._sweeps % PROBE_EVERY == PROBE_AT:
            self._answers_at = None
            self._plan += self._probe_rates
        self._next_rate(now)

    def hear(self, data: bytes, now: float) -> None:
        """Take bytes of any kind, to detect a silent line and the reply of a modem."""
        self._bytes_heard += len(data)
        if data and self._phase is _ConnectPhase.LISTENING:
            self._start_round(now)  # it talks without being asked, so it may be an open robot
        if self._dialler is not None and self._phase is _ConnectPhase.DIALLING:
            self._dialler.receive(data)
            if self._dialler.has_answered:
                self._start_round(now)

    def receive(self, payload: bytes, now: float) -> Identity | None:
        """Take the payload of a sound frame; return the robot's identity once it has given it."""
        self._frames_heard += 1
        if self.baud not in self._rates and self.baud != self._known:  # a probe
            self._answers_at = self.baud
            return None
        if not self._has_frames:
            self._has_frames = True
            self._rounds_left = ROUNDS_AFTER_FRAMES
        if payload == ECHO and self._rates == (AS_IT_IS,):
            self.hangs_up_on_close = True  # it may be slow to close the connection, and this one is given up before
        if self._phase is not _ConnectPhase.SYNCING:
            return None
        before = self._handshake.request()
        identity = self._handshake.receive(payload)
        following = self._handshake.request()
        if identity is not None:
            self.hangs_up_on_close = self._is_bare
            self._known = self.baud
            self._window = self._line.first_window
            self._backoff = self._line.first_backoff
            self._must_dial = False
            self.deadline = inf
        elif following != before:
            self._outbox.put("sync", following)
            window = SIMULATOR_WINDOW if self._is_bare else self._line.step_window
            self.deadline = now + self._outbox.time_to_send(following) + window
        return identity

    def watch(self, now: float) -> SweepFailed | None:
        """Do what is due; return the result of a sweep that has failed."""
        if now < self.deadline:
            return None
        match self._phase:
            case _ConnectPhase.PAUSED:
                self.begin(now)
            case _ConnectPhase.DIALLING:
                assert self._dialler is not None  # only then this phase is entered
                self._dialler.give_up()
                self._start_round(now)
            case _ConnectPhase.SILENT:
                self._start_sync(now)
            case _ConnectPhase.LISTENING:
                self._start_bare_sync(now)
            case _ConnectPhase.SYNCING if self._is_bare:
                self.hangs_up_on_close = False
                return self._pause(now)
            case _ConnectPhase.SYNCING if self._rounds_left > 0:
                self._rounds_left -= 1
                self._start_round(now)
            case _ConnectPhase.SYNCING if self._plan:
                self._next_rate(now)
            case _ConnectPhase.SYNCING:
                return self._pause(now)
        return None

    def change_rate(self, baud: int) -> None:
        """Use another rate, bit/s, and look for the robot at this rate first: the robot was told to change."""
        self.baud = self._outbox.baud = self._known = baud

    @property
    def so_far(self) -> SweepFailed:
        """The result of the current sweep, as if it ended now."""
        return SweepFailed(self._rates, self._bytes_heard, self._frames_heard, self._answers_at)

    @property
    def is_searching(self) -> bool:
        """An attempt is under way."""
        return self._phase is not _ConnectPhase.PAUSED

    def lose_line(self) -> None:
        """Note that the port was lost before the robot was open; the peer may close connections on CLOSE."""
        if self._phase is _ConnectPhase.SYNCING and self._is_bare:
            self.hangs_up_on_close = False
        elif self._rates == (AS_IT_IS,) and self._has_sent_close:
            self.hangs_up_on_close = True

    def rest(self, now: float) -> None:
        """Pause before the next attempt: a robot answered that is not served."""
        self._outbox.clear()
        self._phase = _ConnectPhase.PAUSED
        self.deadline = now + REST

    def _next_rate(self, now: float) -> None:
        self.baud = self._plan.pop(0)
        self._outbox.baud = self._line.baud or self.baud
        self._has_frames = False
        self._rounds_left = 0
        if self._dialler is not None and self._must_dial:
            self._dial(self._dialler, now)
        else:
            self._start_round(now)

    def _dial(self, dialler: ModemDialler, now: float) -> None:
        dialler.begin()
        self._outbox.clear()
        self._outbox.put("dial", dialler.frame)
        self._phase = _ConnectPhase.DIALLING
        self.deadline = now + self._outbox.time_to_send(dialler.frame) + dialler.timeout

    @property
    def _has_sent_close(self) -> bool:
        if self._phase is _ConnectPhase.SILENT:
            return not self._outbox.is_waiting("close")
        return self._phase is _ConnectPhase.SYNCING

    def _listen(self, now: float) -> None:
        self._outbox.clear()
        self._has_frames = False
        self._rounds_left = 0
        self._phase = _ConnectPhase.LISTENING
        self.deadline = now + LISTENING

    def _start_bare_sync(self, now: float) -> None:
        self._is_bare = True
        self._handshake = HostHandshake()
        self._outbox.put("sync", self._handshake.request())
        self._phase = _ConnectPhase.SYNCING
        self.deadline = now + SIMULATOR_WINDOW

    def _start_round(self, now: float) -> None:
        self._is_bare = False
        self._handshake = HostHandshake()
        self._outbox.clear()
        self._outbox.put("stop", STOP)
        self._outbox.put("close", CLOSE)
        self._phase = _ConnectPhase.SILENT
        self.deadline = now + self._outbox.time_to_send(STOP, CLOSE) + PARTIAL_TIMEOUT + self._line.settling

    def _start_sync(self, now: float) -> None:
        sync = self._handshake.request()
        self._outbox.put("stop", STOP)
        self._outbox.put("close", CLOSE)
        self._outbox.put("sync", sync)
        self._phase = _ConnectPhase.SYNCING
        self.deadline = now + self._outbox.time_to_send(STOP, CLOSE, sync) + self._window

    def _pause(self, now: float) -> SweepFailed:
        line = self._line
        self._window = min(2.0 * self._window, line.last_window)
        self._phase = _ConnectPhase.PAUSED
        self._must_dial = True
        self.deadline = now + self._rng.uniform(0.0, self._backoff)
        self._backoff = min(2.0 * self._backoff, line.last_backoff)
        return self.so_far
