"""A container's control: the commands and queries that it serves on the bus.

A query on `<platform>/containers/<name>/control` carries `{"do": ...}` and what goes with it:

| do | with | answer |
|---|---|---|
| `list` | | the container, its process, and its agents: name, kind, state |
| `start` | `name`, `kind`, `properties`, `state` | name and state of the agent, once it is active |
| `stop`, `suspend`, `resume` | `name` | name and state of the agent |
| `introspect` | `name` | what the agent holds and does (introspection.py) |
| `interface` | `name` | what the agent can be asked for, with types and defaults (introspection.py) |
| `move` | `name`, `to` | name, state and container of the agent, once it lives in the other |
| `clone` | `name`, `as`, `to` | name, state and container of the copy, once it is active |

`list`, which is the default there, `introspect` and `interface` are answered on
`<platform>/containers/<name>/description` too, for programs that may read but not control. Containers send each other
`adopt`, `settle`, `deliver`, `begin` and `forsake` when an agent moves (departures.py).

A refusal is an error reply with one sentence.
"""

import asyncio
import contextlib
import logging
import os
import socket
import uuid
from collections.abc import Awaitable, Callable, Mapping
from functools import partial
from typing import Any

from agents.platform.container.controlled import ControlledContainer
from agents.platform.container.delivery_gate import QueuedMessage
from agents.platform.container.introspection import interface, introspect
from agents.platform.directory import check_free
from agents.platform.errors import AgentError, in_words
from agents.platform.life import AgentState
from agents.platform.mobility.arrivals import Arrivals
from agents.platform.mobility.departures import Departures
from agents.platform.mobility.migration_state import MigrationState
from agents.platform.names import AgentName
from bus import BusError, BusUnavailable, Conversation, Subscription
from bus.aio import hand_over
from bus.name_holder import BusProgram
from bus.validation import check_value
from configs.suggestion import meant

log = logging.getLogger("agents")

Given = Mapping[str, Any]
Order = Callable[[Given], Awaitable[dict[str, Any]]]

READING = ("list", "introspect", "interface")  # orders that change nothing


class _OrderNotValid(AgentError, ValueError):
    """An order to a container is unknown or incomplete."""


