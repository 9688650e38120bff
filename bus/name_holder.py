"""Unique names of programs on a bus: which program holds one, and whether it is free.

A program's answer on a description's key identifies it: `process`, `host`, `identity` and `since`.
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

    process: its number. host: the name of its machine. identity: a unique text. since: start time, s since 1970.
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
        """Read it from a description; None if it is missing there."""
        match description:
            case {"process": int(process), "host": str(host), "identity": str(identity), "since": int() | float()}:
                return cls(process, host, identity, float(description["since"]))
        return None

    def told(self) -> dict[str, Any]:
        """Return it as a part of a description."""
        return {"process": self.process, "host": self.host, "identity": self.identity, "since": self.since}

    def __str__(self) -> str:
        where = "this machine" if self.host == socket.gethostname() else self.host[:64]
        return f"process {self.process} on {where}"


def check_name_free(bus: Bus, name: str, key_expr: str, own: BusProgram | None = None) -> None:
    """Check that no other program holds a name.

    A program that was killed leaves the bus at once, so its successor finds the name free. A program that is on the bus
    but does not answer is waited for until it answers or the bus has given it up.

    Args:
        bus: The bus.
        name: The name, for the message.
        key_expr: The key on which the holder of the name answers with its description.
        own: This program, if it has taken the name already. Then only an earlier holder is an error.
    Raises:
        NameTaken: Another program holds it.
        BusError: The bus is closed, or does not permit this query.
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
    """Return the descriptions of the holders of a name; an empty one for an answer of another form.

    Raises:
        TimedOut: A holder has not answered.
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
