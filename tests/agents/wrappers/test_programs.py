"""Programs as agents: ACTS, programs on standard streams, and all the ways in which they come and go."""

import asyncio
import os
import signal
import sys
from pathlib import Path
from typing import Any

import pytest

from agents.platform import Ending
from agents.wrappers.program import ProgramEnded
from tests.agents.wrappers.conftest import bench
from tests.waiting import waiting

SERVER = Path(__file__).with_name("acts_server.py")

TALKER = """
import sys, time
print("ready when you are", flush=True)
for line in sys.stdin:
    word, _, rest = line.strip().partition(" ")
    if word == "ADD":
        a, b = map(float, rest.split())
        print(f"POS {a} {b}")
        print(f"SUM {a + b}" if a >= 0 else "NO I cannot count below zero")
    elif word == "SLEEP":
        time.sleep(float(rest))
        print("SLEPT")
    elif word == "DIE":
        print("it was all too much", file=sys.stderr, flush=True)
        sys.exit(3)
    elif word == "PID":
        import os
        print("PID", os.getpid())
    sys.stdout.flush()
"""


@pytest.fixture
def talker(tmp_path: Path) -> Path:
    (tmp_path / "talker.py").write_text(TALKER)
    file = tmp_path / "talker.toml"
    file.write_text(f"""
services = ["sums"]
[program]
command = [{sys.executable!r}, "talker.py"]
[[requests]]
name = "add"
takes = {{a = "number", b = "number"}}
defaults = {{b = 1.0}}
send = "ADD {{a}} {{b}}"
answer = 'SUM (?P<sum>\\S+)'
error = 'NO (?P<why>.*)'
[[requests]]
name = "sleep"
takes = {{seconds = "number"}}
send = "SLEEP {{seconds}}"
answer = "SLEPT"
within_s = 0.3
[[requests]]
name = "die"
send = "DIE"
[[requests]]
name = "pid"
send = "PID"
answer = 'PID (?P<pid>\\d+)'
[[results]]
line = 'POS (?P<x>\\S+) (?P<y>\\S+)'
""")
    return file


@pytest.fixture
def acts(tmp_path: Path, free_port: int) -> Path:
    file = tmp_path / "acts.toml"
    file.write_text(f"""
[program]
command = [{sys.executable!r}, {str(SERVER)!r}, "{free_port}"]
address = "127.0.0.1:{free_port}"
codec = "acts"
[[requests]]
name = "blobs"
[[requests]]
name = "quit"
[[results]]
request = "blobs"
every_s = 0.02
""")
    return file


def test_a_server_of_acts_is_an_agent(acts: Path) -> None:
    async def scenario() -> None:
        async with bench(acts) as at:
            blobs = (await at.ask("blobs")).value()["blobs"]
            assert [(blob["channel"], blob["area"]) for blob in blobs] == [(1, 5000), (1, 12), (7, 70)]
            await at.until(lambda: len(at.results) >= 3)
            moving = [result["blobs"][2]["x"] for result in at.results]
            assert moving == sorted(set(moving)), "each result is of a newer picture"

    asyncio.run(scenario())


def test_a_server_that_ends_is_started_again_and_serves(acts: Path) -> None:
    async def scenario() -> None:
        async with bench(acts) as at:
            assert (await at.ask("quit")).is_done
            await at.until(lambda: at.reports)
            async with waiting():
                while not (outcome := await at.ask("blobs")).is_done:
                    assert "started again" in outcome.why or "has ended" in outcome.why or "closed" in outcome.why
                    await asyncio.sleep(0.02)

    asyncio.run(scenario())


def test_a_program_on_standard_streams_answers_refuses_and_tells(talker: Path) -> None:
    async def scenario() -> None:
        async with bench(talker) as at:
            assert (await at.ask("add", a=2, b=3.5)).value() == {"sum": 5.5}
            assert (await at.ask("add", a=2)).value() == {"sum": 3.0}
            refused = await at.ask("add", a=-1)
            assert (refused.ending, refused.why) == (Ending.FAILED, "I cannot count below zero")
            assert (await at.ask("add", a="two")).ending is Ending.NOT_UNDERSTOOD
            assert (await at.ask("add")).ending is Ending.NOT_UNDERSTOOD
            await at.until(lambda: len(at.results) == 3)
            assert at.results[0] == {"x": 2, "y": 3.5}

    asyncio.run(scenario())


