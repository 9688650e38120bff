"""Errors of programs that drive robots.

RobotError
 +-- NotThere                 no such robot, element or agent, or no longer
 +-- Refused                  the peer has refused, and has done nothing
 |    +-- LeaseLost           the lease that allowed it is lost, or about to be
 +-- Failed                   it was tried without success
 +-- TimedOut (TimeoutError)  it has not come to an end in time

Every message says in one sentence what happened and, if possible, what to do.

`Stopped` is a BaseException like KeyboardInterrupt: it is no error but ends the program, and `except RobotError` or
`except Exception` must not catch it.
"""

from agents.client.wording import in_api_words
from agents.platform import Ending, Outcome


class RobotError(Exception):
    """The base class of errors of programs that drive robots."""


class NotThere(RobotError):
    """There is no such robot, element or agent, or no longer."""


class RequestRefused(RobotError):
    """The peer has refused, and has done nothing."""


class LeaseLost(RequestRefused):
    """The lease for it is lost, or a program of higher priority is about to take it."""


class Failed(RobotError):
    """It was tried without success."""


class RequestTimedOut(RobotError, TimeoutError):
    """It has not come to an end in time; it may still be done."""


class Stopped(BaseException):
    """The program is stopped from outside."""


_BY_ENDING: dict[Ending, tuple[type[RobotError], str]] = {
    Ending.REFUSED: (RequestRefused, "{peer} refuses {request}: {why}"),
    Ending.NOT_UNDERSTOOD: (RequestRefused, "{peer} does not understand {request}: {why}"),
    Ending.NOT_ALLOWED: (RequestRefused, "{request} is not allowed: {why}"),
    Ending.FAILED: (Failed, "{peer} could not {request}: {why}"),
    Ending.TIMED_OUT: (RequestTimedOut, "{request}: {why}"),
    Ending.DIED: (NotThere, "{why}; see `acromovi ps` for who is there"),
}


def error_of(outcome: Outcome, peer: object, request: str) -> RobotError:
    """Return the error for the outcome of a request, in the terms of this API."""
    kind, sentence = _BY_ENDING[outcome.ending]
    why = in_api_words(outcome.why, str(peer).partition("@")[0])
    return kind(sentence.format(peer=peer, request=request, why=why))
