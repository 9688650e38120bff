"""The program with recordings: it records what flows, serves what was recorded, and checks it."""

import json
from itertools import count, pairwise
from pathlib import Path
from typing import Any

import pytest

import configs
from p2os import Command, RobotModel, encode_command, encode_frame
from p2os.wire_log import FrameSource
from p2os_emu.__main__ import main
from p2os_emu.checking import replay
from p2os_emu.options import EXIT_CONFIG, EXIT_OK, EXIT_PARTS, EmulatorOptions
from p2os_emu.recording import RecordedBytes, Recording, read
from p2os_emu.world import World, load_world
from tests.p2os_emu.test_program import CLOSE, OPEN, Client, program
from tests.waiting import Deadline

HELD_UP = 0.03  # s, three steps of the emulator beyond what its ±5 ms of cadence are


@pytest.fixture(scope="module")
def tape(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive, recorded by the program while the machine let it keep time."""
    folder, deadline = tmp_path_factory.mktemp("tapes"), Deadline()
    for number in count():
        path = folder / f"drive-{number}.jsonl"
        record(path)
        if keeps_time(path):
            return path
        assert not deadline.has_passed(), deadline.in_words("the emulator keeps time for a whole drive")
    raise AssertionError("counting does not end")


def record(path: Path) -> None:
    """Record a drive in real time."""
    with program("--robot", "p3dx-sh:happy", "--perfect", "--record", str(path)) as emulator:
        client = Client(emulator.ports[0])
        client.handshake()
        client.drive()
        client.say(CLOSE)
        client.close()


def keeps_time(tape: Path) -> bool:
    """Whether the SIPs came every 0.1 s: an emulator that the machine holds up answers later than a robot does."""
    sips = [
        each.time for each in read(tape).moments if each.source is FrameSource.ROBOT and each.data[3:4] in (b"2", b"3")
    ]
    return len(sips) > 3 and all(abs(after - before - 0.1) < HELD_UP for before, after in pairwise(sips))


def test_recording_has_both_directions_and_the_name(tape: Path) -> None:
    recording = read(tape)
    assert (recording.name, recording.model) == ("happy", "p3dx-sh")
    assert recording.identity == ("happy", "Pioneer", "p3dx-sh")
    assert recording.moments[0].data == bytes.fromhex("FA FB 03 00 00 00")


def test_of_several_robots_each_has_its_file(tmp_path: Path) -> None:
    with program("--robot", "p3dx:one", "--robot", "p3dx:two", "--record", str(tmp_path / "tape")):
        assert sorted(path.name for path in tmp_path.iterdir()) == ["tape-one", "tape-two"]


def test_a_recording_is_not_overwritten_without_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tape = tmp_path / "tape"
    tape.write_text("a recording that nobody can make again")
    again = ["--robot", "p3dx", "--record", str(tape), "--duration", "0.1", "--quiet"]
    assert main(again) == EXIT_CONFIG
    assert (
        f"{tape} exists already and would be overwritten; choose another file, or add --force"
        in capsys.readouterr().err
    )
    assert tape.read_text() == "a recording that nobody can make again"
    assert main([*again, "--force"]) == EXIT_OK
    assert "cassette" in tape.read_text()


def test_recorded_robot_meets_a_client_as_it_did(tape: Path, tmp_path: Path) -> None:
    with program("--serve", str(tape), "--pty", str(tmp_path / "robot")) as player:
        assert player.ready["robots"][0]["name"] == "happy"
        assert player.ready["control"] is None
        assert player.ports == [str(tmp_path / "robot")]
        client = Client(player.ports[0])
        assert client.handshake() == ["happy", "Pioneer", "p3dx-sh"]
        client.say(OPEN)
        client.wait_for_speed(lambda left, right: left > 100 and right > 100)
        client.close()


def test_recorded_robot_is_served_on_tcp_as_well(tape: Path) -> None:
    with program("--serve", str(tape), "--tcp", "0") as player:
        client = Client(player.ports[0])
        assert client.handshake() == ["happy", "Pioneer", "p3dx-sh"]
        client.close()


def test_own_recording_parts_in_nothing(tape: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--check", str(tape), "--perfect", "--json"]) == EXIT_OK
    assert json.loads(capsys.readouterr().out) == {"same": True, "model": "p3dx-sh", "partings": 0, "kinds": []}


def test_other_model_parts_from_the_recording(tape: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--check", str(tape), "--perfect", "--robot", "p2dx"]) == EXIT_PARTS
    out = capsys.readouterr().out
    assert "SYNC2: subtype differs: recorded p3dx-sh, emulated p2dx" in out
    assert "recording and emulator part in" in out


@pytest.mark.parametrize("option", ["--check", "--serve"])
def test_missing_recording_is_refused(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([option, "nowhere.jsonl"]) == EXIT_CONFIG
    assert "nowhere.jsonl cannot be read" in capsys.readouterr().err


def test_recording_of_nobody_knows_needs_a_model(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "tape"
    path.write_text('{"t": 0, "from": "host", "hex": "fafb03000000"}\n')
    assert main(["--check", str(path)]) == EXIT_CONFIG
    assert "give --robot MODEL" in capsys.readouterr().err


def test_place_that_cannot_be_written_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--robot", "p3dx", "--record", str(tmp_path / "no" / "tape")]) == EXIT_CONFIG
    assert "choose another path" in capsys.readouterr().err


def drive_after_a_pause(version: int, world_name: str = "empty", *, in_plane: bool = True) -> list[RecordedBytes]:
    """Return both ends of a drive that begins 5 s after the connection, computed as in this version."""
    host = [RecordedBytes(0.1 * number, FrameSource.HOST, encode_frame(bytes([number]))) for number in range(3)]
    host += [RecordedBytes(0.4, FrameSource.HOST, encode_command(Command.OPEN))]
    host += [RecordedBytes(0.5 + second, FrameSource.HOST, encode_command(Command.PULSE)) for second in range(12)]
    host += [
        RecordedBytes(0.45, FrameSource.HOST, encode_command(Command.ENABLE, 1)),
        RecordedBytes(5.52, FrameSource.HOST, encode_command(Command.VEL, 0.3)),
        RecordedBytes(7.02, FrameSource.HOST, encode_command(Command.SETRA, 20.0)),
        RecordedBytes(7.04, FrameSource.HOST, encode_command(Command.RVEL, 3.0)),
        RecordedBytes(8.0, FrameSource.HOST, encode_command(Command.PULSE)),
    ]
    host.sort()
    recording = Recording(tuple(host), "happy", "p3dx-sh")
    model = configs.load(RobotModel, "robots", "p3dx-sh")
    with World(load_world(world_name), perfect=True) as world:
        world.rest_parked = version >= 2
        world.engine_use.is_spared = version >= 3
        world.sonar_in_plane = in_plane
        return sorted([*host, *replay(recording, model, world)])


@pytest.mark.parametrize("version", [1, 2, 3])
def test_a_recording_is_checked_as_its_emulator_computed(version: int, tmp_path: Path) -> None:
    said = drive_after_a_pause(version)
    others = [drive_after_a_pause(each) for each in (1, 2, 3) if each != version]
    assert said not in others, "otherwise nothing is tested here"
    write_tape(tmp_path / "tape", version, said)
    assert main(["--check", str(tmp_path / "tape"), "--perfect", "--world", "empty", "--quiet"]) == EXIT_OK


def write_tape(path: Path, version: int, said: list[RecordedBytes]) -> None:
    """Write a recording of a version."""
    lines: list[dict[str, Any]] = [{"cassette": version, "name": "happy", "model": "p3dx-sh"}]
    lines += [{"t": each.time, "from": each.source, "hex": each.data.hex()} for each in said]
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))


@pytest.mark.parametrize("version", [1, 2, 3])
def test_a_recording_is_checked_as_its_emulator_cast_the_rays_of_sonar(
    version: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = drive_after_a_pause(version, "office", in_plane=version >= 3)
    other = drive_after_a_pause(version, "office", in_plane=version < 3)
    assert said != other, "otherwise nothing is tested here"
    again: list[RecordedBytes] = []

    def check(recording: Recording, path: Path, options: EmulatorOptions, world: World) -> bool:
        # What is reported leaves sonar out.
        again.extend(replay(recording, configs.load(RobotModel, "robots", "p3dx-sh"), world))
        return True

    write_tape(tmp_path / "tape", version, said)
    monkeypatch.setattr("p2os_emu.record_and_replay.check", check)
    assert main(["--check", str(tmp_path / "tape"), "--perfect", "--world", "office", "--quiet"]) == EXIT_OK
    assert again == [each for each in said if each.source is FrameSource.ROBOT]
