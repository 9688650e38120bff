"""The team of the mission: one PowerBot and six Pioneers, from its one file to the programs that run on it.

What each robot has to have is written here by hand, from the sentence that describes the team, and not from the code.
"""

import os
import re
import signal
import subprocess
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import configs
from acromovi.__main__ import main
from acromovi.children import EmulatedRobots
from acromovi.team.host_control import HostControl
from agents import Team
from agents.platform import AgentName
from configs.team_file import TeamFile
from p2os import RobotModel
from p2os_emu.fit import read_fit
from tests.acromovi.team.running import RunningTeam, running
from tests.interruptions import INTERRUPTED, again_if_interrupted
from tests.live_team import LIMIT, ROOT, LiveTeam
from tests.waiting import Deadline, end_of, wait_until

EVERY = {"base", "sonar", "battery", "io", "sound", "servos", "localization", "mapping"}
"""What every controller of these robots has: wheels, the sonar on it, its own ports, and the agents of maps."""
PIONEER = EVERY | {"gripper"}
IMAGES = {"camera", "vision", "colours", "flow", "motion"}
AGENTS: Mapping[str, set[str]] = {
    "max": EVERY | {"bumpers", "ir", "arm", "power", "charger"},
    "happy": PIONEER | {"laser"},
    "doc": PIONEER | IMAGES | {"ptz"},
    "sneezy": PIONEER | IMAGES | {"ptz"},
    "grumpy": PIONEER,
    "bashful": PIONEER,
    "sleepy": PIONEER,
}
SERVICES = {"monitor", "subscription", "arbiter", "loader"}
SONARS = {"max": 28, "happy": 16} | dict.fromkeys(("doc", "sneezy", "grumpy", "bashful", "sleepy"), 8)
RADIO = {"grumpy", "bashful", "sleepy"}
PAGE = (ROOT / "docs" / "teams.md").read_text(encoding="utf-8")
UNPLUG, PLUG_IN = (line.split() for line in re.findall(r"^acromovi (world .*)$", PAGE, re.MULTILINE))
ASKED = re.findall(r"^acromovi (ask .*)", PAGE, re.MULTILINE)
SQUARE = ("python", str(ROOT / "examples" / "square.py"))
IN_TIME = 3.0  # s from Ctrl-C until nothing is left


def test_file_of_the_team_gives_each_robot_what_the_mission_says() -> None:
    team = configs.load(TeamFile, "teams", "acromovi")
    assert {robot.name for robot in team.robots} == AGENTS.keys()
    for robot in team.robots:
        model, fit = read_fit(robot.fit, configs.load(RobotModel, "robots", robot.model))
        is_powerbot = robot.name == "max"
        assert model.name.startswith("powerbot" if is_powerbot else ("p2", "p3"))
        assert len(model.sonar) == SONARS[robot.name]
        assert bool(model.front_bumpers) == bool(model.rear_bumpers) == is_powerbot
        assert [infrared.x > 0 for infrared in model.irs] == [True] * (8 if is_powerbot else 0)
        assert set(fit.parts) == AGENTS[robot.name] & {"gripper", "arm", "laser", "camera", "ptz"}
        assert (robot.link == "radio-modem") == (robot.name in RADIO)


def test_team_of_seven_comes_up_works_loses_and_finds_a_laser_and_leaves_nothing() -> None:
    tokens: set[str] = set()
    with running("acromovi") as team:
        team.bus.watch_alive("**", lambda key, is_there: (tokens.add if is_there else tokens.discard)(key))
        assert team.announced["robots"] == list(AGENTS)
        assert_agents_are_those_of_the_hardware(team)
        programs = LiveTeam(team.folder.parent, team.profile)
        emulator = team.emulator()
        starts = {robot: emulator.ask("pose", robot=robot) for robot in ("max", "sleepy")}
        with ExitStack() as squares:
            driven = {robot: squares.enter_context(programs.running(*SQUARE, robot)) for robot in starts}
            looked = programs.run("python", str(ROOT / "examples" / "nearest.py"))
            assert re.fullmatch(r"happy: \d+\.\d\d m\n", looked.stdout), looked.stderr
            assert_page_asks_what_can_be_done(team)
            assert_sensors_are_as_many_as_fitted(team)
            assert_laser_goes_and_comes_with_its_agent(team, tokens)
            assert_killed_container_comes_back(team, "doc", tokens)
            for robot, process in driven.items():
                said, complaints = end_of(process, LIMIT)
                if INTERRUPTED.search(complaints):
                    drive_again(emulator, programs, starts[robot])
                else:
                    assert said.startswith("back at Pose2D"), f"{robot}: {complaints}"
        assert_agents_are_those_of_the_hardware(team)
        assert_it_ends_in_time_and_leaves_nothing(team, tokens)


