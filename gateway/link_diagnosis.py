"""Why there is no robot on a line: the cause, in a word and in a sentence. No port and no clock."""

from enum import StrEnum
from math import inf
from typing import NamedTuple

from gateway.events import SweepFailed

PATIENCE = 2.0
"""Seconds without a robot after which the cause is reported."""
REPEAT = 60.0
"""Seconds after which the same cause is reported again."""
MEMORY = 6.0
"""Seconds for which a hang-up, or a robot that sends no SIPs, explains what follows; longer than the longest pause
between two connections."""


class Cause(StrEnum):
    """What keeps a robot from being connected."""

    NO_PORT = "no port"
    HANG_UP = "peer hangs up"
    NO_ANSWER = "no answer"
    NO_FRAMES = "bytes but no frames"
    NO_HANDSHAKE = "frames but no handshake"
    OTHER_RATE = "answers at another rate"
    NO_PACKETS = "no information packets"
    REJECTED = "another robot"


class LinkProblem(NamedTuple):
    """A cause, and a sentence that says what was observed and what to do."""

    cause: Cause
    sentence: str


class LinkDiagnosis:
    """Takes what is observed on one line while a robot is looked for."""

    def __init__(self) -> None:
        self._since: float | None = None
        self._latest: LinkProblem | None = None
        self._hung_up_at = self._silent_at = -inf

    def begin(self, now: float) -> None:
        """A robot is looked for from now on, steady time, s; nothing changes if it already is."""
        if self._since is None:
            self._since = now
            self._latest = None
            self._hung_up_at = self._silent_at = -inf

    def end(self) -> None:
        """The robot is connected."""
        self._since = None

    def problem(self, now: float) -> LinkProblem | None:
        """Return the cause; None while a robot is connected, and in the first `PATIENCE`.

        Args:
            now: Steady time, s.
        """
        return None if self._since is None or now - self._since < PATIENCE else self._latest

    def is_due(self, now: float) -> bool:
        """Whether a cause is to be given, and none has been found: note what the attempt under way has shown."""
        return self._since is not None and now - self._since >= PATIENCE and self._latest is None

    def note_no_port(self, reason: str) -> None:
        """The port cannot be opened; the reason is a sentence."""
        self._latest = LinkProblem(Cause.NO_PORT, reason)

    def note_hang_up(self, reason: str, now: float) -> None:
        """The port was closed by its other end before the robot was connected."""
        if now - self._silent_at < MEMORY:
            return
        self._hung_up_at = now
        self._latest = LinkProblem(
            Cause.HANG_UP,
            f"each connection is closed by the other end before a robot is connected ({reason}); see what listens "
            "there, and whether it serves another client",
        )

    def note_sweep(self, sweep: SweepFailed, now: float) -> None:
        """No rate has brought a robot."""
        if now - max(self._hung_up_at, self._silent_at) < MEMORY:
            return
        at = "" if not any(sweep.rates) else f" at {', '.join(map(str, sweep.rates))} bit/s"
        if sweep.answers_at is not None:
            self._latest = LinkProblem(
                Cause.OTHER_RATE,
                f"the robot answers at {sweep.answers_at} bit/s, and not{at}; leave out --baud, or make it "
                f"{sweep.answers_at}",
            )
        elif sweep.frames_heard:
            self._latest = LinkProblem(
                Cause.NO_HANDSHAKE,
                "something sends P2OS frames, but does not answer the handshake; see that no other program talks on "
                "this line, then switch the robot off and on",
            )
        elif sweep.bytes_heard:
            self._latest = LinkProblem(
                Cause.NO_FRAMES,
                f"something answers{at}, but not as a P2OS robot does: bytes are received, and no frames; check which "
                "cable this is",
            )
        else:
            self._latest = LinkProblem(
                Cause.NO_ANSWER,
                f"no robot answers{at}; switch it on, check the cable, and see that its own computer is off",
            )

    def note_silence(self, now: float) -> None:
        """The robot answered the handshake, and no SIP followed."""
        self._silent_at = now
        self._latest = LinkProblem(
            Cause.NO_PACKETS,
            "the robot answers the handshake, but sends no information packets; switch it off and on",
        )

    def note_rejected(self, reason: str) -> None:
        """A robot answered that is not served; the reason is a sentence."""
        self._latest = LinkProblem(Cause.REJECTED, reason)


class LinkReports:
    """Chooses when a person is told of a problem: on each change, and once in `REPEAT`."""

    def __init__(self) -> None:
        self._reported: LinkProblem | None = None
        self._reported_at = -inf

    def due(self, problem: LinkProblem | None, now: float) -> LinkProblem | None:
        """Return the problem if it is to be reported now, steady time, s."""
        if problem is None or (problem == self._reported and now - self._reported_at < REPEAT):
            self._reported = problem
            return None
        self._reported, self._reported_at = problem, now
        return problem
