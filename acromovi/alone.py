"""One agent in a container of its own, for as long as a command in a terminal runs."""

import asyncio
import sys
from typing import TYPE_CHECKING

from acromovi.container import EndRequest

if TYPE_CHECKING:
    from agents.platform import Agent, Container, Report
    from bus.bus import Bus

LOOK = 0.1  # s between two looks whether the agent has ended


async def live_alone(bus: "Bus", agent: "Agent", command: str, end: EndRequest) -> bool:
    """Host an agent until it ends or moves away, or until the program is told to end.

    Args:
        bus: Where.
        agent: Whom.
        command: Which command this is, for what is said.
        end: Of the program.
    Returns:
        Whether it has begun; why it has not is on stderr.
    Raises:
        AlreadyThere: There is an agent of this name.
    """
    from agents.platform import Container

    def report(report: "Report") -> None:
        why = "" if report.error is None else f": {report.error}"
        print(f"acromovi {command}: {report.agent}: {report.what}{why}", file=sys.stderr, flush=True)

    name = agent.name
    async with Container(bus, f"{name.local}-{name.platform}", report, platform=name.platform) as container:
        if not await container.start(agent):
            return False
        asked = ", ".join(agent.describe()["requests"]) or "nothing"
        print(f"{name} lives, and can be asked for {asked}; stop with Ctrl-C", flush=True)
        ends = [asyncio.ensure_future(end.wait()), asyncio.ensure_future(_deserted(container))]
        await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
        for waiting in ends:
            waiting.cancel()
    return True


async def _deserted(container: "Container") -> None:
    """Wait until the container has no agents; the answer to the last stop request has been sent by then."""
    while container.agents:
        await asyncio.sleep(LOOK)
