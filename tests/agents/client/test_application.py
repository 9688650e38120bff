"""Applications: files that are loaded, run, and made agents of."""

import threading
from pathlib import Path
from typing import Any

import pytest

from agents import Failed, NotThere, Refused, RobotError, Team
from agents.client.application import Application
from agents.client.program import RunningApplication
from agents.platform import AgentName, AgentState
from tests.agents.client.conftest import BasePart, World
from tests.waiting import wait_until

PATROL = """
from agents import Refused, request

SERVICES = ("patrol",)
laps = 0
ended = []

def main(team, robot="happy", side: float = 1.0):
    global laps
    base = team.robot(robot).base
    for _ in team.every(0.01):
        base.move(side)
        laps += 1
    ended.append(True)

@request("laps")
def how_many(plus: int = 0):
    return laps + plus

@request("where")
def where(team, robot: str):
    return team.robot(robot).base.pose().x

@request("never")
def never():
    raise Refused("no patrol at night")
"""

DRIVER = """
ended = []

def main(team):
    team.robot("happy").base.drive(0.2)
    for _ in team.every(0.01):
        pass
    ended.append(True)
"""

STUMBLER = """
RESTART = True
runs = []

def main(team):
    runs.append(1)
    if len(runs) < 3:
        raise ValueError
"""


def application_agent(file: str, name: str = "", arguments: dict[str, Any] | None = None) -> Application:
    """An agent of a file's program."""
    program = RunningApplication.find(file)
    program.check(arguments or {})
    return Application(program, name or AgentName(program.name, "apps"), arguments or {})


def write(folder: Path, text: str, name: str = "patrol.py") -> str:
    (folder / name).write_text(text)
    return str(folder / name)


def test_an_application_runs_with_a_team_and_its_arguments(tmp_path: Path, team: Team) -> None:
    program = RunningApplication.find(
        write(tmp_path, "def main(team, robot, by=1.0):\n    team.robot(robot).base.move(by)\n")
    )
    program.check({"robot": "happy", "by": 2.0})
    program.run(team, {"robot": "happy", "by": 2.0})
    assert team.robot("happy").base.pose().x == 2.0


def test_an_application_is_found_by_name_in_a_folder(tmp_path: Path) -> None:
    write(tmp_path, PATROL)
    assert RunningApplication.find("patrol", [tmp_path]).services == ("patrol",)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("x = 1\n", "patrol.py has no function main(team); an application begins there"),
        ("def main():\n    pass\n", "has no function main(team)"),
        ("def main(team:\n", "patrol.py, line 1: '(' was never closed"),
        ("import os\n\nx = 1 / 0\n", "patrol.py, line 3: ZeroDivisionError: division by zero"),
        ("import nosuch\n", "patrol.py, line 1: ModuleNotFoundError: No module named 'nosuch'"),
    ],
)
def test_what_is_no_application_is_told_in_one_sentence(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(RobotError) as caught:
        RunningApplication.find(write(tmp_path, text))
    assert told in str(caught.value)


def test_the_nearest_name_is_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, PATROL)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RobotError, match=r"there is no application 'patroll.py'; did you mean patrol.py\?"):
        RunningApplication.find("patroll.py")
    with pytest.raises(RobotError, match=r"there is no application 'patrol'; did you mean the file patrol.py\?"):
        RunningApplication.find("patrol")
    with pytest.raises(RobotError, match="write one with `acromovi new zebra`"):
        RunningApplication.find("zebra")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"sied": 1.0}, "main does not take 'sied' (did you mean side?); it takes robot, side"),
        ({"side": "far"}, "main takes side as float, not str; it takes robot, side"),
        ({"team": 1}, "team in main of patrol is its team"),
    ],
)
def test_arguments_are_checked_before_it_runs(tmp_path: Path, arguments: dict[str, Any], told: str) -> None:
    with pytest.raises(RobotError) as caught:
        RunningApplication.find(write(tmp_path, PATROL)).check(arguments)
    assert told in str(caught.value)


def test_a_mistake_of_the_program_is_told_with_its_line(tmp_path: Path, team: Team) -> None:
    program = RunningApplication.find(
        write(tmp_path, "def main(team):\n    robots = team.robots()\n    robots[7].stop()\n")
    )
    with pytest.raises(RobotError) as caught:
        program.run(team, {})
    assert str(caught.value) == "patrol.py, line 3: IndexError: list index out of range"


def test_a_robots_error_stays_what_it_is(tmp_path: Path, team: Team) -> None:
    program = RunningApplication.find(write(tmp_path, "def main(team):\n    team.robot('nobody')\n"))
    with pytest.raises(NotThere, match="there is no robot 'nobody'"):
        program.run(team, {})


