"""When a robot of a team serves."""

import pytest

from acromovi.team.readiness import PATIENCE, QUIET_TIME, Readiness
from configs.team_file import TeamRobot

HAPPY = TeamRobot("happy", "p3dx-sh", fit=("gripper", "laser", "no-rear-sonar", "joystick"))


def come_up(readiness: Readiness, *agents: str) -> None:
    readiness.connected("happy", 1.0)
    readiness.container("happy", True)
    for agent in agents:
        readiness.agent("happy", agent, True, 2.0)


@pytest.mark.parametrize(
    ("robot", "parts"),
    [
        (HAPPY, {"gripper", "laser"}),
        (TeamRobot("doc", "p3dx-sh", fit=("ptz:vcc4", "camera:160x120@10")), {"ptz", "camera"}),
        (TeamRobot("iron", "p3dx", "/dev/ttyUSB0", laser="/dev/ttyUSB1"), {"laser"}),
        (TeamRobot("bare", "p2dx", fit=("no-gripper",)), set()),
    ],
)
def test_parts_that_must_show_themselves_are_those_that_the_file_names(robot: TeamRobot, parts: set[str]) -> None:
    assert Readiness([robot])[robot.name].parts == parts


def test_robot_serves_when_its_parts_have_agents_and_no_more_come() -> None:
    readiness = Readiness([HAPPY])
    come_up(readiness, "base", "gripper", "laser")
    assert readiness.serving(2.0) == []
    assert readiness.serving(2.0 + QUIET_TIME) == ["happy"]


def test_robot_whose_laser_has_not_shown_itself_does_not_serve_until_patience_ends() -> None:
    readiness = Readiness([HAPPY])
    come_up(readiness, "base", "gripper")
    assert readiness.serving(5.0) == []
    assert readiness["happy"].missing() == ["laser"]
    assert readiness.serving(1.0 + PATIENCE) == ["happy"]


def test_robot_does_not_serve_without_gateway_container_or_agents() -> None:
    readiness = Readiness([HAPPY])
    readiness.agent("happy", "base", True, 0.0)
    assert (readiness.serving(100.0), readiness["happy"].missing()) == ([], ["the robot"])
    readiness.connected("happy", 1.0)
    assert (readiness.serving(100.0), readiness["happy"].missing()) == ([], ["its container"])
    readiness.container("happy", True)
    assert readiness.serving(100.0) == ["happy"]
    readiness.container("happy", False)
    assert readiness.serving(100.0) == []


def test_robot_that_was_lost_has_patience_anew_once_it_is_back() -> None:
    readiness = Readiness([HAPPY])
    come_up(readiness, "base", "gripper")
    readiness.lost("happy")
    assert (readiness.serving(1.0 + PATIENCE), readiness["happy"].missing()) == ([], ["the robot"])
    readiness.connected("happy", 11.0)
    assert readiness.serving(1.0 + PATIENCE) == []
    assert readiness.serving(11.0 + PATIENCE) == ["happy"]


def test_agents_of_other_platforms_are_none_of_the_teams() -> None:
    readiness = Readiness([HAPPY])
    readiness.agent("stranger", "base", True, 0.0)
    readiness.container("services", True)
    assert readiness.services_serve
    assert readiness.serving(100.0) == []
