"""What can go wrong between a program and its robots.

RobotError
 +-- NotThere                 no such robot, element or agent, or not any more
 +-- Refused                  the other said no, and has done nothing
 |    +-- LeaseLost           the lease that allowed it is lost, or about to be
 +-- Failed                   it tried, in vain
 +-- TimedOut (TimeoutError)  it has not come to an end in time

Every message says in one sentence what happened and, where there is a way out, which.

`Stopped` stands apart, as KeyboardInterrupt does: it is no error but the wish that the program ends, and `except
RobotError` or `except Exception` must not hold it up.
"""

from numbers import Real

from agents.client.wording import in_api_words
from agents.platform import Ending, Outcome


class RobotError(Exception):
    """Base class of the errors that a program gets from its robots."""


class NotThere(RobotError):
    """There is no such robot, element or agent, or it has left the bus."""


class RequestRefused(RobotError):
    """The agent refused the request and did nothing."""


class LeaseLost(RequestRefused):
    """The lease that the request needs is lost, or a holder of higher priority is about to take it."""


class Failed(RobotError):
    """The agent agreed to the request, but could not carry it out."""


class RequestTimedOut(RobotError, TimeoutError):
    """The request has not ended in time. The agent may still carry it out."""


class Stopped(BaseException):
    """The container that runs the program ends it. Raised from every call, so that the program can clean up."""


_BY_ENDING: dict[Ending, tuple[type[RobotError], str]] = {
    Ending.REFUSED: (RequestRefused, "{peer} refuses {request}: {why}"),
    Ending.NOT_UNDERSTOOD: (RequestRefused, "{peer} does not understand {request}: {why}"),
    Ending.NOT_ALLOWED: (RequestRefused, "{request} is not allowed: {why}"),
    Ending.FAILED: (Failed, "{peer} could not {request}: {why}"),
    Ending.TIMED_OUT: (RequestTimedOut, "{request}: {why}"),
    Ending.DIED: (NotThere, "{why}; see `acromovi ps` for who is there"),
}


def error_of(outcome: Outcome, peer: object, request: str) -> RobotError:
    """The error that a request's end is to whoever asked, in the words of this API."""
    kind, sentence = _BY_ENDING[outcome.ending]
    why = in_api_words(outcome.why, str(peer).partition("@")[0])
    return kind(sentence.format(peer=peer, request=request, why=why))


def check_seconds(argument: str, value: object) -> None:
    """Check an argument that is a time.

    Raises:
        RobotError: It is not a time of 0 s or more.
    """
    if not isinstance(value, Real) or not float(value) >= 0.0:
        raise RobotError(f"{argument} must be a time of 0 s or more, not {value!r}")
