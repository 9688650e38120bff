"""Poses shared on the bus, with robots that are not there: silence, jumps and refusals."""

from itertools import count
from typing import Any, cast

import pytest

from agents import Robot, RobotError
from agents.client.readings import SonarDiscPose
from apps.formation.members import MemberState
from apps.formation.shared_poses import SharedPoses, read_starts
from geometry import Pose2D, Twist2D
from tests.waiting import wait_until


class Base:
    """Answers as the base of a robot does."""

    def __init__(self) -> None:
        self.x, self.stamp, self.refuses, self.driven = 0.0, 1.0, False, Twist2D()

    def ask(self, request: str, within: float) -> dict[str, Any]:
        return {"stamp": self.stamp, "x": self.x, "y": 0.0, "heading": 0.0, "linear": 0.1, "angular": 0.0}

    def drive(self, linear: float, angular: float) -> None:
        if self.refuses:
            raise RobotError("the e-stop is pressed")
        self.driven = Twist2D(linear, angular)


class Sonar:
    """Answers as a sonar of one disc does; `fails` as one whose agent has heard nothing for some time."""

    def __init__(self) -> None:
        self.stamp, self.distance, self.fails = 1.0, 0.8, False
        self.discs = {3: SonarDiscPose(number=3, frame="doc/sonar_3", x=0.1, y=0.0, heading=0.0, field_of_view=0.5)}

    def ask(self, request: str, within: float) -> dict[str, Any]:
        if self.fails:
            raise RobotError("sonar@doc has heard nothing for 2.0 s")
        return {"stamp": self.stamp, "ranges": {3: self.distance}}


class FakeRobot:
    """A robot, without sonar unless it is told to have one."""

    def __init__(self, has_sonar: bool = False) -> None:
        self.name, self.base, self.sonar = "doc", Base(), Sonar()
        self._has_sonar = has_sonar

    def has(self, element: str) -> bool:
        return element == "base" or (element == "sonar" and self._has_sonar)

    def element(self, name: str) -> Base:
        return self.base


@pytest.fixture
def robot() -> FakeRobot:
    return FakeRobot()


@pytest.fixture
def poses(robot: FakeRobot) -> SharedPoses:
    return SharedPoses([cast(Robot, robot)], {"doc": Pose2D(1.0, 2.0, 0.0)}, 0.2)


def heard(poses: SharedPoses, now: float) -> float:
    """When the reading was new that a look at a time gives, s."""
    poses.read(now)
    wait_until(lambda: "doc" in poses.read(now), "doc is heard")
    return poses.read(now)["doc"].heard


def test_odometry_begins_at_the_start(robot: FakeRobot, poses: SharedPoses) -> None:
    robot.base.x = 0.5
    assert heard(poses, 1.0) == 1.0
    assert poses.read(1.0)["doc"].pose == Pose2D(1.5, 2.0, 0.0)


def test_the_same_reading_again_is_no_sign_of_life(robot: FakeRobot, poses: SharedPoses) -> None:
    assert heard(poses, 1.0) == 1.0
    assert heard(poses, 2.0) == 1.0
    robot.base.stamp = 2.0
    wait_until(lambda: heard(poses, 3.0) == 3.0, "the new reading is taken")


def test_a_robot_whose_odometry_jumps_is_driven_no_more(robot: FakeRobot, poses: SharedPoses) -> None:
    heard(poses, 1.0)
    robot.base.x, robot.base.stamp = 5.0, 1.1
    wait_until(lambda: poses.read(1.1) and poses.has_leapt("doc"), "the jump is seen")
    assert poses.read(1.2)["doc"].pose.x == 1.0
    assert "its odometry has jumped" in poses.drive("doc", Twist2D(0.3, 0.0))
    assert robot.base.driven == Twist2D()


def test_a_refusal_is_told_until_the_robot_obeys(robot: FakeRobot, poses: SharedPoses) -> None:
    robot.base.refuses = True
    wait_until(lambda: poses.drive("doc", Twist2D(0.3, 0.0)) == "the e-stop is pressed", "the refusal is told")
    robot.base.refuses = False
    wait_until(lambda: poses.drive("doc", Twist2D(0.3, 0.0)) == "", "it obeys")
    wait_until(lambda: robot.base.driven == Twist2D(0.3, 0.0), "it drives")


def look(robot: FakeRobot, poses: SharedPoses, now: float) -> MemberState:
    """What is known after readings of odometry that are new at a time, s."""
    robot.base.stamp = now
    wait_until(lambda: heard(poses, now) == now, "the new odometry is taken")
    return poses.read(now)["doc"]


@pytest.mark.parametrize("fails", [False, True], ids=["repeats its reading", "refuses"])
def test_the_echoes_of_a_sonar_that_falls_silent_hold_for_a_second(fails: bool) -> None:
    robot = FakeRobot(has_sonar=True)
    poses = SharedPoses([cast(Robot, robot)], {"doc": Pose2D()}, 0.2)
    times = (1.0 + number / 1000.0 for number in count())
    wait_until(lambda: look(robot, poses, next(times)).echoes, "the first echo is taken")
    robot.sonar.fails = fails
    state = look(robot, poses, 1.9)
    assert [echo.distance for echo in state.echoes] == [0.8]
    assert state.trouble == ""
    state = look(robot, poses, 2.9)
    assert state.echoes == ()
    assert state.trouble == "has a silent sonar"
    robot.sonar.fails, robot.sonar.stamp, robot.sonar.distance = False, 3.0, 0.5
    wait_until(lambda: not look(robot, poses, 2.0 + next(times)).trouble, "the new echo is taken")
    assert [echo.distance for echo in poses.read(3.5)["doc"].echoes] == [0.5]


def test_a_robot_without_sonar_has_no_trouble(robot: FakeRobot, poses: SharedPoses) -> None:
    assert look(robot, poses, 5.0).trouble == ""


def test_starts_come_from_a_team_file() -> None:
    starts = read_starts("acromovi", ["happy", "doc"])
    assert starts["happy"] == Pose2D(1.0, 6.1, 0.0)
    assert starts["doc"].heading == pytest.approx(3.14159, abs=1e-4)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (3, "starts is a team file or"),
        ({"doc": [0, 0]}, "starts gives no start of happy"),
        ({"doc": [0, 0], "happy": [0]}, r"the start of happy is \[0\]; expected \[x, y, heading\]"),
        ({"doc": [0, 0], "happy": [0, float("nan")]}, "expected"),
    ],
)
def test_starts_that_are_none_are_refused(given: object, told: str) -> None:
    with pytest.raises(RobotError, match=told):
        read_starts(given, ["happy", "doc"])
