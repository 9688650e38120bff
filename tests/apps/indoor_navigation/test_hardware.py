"""Base and laser of a robot of the team, whose gateway a test speaks for; and what becomes of them when it goes."""

from collections.abc import Iterator
from math import inf, nan

import pytest

from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.component import send_key
from apps.indoor_navigation.components.laser_server import LaserServer
from apps.indoor_navigation.components.robot_base_server import WAY_NOTES, RobotBaseServer
from apps.indoor_navigation.data import LaserRead, MotionCmd, RobotOdometry, SonarRead, WayRequest
from bus import MemoryBus, Refused, keys
from tests.apps.indoor_navigation.site import ROBOT, Robot, Site


@pytest.fixture
def site() -> Iterator[Site]:
    loop = VirtualTimeLoop()
    site = Site(loop)
    base = {"hears": [["motion_fuser", "MotionCmd"]]}
    site.start(RobotBaseServer(f"robot_base_server@{ROBOT}", base))
    site.start(LaserServer(f"laser_server@{ROBOT}", {"hears": [["robot_base_server", "Odometry"]]}))
    yield site
    site.close()
    loop.close()


@pytest.fixture
def robot(site: Site) -> Robot:
    """It has been heard, and has said what it is."""
    robot = Robot(site)
    robot.odometry()
    robot.scan([1.0, 1.0])
    site.run(0.1)
    return robot


def command(site: Site, linear: float, angular: float = 0.0) -> None:
    site.push("motion_fuser", MotionCmd(site.time, "motion_fuser", linear, angular, 1.0))


def drive(site: Site, robot: Robot, seconds: float, linear: float = 0.2) -> None:
    """Let the fuser say so, and the robot where it is."""
    for step in range(round(seconds / 0.05)):
        command(site, linear)
        if step % 2 == 0:
            robot.odometry()
        site.run(0.05)


def test_the_robot_tells_where_it_is_and_how_fast(site: Site, robot: Robot) -> None:
    heard = site.pushed("robot_base_server", RobotOdometry)
    robot.odometry(0.1, 0.05, 0.3, 0.2, -0.4)
    site.run(0.01)
    (odometry,) = heard
    assert odometry.stamp == pytest.approx(site.time, abs=0.02)
    told = (odometry.x, odometry.y, odometry.heading, odometry.linear, odometry.angular)
    assert told == pytest.approx((0.1, 0.05, 0.3, 0.2, -0.4))
    assert odometry.jumps == 0


def test_a_pose_that_was_set_anew_is_counted(site: Site, robot: Robot) -> None:
    heard = site.pushed("robot_base_server", RobotOdometry)
    for x, heading in ((0.05, 0.0), (0.1, 0.0), (5.0, 0.0), (5.05, 0.1), (5.05, 2.5), (5.1, 2.5)):
        robot.odometry(x, 0.0, heading, 0.5)
        site.run(0.1)
    assert [odometry.jumps for odometry in heard] == [0, 0, 1, 1, 2, 2]


def test_a_robot_that_has_driven_unheard_for_a_moment_has_not_jumped(site: Site, robot: Robot) -> None:
    heard = site.pushed("robot_base_server", RobotOdometry)
    robot.odometry(0.0, 0.0, 0.0, 0.5)
    site.run(1.5)
    robot.odometry(0.75, 0.0, 0.0, 0.5)
    site.run(0.1)
    assert heard[-1].jumps == 0


def test_discs_that_fire_in_turns_are_read_together(site: Site, robot: Robot) -> None:
    heard = site.pushed("robot_base_server", SonarRead)
    robot.sonar({0: 2.0})
    site.run(0.1)
    robot.odometry(0.05, 0.0, 0.0, 0.5)
    robot.sonar({3: inf})
    site.run(0.1)
    reading = heard[-1]
    assert reading.ranges.tolist() == [2.0, inf]
    assert reading.headings.tolist() == pytest.approx([1.5708, 0.0], abs=1e-3)
    assert reading.places_y.tolist() == pytest.approx([0.14, 0.03], abs=1e-3)
    # Disc 0 was at 0.07 when it measured, and the robot has come 0.05 since.
    assert reading.places_x.tolist() == pytest.approx([0.02, 0.17], abs=1e-3)
    assert reading.pose == pytest.approx((0.05, 0.0, 0.0))


