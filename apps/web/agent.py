"""The agent by which the program behind pages asks all other agents."""

import time
import uuid
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager, suppress

from agents.platform import Agent, AgentName, Container
from bus import Bus, NotAllowed

PLATFORM = "apps"


@asynccontextmanager
async def page_agent(
    bus: Bus, program: str, wall_time: Callable[[], float] = time.time, *, is_hidden: bool = False
) -> AsyncIterator[tuple[Agent, bool]]:
    """Have an agent during a block; gives it, and whether the certificate permits more than looking.

    An agent that may only look is in no directory and holds no lease; the streams come to it all the same.

    Args:
        bus: The bus.
        program: Its name begins with that of the program.
        wall_time: Returns s since 1970, as the stamps of readings count it.
        is_hidden: Whether it is to be in no directory, and only look.
    """
    name = f"{program}-{uuid.uuid4().hex[:6]}"
    agent = Agent(AgentName(name, bus.own_name or PLATFORM))
    container = Container(bus, name, wall_time=wall_time)
    async with AsyncExitStack() as ending:
        ending.push_async_callback(container.close)
        may_command = False
        if not is_hidden:
            with suppress(NotAllowed):  # the role may look only, and so does the agent then
                container.show()
                await container.start(agent)
                may_command = True
        if not may_command:
            await agent.look_on(container)
        yield agent, may_command
