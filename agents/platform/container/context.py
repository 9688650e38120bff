"""The interface of a container for its agents."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from enum import StrEnum
from pathlib import Path
from typing import Protocol

from agents.platform.acl import AclMessage
from agents.platform.names import AgentName
from bus import Bus


class AgentEnd(StrEnum):
    """Why an agent is no longer in its container."""

    STOPPED = "stopped"  # on purpose, by itself or by another program
    CLOSED = "closed"  # with its container, on purpose
    MOVED = "moved"  # it continues in another container
    FAILED = "failed"  # a behaviour failed that it cannot do without
    NOT_SET_UP = "not set up"  # its setup raised or took too long

    @property
    def is_failure(self) -> bool:
        """Whether it is a failure."""
        return self in (AgentEnd.FAILED, AgentEnd.NOT_SET_UP)


class ContainerContext(Protocol):
    """The container of an agent."""

    @property
    def bus(self) -> Bus:
        """The bus of its agents."""

    @property
    def name(self) -> str:
        """The container's name."""

    @property
    def folders(self) -> Sequence[Path]:
        """The folders with the programs whose agents the container can be told to start."""

    def report(self, agent: AgentName, what: str, error: Exception | None = None) -> None:
        """Report an error."""

    def end(self, agent: AgentName, end: AgentEnd = AgentEnd.STOPPED) -> None:
        """Stop an agent soon, and publish why."""

    def trace(self, message: AclMessage) -> None:
        """Take each message that an agent sends; called on any thread, so it must be quick."""

    def attend(self, asker: AgentName, gone: Callable[[], None]) -> Callable[[], None]:
        """Call `gone` when the initiator of a conversation dies; call the returned function to stop watching."""

    def beating(self, agent: AgentName) -> AbstractContextManager[None]:
        """Publish an agent's heartbeat during a block."""

    def wall_time(self) -> float:
        """Return s since 1970."""
