"""A program that works for an agent: started with it, used over standard streams or TCP, and ended with it."""

import asyncio
import contextlib
import ctypes
import os
import signal
import sys
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from agents.wrappers.codec import Answered, Event, NonsenseHeard, ProgramCodec, RequestFailed, Told
from bus.validation import printable

PORTION = 1 << 16  # bytes read at a time
KNOCK_PERIOD = 0.1  # s between two tries to reach a server that is starting
ENDING_TIME = 1.0  # s that a program has to end when it is told to
LAST_WORDS = 5  # lines of its standard error that are told when it has ended
_SET_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of Linux's prctl


class ProgramEnded(Exception):
    """The program has ended, or cannot be reached."""


class NotAnswered(Exception):
    """The program refuses, or has not answered."""


class ProgramRun:
    """One run of a program, from its start to its end."""

    def __init__(
        self,
        command: Sequence[str],
        folder: Path,
        address: str,
        codec: ProgramCodec,
        on_told: Callable[[dict[str, Any]], None],
    ) -> None:
        """Prepare a run.

        Args:
            command: What to start; empty for a server that runs already.
            folder: Its working folder.
            address: HOST:PORT, or empty for standard streams.
            codec: Its protocol; new for each run.
            on_told: Called with results without a request.
        """
        self._command = command
        self._folder = folder
        self._address = address
        self._codec = codec
        self._on_told = on_told
        self._process: asyncio.subprocess.Process | None = None
        self._reader: asyncio.StreamReader | None = None
        self._writer: asyncio.StreamWriter | None = None
        self._last_words: deque[str] = deque(maxlen=LAST_WORDS)
        self._listening: asyncio.Task[None] | None = None
        self._answer: asyncio.Future[Answered | RequestFailed] | None = None
        self._turn = asyncio.Lock()

    @property
    def name(self) -> str:
        """Its name, for messages."""
        return Path(self._command[0]).name if self._command else self._address

    async def start(self, within: float) -> None:
        """Start it and connect to it.

        Args:
            within: s, for both.
        Raises:
            ProgramEnded: It cannot be started, or reached in time.
        """
        try:
            if self._command:
                await self._spawn()
            if self._address:
                await self._reach(within)
            else:
                assert self._process is not None
                self._reader, self._writer = self._process.stdout, self._process.stdin
        except BaseException:
            await self.end()
            raise

    async def run(self) -> None:
        """Read its output until it ends.

        Raises:
            ProgramEnded: It has; always.
        """
        try:
            await self._hear()
        except NonsenseHeard as error:
            raise self._lost(f"{self.name} cannot be understood: {error}") from error
        raise self._lost(await self._how_it_ended())

    async def ask(self, name: str, arguments: Mapping[str, Any], within: float) -> dict[str, Any]:
        """Send one request, after earlier ones.

        A cancelled call leaves the request to its end, since its answer would be taken for that of the next one.

        Raises:
            NotAnswered: It refuses, or the arguments cannot be encoded.
            ProgramEnded: It ended meanwhile, or has not answered in time.
        """
        return await asyncio.shield(asyncio.ensure_future(self._ask(name, arguments, within)))

    async def end(self) -> None:
        """Disconnect from it; a process that was started here ends."""
        if self._writer is not None:
            self._writer.close()
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):  # it has just ended by itself
                self._process.terminate()
            try:
                async with asyncio.timeout(ENDING_TIME):
                    await self._process.wait()
            except TimeoutError:
                self._process.kill()
                await self._process.wait()
        if self._listening is not None:
            self._listening.cancel()

    async def _spawn(self) -> None:
        pipe, nothing = (
            asyncio.subprocess.PIPE,
            asyncio.subprocess.DEVNULL,
        )  # a program that is reached by TCP says nothing here
        streams = nothing if self._address else pipe
        try:
            self._process = await asyncio.create_subprocess_exec(
                *self._command,
                cwd=self._folder,
                stdin=streams,
                stdout=streams,
                stderr=pipe,
                limit=PORTION,
                preexec_fn=partial(die_with, os.getpid()) if sys.platform == "linux" else None,
            )
        except OSError as error:
            raise ProgramEnded(f"{self._command[0]} cannot be started: {error.strerror}") from error
        self._listening = asyncio.ensure_future(self._hear_last_words(self._process))

    async def _reach(self, within: float) -> None:
        host, _, port = self._address.rpartition(":")
        loop = asyncio.get_running_loop()
        deadline = loop.time() + within
        while True:
            try:
                async with asyncio.timeout_at(deadline):
                    self._reader, self._writer = await asyncio.open_connection(host, int(port))
                return
            except (OSError, TimeoutError) as error:
                if self._process is not None and self._process.returncode is not None:
                    raise ProgramEnded(await self._how_it_ended()) from error
                if loop.time() + KNOCK_PERIOD > deadline:
                    raise ProgramEnded(f"nobody listens on {self._address} after {within:g} s") from error
            await asyncio.sleep(KNOCK_PERIOD)

    async def _hear(self) -> None:
        assert self._reader is not None
        with contextlib.suppress(ConnectionError):  # it has hung up, and whoever keeps it running says so
            while data := await self._reader.read(PORTION):
                for event in self._codec.receive(data):
                    self._heard(event)

    def _heard(self, event: Event) -> None:
        if isinstance(event, Told):
            self._on_told(event.value)
        elif self._answer is not None and not self._answer.done():
            self._answer.set_result(event)
        # An answer without a request is ignored.

    async def _ask(self, name: str, arguments: Mapping[str, Any], within: float) -> dict[str, Any]:
        async with self._turn:
            if self._writer is None or self._writer.is_closing():
                raise ProgramEnded(f"{self.name} has ended")
            try:
                said = self._codec.ask(name, arguments)
            except ValueError as error:
                raise NotAnswered(str(error)) from error
            self._answer = asyncio.get_running_loop().create_future()
            try:
                async with asyncio.timeout(within):
                    self._writer.write(said)
                    await self._writer.drain()
                    if not self._codec.wants_answer(name):
                        return {}
                    answer = await self._answer
            except ConnectionError as error:
                raise ProgramEnded(f"{self.name} does not listen any more") from error
            except TimeoutError as error:
                # Its answer may still come, and would be taken for that of the next request: restart.
                self._writer.close()
                raise ProgramEnded(f"{self.name} has not answered {name} within {within:g} s") from error
            finally:
                self._answer = None
            if isinstance(answer, RequestFailed):
                raise NotAnswered(answer.why)
            return answer.value

    def _lost(self, why: str) -> ProgramEnded:
        """Report the end, also to calls that wait for an answer."""
        error = ProgramEnded(why)
        if self._answer is not None and not self._answer.done():
            self._answer.set_exception(error)
        return error

    async def _how_it_ended(self) -> str:
        if self._process is None:
            return f"{self._address} has closed the connection"
        if self._writer is not None:
            self._writer.close()
        try:
            async with asyncio.timeout(ENDING_TIME):
                code = await self._process.wait()
                if self._listening is not None:
                    await self._listening
        except TimeoutError:
            return f"{self.name} says nothing more"
        how = f"exit code {code}" if code >= 0 else f"by {signal.Signals(-code).name}"
        words = f": {' / '.join(self._last_words)}" if self._last_words else ""
        return f"{self.name} has ended ({how}){words}"

    async def _hear_last_words(self, process: asyncio.subprocess.Process) -> None:
        assert process.stderr is not None
        rest = b""
        while data := await process.stderr.read(PORTION):
            *lines, rest = (rest + data)[-PORTION:].split(b"\n")
            self._last_words.extend(
                printable(line.decode("utf-8", "replace").strip()) for line in lines if line.strip()
            )


# Found before any fork: between fork and exec nothing may be loaded.
_LIBC = ctypes.CDLL(None) if sys.platform == "linux" else None


def die_with(parent: int) -> None:
    """Let Linux end this program with the one that started it, even if that one is killed."""
    assert _LIBC is not None
    _LIBC.prctl(_SET_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() != parent:  # it was gone before the line above
        os.kill(os.getpid(), signal.SIGKILL)
