"""The commands and programs that the documentation shows for a team, run on one emulated team as they stand."""

import asyncio
import shlex
import signal
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import pytest

from acromovi.__main__ import main
from agents import Team
from agents.platform import Agent, Container
from agents.services.lease_client import leased
from bus import ZenohBus
from tests.acromovi.team.running import RunningTeam, running
from tests.interruptions import INTERRUPTED, again_if_interrupted
from tests.live_team import LIMIT
from tests.reader import blocks
from tests.shown import ELSEWHERE, OF_A_RECORDING, PAGES, PYTHON_ELSEWHERE, command_lines, files, page, to_run
from tests.waiting import end_of, exit_code, run, wait_until, waiting

TEAM = """
world = "empty"

[[robots]]
name = "happy"
model = "peoplebot-sh"
fit = ["gripper", "laser", "arm", "ptz:vcc4", "camera:160x120@10", "compass", "joystick"]
at_m = [0.0, 0.0]

[[robots]]
name = "doc"
model = "p2dx"
at_m = [0.0, 5.0]
"""
ON_THE_TEAM = ("components", "gateway", "services", "accessories", "bus", "command-line", "teams", "vision")
LIMITS = {"echo": ["--count", "1"], "topics": ["--seconds", "0.5"], "ask": ["--timeout", "60"]}
"""Of what runs until Ctrl-C, and of what takes long on a busy machine."""
NO_POWER = "the arm has no power"
EVENTS = "acromovi echo acromovi/agents/monitor/results"
LINES = dict.fromkeys(line for name in ON_THE_TEAM for line in to_run(name, "acromovi"))
del LINES[OF_A_RECORDING], LINES[EVENTS]


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    """The team `acromovi`, on whose bus this process is, with the files of the pages in the working folder."""
    folder = tmp_path_factory.mktemp("team")
    shown = [text for name in ("tutorial", "wrappers") for _, text in blocks(page(name))]
    for name in ("wander.py", "counter.toml"):
        (text,) = [text for text in shown if text.startswith(f"# {name}\n")]
        (folder / name).write_text(text)
    (folder / "acromovi.toml").write_text(TEAM)
    with pytest.MonkeyPatch.context() as patch, running(str(folder / "acromovi.toml"), "--apps", str(folder)) as team:
        patch.setenv("ACROMOVI_BUS", team.profile)
        patch.chdir(folder)
        team.emulator().ask("joystick", robot="happy", y=0.5)  # it is found when it is moved
        wait_until(lambda: "joystick@happy" in team.agents(), "the joystick was found")
        team.emulator().ask("joystick", robot="happy", y=0.0)
        yield team


@contextmanager
def started(line: str) -> "Iterator[subprocess.Popen[str]]":
    """Start a command as in a terminal of its own, and end it after the block."""
    command = [sys.executable, "-m", *shlex.split(line)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.terminate()
            end_of(process, LIMIT)


def test_a_wrapped_program_answers(team: RunningTeam, capsys: pytest.CaptureFixture[str]) -> None:
    wrap, ask, *others = to_run("wrappers", "acromovi")
    assert not others
    with started(wrap) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("counter@happy lives")
        assert main(shlex.split(ask)[1:]) == 0
        assert '"sum": 3' in capsys.readouterr().out


def test_ctrl_c_stops_a_motion(team: RunningTeam) -> None:
    (line,) = to_run("motions", "acromovi")
    with started(line) as process:
        wait_until(lambda: abs(speed(team)) > 0.1, "the robot drives")
        process.send_signal(signal.SIGINT)
        assert exit_code(process) == 130
    wait_until(lambda: abs(speed(team)) < 0.01, "the robot stands")


def test_a_motion_with_a_heartbeat_ends(team: RunningTeam) -> None:
    (program,) = files("motions", "python")

    done = run([sys.executable, "-c", program, "happy"], LIMIT)
    assert "'result': 'reached'" in done.stdout, done.stdout + done.stderr


def test_programs_with_a_team_use_leases(team: RunningTeam) -> None:
    programs = [text for text in files("services", "python") if "async" not in text]
    assert len(programs) == 2
    with Team() as robots:
        robot = robots.robot("doc")
        for program in programs:
            again_if_interrupted(exec)(program, {"team": robots, "robot": robot, "base": robot.base})


def test_agents_subscribe_and_use_leases(team: RunningTeam, capsys: pytest.CaptureFixture[str]) -> None:
    subscribes, leases = [text for text in files("services", "python") if "async" in text]
    team.emulator().ask("fault", fault="sonar-stuck:robot=happy,range=0.4")

    async def scenario() -> None:
        with ZenohBus.open() as bus:
            async with Container(bus, "pages", platform="happy") as container:
                agent = Agent("reader@happy")
                await container.start(agent)
                await method(leases)(agent)
                watching = asyncio.ensure_future(method(subscribes)(agent))
                async with waiting():
                    while "something is near: 0.4" not in capsys.readouterr().out:
                        await asyncio.sleep(0.05)
                watching.cancel()
                with suppress(asyncio.CancelledError):  # it has just been cancelled
                    await watching

    asyncio.run(scenario())


@pytest.mark.parametrize("line", LINES)  # after the others: in the end an application drives happy
def test_a_command_succeeds(team: RunningTeam, line: str, capsys: pytest.CaptureFixture[str]) -> None:
    _, command, *words = shlex.split(line)
    if "--follow" in words:
        with started(line) as process:
            assert process.stdout is not None
            assert process.stdout.readline()
    elif "do=move" in words:  # the gateway refuses it until the arm has reported its power, for which a person waits
        wait_until(lambda: main([command, *words]) == 0, "the arm moves")
    else:
        assert outcome([command, *words, *LIMITS.get(command, [])], capsys) == (0, "")


def outcome(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    """Return exit code and error of a command, repeated while a busy machine interrupts its motion."""
    ends: list[tuple[int, str]] = []

    def has_ended() -> bool:
        code = main(arguments)
        ends.append((code, capsys.readouterr().err if code else ""))
        if NO_POWER in ends[-1][1]:  # the gateway has connected anew since it was switched on, which parks an arm
            main(["ask", "arm@happy", "power", "on=true"])
            return False
        return not INTERRUPTED.search(ends[-1][1])

    wait_until(has_ended, "no motion is interrupted")
    return ends[-1]


def test_events_of_the_monitor_are_printed(team: RunningTeam) -> None:
    with started(EVENTS) as process:
        team.emulator().ask("fault", fault="line-cut:robot=doc")
        assert process.stdout is not None
        assert process.stdout.readline()


def test_every_command_and_program_of_the_pages_is_run_somewhere() -> None:
    shown = {line for name in PAGES for line in command_lines(name, "acromovi")}
    elsewhere = {line for line in ELSEWHERE if line.startswith("acromovi ")}
    own = {line for name in ("wrappers", "motions", "security") for line in to_run(name, "acromovi")}
    assert shown == LINES.keys() | elsewhere | own | {OF_A_RECORDING, EVENTS}
    run_here = {"motions": 1, "services": 4}
    assert {name: len(files(name, "python")) for name in PAGES if files(name, "python")} == run_here | PYTHON_ELSEWHERE


def method(body: str) -> Any:
    """Return a program of a page as the method of an agent that it is."""
    names: dict[str, Any] = {"leased": leased}
    exec(f"async def method(self):\n{textwrap.indent(body, '    ')}", names)
    return names["method"]


def speed(team: RunningTeam) -> float:
    """Return how fast happy really is, m/s."""
    return float(team.emulator().ask("truth", robot="happy")["robots"]["happy"]["linear"])
