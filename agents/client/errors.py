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

from numbers import Real


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


def check_seconds(argument: str, value: object) -> None:
    """Check an argument that is a time.

    Raises:
        RobotError: It is not a time of 0 s or more.
    """
    if not isinstance(value, Real) or not float(value) >= 0.0:
        raise RobotError(f"{argument} must be a time of 0 s or more, not {value!r}")
