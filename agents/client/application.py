"""An application as an agent: it is in the directory, and is asked, suspended and stopped like any other."""

import asyncio
import inspect
import threading
from collections.abc import Awaitable, Callable, Mapping
from functools import wraps
from typing import Any, get_type_hints

from agents.client.discovery import Discovery
from agents.client.errors import Failed, Stopped
from agents.client.loop_thread import LoopThread
from agents.client.program import RunningApplication
from agents.client.team import Team
from agents.platform import FAIL_AGENT, Agent, AgentName, OneShot, Restart
from agents.platform.hooks import marks
from bus.aio import hand_over

SERVICE = "application"
LEAVE = 1.0  # s for a program to end


class Application(Agent):
    """Runs a program's `main` in a thread, and answers with the functions that `@request` marks.

    While it is suspended, the program waits at its next call of the team; continuous driving stops, and a motion under
    way is completed. When it is stopped, that call raises `Stopped`. When `main` returns, the agent continues if it has
    functions for requests, else it ends.

    ended: set when it has. has_failed: whether `main` raised when it last ran.
    """

    def __init__(self, program: RunningApplication, name: AgentName | str, arguments: Mapping[str, Any]) -> None:
        super().__init__(name, {"program": program.name, "arguments": dict(arguments)})
        self.ended = asyncio.Event()
        self.has_failed = False
        self._program = program
        self._arguments = dict(arguments)

    def describe(self) -> dict[str, Any]:
        """Return its description for the directory."""
        return {**super().describe(), "services": [SERVICE, *self._program.services]}

    async def setup(self) -> None:
        """Start the program."""
        self._thread = LoopThread(self, asyncio.get_running_loop())
        self._discovery = Discovery(self.bus)
        self._program = await self.load()
        self._team = Team.of(self._thread, self._discovery)
        for function in self._program.functions:
            for mark in marks(function):
                mark.begin(self, self._threaded(function))
        self.add(OneShot(self._main, "main"), Restart() if self._program.begins_again else FAIL_AGENT)

    async def load(self) -> RunningApplication:
        """Return the program; for kinds of applications that load it later."""
        return self._program

    def suspend(self) -> None:
        """Suspend the agent; the program waits at its next call."""
        super().suspend()
        self._thread.suspend()

    def resume(self) -> None:
        """Resume the agent and the program."""
        super().resume()
        self._thread.resume()

    def mark_deleted(self) -> None:
        """End the program at its next call."""
        super().mark_deleted()
        self._thread.stop(f"{self.name} is stopped")

    async def take_down(self) -> None:
        """Stop what it moves."""
        self._discovery.close()
        try:
            await self._thread.halt()
        finally:
            self.ended.set()  # last: the waiting task may close the container

    async def _main(self) -> None:
        self.has_failed = False
        try:
            await _in_thread(lambda: self._program.run(self._team, self._arguments), str(self.name))
        except Exception:
            self.has_failed = True
            raise
        if not any(marks(function) for function in self._program.functions):
            self.delete()

    def _threaded(self, function: Callable[..., Any]) -> Callable[..., Awaitable[Any]]:
        """Return a coroutine function for a function; it gets the team if its first parameter is `team`."""
        signature = inspect.signature(function)
        wants_team = next(iter(signature.parameters), "") == "team"
        own = (self._team,) if wants_team else ()

        @wraps(function)
        async def run(**arguments: Any) -> Any:
            try:
                return await asyncio.to_thread(function, *own, **arguments)
            except Stopped as err:
                raise Failed(str(err)) from err

        parameters = list(signature.parameters.values())[len(own) :]
        run.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]  # inspect reads it
        run.__annotations__ = {**get_type_hints(function)}
        return run


async def _in_thread(work: Callable[[], None], name: str) -> None:
    """Run a function in a thread of its own, and wait for its end; a cancelled wait lasts a little longer."""
    loop = asyncio.get_running_loop()
    ended: asyncio.Future[None] = loop.create_future()

    def run() -> None:
        error: Exception | None = None
        try:
            work()
        except Exception as err:
            error = err
        except BaseException:  # it was stopped, or has called sys.exit
            pass
        hand_over(loop, tell, error)

    def tell(error: Exception | None) -> None:
        if ended.done():
            return
        if error is None:
            ended.set_result(None)
        else:
            ended.set_exception(error)

    threading.Thread(target=run, name=name, daemon=True).start()
    try:
        await asyncio.shield(ended)
    except asyncio.CancelledError:
        await asyncio.wait([ended], timeout=LEAVE)
        raise
