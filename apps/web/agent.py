"""The agent by which the program behind pages asks all other agents."""

import uuid
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager

from agents.platform import Agent, AgentName, Container
from bus import Bus, NotAllowed

PLATFORM = "apps"


@asynccontextmanager
async def page_agent(bus: Bus, program: str) -> AsyncIterator[tuple[Agent, bool]]:
    """Have an agent during a block; gives it, and whether the certificate permits more than looking.

    An agent that may only look is in no directory and holds no lease; the streams come to it all the same.

    Args:
        bus: The bus.
        program: Its name begins with that of the program.
    """
    name = f"{program}-{uuid.uuid4().hex[:6]}"
    agent = Agent(AgentName(name, bus.own_name or PLATFORM))
    container = Container(bus, name)
    async with AsyncExitStack() as ending:
        ending.push_async_callback(container.close)
        try:
            container.show()
            await container.start(agent)
        except NotAllowed:
            await agent.look_on(container)
            yield agent, False
        else:
            yield agent, True
