"""`acromovi localize` and goals by name, on the real bus with the real agent; the test plays odometry and laser."""

import json
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from acromovi.__main__ import main
from agents.components.localization.localization_agent import LocalizationAgent
from bus import ZenohBus, keys
from bus.messages import LaserScan, Odometry, Point, Pose, header, quaternion, twist
from bus.ros_msgs import PoseWithCovariance, TwistWithCovariance
from geometry import Cairn, Pose2D, Segment
from maps.map_files import write_building_map
from tests.acromovi.agents_alive import living
from tests.acromovi.navigation.planning import navigation
from tests.maps.localization.simulated import ANGLES, FLOOR, PERIOD, scan

HOME = Pose2D(3.0, 1.5, 0.5)
PLACES = (
    Cairn("RobotHome", HOME, ""),
    Cairn("Goal", Pose2D(8.0, 2.0), "Lab 2"),
    Cairn("Goal", Pose2D(1.0, 4.0), "Store"),
    Cairn("ForbiddenArea", Pose2D(), "", Segment(0.5, 3.5, 1.5, 4.5)),
)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("maps") / "office.map"
    return str(write_building_map(replace(FLOOR, places=PLACES), path)[0])


@pytest.fixture
def standing(robot: str) -> Iterator[str]:
    """A robot that stands at HOME, with laser, navigation and the agent of localization."""
    agent = LocalizationAgent(f"localization@{robot}", {"laser": {"x": 0.0, "y": 0.0, "heading": 0.0}})
    is_over = threading.Event()
    with ZenohBus.open() as bus, living(robot, agent, *navigation(robot, "going")):
        thread = threading.Thread(target=_play, args=(bus, robot, is_over))
        thread.start()
        yield robot
        is_over.set()
        thread.join()


def _play(bus: ZenohBus, robot: str, is_over: threading.Event) -> None:
    odometry, scans = (bus.publisher(topic.key(robot), topic.type_name) for topic in (keys.ODOM, keys.SCAN))
    ranges = np.hypot(*scan(FLOOR, HOME, np.random.default_rng(0)).T).astype(np.float32)
    assert len(ranges) == len(ANGLES)
    pose = Pose(position=Point(x=0.0, y=0.0, z=0.0), orientation=quaternion(0.0))
    stamp = 1_700_000_000_000_000_000
    while not is_over.wait(PERIOD / 2.0):
        stamp += round(PERIOD * 1e9)
        odometry.put(
            Odometry(
                header=header(stamp, f"{robot}/odom"),
                child_frame_id=f"{robot}/base_link",
                pose=PoseWithCovariance(pose=pose, covariance=np.zeros(36)),
                twist=TwistWithCovariance(twist=twist(0.0, 0.0), covariance=np.zeros(36)),
            )
        )
        scans.put(
            LaserScan(
                header=header(stamp, f"{robot}/laser"),
                angle_min=float(ANGLES[0]),
                angle_max=float(ANGLES[-1]),
                angle_increment=float(ANGLES[1] - ANGLES[0]),
                time_increment=0.0,
                scan_time=PERIOD,
                range_min=0.0,
                range_max=32.0,
                ranges=ranges,
                intensities=np.empty(0, np.float32),
            )
        )


def test_a_robot_is_localized_and_sent_to_a_goal_of_the_map(
    standing: str, file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["navigate", "go", standing, "Lab 2"]) == 1
    assert "no localization" in capsys.readouterr().err
    assert main(["localize", standing, "--state"]) == 1
    assert "stopped" in capsys.readouterr().err
    assert main(["localize", standing, "--map", file]) == 0
    assert capsys.readouterr().out.startswith(f"{standing} is localized at (3.0")
    assert main(["localize", standing, "--state", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["pose"] == pytest.approx([HOME.x, HOME.y, HOME.heading], abs=0.1)
    assert main(["navigate", "go", standing, "lab 2", "--json"]) == 0
    capsys.readouterr()
    assert main(["navigate", "state", standing, "--json"]) == 0
    goal = json.loads(capsys.readouterr().out)["goal"]
    assert (goal["x"], goal["y"], goal["frame"]) == (8.0, 2.0, "map")
    for place, why in (
        (["Lab 3"], "did you mean Lab 2?"),
        (["Store"], "forbidden area"),
        (["5", "0.1", "--map"], "wall"),
    ):
        assert main(["navigate", "go", standing, *place]) == 1
        assert why in capsys.readouterr().err
    assert main(["localize", standing, "--stop"]) == 0
    assert "stopped" in capsys.readouterr().out


def test_a_robot_in_an_unknown_place_is_not_localized_by_standing(
    standing: str, file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["localize", standing, "--map", file, "--unknown", "--timeout", "1"]) == 1
    assert "is not localized (searching)" in capsys.readouterr().err


def test_settings_beside_the_command_are_named_by_their_whole_path_to_the_agent(
    standing: str, file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text("particels = 3\n")
    assert main(["localize", standing, "--map", file, "--settings", "mine.toml"]) == 1
    assert f"{tmp_path / 'mine.toml'}: unknown key particels" in capsys.readouterr().err


def test_errors_of_a_map_name_file_and_line(standing: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = tmp_path / "bad.map"
    bad.write_text("2D-Map\nLINES\n0 0 1000\n")
    assert main(["localize", standing, "--map", str(bad)]) == 1
    assert f"{bad}:3: a line needs x1 y1 x2 y2" in capsys.readouterr().err


def test_wrong_usage_is_explained(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["localize", "happy", "--state", "--unknown"]) == 2
    assert "--unknown and --settings need --map FILE" in capsys.readouterr().err
