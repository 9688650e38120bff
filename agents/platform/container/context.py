"""What a container is to its agents."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from enum import StrEnum
from pathlib import Path
from typing import Protocol

from agents.platform.acl import AclMessage
from agents.platform.names import AgentName
from bus import Bus


class AgentEnd(StrEnum):
    """Why an agent does not live in its container any more."""

    STOPPED = "stopped"  # on purpose, by itself or by somebody
    CLOSED = "closed"  # with its container, on purpose
    MOVED = "moved"  # it lives on in another container
    FAILED = "failed"  # a behaviour without which it is nothing
    NOT_SET_UP = "not set up"  # its setup raised or took too long

    @property
    def is_failure(self) -> bool:
        """Whether nobody wanted it."""
        return self in (AgentEnd.FAILED, AgentEnd.NOT_SET_UP)


class ContainerContext(Protocol):
    """Where an agent lives."""

    @property
    def bus(self) -> Bus:
        """Where its agents hear and speak."""
        ...

    @property
    def name(self) -> str:
        """The container's name."""
        ...

    @property
    def folders(self) -> Sequence[Path]:
        """Where the programs lie whose agents the container may be told to start."""
        ...

    def report(self, agent: AgentName, what: str, error: Exception | None = None) -> None:
        """Make known that something went wrong."""
        ...

    def end(self, agent: AgentName, end: AgentEnd = AgentEnd.STOPPED) -> None:
        """Stop an agent soon, and say why."""
        ...

    def trace(self, message: AclMessage) -> None:
        """Told of each message once, by who says it; called on any thread, so it must be quick."""
        ...

    def attend(self, asker: AgentName, gone: Callable[[], None]) -> Callable[[], None]:
        """Have `gone` called if one who asks dies; what is returned is called when that does not matter any more."""
        ...

    def beating(self, agent: AgentName) -> AbstractContextManager[None]:
        """Let an agent's heartbeat beat during a block."""
        ...

    def wall_time(self) -> float:
        """s since 1970."""
        ...
