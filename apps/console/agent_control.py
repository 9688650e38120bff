"""What a page does to agents: suspend, resume, stop, move and clone them; and why it may not."""

from agents.platform import AgentError, AgentName, ContainerName
from agents.platform.containers import order
from agents.platform.errors import in_words
from apps.console.agent_watch import WatchedAgent
from apps.console.program import Console
from apps.console.visits import Visit
from bus import BusError, NotAllowed


def why_not_control(console: Console, visit: Visit, container: ContainerName) -> str:
    """Return why a page may not control a container; empty if it may."""
    return _why_not(console, visit, container.control_key)


def why_not_ask(console: Console, visit: Visit, agent: AgentName) -> str:
    """Return why a page may not send messages to an agent; empty if it may."""
    return _why_not(console, visit, agent.acl_key)


async def control(console: Console, visit: Visit, agent: WatchedAgent, do: str, **given: str) -> str:
    """Have an agent suspended, resumed, stopped, moved or cloned by its container.

    Args:
        console: The program.
        visit: The page that wants it, which is told the outcome.
        agent: The agent.
        do: `suspend`, `resume`, `stop`, `move`, or `clone`.
        given: For `move`, `to`: the name of the other container; for `clone`, `as`: the name of the copy.
    Returns:
        The outcome in words, or why the page may not.
    """
    if why_not := why_not_control(console, visit, agent.container):
        return why_not
    try:
        answer = await order(console.agent.bus, agent.container, do, name=str(agent.name), **given)
        where = answer.get("container", agent.container.name)
        words = f"{answer.get('name', agent.name)} is {answer.get('state')} in {where}"
    except TimeoutError:
        words = f"{agent.name}: the container {agent.container} does not answer"
    except (AgentError, BusError) as err:
        words = f"{agent.name}: {in_words(err)}"
    console.say(visit, words)
    console.timeline.tell("console", str(agent.name), f"{do} by {visit.name}: {words}")
    await console.agents.refresh(soon=True)
    return words


def _why_not(console: Console, visit: Visit, key: str) -> str:
    try:
        console.agent.bus.check_may_query(key)
    except NotAllowed as err:
        return str(err)
    return visit.look_only
