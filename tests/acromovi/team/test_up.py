"""`acromovi up` with real processes: a team of two robots on a bus of its own."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from acromovi.team.host_control import HostControl
from acromovi.team.team import STARTING_TIME
from tests.acromovi.team.private_bus import private_bus
from tests.acromovi.team.running import RunningTeam, run, running
from tests.waiting import Deadline, wait_until

DWARFS = """\
world = "empty"

[[robots]]
name = "happy"
model = "p3dx-sh"
fit = ["laser"]

[[robots]]
name = "grumpy"
model = "p2dx"

[[robots]]
name = "iron"
model = "p3dx"
port = "/dev/nowhere"
"""
IN_TIME = 3.0  # s from Ctrl-C until nothing is left


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("team") / "dwarfs.toml"
    path.write_text(DWARFS)
    return str(path)


@pytest.fixture(scope="module")
def dwarfs(file: str) -> Iterator[RunningTeam]:
    with running(file) as team:
        yield team


def processes(team: RunningTeam) -> dict[str, dict[str, object]]:
    (answer,) = team.bus.query(HostControl.key("dwarfs"), {"do": "status"})
    return {process["name"]: process for process in answer.value["processes"]}


def test_one_line_of_json_says_which_robots_serve(dwarfs: RunningTeam) -> None:
    assert dwarfs.announced["robots"] == ["happy", "grumpy"]
    assert dwarfs.announced["console"] is None
    assert Path(dwarfs.announced["control"]).is_socket()


def test_ps_shows_an_agent_for_each_element_and_those_of_the_team(dwarfs: RunningTeam) -> None:
    agents = dwarfs.agents()
    assert {"base@happy", "sonar@happy", "laser@happy", "base@grumpy"} <= agents.keys()
    assert "laser@grumpy" not in agents
    assert (agents["laser@happy"]["state"], agents["laser@happy"]["container"]) == ("active", "happy")
    assert agents["monitor@dwarfs"]["container"] == "services"


def test_robots_say_that_they_are_emulated(dwarfs: RunningTeam) -> None:
    (answer,) = dwarfs.bus.query("happy/description")
    assert answer.value["emulated"] is True


def test_host_lists_its_processes_the_waiting_gateway_of_a_real_robot_included(dwarfs: RunningTeam) -> None:
    listed = processes(dwarfs)
    assert listed["the emulator"]["state"] == listed["the gateway of iron"]["state"] == "running"
    assert "the container of iron" not in listed


@pytest.mark.parametrize("how", ["is told to", "is killed"])
def test_container_that_is_started_again_has_its_agents_back(dwarfs: RunningTeam, how: str) -> None:
    before = processes(dwarfs)["the container of grumpy"]["pid"]
    assert isinstance(before, int)
    if how == "is told to":
        dwarfs.bus.query(HostControl.key("dwarfs"), {"do": "restart", "container": "grumpy"})
    else:
        os.kill(before, signal.SIGKILL)
    wait_until(lambda: processes(dwarfs)["the container of grumpy"]["pid"] not in (before, None), "a new process runs")
    wait_until(lambda: "base@grumpy" in dwarfs.agents(), "its agents are back")


def test_team_that_is_up_is_not_brought_up_a_second_time(dwarfs: RunningTeam, file: str) -> None:
    done = dwarfs.acromovi("up", file, "--only", "happy")
    assert done.returncode == 1
    assert "is on this bus already; end it first" in done.stderr
    assert (done.stdout, done.stderr.count("\n")) == ("", 1)


def test_end_takes_no_longer_than_said_though_a_container_is_frozen_and_leaves_nothing(file: str) -> None:
    with running(file, "--only", "grumpy") as team:
        frozen = processes(team)["the container of grumpy"]["pid"]
        assert isinstance(frozen, int)
        os.kill(frozen, signal.SIGSTOP)
        in_time = Deadline(IN_TIME)
        team.end(signal.SIGINT)
        assert not in_time.has_passed(), in_time.in_words("nothing is left")
        assert team.process.returncode == 130
        assert team.left_behind() == []


def test_killed_outright_it_leaves_nothing_behind_all_the_same(file: str) -> None:
    with running(file, "--only", "happy") as team:
        assert len(team.pids()) >= 5  # with the reaper
        team.end(signal.SIGKILL)
        wait_until(lambda: team.left_behind() == [], "the folder is gone")


def test_team_that_is_not_up_within_the_timeout_ends_with_a_code_of_its_own_and_a_cause_for_each_robot(
    file: str,
) -> None:
    done = run("up", file, "--timeout", "0.2", "--bus", private_bus())
    assert done.returncode == 3
    # A gateway that starts in less than 0.2 s has reported before that it waits for its port.
    progress, _, causes = done.stderr.partition("acromovi up: dwarfs is not complete after 0.2 s (--timeout):\n")
    assert progress in ("", "acromovi up: iron is not there yet: waiting for /dev/nowhere\n")
    causes_begin = ("happy: the emulator ", "grumpy: the emulator ", "iron: there is no port /dev/nowhere; ")
    for begin, cause in zip(causes_begin, causes.splitlines(), strict=True):
        assert cause.startswith(f"  {begin}")
    assert done.stdout.startswith("starting 3 robots of dwarfs: happy, grumpy, iron\n")


def test_help_names_the_default_timeout() -> None:
    assert f"s [{STARTING_TIME:g}]" in run("up", "--help").stdout


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["acromov"], "there is no 'acromov' among the teams; did you mean acromovi"),
        (["acromovi", "--only", "hapy"], "did you mean 'happy'"),
        (["acromovi", "--bus", "locl"], "did you mean local"),
    ],
)
def test_mistake_on_the_command_line_is_one_sentence(arguments: list[str], why: str) -> None:
    done = run("up", *arguments)
    assert done.returncode == 1
    assert why in done.stderr
    assert done.stderr.startswith("acromovi up: ")
    assert done.stderr.count("\n") == 1


def test_mistake_that_the_emulator_finds_is_one_sentence_and_nothing_is_left(tmp_path: Path) -> None:
    file = tmp_path / "dwarfs.toml"
    file.write_text(DWARFS.replace('"empty"', '"emty"'))
    done = run("up", str(file))
    assert done.returncode == 1
    assert "'emty' among the worlds; did you mean empty" in done.stderr
    assert done.stderr.count("\n") == 1 + ("iron is not there" in done.stderr)
