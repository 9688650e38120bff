"""`acromovi record` and `acromovi replay` on the real bus, as people use them."""

import json
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from acromovi.__main__ import main
from bus import ZenohBus
from bus.bus import Sample
from recorder.recorded_file import McapRecordingError
from recorder.recording import McapRecording
from tests.acromovi.team.private_bus import private_bus
from tests.live_team import environment
from tests.recorder.recordings import drive, odometry, read
from tests.waiting import end_of, wait_until

STAMP = 1_700_000_000_000_000_000


@contextmanager
def recording(
    profile: str, output: Path, *options: str, largest: int | None = None
) -> "Iterator[subprocess.Popen[str]]":
    """A recorder as a process. largest: bytes that its files may have, in place of a full disk."""

    def limit() -> None:
        if largest is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))

    command = [sys.executable, "-m", "acromovi", "record", "--bus", profile, "--output", str(output), *options]
    process = subprocess.Popen(
        command, env=environment(), preexec_fn=limit, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        yield process
    finally:
        process.kill()
        end_of(process)


def publish_until(bus: ZenohBus, is_enough: Callable[[], object], payload: int = 0) -> int:
    """Publish odometry until a condition holds; return how many messages."""
    count = 0

    def publish() -> bool:
        nonlocal count
        for _ in range(20):
            bus.send("happy/odom", odometry("happy", 0.001 * count, STAMP + count))
            if payload:
                bus.deliver(Sample("happy/noise", os.urandom(payload), "application/octet-stream"))
            count += 1
        return bool(is_enough())

    wait_until(publish)
    return count


def messages_in(path: Path) -> int:
    """How many messages of a file can be read."""
    try:
        return len(read(path))
    except McapRecordingError:  # it is not there yet, or the first chunk is not written yet as a whole
        return 0


def test_a_killed_recorder_leaves_a_readable_file(tmp_path: Path) -> None:
    profile, path = private_bus(), tmp_path / "killed.mcap"
    with ZenohBus.open(profile) as bus, recording(profile, path, "happy") as process:
        publish_until(bus, lambda: messages_in(path) > 10)
        process.send_signal(signal.SIGKILL)
        assert end_of(process)
    positions = [each.sample.decoded().pose.pose.position.x for each in read(path)]
    assert positions == sorted(positions)
    assert len(positions) > 10
    with McapRecording.open([path]) as opened:
        assert "is cut short" in opened.notes[0]


def test_ctrl_c_ends_it_with_one_line_of_json(tmp_path: Path) -> None:
    profile, path = private_bus(), tmp_path / "drive.mcap"
    with ZenohBus.open(profile) as bus, recording(profile, path, "--json") as process:
        publish_until(bus, lambda: messages_in(path) > 10)
        process.send_signal(signal.SIGINT)
        printed, errors = end_of(process)
    assert (process.returncode, errors) == (0, "")
    said = json.loads(printed)
    assert (said["files"], said["lost"], said["error"]) == ([str(path)], 0, None)
    assert said["messages"] == len(read(path))


def test_a_full_disk_ends_it_with_one_sentence(tmp_path: Path) -> None:
    profile, path = private_bus(), tmp_path / "full.mcap"
    with ZenohBus.open(profile) as bus, recording(profile, path, "happy", largest=3_000_000) as process:
        publish_until(bus, lambda: process.poll() is not None, payload=20_000)
        _, errors = end_of(process)
    assert process.returncode == 1
    assert errors.startswith(f"acromovi record: the recording ended: {path} cannot become longer (File too large)")
    assert errors.count("\n") == 1
    assert len(read(path)) > 10
    with McapRecording.open([path]) as opened:
        assert "is cut short" not in " ".join(opened.notes)


def test_a_recording_never_replaces_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "drive.mcap"
    path.write_text("precious")
    assert main(["record", "--output", str(path), "--bus", private_bus()]) == 1
    assert "exists already; choose another --output" in capsys.readouterr().err
    assert path.read_text() == "precious"


def test_info_lists_channels_for_people_and_programs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (path,) = drive(tmp_path / "drive.mcap")
    assert main(["record", "--info", str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(f"{path}: 122 messages in 3.9 s from ")
    assert "happy/odom                 nav_msgs/msg/Odometry         40    10.3 Hz" in lines
    assert main(["record", "--info", str(path), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert {"key": "happy/cmd_vel", "type": "geometry_msgs/msg/Twist", "encoding": "cdr", "count": 40} in said[
        "channels"
    ]


def test_a_replay_publishes_streams_under_another_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile = private_bus()
    (path,) = drive(tmp_path / "drive.mcap")
    heard: list[Sample] = []
    with ZenohBus.open(profile) as bus:
        bus.subscribe("**", heard.append)
        words = ["replay", str(path), "--bus", profile, "--speed", "20", "--start", "2", "--rename", "happy=ghost"]
        assert main(words) == 0
        wait_until(lambda: len(heard) >= 40)
    assert {each.key for each in heard} == {"ghost/odom", "ghost/agents/base/results"}
    assert "published 40 messages; left out happy/cmd_vel, which are commands" in capsys.readouterr().out


def test_no_recording_is_published_under_the_name_of_a_live_robot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    profile = private_bus()
    (path,) = drive(tmp_path / "drive.mcap")
    heard: list[Sample] = []
    with ZenohBus.open(profile) as bus:
        bus.declare_alive("happy/alive")
        bus.subscribe("**", heard.append)
        assert main(["replay", str(path), "--bus", profile]) == 1
        assert "happy lives on this bus" in capsys.readouterr().err
        assert main(["replay", str(path), "--bus", profile, "--speed", "20", "--rename", "happy=ghost"]) == 0
    assert not [each for each in heard if each.key.startswith("happy/")]


def test_a_replay_ends_when_a_robot_of_its_name_comes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile = private_bus()
    (path,) = drive(tmp_path / "drive.mcap")
    with ZenohBus.open(profile) as bus:

        def come(sample: Sample) -> None:
            bus.declare_alive("happy/alive")

        bus.subscribe("happy/odom", come)
        assert main(["replay", str(path), "--bus", profile, "--loop"]) == 1
    assert "choose another name: --rename happy=recorded" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["absent.mcap"], 1, "absent.mcap cannot be opened"),
        (["{drive}", "--speed", "0"], 2, "0 is no speed; choose one from 0.01 to 100"),
        (["{drive}", "--start", "-1"], 2, "-1 is no time after the start"),
        (["{drive}", "--rename", "happy"], 2, "'happy' is not OLD=NEW"),
        (["{drive}", "--rename", "doc=ghost"], 2, "the recording has no such name"),
    ],
)
def test_mistakes_of_a_replay_are_answered_in_a_sentence(
    words: list[str], code: int, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (path,) = drive(tmp_path / "drive.mcap")
    try:
        found = main(["replay", *(word.format(drive=path) for word in words), "--bus", private_bus()])
    except SystemExit as err:
        found = int(str(err.code))
    assert found == code
    assert says in capsys.readouterr().err
