"""What may happen to a program while its robots move: each is told in one sentence, and the robot comes to rest."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from math import hypot
from pathlib import Path

import pytest

from acromovi.__main__ import main
from acromovi.team.host_control import HostControl
from agents import Failed, NotThere, Robot, RobotError, Team
from tests.acromovi.team.running import RunningTeam, running
from tests.interruptions import again_if_interrupted
from tests.live_team import SCRIPT
from tests.waiting import end_of, join, wait_until

DWARFS = """\
world = "empty"

[[robots]]
name = "happy"
model = "p3dx-sh"
fit = ["laser"]
at_m = [0.0, 0.0]

[[robots]]
name = "grumpy"
model = "p2dx"
at_m = [0.0, 5.0]
"""
STEP = 0.1  # s
LATE = re.compile(r"^someone has not answered a search of the directory within \S+ s\n", re.MULTILINE)
"""What a program says on a busy machine, where nothing else is wrong."""
LITTLE = 0.002  # m in a step, which a robot that stands does not go
MOVE = "from agents import Team\nteam = Team()\nteam.robot('grumpy').base.move(30.0)\n"
DRIVE = "from agents import Team\nteam = Team()\nteam.robot('grumpy').base.drive(0.3)\nteam.sleep(60.0)\n"
FORGOTTEN = """
from agents import Team
team = Team()
scans = team.robot("happy").laser.watch()
next(scans)
team.robot("grumpy").base.drive(0.3)
team.sleep(1.5)
"""


@pytest.fixture(scope="module")
def dwarfs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    file = tmp_path_factory.mktemp("team") / "dwarfs.toml"
    file.write_text(DWARFS)
    with running(str(file)) as team:
        yield team


@pytest.fixture
def team(dwarfs: RunningTeam) -> Iterator[Team]:
    with Team(dwarfs.profile) as team:
        yield team


def step(dwarfs: RunningTeam, robot: str) -> float:
    """How far a robot goes in a moment, m."""
    before = dwarfs.emulator().ask("truth", robot=robot)
    time.sleep(STEP)
    after = dwarfs.emulator().ask("truth", robot=robot)
    return hypot(after["x"] - before["x"], after["y"] - before["y"])


def wait_until_it_drives(dwarfs: RunningTeam, robot: str, driven_by: "subprocess.Popen[str] | None" = None) -> None:
    """Return as well when the program that drives it has ended: its exit code and what it says are to be looked at."""

    def drives() -> bool:
        has_ended = driven_by is not None and driven_by.poll() is not None
        return has_ended or step(dwarfs, robot) > 5 * LITTLE

    wait_until(drives, f"{robot} drives")


def wait_until_it_stands(dwarfs: RunningTeam, robot: str) -> None:
    wait_until(lambda: step(dwarfs, robot) < LITTLE, f"{robot} stands")


def during_a_move(dwarfs: RunningTeam, robot: Robot, happens: "threading.Thread") -> str:
    """Let something happen while a robot moves; returns the sentence that the program gets."""
    told: list[str] = []

    def move() -> None:
        try:
            robot.base.move(30.0)
        except RobotError as error:
            told.append(str(error))

    moving = threading.Thread(target=move)
    moving.start()
    wait_until_it_drives(dwarfs, robot.name)
    happens.start()
    join(moving)
    join(happens)
    assert told, "the motion goes on"
    wait_until_it_stands(dwarfs, robot.name)
    return told[0]


def script(dwarfs: RunningTeam, folder: Path, text: str) -> "subprocess.Popen[str]":
    """Start a script as `python drive.py`, on the team's bus."""
    (folder / "drive.py").write_text(text)
    command = [sys.executable, "-c", SCRIPT, dwarfs.profile, "drive.py"]
    return subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True)


def test_the_e_stop_in_a_motion(dwarfs: RunningTeam, team: Team) -> None:
    happy = team.robot("happy")
    told = during_a_move(dwarfs, happy, threading.Thread(target=happy.base.estop))
    assert re.fullmatch(r"base@happy could not move: the e-stop was pressed by app-\w+@apps", told)
    with pytest.raises(RobotError, match=r"base@happy .* e-stop"):
        happy.base.move(0.1)
    happy.base.estop(False)
    happy.base.enable()
    happy.base.move(0.05)


