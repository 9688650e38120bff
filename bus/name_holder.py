"""Names that one program on a bus may have at a time: who has one, and whether it is free.

A program shows who it is in what it answers on a description's key: `process`, `host`, `identity` and `since`.
"""

import os
import socket
import time
import uuid
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from bus.bus import Bus
from bus.errors import MessageError, NameTaken, NoAnswer, Refused, TimedOut

ANSWER_TIME = 2.0  # s for the program that has the name; longer than a process is late on a busy machine
MOST_TRIES = 3  # to get an answer; a program that was killed or frozen has left the bus by then


@dataclass(frozen=True, slots=True)
class BusProgram:
    """A program on the bus.

    process: its number. host: the name of its machine. identity: no other program has it. since: s since 1970.
    """

    process: int
    host: str
    identity: str
    since: float

    @classmethod
    def here(cls) -> Self:
        """Return this process, with an identity of its own for each call."""
        return cls(os.getpid(), socket.gethostname(), uuid.uuid4().hex, time.time())

    @classmethod
    def of(cls, description: Mapping[str, Any]) -> Self | None:
        """Read what a program has told; None if it does not tell."""
        match description:
            case {"process": int(process), "host": str(host), "identity": str(identity), "since": int() | float()}:
                return cls(process, host, identity, float(description["since"]))
        return None

    def told(self) -> dict[str, Any]:
        """Return its part of a description."""
        return {"process": self.process, "host": self.host, "identity": self.identity, "since": self.since}

    def __str__(self) -> str:
        where = "this machine" if self.host == socket.gethostname() else self.host[:64]
        return f"process {self.process} on {where}"


def check_name_free(bus: Bus, name: str, key_expr: str, own: BusProgram | None = None) -> None:
    """See that nobody else has a name.

    A program that was killed leaves the bus at once and answers nothing, so its successor finds the name free. One that
    is there but does not answer is waited for until it answers or the bus has given it up.

    Args:
        bus: Where to look.
        name: For the message.
        key_expr: Where whoever has the name answers with its description.
        own: The program that asks, if it has taken the name already. Then it is a later one that has to leave.
    Raises:
        NameTaken: Another program has it.
        BusError: The bus is closed, or does not let this program ask.
    """
    for _ in range(MOST_TRIES):  # and not until a moment: this program may be the one that is late
        try:
            found = _descriptions(bus, key_expr)
        except TimedOut:
            if own is not None:
                return  # it is no proof of another one: this program answers here as well
            continue
        for holder in map(BusProgram.of, found):
            if holder is None:
                raise NameTaken(f"{name} is on this bus already, in a program that does not tell which it is")
            is_later = own is not None and (own.since, own.identity) < (holder.since, holder.identity)
            if not is_later and (own is None or holder.identity != own.identity):
                raise NameTaken(f"{name} is on this bus already, in {holder}")
        return
    raise NameTaken(f"{name} is on this bus already, in a program that does not answer")


def _descriptions(bus: Bus, key_expr: str) -> list[dict[str, Any]]:
    """What those answer who have a name; an empty one for who answers something else.

    Raises:
        TimedOut: Somebody who has it has not answered.
    """
    try:
        return [answer.value for answer in bus.query(key_expr, timeout=ANSWER_TIME)]
    except TimedOut:
        raise
    except NoAnswer:
        return []
    except Refused as err:
        return list(err.answers.values()) or [{}]
    except MessageError:
        return [{}]