@again_if_interrupted
def drive_again(emulator: EmulatedRobots, programs: LiveTeam, start: dict[str, Any]) -> None:
    """Drive the square from the start again: an interruption stops a robot anywhere on its way, even before a wall."""
    emulator.ask("pose", **{key: start[key] for key in ("robot", "x", "y", "heading")})
    done = programs.run(*SQUARE, start["robot"])
    assert done.stdout.startswith("back at Pose2D"), f"{start['robot']}: {done.stderr}"


def assert_agents_are_those_of_the_hardware(team: RunningTeam) -> None:
    wanted = {f"{element}@{robot}": robot for robot, elements in AGENTS.items() for element in elements}
    wanted |= {f"{service}@acromovi": "services" for service in SERVICES}
    shown = team.agents()
    assert {name: agent["container"] for name, agent in shown.items()} == wanted
    assert {agent["state"] for agent in shown.values()} == {"active"}


def assert_page_asks_what_can_be_done(team: RunningTeam) -> None:
    @again_if_interrupted
    def ask(words: str) -> None:
        done = team.acromovi(*words.split())
        assert done.returncode == 0, done.stderr

    for words in ASKED:
        ask(words)


def assert_sensors_are_as_many_as_fitted(team: RunningTeam) -> None:
    with Team(team.profile) as seen:
        ranges = {robot: seen.ask(f"sonar@{robot}", "read")["ranges"] for robot in AGENTS}
        assert {robot: len(discs) for robot, discs in ranges.items()} == SONARS
        bumpers, infrared = seen.ask("bumpers@max", "read"), seen.ask("ir@max", "read")
        assert (len(bumpers["front"]), len(bumpers["rear"]), len(infrared["ranges"])) == (7, 5, 8)
        assert set(range(1, 8)) <= seen.ask("arm@max", "read")["joints"].keys()


def assert_laser_goes_and_comes_with_its_agent(team: RunningTeam, tokens: set[str]) -> None:
    laser = AgentName("laser", "happy").alive_key
    assert main([*UNPLUG, "--control", team.announced["control"]]) == 0
    wait_until(lambda: laser not in tokens, "the agent of the laser has gone")
    assert "laser@happy" not in team.agents()
    assert main([*PLUG_IN, "--control", team.announced["control"]]) == 0
    wait_until(lambda: laser in tokens, "the agent of the laser is back")


def assert_killed_container_comes_back(team: RunningTeam, robot: str, tokens: set[str]) -> None:
    agents = {AgentName(element, robot).alive_key for element in AGENTS[robot]}
    (answer,) = team.bus.query(HostControl.key("acromovi"), {"do": "status"})
    (pid,) = (row["pid"] for row in answer.value["processes"] if row["container"] == robot)
    os.kill(pid, signal.SIGKILL)
    wait_until(lambda: not agents & tokens, "its agents have gone")
    wait_until(lambda: agents <= tokens, "its agents are back")


def assert_it_ends_in_time_and_leaves_nothing(team: RunningTeam, tokens: set[str]) -> None:
    cameras = drawing(team)
    assert len(cameras) == 2
    in_time = Deadline(IN_TIME)
    team.end(signal.SIGINT)
    assert not in_time.has_passed(), in_time.in_words("nothing is left")
    assert team.process.returncode == 130
    assert team.left_behind() == []
    wait_until(lambda: not any(Path(f"/proc/{pid}").exists() for pid in cameras), "the cameras have ended")
    wait_until(lambda: not tokens, "no token is left")


def drawing(team: RunningTeam) -> list[str]:
    """The emulator's processes that draw, which are in sessions of their own."""
    found = subprocess.run(["pgrep", "-f", "The camera of"], capture_output=True, text=True).stdout.split()
    ours = team.pids()
    return [pid for pid in found if parent(pid) in ours]


def parent(pid: str) -> int:
    return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])