def test_requests_that_come_together_are_put_one_after_the_other(talker: Path) -> None:
    async def scenario() -> None:
        async with bench(talker) as at:
            outcomes = await asyncio.gather(*(at.ask("add", a=a, b=0) for a in range(20)))
            assert [outcome.value()["sum"] for outcome in outcomes] == list(range(20))

    asyncio.run(scenario())


def test_a_program_that_dies_is_told_with_its_last_words_and_begins_again(talker: Path) -> None:
    async def scenario() -> None:
        async with bench(talker) as at:
            await at.ask("die")
            await at.until(lambda: at.reports)
            error = at.reports[0].error
            assert isinstance(error, ProgramEnded)
            assert "(exit code 3): it was all too much" in str(error)
            async with waiting():
                while not (await at.ask("add", a=1)).is_done:
                    await asyncio.sleep(0.02)

    asyncio.run(scenario())


def test_a_late_answer_is_never_taken_for_the_next_one(talker: Path) -> None:
    async def scenario() -> None:
        async with bench(talker) as at:
            late = await at.ask("sleep", seconds=1.0)
            assert (late.ending, "has not answered sleep within 0.3 s" in late.why) == (Ending.FAILED, True)
            async with waiting():
                while not (outcome := await at.ask("add", a=1)).is_done:
                    await asyncio.sleep(0.02)
            assert outcome.value() == {"sum": 2.0}

    asyncio.run(scenario())


def test_the_program_ends_with_its_agent(talker: Path) -> None:
    async def scenario() -> None:
        async with bench(talker) as at:
            pid: int = (await at.ask("pid")).value()["pid"]
            os.kill(pid, 0)
            await at.container.stop("it@happy")
            with pytest.raises(ProcessLookupError):
                os.kill(pid, 0)

    asyncio.run(scenario())


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux ends children of a process that is killed")
def test_the_program_ends_even_when_its_container_is_killed(talker: Path, tmp_path: Path) -> None:
    script = f"""
import asyncio
from tests.agents.wrappers.conftest import bench
from pathlib import Path

async def main():
    async with bench(Path({str(talker)!r})) as at:
        print((await at.ask("pid")).value()["pid"], flush=True)
        await asyncio.sleep(60.0)

asyncio.run(main())
"""

    async def scenario() -> None:
        container = await asyncio.create_subprocess_exec(
            sys.executable, "-c", script, stdout=asyncio.subprocess.PIPE, cwd=Path(__file__).parents[3]
        )
        assert container.stdout is not None
        pid = int(await container.stdout.readline())
        container.send_signal(signal.SIGKILL)
        await container.wait()
        async with waiting():
            while is_alive(pid):
                await asyncio.sleep(0.01)

    asyncio.run(scenario())


def is_alive(pid: int) -> bool:
    """Whether it runs; a zombie that nobody fetches does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):  # it has ended
        return False


@pytest.mark.parametrize(
    ("program", "why"),
    [
        ('command = ["no-such-program"]', "no-such-program cannot be started: No such file or directory"),
        ('command = ["./talker.toml"]', "cannot be started: Permission denied"),
        ('address = "127.0.0.1:9"\nready_within_s = 0.2', "nobody listens on 127.0.0.1:9 after 0.2 s"),
    ],
)
def test_requests_are_refused_while_the_program_is_not_there(talker: Path, program: str, why: str) -> None:
    text = talker.read_text().splitlines()
    text[text.index("[program]") + 1] = program
    talker.write_text("\n".join(text))

    async def scenario() -> None:
        async with bench(talker) as at:
            outcome = await at.ask("add", a=1)
            assert outcome.ending is Ending.REFUSED
            assert why in outcome.why
            assert "being started again" in outcome.why

    asyncio.run(scenario())


def test_the_directory_says_what_a_wrapped_program_offers(talker: Path) -> None:
    async def scenario() -> dict[str, Any]:
        async with bench(talker) as at:
            return at.container.agent("it@happy").describe()

    description = asyncio.run(scenario())
    assert description["services"] == ["sums"]
    assert description["requests"] == ["add", "die", "pid", "sleep"]
