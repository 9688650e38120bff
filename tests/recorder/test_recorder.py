"""The recorder hears samples, tokens and descriptions of the keys that are wanted, each once."""

import errno
from pathlib import Path
from types import SimpleNamespace

import pytest

from bus.bus import JSON
from bus.errors import KeyNotValid
from bus.memory import MemoryBus
from bus.messages import NS_PER_S, twist
from recorder.recorder import Recorder, expression_of
from recorder.writer import RecordingWriter
from tests.recorder.recordings import START, read
from tests.waiting import wait_until


def recorded(path: Path, expressions: list[str]) -> list[str]:
    """Keys in a recording of a small team."""
    robots, bus = MemoryBus(), None
    bus = MemoryBus(robots.network)
    robots.serve("happy/description", lambda given: {"model": "p3dx-sh"})
    robots.serve("happy/lease/state", lambda given: {"leases": []})
    robots.declare_alive("happy/alive")
    with Recorder(bus, expressions, RecordingWriter(path, "test")) as recorder:
        robots.publisher("happy/agents/base/results", JSON).put({"x": 1})
        robots.put("happy/cmd_vel", twist(0.2, 0.0))
        robots.put("doc/cmd_vel", twist(0.2, 0.0))
        robots.declare_alive("doc/alive")
    assert recorder.error is None
    return sorted(each.sample.key for each in read(path))


def test_everything_is_recorded_with_tokens_and_descriptions(tmp_path: Path) -> None:
    found = recorded(tmp_path / "all.mcap", ["**"])
    assert [*filter(lambda key: key != "tokens", found)] == [
        "doc/cmd_vel",
        "happy/agents/base/results",
        "happy/cmd_vel",
        "happy/description",
        "happy/lease/state",
    ]
    assert found.count("tokens") == 2


def test_a_key_that_two_expressions_match_is_recorded_once(tmp_path: Path) -> None:
    found = recorded(tmp_path / "twice.mcap", ["*/cmd_vel", "happy/**", "happy/cmd_vel"])
    assert found.count("happy/cmd_vel") == found.count("doc/cmd_vel") == 1


def test_of_one_robot_nothing_of_others_is_recorded(tmp_path: Path) -> None:
    assert not [key for key in recorded(tmp_path / "one.mcap", [expression_of("happy")]) if key.startswith("doc")]


def test_a_robots_name_stands_for_all_of_its_keys() -> None:
    assert [expression_of(each) for each in ("happy", "*", "**", "*/odom", "happy/scan")] == [
        "happy/**",
        "*/**",
        "**",
        "*/odom",
        "happy/scan",
    ]
    with pytest.raises(KeyNotValid):
        expression_of("hap py")


def test_a_malformed_key_is_refused_and_the_file_is_closed(tmp_path: Path) -> None:
    with pytest.raises(KeyNotValid):
        Recorder(MemoryBus(), ["happy//odom"], RecordingWriter(tmp_path / "bad.mcap", "test"))


def test_a_full_disk_ends_the_recorder_and_no_one_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bus = MemoryBus()
    writer = RecordingWriter(tmp_path / "full.mcap", "test")
    with Recorder(bus, ["**"], writer) as recorder:

        def full(descriptor: int, data: bytes, offset: int) -> int:
            raise OSError(errno.ENOSPC, "No space left on device")

        monkeypatch.setattr("recorder.mcap_file.os.pwrite", full)
        bus.put("happy/cmd_vel", twist(0.2, 0.0))
        wait_until(recorder.ended.is_set, "the recorder has ended")
        bus.put("happy/cmd_vel", twist(0.2, 0.0))
    assert recorder.error is not None
    assert recorder.error.errno == errno.ENOSPC


def test_what_a_slow_disk_cannot_take_is_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("recorder.recorder.MOST_WAITING", 2000)
    monkeypatch.setattr("recorder.recorder.TURN", 3600.0)
    bus = MemoryBus()
    with Recorder(bus, ["**"], RecordingWriter(tmp_path / "slow.mcap", "test")) as recorder:
        for _ in range(10):
            bus.put("happy/cmd_vel", twist(0.2, 0.0))
    assert recorder.lost == 7
    assert len(read(tmp_path / "slow.mcap")) == 3


def test_a_clock_that_is_set_back_neither_delays_the_file_nor_disorders_the_times(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = {"wall": START, "steady": 0}
    played = SimpleNamespace(time_ns=lambda: clock["wall"], monotonic_ns=lambda: clock["steady"])
    monkeypatch.setattr("recorder.recorder.time", played)
    bus, path = MemoryBus(), tmp_path / "set.mcap"
    writer = RecordingWriter(path, "test")
    with Recorder(bus, ["**"], writer):
        bus.put("happy/cmd_vel", twist(0.2, 0.0))
        wait_until(lambda: writer.messages == 1, "the first message is in the chunk that waits")
        before = path.stat().st_size
        clock["wall"] -= 3600 * NS_PER_S
        clock["steady"] += NS_PER_S
        wait_until(lambda: path.stat().st_size > before, "the first message is in the file")
        bus.put("happy/cmd_vel", twist(0.3, 0.0))
    assert [each.time_ns for each in read(path)] == [START, START + NS_PER_S]
