"""The interface of a container for its control and for the moves of its agents."""

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
        """Its name and platform, and its keys."""

    @property
    def kinds(self) -> Kinds:
        """The agents that it can be told to start."""

    @property
    def agents(self) -> list[Agent]:
        """Its agents, the oldest first."""

    def agent(self, name: AgentName | str) -> Agent:
        """Return one of its agents.

        Raises:
            UnknownAgent: It has none of this name.
        """

    async def bring_up(self, agent: Agent, begin: Callable[[Any], Awaitable[None]]) -> None:
        """Start an agent by a function of the caller.

        Raises:
            AlreadyThere: This container has an agent of this name.
            SetupFailed: It raised or took too long, which has been reported; the agent is removed.
        """

    async def stop(self, name: AgentName | str, end: AgentEnd = AgentEnd.STOPPED) -> None:
        """Stop an agent, and wait until it has ended."""