def test_an_application_is_an_agent_that_runs_and_answers(tmp_path: Path, world: World, team: Team) -> None:
    agent = world.add(application_agent(write(tmp_path, PATROL), arguments={"side": 0.5}))
    assert str(agent.name) == "patrol@apps"
    assert agent.describe()["services"] == ["application", "patrol"]
    assert agent.describe()["requests"] == ["laps", "never", "where"]
    wait_until(lambda: team.ask("patrol@apps", "laps") > 2)
    assert team.ask("patrol@apps", "laps", plus=1000) > 1000
    assert team.ask("patrol@apps", "where", robot="happy") > 0.0


def test_what_an_application_is_asked_wrongly_is_told(tmp_path: Path, world: World, team: Team) -> None:
    world.add(application_agent(write(tmp_path, PATROL), "patrol@lab"))
    with pytest.raises(Refused, match="does not take"):
        team.ask("patrol@lab", "laps", team=1)
    with pytest.raises(Refused, match="takes plus as int, not str"):
        team.ask("patrol@lab", "laps", plus="one")
    with pytest.raises(Failed, match="no patrol at night"):
        team.ask("patrol@lab", "never")


def test_an_application_that_is_suspended_waits_and_goes_on(tmp_path: Path, world: World, team: Team) -> None:
    agent = world.add(application_agent(write(tmp_path, PATROL)))
    wheels: BasePart = world.agent("base@happy")
    wait_until(lambda: wheels.asked)
    world.loop.call_soon_threadsafe(agent.suspend)
    wait_until(lambda: agent.state is AgentState.SUSPENDED)
    team.sleep(0.1)  # what was under way has ended
    moves = len(wheels.asked)
    team.sleep(0.1)
    assert len(wheels.asked) == moves
    world.loop.call_soon_threadsafe(agent.resume)
    wait_until(lambda: len(wheels.asked) > moves)


def test_an_application_that_is_stopped_ends_its_loop_and_its_drive(tmp_path: Path, world: World) -> None:
    agent = application_agent(write(tmp_path, DRIVER))
    world.add(agent)
    wheels: BasePart = world.agent("base@happy")
    wait_until(lambda: wheels.velocities)
    world.run(world.container.stop(agent.name))
    assert agent._program.module.ended
    assert "stop" in wheels.asked
    wait_until(lambda: wheels.velocities[-1:] == [(0.0, 0.0)])
    assert not world.reports


@pytest.mark.parametrize(("request_too", "lives"), [("", False), ("@request('x')\ndef x():\n    return 1\n", True)])
def test_an_application_whose_main_has_ended_lives_on_if_it_can_be_asked(
    tmp_path: Path, world: World, request_too: str, lives: bool
) -> None:
    agent = application_agent(
        write(tmp_path, f"from agents import request\ndone = []\ndef main(team):\n    done.append(1)\n{request_too}")
    )
    world.add(agent)
    wait_until(lambda: agent._program.module.done)
    if lives:
        world.run(world.container.stop(agent.name))
    else:
        wait_until(lambda: agent.state is AgentState.DELETED)


def test_an_application_that_fails_is_reported_and_ends(tmp_path: Path, world: World) -> None:
    agent = world.add(application_agent(write(tmp_path, "def main(team):\n    team.robot('nobody')\n")))
    wait_until(lambda: agent.state is AgentState.DELETED)
    (report,) = world.reports
    assert "its agent ends" in report.what
    assert isinstance(report.error, NotThere)


def test_an_application_that_fails_begins_again_if_it_says_so(tmp_path: Path, world: World) -> None:
    agent = application_agent(write(tmp_path, STUMBLER))
    world.add(agent)
    wait_until(lambda: len(agent._program.module.runs) == 3)
    wait_until(lambda: agent.state is AgentState.DELETED)
    assert [report.what.partition(":")[0] for report in world.reports] == ["main failed"] * 2


def test_an_application_that_does_not_listen_does_not_hold_up_its_container(
    tmp_path: Path, world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agents.client.application.LEAVE", 0.05)
    text = "import threading\ngo_on = threading.Event()\ndef main(team):\n    go_on.wait()\n"
    agent = application_agent(write(tmp_path, text))
    world.add(agent)
    world.run(world.container.stop(agent.name))
    assert agent.state is AgentState.DELETED
    agent._program.module.go_on.set()
    wait_until(lambda: not any(thread.name == "patrol@apps" for thread in threading.enumerate()))
