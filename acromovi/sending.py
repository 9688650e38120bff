"""Send an application to a loader or container. Only its name is sent; the program must be installed there."""

import asyncio
from collections.abc import Mapping
from typing import Any

from acromovi.ask import ask
from acromovi.known_agents import KnownAgents, NoSuchAgent
from acromovi.known_containers import find_container, tell
from agents.platform import AgentName
from agents.services.loaded import KIND
from agents.services.loader import SERVICE
from bus.bus import Bus
from bus.errors import Refused

PATIENCE = 60.0  # s for a process to begin, and an application in it


def into_loader(bus: Bus, which: str, agent: AgentName, given: Mapping[str, Any]) -> str:
    """Ask a team's loader to load an application.

    Args:
        bus: Where the team is.
        which: `loader@TEAM`, or `loader` for the only one there is.
        agent: What the application is to be called.
        given: Program, arguments and digest.
    Returns:
        The container where it lives.
    Raises:
        NoSuchAgent: There is no such loader, or several.
        Refused: The loader does not, or has failed; says why.
    """
    loader = AgentName.parse(which) if "@" in which else _only_loader(bus)
    with KnownAgents(bus) as known:
        known.expect(loader)
    asked = {"application": given["program"], "arguments": given["arguments"], "sha256": given["sha256"]}
    outcome = asyncio.run(ask(bus, loader, "load", {**asked, "name": str(agent)}, PATIENCE))
    if not outcome.is_done:
        raise Refused(outcome.why)
    return str(outcome.result["container"])


def into_container(bus: Bus, which: str, agent: AgentName, given: Mapping[str, Any]) -> str:
    """Ask a container to start an application.

    Raises:
        NoSuchContainer: There is none of this name.
        Refused: The container does not; says why.
    """
    there = find_container(bus, which)
    tell(bus, there, "start", name=str(agent), kind=KIND, properties=dict(given))
    return there.name


def _only_loader(bus: Bus) -> AgentName:
    with KnownAgents(bus) as known:
        found, _ = known.describe(SERVICE)
    if not found:
        raise NoSuchAgent(
            "no team here has a loader: start one with acromovi up TEAM --apps FOLDER, and see whether both use the "
            "same --bus"
        )
    if len(found) > 1:
        names = ", ".join(str(each.name) for each in found)
        raise NoSuchAgent(f"several teams have a loader; say whose, --into {found[0].name} for example, of {names}")
    return found[0].name