def test_a_disc_that_has_died_is_left_out_and_a_dead_sonar_is_silent(site: Site, robot: Robot) -> None:
    heard = site.pushed("robot_base_server", SonarRead)
    robot.sonar({0: 2.0, 3: 1.0})
    for _ in range(8):
        site.run(0.1)
        robot.odometry()
        robot.sonar({3: 1.0})
    site.run(0.1)
    assert heard[-1].ranges.tolist() == [1.0]
    silent_from = len(heard)
    for _ in range(10):
        robot.odometry()
        robot.sonar({})
        site.run(0.1)
    assert len(heard) - silent_from <= 6  # 0.6 s


def test_a_range_that_is_no_number_is_left_out(site: Site, robot: Robot) -> None:
    heard = site.pushed("robot_base_server", SonarRead)
    robot.sonar({0: nan, 3: 1.0, 77: 0.5})
    site.run(0.1)
    assert heard[-1].ranges.tolist() == [1.0]


def test_the_robot_is_described(site: Site, robot: Robot) -> None:
    assert site.ask("robot_base_server", "robot") == {
        "name": "happy",
        "model": "p2dx",
        "front": 0.21,
        "rear": 0.301,
        "width": 0.425,
        "radius": 0.25,
        "limits": {"linear": 2.2, "angular": 8.7, "deceleration": 0.6},
    }


def test_before_the_robot_is_there_nobody_knows_it(site: Site) -> None:
    with pytest.raises(Refused, match="check whether its p2os-gateway runs"):
        site.ask("robot_base_server", "robot")


def ask_for_way(site: Site, age: float = 0.0) -> None:
    key = send_key(ROBOT, "robot_base_server", WayRequest)
    site.bus.send(key, WayRequest(site.time - age, "m1").to_json())
    site.run(0.1)


def test_people_are_asked_for_way_by_a_sound(site: Site, robot: Robot) -> None:
    played: list[object] = []

    def play(arguments: dict[str, object]) -> dict[str, object]:
        played.append(arguments)
        return {}

    buzzer = MemoryBus(site.network)
    buzzer.serve(keys.SOUND.key(ROBOT), play)
    ask_for_way(site)
    (sound,) = played
    assert sound == {"notes": WAY_NOTES}
    ask_for_way(site, age=5.0)
    site.bus.send(send_key(ROBOT, "robot_base_server", WayRequest), {"stamp": "now", "mission": "m1"})
    site.run(0.1)
    assert len(played) == 1, "a request of before a freeze is not played, nor one without a time"
    assert site.reports == []


def test_a_robot_that_cannot_play_a_sound_drives_as_before(site: Site, robot: Robot) -> None:
    def refuse(arguments: dict[str, object]) -> dict[str, object]:
        raise Refused("there is no buzzer")

    ask_for_way(site)
    buzzer = MemoryBus(site.network)
    buzzer.serve(keys.SOUND.key(ROBOT), refuse)
    ask_for_way(site)
    assert site.reports == []
    command(site, 0.2)
    site.run(0.05)
    assert robot.told[-1][1:] == (0.2, 0.0, "")


def test_the_wheels_are_told_what_the_fuser_says(site: Site, robot: Robot) -> None:
    command(site, 0.2, -0.3)
    site.run(0.01)
    assert [told[1:] for told in robot.told] == [(0.2, -0.3, "")]


def test_when_the_fuser_falls_silent_the_robot_is_stopped_within_0_4_s(site: Site, robot: Robot) -> None:
    drive(site, robot, 1.0)
    silent_since = robot.told[-1][0]
    site.run(1.0)
    at, *told = robot.told[-1]
    assert told == [0.0, 0.0, ""]
    assert at - silent_since <= 0.4


