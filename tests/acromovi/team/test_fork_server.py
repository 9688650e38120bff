"""Processes that begin as copies of the fork server."""

import asyncio
import os
import signal
from collections.abc import Awaitable, Callable
from pathlib import Path

from acromovi.team.forks import ForkedProcess, ForkServer
from acromovi.team.processes import LONGEST_LINE
from tests.waiting import waiting

TIME = 30.0  # s
CONTAINER = ("acromovi", "container", "fork-test", "--json")


def _play(part: Callable[[ForkServer, int], Awaitable[None]]) -> None:
    """Run a part with a server whose process is the leader of its group; gives its number as well."""

    async def play() -> None:
        async with waiting(TIME):
            forks = await ForkServer.open(0)
            try:
                await part(forks, forks.pid)
            finally:
                await forks.close()

    asyncio.run(play())


def _command(pid: int) -> str:
    return Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8").rstrip("\0").replace("\0", " ")


async def _start(forks: ForkServer, *words: str) -> ForkedProcess:
    process = await forks.start(words, LONGEST_LINE)
    assert process is not None
    return process


def test_a_copy_prints_and_ends_as_a_program_does() -> None:
    async def part(forks: ForkServer, server: int) -> None:
        good, bad = (
            await _start(forks, "acromovi", "--version"),
            await _start(forks, "gateway", "nowhere", "--nonsense"),
        )
        assert (await good.stdout.read()).startswith(b"acromovi ")
        assert b"--nonsense" in await bad.stderr.read()
        assert [await good.wait(), await bad.wait()] == [0, 2]

    _play(part)


def test_a_copy_shows_its_own_command_line_and_lives_in_the_group_of_its_server() -> None:
    async def part(forks: ForkServer, server: int) -> None:
        process = await _start(forks, *CONTAINER)
        assert await process.stdout.readline() == b'{"container": "fork-test"}\n'
        assert _command(process.pid).endswith("-m acromovi container fork-test --json")
        assert os.getpgid(process.pid) == os.getpgid(server) == server
        os.kill(process.pid, signal.SIGTERM)
        assert await process.wait() == 128 + signal.SIGTERM

    _play(part)


def test_a_signal_that_ends_a_copy_is_reported() -> None:
    async def part(forks: ForkServer, server: int) -> None:
        process = await _start(forks, *CONTAINER)
        os.kill(process.pid, signal.SIGKILL)
        assert await process.wait() == -signal.SIGKILL

    _play(part)


def test_when_the_server_is_killed_its_copies_go_on_and_their_ends_are_seen() -> None:
    async def part(forks: ForkServer, server: int) -> None:
        process = await _start(forks, *CONTAINER)
        await process.stdout.readline()
        os.kill(server, signal.SIGKILL)
        while await forks.start(("acromovi", "--version"), LONGEST_LINE) is not None:
            await asyncio.sleep(0.01)
        os.kill(process.pid, 0)  # it is still there
        waits = asyncio.ensure_future(process.wait())
        os.kill(process.pid, signal.SIGTERM)
        assert await waits == 1  # nobody knows its exit code

    _play(part)


def test_copies_are_programs_of_their_own_on_the_bus() -> None:
    async def part(forks: ForkServer, server: int) -> None:
        names = [f"fork-test-{number}" for number in range(3)]
        processes = [await _start(forks, "acromovi", "container", name, "--json") for name in names]
        for process, name in zip(processes, names, strict=True):
            assert name.encode() in await process.stdout.readline()
        found = await _start(forks, "acromovi", "ps", "--json")
        assert await found.wait() == 0
        for process in processes:
            os.kill(process.pid, signal.SIGTERM)
            assert await process.wait() == 128 + signal.SIGTERM

    _play(part)
