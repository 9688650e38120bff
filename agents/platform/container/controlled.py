"""A container as its control and the moves of its agents see it."""

from collections.abc import Awaitable, Callable
from typing import Any, Protocol

from agents.platform.agent import Agent
from agents.platform.container.context import AgentEnd, ContainerContext
from agents.platform.kinds import Kinds
from agents.platform.names import AgentName, ContainerName


class ControlledContainer(ContainerContext, Protocol):
    """A container that can be told to start and stop agents."""

    @property
    def called(self) -> ContainerName:
        """Its name with its platform, and its keys."""
        ...

    @property
    def kinds(self) -> Kinds:
        """Which agents it may be told to start."""
        ...

    @property
    def agents(self) -> list[Agent]:
        """Those that live here, the eldest first."""
        ...

    def agent(self, name: AgentName | str) -> Agent:
        """One that lives here.

        Raises:
            UnknownAgent: It does not.
        """
        ...

    async def bring_up(self, agent: Agent, begin: Callable[[Any], Awaitable[None]]) -> None:
        """Let an agent live here that begins in a way of its own.

        Raises:
            AlreadyThere: One of this name lives here.
            SetupFailed: It raised or took too long; that has been reported, and it lives here no more.
        """
        ...

    async def stop(self, name: AgentName | str, end: AgentEnd = AgentEnd.STOPPED) -> None:
        """Stop an agent, and wait until it has ended."""
        ...
