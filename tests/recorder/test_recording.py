"""Recordings are written so that others and we read them, whatever happens to the file."""

import errno
import os
import shutil
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from bus.bus import Sample
from bus.messages import NS_PER_S
from recorder.mcap_file import DiskFull, McapFile
from recorder.recorded_file import McapRecordingError
from recorder.recording import McapRecording
from recorder.writer import RecordingWriter
from tests.recorder.recordings import START, drive, odometry, read, sample

STEPS = 40
IN_ALL = 2 + 3 * STEPS  # a token, a description, and three messages in each step


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return drive(tmp_path_factory.mktemp("whole") / "drive.mcap")[0]


@pytest.fixture(scope="module")
def killed(whole: Path) -> bytes:
    """The same recording as a killed recorder leaves it: without the index."""
    with McapRecording.open([whole]) as recording:
        assert not recording.notes
    data = whole.read_bytes()
    return data[: data.index(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00")]  # up to the record of the end of the data


def test_all_that_was_recorded_is_read_unchanged_and_in_order(whole: Path) -> None:
    found = read(whole)
    assert len(found) == IN_ALL
    assert [each.time_ns for each in found] == sorted(each.time_ns for each in found)
    first = next(each for each in found if each.sample.key == "happy/odom")
    assert first.sample == sample("happy/odom", odometry("happy", 0.0, START - 20_000_000))
    assert first.time_ns - first.published_ns == 20_000_000


def test_reading_begins_at_any_time_and_with_any_keys(whole: Path) -> None:
    with McapRecording.open([whole]) as recording:
        found = list(recording.samples(START + 3 * NS_PER_S, lambda key: key == "happy/odom"))
        assert len(found) == 10
        assert recording.duration == pytest.approx(3.9)
        counts = {channel.key: channel.count for channel in recording.channels}
    assert counts["happy/odom"] == counts["happy/cmd_vel"] == STEPS


def test_rosbags_reads_it_with_our_own_types(tmp_path: Path) -> None:
    path = tmp_path / "state.mcap"
    writer = RecordingWriter(path, "test")
    from bus.messages import RobotState, header

    writer.add(sample("happy/state", RobotState(header(START, "happy/base_link"), "connected", motors=True)), START)
    writer.add(sample("happy/agents/base/results", {"x": 1}), START + 1)
    writer.close()
    with Reader(path) as reader:
        (state,) = [each for each in reader.connections if each.topic == "/happy/state"]
        typestore = get_typestore(Stores.ROS2_JAZZY)
        typestore.register(get_types_from_msg(state.msgdef.data, state.msgtype))
        ((_, time, data),) = [row for row in reader.messages([state]) if row[0].id == state.id]
        message: Any = typestore.deserialize_cdr(data, state.msgtype)
    assert (time, message.connection, message.motors) == (START, "connected", True)


def test_the_library_of_mcap_reads_it_with_its_checksums(whole: Path) -> None:
    with whole.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == IN_ALL
        assert reader.get_header().profile == "ros2"
        found = list(reader.iter_messages(topics=["/happy/odom"]))
    schema, channel, _ = found[0]
    assert schema is not None
    assert (schema.name, schema.encoding, channel.message_encoding) == ("nav_msgs/msg/Odometry", "ros2msg", "cdr")
    assert b"MSG: geometry_msgs/PoseWithCovariance" in schema.data
    assert len(found) == STEPS


def test_a_killed_recorder_loses_only_the_last_chunk(whole: Path, killed: bytes, tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    path.write_bytes(killed)
    assert read(path) == read(whole)
    with McapRecording.open([path]) as recording:
        assert "is cut short" in " ".join(recording.notes)


@given(cut=st.floats(0.0, 1.0))
def test_a_file_cut_anywhere_gives_a_beginning_of_what_was_recorded(
    cut: float, whole: Path, killed: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "cut.mcap"
    path.write_bytes(killed[: int(cut * len(killed))])
    everything = read(whole)
    try:
        found = read(path)
    except McapRecordingError:
        found = []
    assert found == everything[: len(found)]


@given(place=st.floats(0.0, 1.0, exclude_max=True), value=st.integers(0, 255))
def test_a_damaged_byte_never_gives_a_traceback(
    place: float, value: int, whole: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    data = bytearray(whole.read_bytes())
    data[int(place * len(data))] = value
    path = tmp_path_factory.getbasetemp() / "damaged.mcap"
    path.write_bytes(data)
    try:
        found = read(path)
    except McapRecordingError:  # nothing of it can be read, and that is said
        return
    payloads = {each.sample.payload for each in read(whole)}
    assert {each.sample.payload for each in found} <= payloads


def test_a_file_is_split_by_time_and_each_part_says_which_robots_are_there(tmp_path: Path) -> None:
    files = drive(tmp_path / "long.mcap", split_ns=NS_PER_S)
    assert [each.name for each in files] == ["long.mcap", "long_1.mcap", "long_2.mcap", "long_3.mcap"]
    for each in files:
        found = {one.sample.key for one in read(each)}
        assert {"tokens", "happy/description", "happy/odom"} <= found
    parts = [each for each in read(*reversed(files)) if each.sample.key == "happy/odom"]
    assert len(parts) == STEPS
    assert [each.time_ns for each in parts] == sorted(each.time_ns for each in parts)


def test_a_file_is_split_by_size(tmp_path: Path) -> None:
    files = drive(tmp_path / "big.mcap", split_size=6_000)
    assert len(files) > 2
    assert len([each for each in read(*files) if each.sample.key == "happy/odom"]) == STEPS


@pytest.mark.parametrize("room", [0, 200, 2000, 4000, 8000, 9000, 9500, 12000])
def test_a_full_disk_ends_the_recording_and_others_still_read_it(
    room: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put = os.pwrite

    def limited(descriptor: int, data: Any, offset: int) -> int:
        if offset >= room:
            raise OSError(errno.ENOSPC, "No space left on device")
        return put(descriptor, bytes(data)[: room - offset], offset)

    monkeypatch.setattr("recorder.mcap_file.os.pwrite", limited)
    path = tmp_path / "full.mcap"
    writers: list[RecordingWriter] = []
    with pytest.raises(DiskFull, match="No space left"):
        _fill(path, writers)
    monkeypatch.undo()
    assert path.stat().st_size <= room
    if room >= 8000:  # smaller ones have no room for a chunk and an index
        with Reader(path) as reader:
            count = reader.message_count
        assert 0 < count == writers[0].messages == len(read(path)) < IN_ALL


def _fill(path: Path, writers: list[RecordingWriter]) -> None:
    """Record until the disk is full; `writers` gets what records."""
    writer = RecordingWriter(path, "test")
    writers.append(writer)
    try:
        for step in range(STEPS):
            now = START + step * NS_PER_S // 10
            writer.add(sample("happy/odom", odometry("happy", 0.03 * step, now)), now)
            writer.add(Sample("happy/noise", os.urandom(400), "application/cdr;std_msgs/msg/String"), now)
            writer.flush(now)
        writer.close()
    except OSError as err:
        writer.give_up(err)
        raise


def test_what_is_no_recording_is_refused_in_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "notes.mcap"
    path.write_text("these are my notes")
    with pytest.raises(McapRecordingError, match=r"is no MCAP file; acromovi record writes them"):
        McapRecording.open([path])
    with pytest.raises(McapRecordingError, match="cannot be opened: No such file"):
        McapRecording.open([tmp_path / "absent.mcap"])
    empty = tmp_path / "empty.mcap"
    RecordingWriter(empty, "test").close()
    with pytest.raises(McapRecordingError, match="holds no messages"):
        McapRecording.open([empty])


def test_of_a_newer_version_what_is_known_is_read(whole: Path, tmp_path: Path) -> None:
    newer = tmp_path / "newer.mcap"
    data = bytearray(whole.read_bytes())
    data[5] = data[-3] = ord("1")
    newer.write_bytes(data)
    with McapRecording.open([newer]) as recording:
        assert "has MCAP version '1', newer than 0" in recording.notes[0]
        assert len(list(recording.samples())) == IN_ALL


def test_a_newer_format_of_our_own_is_read_and_noted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("recorder.writer.FORMAT", 7)
    (path,) = drive(tmp_path / "newer.mcap")
    with McapRecording.open([path]) as recording:
        assert "newer version of acromovi (format '7', known is 1)" in " ".join(recording.notes)
        assert len(list(recording.samples())) == IN_ALL


def test_messages_of_unknown_types_are_noted_and_passed_on(tmp_path: Path) -> None:
    path = tmp_path / "strange.mcap"
    writer = RecordingWriter(path, "test")
    writer.add(Sample("happy/strange", b"\x00\x01\x00\x00????", "application/cdr;strange_msgs/msg/Thing"), START)
    writer.add(Sample("happy/proto", b"????", "application/protobuf"), START)
    writer.add(sample("happy/odom", odometry("happy", 0.0, START)), START)
    writer.close()
    with McapRecording.open([path]) as recording:
        assert recording.notes == [
            f"{path} has messages of unknown types on /happy/proto, /happy/strange; they are not decoded"
        ]
        assert [each.sample.key for each in recording.samples()] == ["happy/strange", "happy/odom"]


def test_a_copy_that_is_still_written_is_read_up_to_now(tmp_path: Path) -> None:
    path = tmp_path / "live.mcap"
    writer = RecordingWriter(path, "test")
    for step in range(20):
        now = START + step * NS_PER_S // 10
        writer.add(sample("happy/odom", odometry("happy", 0.03 * step, now)), now)
        writer.flush(now)
    copy = shutil.copy(path, tmp_path / "copy.mcap")
    writer.close()
    assert 15 <= len(read(Path(copy))) <= 20


def test_hostile_names_and_definitions_are_quoted_and_never_run(tmp_path: Path) -> None:
    path = tmp_path / "hostile.mcap"
    file = McapFile(path, "test\x1b[2J", {"format": "\x1b[31m9"})
    evil = file.add_schema(
        "x/msg/Y:\n    import os\n#", "__import__('os').system('touch " + str(tmp_path / "touched") + "')"
    )
    plain = file.add_schema("evil_msgs/msg/Thing", "string __class__=\"\"\"); open('touched', 'w') #\nfloat32 x")
    for number, schema in enumerate((evil, plain)):
        file.add_message(file.add_channel(f"/\x1b[2Jevil{number}", "cdr", schema), START, START, b"\0\1\0\0" * 4)
    file.finish()
    with McapRecording.open([path]) as recording:
        assert not any("\x1b" in note for note in recording.notes)
        assert "unknown types on /?[2Jevil0" in " ".join(recording.notes)
        assert len(list(recording.samples())) == 2
    assert not (tmp_path / "touched").exists()


@given(text=st.text(max_size=200), name=st.text(max_size=40))
def test_no_definition_in_a_file_raises_anything(
    text: str, name: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "definition.mcap"
    path.unlink(missing_ok=True)  # of the definition before, if any
    file = McapFile(path, "test", {})
    file.add_message(file.add_channel("/a/b", "cdr", file.add_schema(name, text)), START, START, b"\0\1\0\0")
    file.finish()
    with McapRecording.open([path]) as recording:
        assert len(list(recording.samples())) == bool(name)


@pytest.mark.parametrize(
    "text",
    [
        "uint8 x\nstrange_msgs/Other y\n",
        "strange_msgs/Other[] y\n",
        "strange_msgs/Other[3] y\n" + "=" * 80 + "\nMSG: strange_msgs/Other\nstrange_msgs/Third[] z\n",
        "strange_msgs/Thing[] again\n",
    ],
)
def test_a_definition_that_lacks_the_types_in_it_is_noted_and_the_rest_is_read(text: str, tmp_path: Path) -> None:
    path = tmp_path / "part.mcap"
    file = McapFile(path, "test", {"format": "1"})
    schema = file.add_schema("strange_msgs/msg/Thing", text)
    file.add_message(file.add_channel("/happy/strange", "cdr", schema), START, START, b"\0\1\0\0")
    file.add_message(file.add_channel("/happy/told", "json", 0), START, START, b"{}")
    file.finish()
    with McapRecording.open([path]) as recording:
        assert recording.notes == [f"{path} has messages of unknown types on /happy/strange; they are not decoded"]
        assert len(list(recording.samples())) == 2


def test_messages_of_a_type_that_only_the_file_defines_are_decoded(tmp_path: Path) -> None:
    path = tmp_path / "own.mcap"
    file = McapFile(path, "test", {"format": "1"})
    schema = file.add_schema("lab_msgs/msg/Weight", "float32 kilograms\nuint8 count\n")
    file.add_message(file.add_channel("/a/weight", "cdr", schema), START, START, b"\0\1\0\0" + b"\0\0\x20\x40\x07")
    file.finish()
    with McapRecording.open([path]) as recording:
        assert recording.notes == []
        (recorded,) = recording.samples()
        weight = recorded.sample.decoded()
    assert (weight.kilograms, weight.count) == (2.5, 7)
