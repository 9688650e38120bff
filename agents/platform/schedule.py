"""Runs an agent's behaviours, and applies a policy to those that raise."""

import asyncio
import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from agents.platform.behaviours import Behaviour, Gate

LETTING_GO = 1.0  # s for handlers and behaviours to end when they are cancelled


@dataclass(frozen=True, slots=True)
class Drop:
    """A behaviour that raises ends; the others continue."""


@dataclass(frozen=True, slots=True)
class FailAgent:
    """A behaviour that raises ends its agent, which cannot do without it."""


@dataclass(frozen=True, slots=True)
class Restart:
    """A behaviour that raises is restarted after a pause, which doubles with each failure.

    first, longest: s. A pause is up to a tenth longer, at random, so that many are not restarted at once.
    healthy_after: s without a failure after which the next pause is the first again.
    attempts: number of consecutive failures after which the behaviour is dropped; None for no limit.
    """

    first: float = 0.1
    longest: float = 10.0
    healthy_after: float = 30.0
    attempts: int | None = None

    def pause(self, failures: int) -> float:
        """Return the pause after this number of consecutive failures, s, without its random part."""
        return float(min(self.longest, self.first * 2.0 ** min(failures - 1, 60)))


Policy = Drop | FailAgent | Restart
DROP = Drop()
"""Policy: a behaviour that fails is removed; the agent and its other behaviours continue."""
FAIL_AGENT = FailAgent()
"""Policy: a behaviour that fails makes its agent fail."""


@dataclass(frozen=True, slots=True)
class Failure:
    """A behaviour has raised.

    outcome: what follows, as text: `dropped`, `begins again in 0.2 s`, `its agent ends`.
    """

    behaviour: str
    error: Exception
    outcome: str


class Running:
    """One behaviour in a schedule.

    failures: number of times it has raised.
    """

    def __init__(self, behaviour: Behaviour, policy: Policy) -> None:
        self.behaviour = behaviour
        self.policy = policy
        self.failures = 0
        self.task: asyncio.Task[Any] | None = None

    async def result(self) -> Any:
        """Wait for its end, and return its result, or None when it was dropped.

        Raises:
            asyncio.CancelledError: It was stopped.
        """
        assert self.task is not None
        return await asyncio.shield(self.task)

    def stop(self) -> None:
        """Cancel it."""
        if self.task is not None:
            self.task.cancel()


class Schedule:
    """The behaviours of one agent. Their errors are reported, and handled by their policies."""

    def __init__(self, report: Callable[[Failure], None], fail_agent: Callable[[Failure], None]) -> None:
        """Make an empty one.

        Args:
            report: Called with every failure.
            fail_agent: Called after `report` with a failure whose policy is `FailAgent`.
        """
        self.gate = Gate()
        self._report = report
        self._fail_agent = fail_agent
        self._running: dict[Running, None] = {}

    def add(self, behaviour: Behaviour, policy: Policy = DROP) -> Running:
        """Start a behaviour; needs a running event loop."""
        running = Running(behaviour, policy)
        running.task = asyncio.get_running_loop().create_task(self._live(running), name=behaviour.name)
        self._running[running] = None
        running.task.add_done_callback(lambda task: self._running.pop(running, None))
        return running

    @property
    def running(self) -> list[Running]:
        """The behaviours that have not ended, oldest first."""
        return list(self._running)

    async def stop(self, within: float = LETTING_GO) -> list[str]:
        """Cancel all and wait until they have ended, except for the one that calls this.

        Args:
            within: s for them to end.
        Returns:
            Those that have not ended, as text.
        """
        me = asyncio.current_task()
        running = {one.task: one for one in self._running if one.task is not None and one.task is not me}
        for task in running:
            task.cancel()
        _, late = await asyncio.wait(running, timeout=within) if running else (None, set())
        return [f"the behaviour {one.behaviour.name}" for task, one in running.items() if task in late]

    async def _live(self, running: Running) -> Any:
        in_a_row = 0
        loop = asyncio.get_running_loop()
        while True:
            began = loop.time()
            try:
                return await running.behaviour.run(self.gate)
            except Exception as error:
                running.failures += 1
                healthy = isinstance(running.policy, Restart) and loop.time() - began >= running.policy.healthy_after
                in_a_row = 1 if healthy else in_a_row + 1
                pause = self._judge(running, error, in_a_row)
            if pause is None:
                return None
            await asyncio.sleep(pause)

    def _judge(self, running: Running, error: Exception, in_a_row: int) -> float | None:
        """Report a failure; return the pause before the restart, s, or None when there is none."""
        name = running.behaviour.name
        match running.policy:
            case Restart(attempts=attempts) as policy if attempts is None or in_a_row < attempts:
                pause = policy.pause(in_a_row) * random.uniform(1.0, 1.1)
                self._report(Failure(name, error, f"begins again in {pause:.2g} s"))
                return pause
            case FailAgent():
                failure = Failure(name, error, "its agent ends")
                self._report(failure)
                self._fail_agent(failure)
            case _:
                self._report(Failure(name, error, "dropped"))
        return None
