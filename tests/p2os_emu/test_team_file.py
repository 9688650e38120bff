from pathlib import Path

import pytest

import configs
from configs.team_file import TeamFile
from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.fit import read_fit
from p2os_emu.options import parse

TEAM = """\
world = "empty"
link = "rs232"

[[robots]]
name = "happy"
model = "p3dx"
fit = ["gripper", "no-rear-sonar"]
at_m = [1.0, 2.0]

[[robots]]
name = "iron"
model = "p2at"
port = "/dev/ttyUSB0"

[[robots]]
name = "doc"
model = "p2dx"
link = "radio-modem"
"""


@pytest.fixture
def team(tmp_path: Path) -> str:
    path = tmp_path / "team.toml"
    path.write_text(TEAM)
    return str(path)


def test_emulated_robots_of_a_team_come_with_their_parts_and_places(team: str) -> None:
    options = parse(["--team", team])
    assert options.robots == ("p3dx:happy", "p2dx:doc")
    assert options.fits == ("happy=gripper,no-rear-sonar",)
    assert options.places == {"happy": Pose2D(1.0, 2.0, 0.0)}
    assert (options.world, options.link, options.links) == ("empty", "rs232", {"doc": "radio-modem"})


def test_command_line_wins_over_the_team_file(team: str) -> None:
    options = parse(["--team", team, "--world", "office", "--link", "ideal", "--robot", "amigo"])
    assert (options.world, options.link) == ("office", "ideal")
    assert options.robots == ("amigo", "p3dx:happy", "p2dx:doc")


@pytest.mark.parametrize("name", configs.names("teams"))
def test_every_team_has_models_and_parts_that_there_are(name: str) -> None:
    for robot in configs.load(TeamFile, "teams", name).robots:
        read_fit(robot.fit, configs.load(RobotModel, "robots", robot.model))


def test_some_robots_of_a_team_can_be_had_without_the_others(team: str) -> None:
    options = parse(["--team", team, "--only", "doc"])
    assert (options.robots, options.fits, options.links) == (("p2dx:doc",), (), {"doc": "radio-modem"})


@pytest.mark.parametrize("name", ["sneezy", "iron"])
def test_robot_that_a_team_has_not_or_not_emulated_cannot_be_chosen(team: str, name: str) -> None:
    with pytest.raises(configs.ConfigError, match=f"--only {name}: no emulated robot of .* has this name"):
        parse(["--team", team, "--only", name])
