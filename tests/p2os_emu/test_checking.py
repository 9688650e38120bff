"""Where a recorded robot and the emulated one part: found in what is changed on purpose, and nowhere else."""

from collections.abc import Callable
from pathlib import Path

import pytest

import configs
from p2os import Command, Frame, FrameDecoder, RobotModel, encode_command, encode_frame
from p2os.sip import SIP_TYPES
from p2os.wire_log import FrameSource
from p2os_emu.checking import RecordingDifference, compare, replay
from p2os_emu.emulator import STEP
from p2os_emu.recording import RecordedBytes, Recording, read
from tests.p2os_emu.flat_world import FlatWorld

CAPTURES = Path(__file__).resolve().parents[3] / "shared" / "captures"
P3DX = configs.load(RobotModel, "robots", "p3dx-sh")
SCRIPT = (
    (0.0, Command.SYNC0, None),
    (0.1, Command.SYNC1, None),
    (0.2, Command.SYNC2, None),
    (0.3, Command.OPEN, None),
    (0.5, Command.CONFIG, None),
    (0.6, Command.ENABLE, 1),
    (0.7, Command.VEL, 0.3),
    (1.6, Command.ENCODER, 1),
    (2.4, Command.STOP, None),
    (3.4, Command.CLOSE, None),
)
Change = Callable[[float, bytes], bytes | None]


@pytest.fixture(scope="module")
def recorded() -> list[RecordedBytes]:
    """A drive of the emulated robot, both directions."""
    host = [
        RecordedBytes(5.0 + time, FrameSource.HOST, encode_command(command, value)) for time, command, value in SCRIPT
    ]
    return sorted([*host, *replay(Recording(tuple(host)), P3DX, FlatWorld())])


def changed(recorded: list[RecordedBytes], change: Change) -> list[RecordingDifference]:
    """Where the emulator parts from a recording in which the robot's payloads were changed; None leaves one out."""
    moments = []
    for time, source, data in recorded:
        payloads = [event.payload for event in FrameDecoder().receive(data, time) if isinstance(event, Frame)]
        if source is FrameSource.ROBOT:
            kept = [new for payload in payloads if (new := change(time, payload)) is not None]
            data = b"".join(map(encode_frame, kept))
        moments.append(RecordedBytes(time, source, data))
    return compare(moments, replay(Recording(tuple(moments)), P3DX, FlatWorld()), P3DX)


def test_emulator_agrees_with_itself(recorded: list[RecordedBytes]) -> None:
    assert changed(recorded, lambda time, payload: payload) == []


@pytest.mark.parametrize("steps", range(1, 12))
def test_robot_whose_cycle_began_at_another_time_is_the_same(steps: int) -> None:
    """Where the motors are enabled at once, only one of the two robots may have told of the time before."""
    enabled = [(0.3083 if command is Command.ENABLE else time, command, value) for time, command, value in SCRIPT]
    # ENCODER is left out: its answer counts on, so the moment matters.
    hurried = sorted((said for said in enabled if said[1] is not Command.ENCODER), key=lambda said: said[0])
    earlier = RecordedBytes(5.0 - steps * STEP, FrameSource.HOST, encode_command(Command.STOP))
    host = [
        RecordedBytes(5.0 + time, FrameSource.HOST, encode_command(command, value)) for time, command, value in hurried
    ]
    recorded = sorted([*host, *replay(Recording((earlier, *host)), P3DX, FlatWorld())])
    assert compare(recorded, replay(Recording(tuple(recorded)), P3DX, FlatWorld()), P3DX) == []


def test_missing_and_extra_packets_are_named(recorded: list[RecordedBytes]) -> None:
    (difference,) = changed(recorded, lambda time, payload: None if payload[0] == 0x90 else payload)
    assert (difference.kind, difference.aspect, difference.recorded, difference.emulated) == (
        "ENCODERS",
        "number of packets",
        0,
        1,
    )
    (difference,) = changed(recorded, lambda time, payload: b"\xd0" + bytes(26) if payload[0] == 0x90 else payload)[-1:]
    assert (difference.kind, difference.recorded, difference.emulated) == ("PLAYLIST", 1, 0)


def test_field_that_differs_is_shown_with_both_values(recorded: list[RecordedBytes]) -> None:
    def of_another_model(time: float, payload: bytes) -> bytes:
        return payload.replace(b"p3dx-sh", b"p3at-sh", 1) if payload[0] == 0x20 else payload

    (difference,) = changed(recorded, of_another_model)
    assert difference[:4] == ("CONFIGURATION", "subtype", "p3at-sh", "p3dx-sh")
    assert str(difference) == "CONFIGURATION: subtype differs: recorded p3at-sh, emulated p3dx-sh"


def test_sips_that_differ_are_counted(recorded: list[RecordedBytes]) -> None:
    def stalled(time: float, payload: bytes) -> bytes:
        stall = slice(12, 14)  # source: protocol sheet, standard SIP
        if payload[0] not in SIP_TYPES or time < 7.0:
            return payload
        return payload[: stall.start] + b"\1\1" + payload[stall.stop :]

    (difference,) = changed(recorded, stalled)
    assert difference[:4] == ("SIP", "stall", 0x0101, 0)
    assert 0 < difference.packets < difference.of
    assert difference.time >= 7.0


def test_odometry_that_starts_elsewhere_is_the_same(recorded: list[RecordedBytes]) -> None:
    def moved(time: float, payload: bytes) -> bytes:
        x = int.from_bytes(payload[1:3], "little") + 32700
        moved = payload[:1] + (x % 32768).to_bytes(2, "little") + payload[3:]
        return moved if payload[0] in SIP_TYPES else payload

    assert changed(recorded, moved) == []


def test_other_pace_of_sips_is_found(recorded: list[RecordedBytes]) -> None:
    count = iter(range(1000))
    differences = changed(recorded, lambda time, sip: None if sip[0] in SIP_TYPES and next(count) % 2 else sip)
    assert {difference.aspect for difference in differences} == {"number of packets", "period"}


def test_late_answer_is_found(recorded: list[RecordedBytes]) -> None:
    late = [
        moment._replace(time=moment.time + 0.4)
        if moment.source is FrameSource.ROBOT and b"\xfa\xfb\x0b\x90" in moment.data
        else moment
        for moment in recorded
    ]
    (difference,) = compare(late, recorded, P3DX)
    assert (difference.kind, difference.aspect) == ("ENCODERS", "time")


def test_damaged_frame_of_the_recording_is_a_kind_of_its_own(recorded: list[RecordedBytes]) -> None:
    noise = RecordedBytes(6.0, FrameSource.ROBOT, b"\xfa\xfb\x03\x00\x00\x01")
    (difference,) = compare(sorted([*recorded, noise]), recorded, P3DX)
    assert difference.kind == "damaged (checksum)"


@pytest.mark.skipif(not CAPTURES.is_dir(), reason="the recordings are not beside the repository")
def test_recording_of_another_simulator_parts_from_ours_where_it_is_known_to() -> None:
    recording = read(CAPTURES / "carmen.p3dx-sh.jsonl")
    differences = compare(recording.moments, replay(recording, P3DX, FlatWorld()), P3DX)
    # Source: their notes: type 0x32 always, SIPs longer than ARCOS sends, digital outputs all on.
    assert {"moving", "size", "digital_out"} <= {
        difference.aspect for difference in differences if difference.kind == "SIP"
    }
    assert {difference.kind for difference in differences} == {"SIP"}, "the handshake is the same"
