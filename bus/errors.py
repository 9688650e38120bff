"""What can go wrong on the bus.

BusError
 +-- BusUnavailable (ConnectionError)   no session can be opened, or it is closed
 +-- KeyNotValid (ValueError)           not a key, or not a robot's name
 +-- MessageError (ValueError)          a payload is not the message it claims to be, or a message does not fit its type
 +-- NameTaken                          another program has the name that this one wants
 +-- NotAllowed (PermissionError)       the certificate's role does not allow it
 +-- NoAnswer (TimeoutError)            nobody answered a query in time
 |    +-- TimedOut                      someone is there and has not answered, or not ended its answers, in time
 +-- Refused                            the answerer said no, and why
"""

from typing import Any


class BusError(Exception):
    """Base class of the errors of the bus."""


class BusUnavailable(BusError, ConnectionError):
    """No session can be opened, or the session is closed."""


class KeyNotValid(BusError, ValueError):
    """A text is not a key, a key expression or the name of a robot."""


class MessageError(BusError, ValueError):
    """A payload is not the message it claims to be, or a message does not fit its type."""


class NotAllowed(BusError, PermissionError):
    """The role of this program's certificate does not allow it; the message says what the role allows."""


class NameTaken(BusError):
    """Another program on this bus has the name; the message says which program."""


class NoAnswer(BusError, TimeoutError):
    """No program answered a query in time, or the program that did was killed."""


class TimedOut(NoAnswer):
    """A program that serves the key has not answered in time, or has not ended its answers."""


class Refused(BusError):
    """The answerer said no.

    A handler given to `Bus.serve` raises it with the reason; `Bus.query` raises it on the asker's side.

    why: the reason in one sentence.
    answers: what the other answerers of the same query said, key to value; empty for a query to one key.
    """

    def __init__(self, why: str, answers: dict[str, dict[str, Any]] | None = None) -> None:
        super().__init__(why)
        self.why = why
        self.answers = answers or {}
