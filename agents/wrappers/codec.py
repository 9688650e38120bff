"""Languages of programs, without port and clock: bytes of a request out, events of what comes back in."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


class NonsenseHeard(ValueError):
    """What the program says is not its language; the conversation with it has to begin anew."""


@dataclass(frozen=True, slots=True)
class Answered:
    """The request under way is done; bytes may stand among the values."""

    value: dict[str, Any]


@dataclass(frozen=True, slots=True)
class RequestFailed:
    """The program says no to the request under way."""

    why: str


@dataclass(frozen=True, slots=True)
class Told:
    """The program has said something of its own accord."""

    value: dict[str, Any]


Event = Answered | RequestFailed | Told


class ProgramCodec(ABC):
    """One conversation with a program. One request is under way at a time."""

    @abstractmethod
    def ask(self, name: str, arguments: Mapping[str, Any]) -> bytes:
        """Begin a request, and give the bytes that say it.

        Raises:
            ValueError: The arguments cannot be said in this language; the message says why.
        """

    @abstractmethod
    def receive(self, data: bytes) -> list[Event]:
        """Take what the program said, in any portions.

        Raises:
            NonsenseHeard: It is not its language.
        """

    def wants_answer(self, name: str) -> bool:
        """Whether an answer is to be waited for."""
        return True
