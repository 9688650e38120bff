"""Why there is no robot on a line, and when a person is told of it, or of an element. No port and no clock."""

from collections.abc import Iterator, Sequence
from enum import StrEnum
from math import inf
from typing import NamedTuple

from gateway.cables.cable import ElementCable
from gateway.events import SweepFailed

PATIENCE = 2.0
"""Seconds without a robot after which the cause is reported."""
REPEAT = 60.0
"""Seconds after which the same cause is reported again."""
ELEMENT_PATIENCE = 10.0
"""Seconds in which an element must have answered for the first time; a laser finds its rate within that."""
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
        """Begin the search for a robot at a steady time, s; has no effect during a search."""
        if self._since is None:
            self._since = now
            self._latest = None
            self._hung_up_at = self._silent_at = -inf

    def end(self) -> None:
        """End the search: the robot is connected."""
        self._since = None

    def problem(self, now: float) -> LinkProblem | None:
        """Return the cause; None while a robot is connected, and in the first `PATIENCE`.

        Args:
            now: Steady time, s.
        """
        return None if self._since is None or now - self._since < PATIENCE else self._latest

    def is_due(self, now: float) -> bool:
        """Return whether a cause is due and none is known, so that the current attempt is to be noted."""
        return self._since is not None and now - self._since >= PATIENCE and self._latest is None

    def note_no_port(self, reason: str) -> None:
        """Note that the port cannot be opened; the reason is a sentence."""
        self._latest = LinkProblem(Cause.NO_PORT, reason)

    def note_hang_up(self, reason: str, now: float) -> None:
        """Note that the peer closed the port before the robot was connected."""
        if now - self._silent_at < MEMORY:
            return
        self._hung_up_at = now
        self._latest = LinkProblem(
            Cause.HANG_UP,
            f"each connection is closed by the other end before a robot is connected ({reason}); see what listens "
            "there, and whether it serves another client",
        )

    def note_sweep(self, sweep: SweepFailed, now: float) -> None:
        """Note a sweep that has found no robot."""
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
        """Note that no SIP followed the handshake."""
        self._silent_at = now
        self._latest = LinkProblem(
            Cause.NO_PACKETS,
            "the robot answers the handshake, but sends no information packets; switch it off and on",
        )

    def note_rejected(self, reason: str) -> None:
        """Note that a robot answers that is not served; the reason is a sentence."""
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


class _ElementChange(NamedTuple):
    """An element on a cable of its own began to answer, or does not answer.

    has_answered: before. reasons: why it does not answer, a sentence each.
    """

    element: str
    answers: bool
    has_answered: bool
    reasons: Sequence[str]


class ElementReports:
    """Chooses when a person is told of an element on a cable of its own: found, lost, or not there at all."""

    def __init__(self, elements: Sequence[ElementCable]) -> None:
        self._elements = elements
        self._reported: dict[str, bool] = {}
        self._since = inf

    def due(self, now: float) -> Iterator[_ElementChange]:
        """Return what has changed until now, steady time, s; patience begins with the first call."""
        self._since = min(self._since, now)
        for element in self._elements:
            answers, reported = element.driver.is_connected, self._reported.get(element.name)
            if answers == reported or (reported is None and not answers and now - self._since < ELEMENT_PATIENCE):
                continue
            self._reported[element.name] = answers
            reasons = () if answers else element.driver.faults()
            yield _ElementChange(element.name, answers, reported is not None, reasons)
