"""Protocols of programs, without port and clock: they encode requests and decode events."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


class NonsenseHeard(ValueError):
    """The output of the program does not follow its protocol; it has to be restarted."""


@dataclass(frozen=True, slots=True)
class Answered:
    """The request under way is done; values may be bytes."""

    value: dict[str, Any]


@dataclass(frozen=True, slots=True)
class RequestFailed:
    """The program refuses the request under way."""

    why: str


@dataclass(frozen=True, slots=True)
class Told:
    """The program has sent a result without a request."""

    value: dict[str, Any]


Event = Answered | RequestFailed | Told


class ProgramCodec(ABC):
    """The protocol of one run of a program. One request is under way at a time."""

    @abstractmethod
    def ask(self, name: str, arguments: Mapping[str, Any]) -> bytes:
        """Begin a request, and return its bytes.

        Raises:
            ValueError: The arguments cannot be encoded; the message says why.
        """

    @abstractmethod
    def receive(self, data: bytes) -> list[Event]:
        """Take output of the program, in any portions.

        Raises:
            NonsenseHeard: It does not follow the protocol.
        """

    def wants_answer(self, name: str) -> bool:
        """Whether the request under way has an answer."""
        return True
