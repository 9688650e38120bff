"""Pictures of a recording show what was recorded."""

import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from acromovi.__main__ import main
from acromovi.plot.figures import Background, PlottedRecording
from acromovi.plot.series import RobotSeries, read_series, worst_each_second
from bus.bus import Sample
from bus.messages import Point, Pose, Time, header, placed, prepare, quaternion
from bus.ros_msgs import TFMessage
from geometry import Pose2D
from recorder.recording import McapRecording, Recorded
from recorder.writer import RecordingWriter
from tests.recorder.recordings import START, drive, odometry, sample


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return drive(tmp_path_factory.mktemp("plot") / "drive.mcap")[0]


def test_curves_are_those_of_the_recording(recording: Path) -> None:
    with McapRecording.open([recording]) as opened:
        ((robot,), damaged) = read_series(opened.samples(), opened.start_ns)
    assert damaged == 0
    assert robot.name == "happy"
    time, pose = robot.path[10]
    assert (time, pose.x, pose.y, pose.heading) == pytest.approx((1.0, 0.3, 0.15, 0.0))
    assert robot.actual[10] == pytest.approx((1.0, 0.3))
    assert robot.commanded[10] == pytest.approx((1.0, 0.4))
    assert robot.latency[10] == pytest.approx((1.0, 0.02))


def test_the_place_in_the_map_is_that_of_the_recorded_transform() -> None:
    moved = TFMessage([placed(header(START, "map"), "happy/odom", 3.0, 4.0, math.pi / 2)])
    samples = [sample("happy/odom", odometry("happy", 0.0, START)), sample("happy/tf", moved)]
    ((robot,), _) = read_series([Recorded(START, START, each) for each in samples], START)
    assert robot.in_map is not None
    assert (robot.in_map.x, robot.in_map.y, robot.in_map.heading) == pytest.approx((3.0, 4.0, math.pi / 2))


def test_garbage_and_messages_of_another_type_are_counted() -> None:
    garbage = Sample("happy/odom", b"??", "application/cdr;nav_msgs/msg/Odometry")
    other = Sample("happy/odom", sample("happy/tf", TFMessage([])).payload, "application/cdr;tf2_msgs/msg/TFMessage")
    nonsense = Sample("happy/odom", b"{}", "application/json")
    found = read_series([Recorded(START, START, each) for each in (garbage, other, nonsense)], START)
    assert found == ([], 3)


def test_the_worst_of_each_second() -> None:
    assert list(worst_each_second([(0.1, 1.0), (0.9, 3.0), (1.0, 2.0), (5.5, 4.0)])) == [
        (0.0, 3.0),
        (1.0, 2.0),
        (5.0, 4.0),
    ]
    assert list(worst_each_second([])) == []


def test_an_svg_names_the_robot_and_every_figure(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "drive.svg"
    assert (
        main(["plot", str(recording), "--output", str(output), "--map", str(_map(tmp_path)), "--at", "happy=1,1,90"])
        == 0
    )
    assert capsys.readouterr().out == f"drawn: {output}\n"
    texts = [each.text for each in ElementTree.parse(output).iter() if each.tag.endswith("text")]
    assert {"happy", "happy, actual", "happy, commanded", "latency, ms", "battery, V"} <= set(texts)
    assert any("drive.mcap: 4 s from" in (text or "") for text in texts)


def test_a_recorded_grid_is_the_map_and_a_robot_without_a_place_in_it_is_said_and_not_drawn(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "grid.mcap"
    prepare("nav_msgs/msg/OccupancyGrid")  # loads the standard types that robots do not use
    types = get_typestore(Stores.ROS2_JAZZY).types
    origin = Pose(position=Point(x=-1.0, y=-1.0, z=0.0), orientation=quaternion(0.0))
    info = types["nav_msgs/msg/MapMetaData"](Time(0, 0), 0.5, 6, 4, origin)
    cells = np.full(24, -1, np.int8)
    grid = types["nav_msgs/msg/OccupancyGrid"](header(START, "map"), info, cells)
    writer = RecordingWriter(path, "test")
    writer.add(sample("happy/map", grid), START)
    writer.add(sample("happy/odom", odometry("happy", 0.0, START)), START + 1)
    writer.close()
    output = tmp_path / "grid.svg"
    assert main(["plot", str(path), "--output", str(output)]) == 0
    assert "<image" in output.read_text()
    assert "where happy began in the map is not known; say it: --at happy=X,Y,DEG" in capsys.readouterr().err
    robots = [RobotSeries("happy", path=[(0.0, Pose2D(0.0, 0.0, 0.0))])]
    own = PlottedRecording("own", robots, Background(grid=Background.of_grid(grid).grid, frame="happy/odom"), {})
    assert own.not_in_map() == []


def test_a_folder_has_a_file_for_each_figure(recording: Path, tmp_path: Path) -> None:
    assert main(["plot", str(recording), "--output", str(tmp_path / "figures"), "--quiet"]) == 0
    assert sorted(each.name for each in (tmp_path / "figures").iterdir()) == [
        "battery.png",
        "latency.png",
        "paths.png",
        "ranges.png",
        "speeds.png",
        "turns.png",
    ]


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["absent.mcap"], 1, "absent.mcap cannot be opened: No such file"),
        (["{drive}", "--output", "a.gif"], 2, "a.gif must end in .png or .svg, or be a folder"),
        (["{drive}", "--output", "absent/a.svg"], 2, "there is no folder absent"),
        (["{drive}", "--map", "nowhere"], 1, "nowhere"),
        (["{drive}", "--map", "absent.map"], 1, "absent.map: cannot be read"),
        (["{drive}", "--at", "doc=1,1,0"], 2, "the recording has no such robot"),
        (["{battery}"], 1, "the recording has no odometry; record a robot"),
    ],
)
def test_mistakes_are_answered_in_a_sentence(
    words: list[str],
    code: int,
    says: str,
    recording: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    battery = tmp_path / "battery.mcap"
    writer = RecordingWriter(battery, "test")
    writer.add(sample("happy/tf", TFMessage([])), START)
    writer.close()
    assert main(["plot", *(word.format(drive=recording, battery=battery) for word in words)]) == code
    assert says in capsys.readouterr().err


def test_without_rerun_it_says_how_to_install_it(
    recording: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr("sys.executable", "/nowhere/python")
    assert main(["plot", str(recording), "--rerun"]) == 1
    assert "Rerun is not installed; install it with:" in capsys.readouterr().err


@pytest.mark.parametrize("is_on_the_path", [True, False])
def test_rerun_is_opened_with_the_recording_from_the_path_or_beside_the_interpreter(
    is_on_the_path: bool, recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "rerun"
    program.write_text(f'#!/bin/sh\necho "$@" > {tmp_path}/said\n')
    program.chmod(0o755)
    if is_on_the_path:
        monkeypatch.setenv("PATH", f"{tmp_path}:/bin:/usr/bin")
    else:
        monkeypatch.setattr("sys.executable", str(tmp_path / "python"))
    assert main(["plot", str(recording), "--rerun"]) == 0
    assert (tmp_path / "said").read_text() == f"{recording}\n"


def _map(folder: Path) -> Path:
    file = folder / "room.map"
    lines = ["2D-Map", "NumLines: 1", "LINES", "0 0 5000 0", "DATA"]
    file.write_text("\n".join(lines) + "\n")
    return file
