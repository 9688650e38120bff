import io
import json
import threading
from collections.abc import Callable

import pytest

from acromovi.echo import echo, record, text
from bus import Bus, MemoryBus, MemoryNetwork, Sample
from bus.messages import Bumpers, encode, header, twist

STAMP = 1_700_000_000_123_456_789


@pytest.fixture
def network() -> MemoryNetwork:
    return MemoryNetwork()


@pytest.fixture
def bus(network: MemoryNetwork) -> Bus:
    return MemoryBus(network)


@pytest.fixture
def happy(network: MemoryNetwork) -> Bus:
    """A robot's side of the bus."""
    bus = MemoryBus(network)
    bus.declare_alive("happy/alive")
    return bus


def bumpers() -> Bumpers:
    return Bumpers(header(STAMP, "happy/base_link"), [True, False], stall_left=True)


def cdr(message: object, key: str = "happy/x", encoding: str = "") -> Sample:
    return Sample(key, encode(message), encoding)


def put_when_heard(network: MemoryNetwork, put: Callable[[], None], until: Callable[..., None]) -> threading.Thread:
    """Put from another thread as soon as someone subscribes."""

    def wait_and_put() -> None:
        until(lambda: network.subscribers)
        put()

    thread = threading.Thread(target=wait_and_put)
    thread.start()
    return thread


def test_json_lines_hold_key_type_stamp_and_message(
    network: MemoryNetwork, bus: Bus, happy: Bus, until: Callable[..., None]
) -> None:
    output = io.StringIO()

    def put() -> None:
        happy.put("happy/bumpers", bumpers())
        happy.put("happy/cmd_vel", twist(0.2, 0.0))

    putting = put_when_heard(network, put, until)
    assert echo(bus, "happy/*", as_json=True, count=2, timeout=10.0, output=output) == 0
    putting.join()
    first, second = (json.loads(line) for line in output.getvalue().splitlines())
    assert first == {
        "key": "happy/bumpers",
        "type": "acromovi_msgs/msg/Bumpers",
        "stamp_ns": STAMP,
        "message": {
            "header": {"stamp": {"sec": 1_700_000_000, "nanosec": 123_456_789}, "frame_id": "happy/base_link"},
            "front": [True, False],
            "rear": [],
            "stall_left": True,
            "stall_right": False,
        },
    }
    assert (second["type"], second["stamp_ns"]) == ("geometry_msgs/msg/Twist", None)


def test_the_table_says_the_type_where_the_encoding_does_not() -> None:
    assert record(cdr(twist(0.5, 0.0), "happy/cmd_vel"))["message"]["linear"]["x"] == 0.5


def test_the_encoding_wins_over_the_table() -> None:
    shown = record(cdr(twist(0.5, 0.0), "happy/odom", "application/cdr;geometry_msgs/msg/Twist"))
    assert shown["type"] == "geometry_msgs/msg/Twist"
    assert shown["message"]["linear"]["x"] == 0.5


def test_what_cannot_be_decoded_is_shown_by_its_size_and_reason() -> None:
    shown = record(Sample("happy/odom", b"\0\1\0\0abc", "application/cdr;nav_msgs/msg/Odometry"))
    assert (shown["message"], shown["bytes"]) == (None, 7)
    assert "7 bytes are not a nav_msgs/msg/Odometry" in shown["error"]
    assert "4 bytes" in text(Sample("mine", b"abcd", "zenoh/bytes"))


def test_payloads_are_shown_as_they_are() -> None:
    shown = record(Sample("happy/lease/state", b'{"holder": null}', "application/json"))
    assert shown["message"] == {"holder": None}


def test_people_get_a_head_line_and_a_line_for_each_field() -> None:
    shown = text(cdr(bumpers(), "happy/bumpers")).splitlines()
    assert shown[0].startswith("--- happy/bumpers  acromovi_msgs/msg/Bumpers  ")
    assert "  frame_id: happy/base_link" in shown
    assert "front: [True, False]" in shown


@pytest.mark.parametrize(
    ("key", "hint"),
    [
        ("hapy/odom", "did you mean 'happy'?"),
        ("zzz/odom", "the robots seen are happy"),
        ("happy/odm", "did you mean happy/odom?"),
        ("happy/description", "programs ask there"),
        ("happy/cmd_vel", "programs command the robot there"),
        ("happy/odom", "see what flows with acromovi topics"),
        ("*/odom", "see what flows with acromovi topics"),
    ],
)
def test_silence_is_explained(bus: Bus, happy: Bus, key: str, hint: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert echo(bus, key, timeout=0.01) == 1
    assert hint in capsys.readouterr().err


def test_without_any_robot_the_hint_says_how_to_start_one(bus: Bus, capsys: pytest.CaptureFixture[str]) -> None:
    assert echo(bus, "happy/odom", timeout=0.01) == 1
    assert "p2os-gateway" in capsys.readouterr().err