class Control:
    """Carries out the orders to a container, concurrently, in the container's event loop."""

    def __init__(self, container: ControlledContainer) -> None:
        self._container = container
        self._process = BusProgram(os.getpid(), socket.gethostname(), uuid.uuid4().hex, container.wall_time())
        self._tasks: set[asyncio.Task[None]] = set()
        self._stopping: set[asyncio.Task[None]] = set()  # those of them that stop an agent
        self._orders: dict[str, Order] = {
            "list": self._list,
            "start": self._start,
            "stop": self._stop,
            "suspend": self._suspend,
            "resume": self._resume,
            "introspect": self._introspect,
            "interface": self._interface,
            "move": self._move,
            "clone": self._clone,
            "adopt": self._adopt,
            "settle": self._settle,
            "deliver": self._deliver,
            "forsake": self._forsake,
        }
        self._departures = Departures(container)
        self._arrivals = Arrivals(container)

    @property
    def process(self) -> BusProgram:
        """The process, host and start time."""
        return self._process

    def serve(self) -> list[Subscription]:
        """Serve orders and queries; needs a running event loop."""
        loop, called, bus = asyncio.get_running_loop(), self._container.called, self._container.bus

        def take(arguments: dict[str, Any], conversation: Conversation) -> None:
            check_value(arguments)
            hand_over(loop, self._begin, arguments, conversation, self._orders)

        def show(arguments: dict[str, Any], conversation: Conversation) -> None:
            check_value(arguments)
            reading = {name: self._orders[name] for name in READING}
            hand_over(loop, self._begin, {"do": "list", **arguments}, conversation, reading)

        return [
            bus.converse(called.control_key, take, urgent=True),
            bus.converse(called.description_key, show, urgent=True),
        ]

    async def close(self) -> None:
        """Refuse the orders under way, except those that stop an agent."""
        for task in self._tasks - self._stopping:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)  # they have answered, or end as cancelled
        await self._arrivals.close()
        self._departures.close()

    def _begin(self, arguments: dict[str, Any], conversation: Conversation, orders: Mapping[str, Order]) -> None:
        if arguments.get("do") == "begin" and orders is self._orders:
            self._call(arguments, conversation)
            return
        task = asyncio.ensure_future(self._answer(arguments, conversation, orders))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        task.add_done_callback(lambda task: conversation.close())  # also if the task was cancelled before it began

    async def _answer(self, arguments: dict[str, Any], conversation: Conversation, orders: Mapping[str, Order]) -> None:
        with contextlib.suppress(BusUnavailable):  # the sender cannot be reached any more
            try:
                conversation.reply(await self._do(arguments, orders))
            except asyncio.CancelledError:
                conversation.refuse(f"the container {self._container.name} is being closed")
                raise
            except (AgentError, BusError) as err:
                conversation.refuse(str(err))
            except Exception as err:
                log.error("the container %s cannot do %.200s", self._container.name, arguments, exc_info=err)
                conversation.refuse(f"the container {self._container.name} failed with {in_words(err)}")

    def _call(self, given: Given, conversation: Conversation) -> None:
        """Pass a conversation to an agent that has moved here, and that replies itself."""
        try:
            agent = self._container.agent(_name_in(given))
            agent.migration.gate.caller(_table_of(given, "message"), conversation)
        except AgentError as err:
            with contextlib.suppress(BusUnavailable):  # the sender cannot be reached any more
                conversation.refuse(str(err))

    async def _do(self, given: Given, orders: Mapping[str, Order]) -> dict[str, Any]:
        order = _text_of(given, "do")
        if order not in orders:
            near = meant(order, orders)
            advice = f"did you mean {near}?" if near else f"it obeys {', '.join(orders)}"
            where = "" if orders is self._orders else " where it is described"
            raise _OrderNotValid(f"a container does not obey {order!r}{where}; {advice}")
        return await orders[order](given)

    async def _list(self, given: Given) -> dict[str, Any]:
        called = self._container.called
        return {
            "container": called.name,
            "platform": called.platform,
            **self._process.told(),
            "agents": [
                {"name": str(agent.name), "kind": agent.kind, "state": str(agent.state)}
                for agent in self._container.agents
            ],
        }

    async def _start(self, given: Given) -> dict[str, Any]:
        agent = self._container.kinds.make(_text_of(given, "kind"), _name_in(given), _table_of(given, "properties"))
        await check_free(self._container.bus, agent.name)
        state = _table_of(given, "state") if "state" in given else None
        await self._container.bring_up(agent, partial(agent.begin, state=state))
        return {"name": str(agent.name), "state": str(agent.state)}

    async def _stop(self, given: Given) -> dict[str, Any]:
        agent, task = self._container.agent(_name_in(given)), asyncio.current_task()
        assert task is not None
        self._stopping.add(task)
        try:
            await self._container.stop(agent.name)
        finally:
            self._stopping.discard(task)
        return {"name": str(agent.name), "state": str(agent.state)}

    async def _suspend(self, given: Given) -> dict[str, Any]:
        agent = self._container.agent(_name_in(given))
        if agent.state is AgentState.SUSPENDED:
            raise _OrderNotValid(f"{agent.name} is suspended already")
        agent.suspend()
        return {"name": str(agent.name), "state": str(agent.state)}

    async def _resume(self, given: Given) -> dict[str, Any]:
        agent = self._container.agent(_name_in(given))
        if agent.state is not AgentState.SUSPENDED:
            raise _OrderNotValid(f"{agent.name} is not suspended; it is {agent.state}")
        agent.resume()
        return {"name": str(agent.name), "state": str(agent.state)}

    async def _introspect(self, given: Given) -> dict[str, Any]:
        return introspect(self._container.agent(_name_in(given)))

    async def _interface(self, given: Given) -> dict[str, Any]:
        return interface(self._container.agent(_name_in(given)))

    async def _move(self, given: Given) -> dict[str, Any]:
        agent = self._container.agent(_name_in(given))
        there, state = await self._departures.send(agent, _text_of(given, "to"))
        return {"name": str(agent.name), "state": str(state), "container": there.name}

    async def _clone(self, given: Given) -> dict[str, Any]:
        agent, name = self._container.agent(_name_in(given)), AgentName.parse(_text_of(given, "as"))
        to = _text_of(given, "to") if "to" in given else self._container.name
        there, state = await self._departures.clone(agent, name, to)
        return {"name": str(name), "state": str(state), "container": there.name}

    async def _adopt(self, given: Given) -> dict[str, Any]:
        agent = self._container.kinds.make(_text_of(given, "kind"), _name_in(given), _table_of(given, "properties"))
        await self._arrivals.adopt(
            agent, MigrationState.from_dict(_table_of(given, "luggage")), _text_of(given, "from")
        )
        return {"name": str(agent.name), "state": str(agent.state)}

    async def _settle(self, given: Given) -> dict[str, Any]:
        self._arrivals.settle(_name_in(given), QueuedMessage.from_list(given.get("letters")))
        return {}

    async def _deliver(self, given: Given) -> dict[str, Any]:
        self._container.agent(_name_in(given)).migration.gate.bring(QueuedMessage.from_list(given.get("letters")))
        return {}

    async def _forsake(self, given: Given) -> dict[str, Any]:
        await self._arrivals.forsake(_name_in(given), _text_of(given, "from"))
        return {}


def _name_in(given: Given) -> AgentName:
    """Return the name of the agent in an order.

    Raises:
        _OrderNotValid: There is none.
        NameNotValid: It is not the name of an agent.
    """
    return AgentName.parse(_text_of(given, "name"))


def _text_of(given: Given, field: str) -> str:
    """Return a text that an order must have.

    Raises:
        _OrderNotValid: It is missing or of another type.
    """
    value = given.get(field)
    if not isinstance(value, str):
        raise _OrderNotValid(f"this order to a container needs {field!r}, a text")
    return value


def _table_of(given: Given, field: str) -> dict[str, Any]:
    """Return a JSON object that an order may have.

    Raises:
        _OrderNotValid: It is of another type.
    """
    value = given.get(field, {})
    if not isinstance(value, dict):
        raise _OrderNotValid(f"{field!r} in an order to a container is a JSON object")
    return value
