"""A recording is played as it was, and never tells a robot what to do."""

from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bus import keys
from bus.bus import JSON, Sample
from bus.errors import KeyNotValid, NoAnswer
from bus.memory import MemoryBus
from bus.messages import NS_PER_S, Odometry
from recorder.channels import is_stream
from recorder.playback import Playback, PlaybackPublisher, platforms, presence_at
from recorder.recording import McapRecording, Recorded
from tests.recorder.recordings import START, drive

COMMANDS = [topic for topic in keys.TOPICS if topic.kind is not keys.Kind.STREAM]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Iterator[McapRecording]:
    files = drive(tmp_path_factory.mktemp("playback") / "drive.mcap")
    with McapRecording.open(files) as opened:
        yield opened


def odometry_in(found: list[Recorded]) -> list[float]:
    return [(each.time_ns - START) / NS_PER_S for each in found if each.sample.key == "happy/odom"]


def test_samples_are_due_when_their_time_has_come(recording: McapRecording) -> None:
    playback = Playback(recording)
    assert playback.due(0.0) == []  # it is paused
    playback.resume(10.0)
    assert odometry_in(playback.due(10.35)) == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert playback.next_at() == pytest.approx(10.4)
    assert odometry_in(playback.due(10.55)) == pytest.approx([0.4, 0.5])
    playback.due(100.0)
    assert playback.ended


def test_speed_pause_and_seek(recording: McapRecording) -> None:
    playback = Playback(recording, speed=2.0)
    playback.resume(0.0)
    assert len(odometry_in(playback.due(0.5))) == 11
    playback.pause(0.5)
    assert playback.due(9.0) == []
    playback.resume(20.0)
    playback.set_speed(1.0, 20.0)
    assert odometry_in(playback.due(20.1)) == pytest.approx([1.1])
    playback.seek(3.0, 21.0)
    assert odometry_in(playback.due(21.05)) == pytest.approx([3.0])
    playback.seek(-5.0, 22.0)
    assert odometry_in(playback.due(22.0)) == pytest.approx([0.0])
    playback.seek(99.0, 23.0)
    assert playback.elapsed == pytest.approx(3.9)


def test_a_loop_begins_again(recording: McapRecording) -> None:
    playback = Playback(recording, loop=True)
    playback.resume(0.0)
    assert len(odometry_in(playback.due(5.0))) == 40
    assert not playback.ended
    assert odometry_in(playback.due(5.05)) == pytest.approx([0.0])


@given(times=st.lists(st.floats(0.0, 10.0), max_size=20), speed=st.floats(0.1, 10.0))
def test_whenever_it_is_looked_at_everything_is_due_once_and_in_order(
    times: list[float], speed: float, recording: McapRecording
) -> None:
    playback = Playback(recording, speed)
    playback.resume(0.0)
    found = [each for now in sorted(times) for each in playback.due(now)] + playback.due(1000.0)
    assert found == list(recording.samples())


@pytest.mark.parametrize("speed", [0.0, -1.0, 1000.0, float("nan")])
def test_impossible_speeds_are_refused(speed: float, recording: McapRecording) -> None:
    with pytest.raises(ValueError, match="choose one from"):
        Playback(recording, speed)


def played(
    recording: McapRecording, renamed: dict[str, str], **options: bool
) -> tuple[list[Sample], PlaybackPublisher]:
    heard: list[Sample] = []
    with MemoryBus() as bus:
        bus.subscribe("**", heard.append)
        publisher = PlaybackPublisher(bus, renamed)
        for recorded in recording.samples():
            publisher.publish(recorded)
    return heard, publisher


def test_streams_are_published_unchanged_and_commands_never(recording: McapRecording) -> None:
    heard, publisher = played(recording, {})
    assert {each.key for each in heard} == {"happy/odom", "happy/agents/base/results"}
    assert [each for each in heard if each.key == "happy/odom"] == [
        each.sample for each in recording.samples(is_wanted=lambda key: key == "happy/odom")
    ]
    assert publisher.left_out == {"happy/cmd_vel"}
    assert publisher.published == len(heard) == 80


@pytest.mark.parametrize("topic", COMMANDS, ids=lambda topic: topic.suffix)
def test_no_key_on_which_robots_obey_is_a_stream(topic: keys.Topic) -> None:
    assert not is_stream(topic.key("happy", "laser"))


@pytest.mark.parametrize(
    "key",
    [
        "happy/agents/base/acl",
        "happy/containers/happy/control",
        "happy/agents/base/heartbeat",
        "team/host/control",
        "happy/navigation/goto/send/goal",
        "happy/navigation/goto/query/state",
        "happy/command/anything/new",
        "happy/lease/new",
        "cmd_vel",
    ],
)
def test_nor_is_one_on_which_agents_and_programs_obey(key: str) -> None:
    assert not is_stream(key)


@pytest.mark.parametrize(
    "key", ["happy/odom", "happy/camera/image/compressed", "happy/containers/happy/said", "happy/lease/state", "a/b"]
)
def test_readings_results_and_messages_that_were_heard_are_streams(key: str) -> None:
    assert is_stream(key)


def test_a_renamed_robot_has_its_new_name_in_keys_and_frames(recording: McapRecording) -> None:
    heard, _ = played(recording, {"happy": "ghost"})
    first = next(each for each in heard if each.key == "ghost/odom")
    message: Odometry = first.decoded()
    assert (message.header.frame_id, message.child_frame_id) == ("ghost/odom", "ghost/base_link")
    assert not any(each.key.startswith("happy") for each in heard)
    assert platforms(recording, {"happy": "ghost"}) == ["ghost"]


def test_a_new_name_must_be_a_name(recording: McapRecording) -> None:
    with MemoryBus() as bus, pytest.raises(KeyNotValid):
        PlaybackPublisher(bus, {"happy": "a/b"})


def test_in_one_process_a_recording_looks_like_a_live_team(recording: McapRecording) -> None:
    alive: dict[str, bool] = {}
    bus = MemoryBus()
    bus.watch_alive("**", lambda key, is_alive: alive.update({key: is_alive}))
    with PlaybackPublisher(bus, with_presence=True) as publisher:
        for recorded in presence_at(recording, START + NS_PER_S):
            publisher.publish(recorded)
        assert alive == {"happy/alive": True}
        assert bus.query("happy/description")[0].value == {"model": "p3dx-sh", "emulated": True}
        publisher.stand_still()
        assert alive == {"happy/alive": False}
        with pytest.raises(NoAnswer):
            bus.query("happy/description")


@pytest.mark.parametrize(
    "payload", [b"{}", b"[1]", b'{"key": 3, "alive": true}', b'{"key": "*", "alive": true}', b"\xff"]
)
def test_malformed_tokens_show_nothing(payload: bytes) -> None:
    seen: list[Any] = []
    bus = MemoryBus()
    bus.watch_alive("**", lambda key, is_alive: seen.append(key))
    publisher = PlaybackPublisher(bus, with_presence=True)
    publisher.publish(Recorded(START, START, Sample("tokens", payload, JSON)))
    assert seen == []
