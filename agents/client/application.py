"""An application as an agent of the upper layer: in the directory, asked, suspended and stopped like any other."""

import asyncio
import inspect
import threading
from collections.abc import Awaitable, Callable, Mapping
from functools import wraps
from pathlib import Path
from typing import Any, get_type_hints

from agents.client.errors import Failed, Stopped
from agents.client.loop_thread import LoopThread
from agents.client.private_container import PLATFORM
from agents.client.program import RunningApplication, find_program
from agents.client.team import Team, look
from agents.platform import FAIL_AGENT, Agent, AgentName, OneShot, Restart
from agents.platform.hooks import marks
from bus.aio import hand_over

SERVICE = "application"
LEAVE = 1.0  # s in which a program that is told to end is expected to


def application_agent(
    path_or_module: str | Path, name: AgentName | str | None = None, arguments: Mapping[str, Any] | None = None
) -> "Application":
    """Make an agent of an application; a container starts it.

    Args:
        path_or_module: A file, or a module of the package `apps`.
        name: The agent's; by default the file's, `wander@apps`.
        arguments: For its `main`.
    Raises:
        RobotError: There is no such application, it cannot be loaded, or does not take these arguments.
    """
    program = find_program(str(path_or_module))
    program.check(arguments or {})
    return Application(program, name or AgentName(program.name, PLATFORM), arguments or {})


class Application(Agent):
    """Runs a program's `main` in a thread, and answers with the functions that `@request` marks.

    While it is suspended, the program waits at its next call of the team; what it drives stands, and a motion that is
    under way goes to its end. When it is stopped, that call raises `Stopped`. When `main` returns, the agent lives on
    if there is something to ask it for, else it ends.

    ended: set when it has. has_failed: whether `main` raised when it last ran.
    """

    def __init__(self, program: RunningApplication, name: AgentName | str, arguments: Mapping[str, Any]) -> None:
        super().__init__(name, {"program": program.name, "arguments": dict(arguments)})
        self.ended = asyncio.Event()
        self.has_failed = False
        self._program = program
        self._arguments = dict(arguments)

    def describe(self) -> dict[str, Any]:
        """What the directory says of it."""
        return {**super().describe(), "services": [SERVICE, *self._program.services]}

    async def setup(self) -> None:
        """Begin."""
        self._thread = LoopThread(self, asyncio.get_running_loop())
        self._discovery = await look(self._thread)
        self._program = await self.load()
        self._team = Team.of(self._thread, self._discovery)
        for function in self._program.functions:
            for mark in marks(function):
                mark.begin(self, self._threaded(function))
        self.add(OneShot(self._main, "main"), Restart() if self._program.begins_again else FAIL_AGENT)

    async def load(self) -> RunningApplication:
        """The program; for kinds of applications that have not loaded it when they are made."""
        return self._program

    def suspend(self) -> None:
        """Rest; the program waits at its next call."""
        super().suspend()
        self._thread.suspend()

    def resume(self) -> None:
        """Go on."""
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
            self.ended.set()  # last: who waits for this may close the container, and who has stopped it is to hear so

    async def _main(self) -> None:
        self.has_failed = False
        try:
            await in_thread(lambda: self._program.run(self._team, self._arguments), str(self.name))
        except Exception:
            self.has_failed = True
            raise
        if not any(marks(function) for function in self._program.functions):
            self.delete()

    def _threaded(self, function: Callable[..., Any]) -> Callable[..., Awaitable[Any]]:
        """The same function for the event loop; it gets the team if it asks for one as its first argument."""
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


async def in_thread(work: Callable[[], None], name: str) -> None:
    """Do what may take long, or for ever, in a thread of its own; who is cancelled waits a little for its end."""
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
