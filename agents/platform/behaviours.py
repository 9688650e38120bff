"""Behaviours of agents, as in JADE, made of coroutines.

A behaviour consists of actions, which are coroutine functions without arguments, and of other behaviours; an action can
be used wherever a behaviour can. Time is that of the event loop, so a loop of virtual time runs a day in a second
(`virtual_time`). Blocking work belongs in `asyncio.to_thread`.

A behaviour has no reference to its agent: `Schedule` (schedule.py) runs it with a gate, for which it waits before each
action, and which is closed while the agent is suspended.
"""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Mapping
from enum import Enum
from numbers import Real
from typing import Any

Action = Callable[[], Awaitable[Any]]


class Gate:
    """A condition for which every action waits before it starts; closed while the agent is suspended or waits."""

    def __init__(self) -> None:
        self._open = asyncio.Event()
        self._open.set()

    def shut(self) -> None:
        """Close the gate."""
        self._open.clear()

    def open(self) -> None:
        """Open the gate."""
        self._open.set()

    async def passed(self) -> None:
        """Wait until it is open."""
        await self._open.wait()


class Behaviour(ABC):
    """A unit of work of an agent, which may run for ever.

    name: for reports and tools.
    """

    name: str = ""

    @staticmethod
    def of(part: "Behaviour | Action") -> "Behaviour":
        """Return a behaviour as it is, and an action as a behaviour that is done once."""
        return part if isinstance(part, Behaviour) else OneShot(part)

    @abstractmethod
    async def run(self, gate: Gate) -> Any:
        """Run it from the beginning, and return its result. It can be run again after it has ended or raised."""


class OneShot(Behaviour):
    """An action that is done once; its result is the behaviour's."""

    def __init__(self, action: Action, name: str = "") -> None:
        self.name = name or _name_of(action)
        self._action = _checked(action)

    async def run(self, gate: Gate) -> Any:
        """Do the action."""
        await gate.passed()
        return await self._action()


class Cyclic(Behaviour):
    """An action that is done again and again, until its agent ends or it raises `Done`.

    Other tasks get their turn after each action, even after one that waits for nothing.
    """

    def __init__(self, action: Action, name: str = "") -> None:
        self.name = name or _name_of(action)
        self._action = _checked(action)

    async def run(self, gate: Gate) -> Any:
        """Do the action until it raises `Done`."""
        try:
            while True:
                await gate.passed()
                await self._action()
                await asyncio.sleep(0)
        except Done as done:
            return done.result


class Ticker(Behaviour):
    """An action that is done every `period` seconds, the first time after one period, until it raises `Done`.

    The times are absolute, so the period does not drift. Times that were missed, because the action took longer or the
    agent was suspended, are skipped and counted.
    """

    def __init__(self, period: float, action: Action, name: str = "") -> None:
        self.check(period)
        self.name = name or _name_of(action)
        self.missed = 0
        self._period = period
        self._action = _checked(action)

    @staticmethod
    def check(period: object) -> None:
        """Check the time from one beat to the next.

        Raises:
            ValueError: It is not a time of more than 0 s.
        """
        if not isinstance(period, Real) or not float(period) > 0.0:
            raise ValueError(f"a period is more than 0 s, not {period!r}")

    async def run(self, gate: Gate) -> Any:
        """Do the action in every period until it raises `Done`."""
        loop = asyncio.get_running_loop()
        start, beat = loop.time(), 0
        try:
            while True:
                beat += 1
                late = int((loop.time() - start) / self._period) + 1
                self.missed += max(late - beat, 0)
                beat = max(late, beat)
                await asyncio.sleep(start + beat * self._period - loop.time())
                await gate.passed()
                await self._action()
        except Done as done:
            return done.result


class Waker(Behaviour):
    """An action that is done once, `delay` seconds from now."""

    def __init__(self, delay: float, action: Action, name: str = "") -> None:
        self.name = name or _name_of(action)
        self._delay = delay
        self._action = _checked(action)

    async def run(self, gate: Gate) -> Any:
        """Wait, and do the action."""
        await asyncio.sleep(self._delay)
        await gate.passed()
        return await self._action()


class Sequential(Behaviour):
    """Behaviours one after the other; the result is the list of their results. One that raises ends the sequence."""

    def __init__(self, *parts: Behaviour | Action, name: str = "sequence") -> None:
        self.name = name
        self._parts = [Behaviour.of(part) for part in parts]

    async def run(self, gate: Gate) -> list[Any]:
        """Run each to its end."""
        return [await part.run(gate) for part in self._parts]


class Until(Enum):
    """When a parallel behaviour ends."""

    ALL = "all"  # its result is the list of all results
    ANY = "any"  # its result is that of the first to end; the others are cancelled


class Parallel(Behaviour):
    """Behaviours at the same time, until all or any have ended. One that raises cancels the others."""

    def __init__(self, *parts: Behaviour | Action, until: Until = Until.ALL, name: str = "parallel") -> None:
        if not parts:
            raise ValueError("a parallel behaviour has at least one part")
        self.name = name
        self._parts = [Behaviour.of(part) for part in parts]
        self._until = until

    async def run(self, gate: Gate) -> Any:
        """Run all together."""
        tasks = [asyncio.ensure_future(part.run(gate)) for part in self._parts]
        try:
            if self._until is Until.ALL:
                return await asyncio.gather(*tasks)
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            return next(task for task in tasks if task.done()).result()
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)  # the first error goes on; the others end as cancelled


class FiniteStateMachine(Behaviour):
    """States, each a behaviour, whose results select the next state.

    The result of a state is the event; `(state, event)` in the transitions names the next state. A state that has no
    transitions at all is final, and its result is the machine's. An event without a transition raises `NoTransition`.
    """

    def __init__(
        self,
        states: Mapping[str, Behaviour | Action],
        transitions: Mapping[tuple[str, Any], str],
        start: str,
        name: str = "state machine",
    ) -> None:
        """Check the machine and keep it.

        Raises:
            ValueError: The start or a transition names a state that does not exist.
        """
        named = {start, *(state for state, _ in transitions), *transitions.values()}
        if missing := sorted(named - states.keys()):
            raise ValueError(f"the state machine has no state {', '.join(map(repr, missing))}")
        self.name = name
        self.state = start
        self._start = start
        self._states = {name: Behaviour.of(part) for name, part in states.items()}
        self._transitions = dict(transitions)
        self._leading_on = {state for state, _ in transitions}

    async def run(self, gate: Gate) -> Any:
        """Go from state to state until a final one has ended."""
        self.state = self._start
        while True:
            event = await self._states[self.state].run(gate)
            if self.state not in self._leading_on:
                return event
            if (self.state, event) not in self._transitions:
                raise NoTransition(f"nothing follows {event!r} in the state {self.state!r}")
            self.state = self._transitions[self.state, event]
            await asyncio.sleep(0)


class Done(Exception):
    """Raised by an action to end the behaviour that repeats it.

    result: what the behaviour returns.
    """

    def __init__(self, result: Any = None) -> None:
        super().__init__("done")
        self.result = result


class NoTransition(LookupError):
    """A state of a machine ended with an event that has no transition."""


def _checked(action: Action) -> Action:
    """Return an action that can be called.

    Raises:
        TypeError: It cannot.
    """
    if not callable(action):
        raise TypeError(f"an action is a coroutine function, not {action!r}")
    return action


def _name_of(action: Action) -> str:
    """Return the name of an action."""
    return str(getattr(action, "__name__", type(action).__name__))