def test_a_command_with_no_number_is_as_good_as_silence(site: Site, robot: Robot) -> None:
    drive(site, robot, 1.0)
    for _ in range(20):
        site.bus.put(
            f"{ROBOT}/navigation/motion_fuser/push/MotionCmd",
            {"stamp": site.time, "source": "motion_fuser", "linear": None, "angular": 0.0, "weight": 1.0},
        )
        site.run(0.05)
    assert robot.told[-1][1:] == (0.0, 0.0, "")


def test_commands_that_waited_while_the_process_was_frozen_move_nothing(site: Site, robot: Robot) -> None:
    for _ in range(10):
        site.push("motion_fuser", MotionCmd(site.time - 3.0, "motion_fuser", 0.2, 0.0, 1.0))
        site.run(0.05)
    assert robot.told == []


def test_the_wheels_of_a_robot_that_rests_are_left_alone(site: Site, robot: Robot) -> None:
    drive(site, robot, 1.0)
    drive(site, robot, 1.5, linear=0.0)
    said = len(robot.told)
    assert robot.told[-1][1:] == (0.0, 0.0, "")
    drive(site, robot, 1.0, linear=0.0)
    assert len(robot.told) == said


def test_a_base_server_that_is_stopped_leaves_nothing_rolling(site: Site, robot: Robot) -> None:
    drive(site, robot, 0.5)
    site.close()
    site.run(0.1)
    assert robot.told[-1][1:] == (0.0, 0.0, "")


def test_when_the_gateway_goes_it_is_said_and_when_it_is_back_all_goes_on(site: Site, robot: Robot) -> None:
    heard = site.pushed("robot_base_server", RobotOdometry)
    robot.go()
    site.run(3.0)
    missed = [report for report in site.reports if ": happy has published no odometry" in report]
    assert len(missed) == 1
    before = len(heard)
    robot.come()
    drive(site, robot, 2.0)
    assert len(heard) > before
    assert robot.told[-1][1] == 0.2
    robot.go()
    site.run(3.0)
    assert len([report for report in site.reports if ": happy has published no odometry" in report]) == 2


def test_a_scan_comes_with_the_pose_that_the_robot_had_then(site: Site, robot: Robot) -> None:
    heard = site.pushed("laser_server", LaserRead)
    robot.odometry(0.0, 0.0, 0.0, 0.5, 0.2)
    site.run(0.1)
    robot.odometry(0.05, 0.0, 0.02, 0.5, 0.2)
    site.run(0.1)
    robot.scan([1.0, inf, 2.0], age=0.15)
    robot.scan([1.0, inf, 2.0])
    site.run(0.1)
    assert heard[-1].mount == (0.02, 0.01, 0.1)
    assert heard[-1].ranges.tolist() == [1.0, inf, 2.0]
    assert heard[-1].range_max == 8.0
    assert heard[-1].angle_min == pytest.approx(-0.5)
    assert heard[-1].pose == pytest.approx((0.1, 0.0, 0.04), abs=5e-3)  # it went on as it had gone
    robot.scan([1.0, inf, 2.0], age=0.25)  # between the two odometries
    site.run(0.1)
    assert heard[-1].pose == pytest.approx((0.025, 0.0, 0.01), abs=5e-3)


def test_a_beam_that_measured_nothing_is_not_taken_for_free(site: Site, robot: Robot) -> None:
    heard = site.pushed("laser_server", LaserRead)
    robot.scan([1.0, nan, nan, 2.0, nan])
    site.run(0.1)
    assert heard[-1].ranges.tolist() == [1.0, 1.0, 1.0, 2.0, 2.0]
    robot.scan([nan, nan, nan])
    site.run(0.1)
    assert len(heard) == 1


def test_when_the_laser_dies_it_is_said(site: Site, robot: Robot) -> None:
    for _ in range(30):
        robot.odometry()
        site.run(0.1)
    assert len([report for report in site.reports if "the laser of happy has published no scan" in report]) == 1
