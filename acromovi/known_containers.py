"""Containers on the bus, found by their liveliness tokens, and requests to them."""

import difflib
from collections.abc import Mapping
from threading import Condition
from typing import Any

from acromovi.known_agents import KnownAgents, NotOnBus
from acromovi.presence import MEETING_TIME
from agents.platform.containers import ORDER_TIME, ContainerDirectory
from agents.platform.names import AgentName, ContainerName
from bus.bus import Bus
from bus.meeting import wait_for_others


def find_container(bus: Bus, name: str) -> ContainerName:
    """The container that has a name.

    Raises:
        NotOnBus: It has not been seen within `MEETING_TIME` s of meeting all on the bus; the message gives the
            nearest name.
    """
    changed = Condition()

    def note(called: ContainerName, is_alive: bool) -> None:
        with changed:
            changed.notify_all()

    with ContainerDirectory(bus, note) as directory, changed:
        found = wait_for_others(bus, changed, lambda: directory.find(name), MEETING_TIME)
        if found is None:
            seen = [each.name for each in directory.names]
            raise NotOnBus(f"there is no container {name!r}; {_advice(name, seen)}")
        return found


def home_of(bus: Bus, agent: AgentName) -> str:
    """The name of the container where an agent lives.

    Raises:
        NotOnBus: There is no such agent; the message gives the nearest name.
        NoAnswer: It is there and does not answer.
    """
    with KnownAgents(bus) as known:
        known.expect(agent)
    return str(bus.query(agent.description_key)[0].value.get("container", ""))


def tell(bus: Bus, container: ContainerName, do: str, **given: object) -> Mapping[str, Any]:
    """Send a request to a container.

    Raises:
        Refused: It does not; says why.
        NoAnswer: It does not answer.
    """
    return bus.query(container.control_key, {"do": do, **given}, ORDER_TIME)[0].value


def _advice(name: str, seen: list[str]) -> str:
    if not seen:
        return "there are none at all: start one with acromovi container, and see whether both use the same --bus"
    near = difflib.get_close_matches(name, seen, 1)
    return f"did you mean {near[0]!r}?" if near else f"the containers seen are {', '.join(seen)}"