def test_a_program_that_drives_what_another_moves(dwarfs: RunningTeam, team: Team) -> None:
    with Team(dwarfs.profile) as other:
        base = other.robot("happy").base

        def turn() -> None:
            with suppress(Failed):  # on a busy machine, that this program was silent for 0.5 s
                base.turn(0.1)

        told = during_a_move(dwarfs, team.robot("happy"), threading.Thread(target=turn))
    assert re.fullmatch(r"base@happy could not move: replaced by turn, asked by app-\w+@apps", told)


def test_threads_of_a_program_move_robots_side_by_side(team: Team) -> None:
    ends = dict.fromkeys(["happy", "grumpy"], 0.0)

    @again_if_interrupted
    def move(robot: Robot) -> None:
        before = robot.base.pose().x
        ends[robot.name] = robot.base.move(0.2).x - before

    threads = [threading.Thread(target=move, args=[team.robot(name)]) for name in ends]
    for thread in threads:
        thread.start()
    for thread in threads:
        join(thread)
    assert all(way > 0.1 for way in ends.values())


@pytest.mark.parametrize("text", [MOVE, DRIVE], ids=["move", "drive"])
def test_ctrl_c_in_a_motion_stops_the_robot(dwarfs: RunningTeam, tmp_path: Path, text: str) -> None:
    with script(dwarfs, tmp_path, text) as process:
        wait_until_it_drives(dwarfs, "grumpy", process)
        process.send_signal(signal.SIGINT)
        _, told = end_of(process)
    wait_until_it_stands(dwarfs, "grumpy")
    assert re.fullmatch(r"drive.py, line \d: stopped by Ctrl-C\n", LATE.sub("", told))
    assert process.returncode == -signal.SIGINT


def test_a_script_that_closes_nothing_leaves_its_robot_at_rest(dwarfs: RunningTeam, tmp_path: Path) -> None:
    with script(dwarfs, tmp_path, FORGOTTEN) as process:
        wait_until_it_drives(dwarfs, "grumpy", process)
        _, told = end_of(process)
    wait_until_it_stands(dwarfs, "grumpy")
    assert (LATE.sub("", told), process.returncode) == ("", 0)


def test_a_new_application_drives_as_it_is(
    dwarfs: RunningTeam, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "patrol"]) == 0
    command = [sys.executable, "-m", "acromovi", "run", "patrol.py", "robot=grumpy", "--bus", dwarfs.profile]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        wait_until_it_drives(dwarfs, "grumpy", process)
        process.send_signal(signal.SIGINT)
        _, told = end_of(process)
    assert (LATE.sub("", told), process.returncode) == ("", 130)
    wait_until_it_stands(dwarfs, "grumpy")


def test_a_laser_that_is_unplugged_while_it_is_watched(dwarfs: RunningTeam, team: Team) -> None:
    laser = team.robot("happy").laser
    scans = laser.watch(within=4.0)
    next(scans)
    fault = dwarfs.emulator().ask("fault", fault="line-cut:robot=happy,cable=laser")["number"]
    with pytest.raises((Failed, NotThere), match="laser@happy"):
        for _ in scans:
            pass
    dwarfs.emulator().ask("clear", number=fault)
    wait_until(lambda: team.robot("happy").has("laser"), "happy has its laser again")
    assert laser.read().stamp > 0.0


def test_a_gateway_that_is_killed_in_a_motion(dwarfs: RunningTeam, team: Team) -> None:
    (answer,) = dwarfs.bus.query(HostControl.key("dwarfs"), {"do": "status"})
    (pid,) = (
        each["pid"] for each in answer.value["processes"] if "gateway" in each["name"] and "happy" in each["robots"]
    )
    told = during_a_move(dwarfs, team.robot("happy"), threading.Thread(target=os.kill, args=[pid, signal.SIGKILL]))
    assert told.startswith("base@happy could not move: ")
    assert team.robot("happy", having="base").name == "happy"
