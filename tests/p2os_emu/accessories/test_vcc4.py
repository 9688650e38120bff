"""The emulated Canon VC-C4: dialogues as clients hold them, from the fact sheet of accessories, section 3."""

from math import degrees, radians

import pytest

from configs import load
from p2os.accessories import vcc4
from p2os.accessories.head_model import HeadModel
from p2os.accessories.vcc4 import Code
from p2os_emu.accessories.vcc4 import Vcc4

STEP = 1 / 120
OK, BUSY, BAD, UNHEARD = (bytes.fromhex(f"FE 30 30 {status} 30 EF") for status in ("30", "31", "35", "39"))


@pytest.fixture
def head() -> Vcc4:
    return Vcc4(load(HeadModel, "accessories", "vcc4"))


def ask(head: Vcc4, request: bytes, seconds: float = STEP) -> bytes:
    """Send, and collect what comes within some s."""
    head.receive(request)
    return wait(head, seconds)


def wait(head: Vcc4, seconds: float) -> bytes:
    return b"".join(head.step(STEP) for _ in range(max(1, round(seconds / STEP))))


def start(head: Vcc4) -> None:
    assert ask(head, vcc4.encode_command(Code.POWER, vcc4.ON), 1.1) == OK
    assert ask(head, vcc4.encode_command(Code.CONTROL_MODE, vcc4.HOST_CONTROL)) == OK
    assert ask(head, vcc4.encode_command(Code.INITIALISE, vcc4.START)) == OK
    wait(head, 2.1)


def test_start_up_of_aria_is_answered_step_by_step(head: Vcc4) -> None:
    for request in (
        vcc4.encode_command(Code.POWER, vcc4.ON),
        vcc4.encode_command(Code.CONTROL_MODE, vcc4.HOST_CONTROL),
        vcc4.encode_command(Code.INITIALISE, vcc4.START),
        vcc4.encode_command(Code.PAN_SLEW, (800,)),
        vcc4.encode_command(Code.TILT_SLEW, (662,)),
    ):
        assert ask(head, request) == OK
    assert ask(head, vcc4.encode_command(Code.TILT_RANGE, (-267, 790))) == OK
    assert ask(head, vcc4.encode_command(Code.DIRECTION)) == bytes.fromhex("FE 30 30 30 30 38 30 30 30 38 30 30 30 EF")
    assert ask(head, vcc4.encode_command(Code.ZOOM_REQUEST, vcc4.START)) == bytes.fromhex(
        "FE 30 30 30 30 30 30 30 30 EF"
    )


def test_second_initialise_is_taken_with_the_first_one(head: Vcc4) -> None:
    """ARIA sends two, half a second apart, and then never gets over one that is busy for 2 s."""
    for request in (
        vcc4.encode_command(Code.POWER, vcc4.ON),
        vcc4.encode_command(Code.CONTROL_MODE, vcc4.HOST_CONTROL),
        vcc4.encode_command(Code.INITIALISE, vcc4.START),
    ):
        assert ask(head, request) == OK
    wait(head, 0.5)
    assert ask(head, vcc4.encode_command(Code.INITIALISE, vcc4.START)) == OK
    wait(head, 2.6)
    assert not head.is_initialising


def test_start_up_of_ros_p2os_works_although_it_never_waits_for_an_answer(head: Vcc4) -> None:
    ranges = [vcc4.encode_command(Code.TILT_RANGE, (-267, 790))] * 3
    for request in (
        vcc4.encode_command(Code.POWER, vcc4.ON),
        vcc4.encode_command(Code.CONTROL_MODE, vcc4.HOST_CONTROL),
        vcc4.encode_command(Code.INITIALISE, vcc4.START),
        *ranges,
        vcc4.encode_command(Code.MOVE, (0, 0)),
        vcc4.encode_command(Code.ZOOM, (0,)),
    ):
        ask(head, request, 0.3)
    wait(head, 3.0)
    assert ask(head, vcc4.encode_command(Code.MOVE, (100, 50))) == OK
    wait(head, 2.0)
    assert degrees(head.head.pan.position) == pytest.approx(-11.25)  # the wire counts to the right
    assert degrees(head.head.tilt.position) == pytest.approx(5.625)


def test_start_up_of_player_asks_for_the_narrow_end_of_the_zoom(head: Vcc4) -> None:
    start(head)
    assert ask(head, vcc4.encode_command(Code.ZOOM_REQUEST, b"3")) == bytes.fromhex("FE 30 30 30 30 30 37 41 38 EF")
    assert ask(head, vcc4.encode_command(Code.ZOOM_POSITION)) == bytes.fromhex("FE 30 30 30 30 30 30 30 30 EF")


def test_nothing_but_power_is_obeyed_without_power_and_without_host_control(head: Vcc4) -> None:
    assert ask(head, vcc4.encode_command(Code.CONTROL_MODE, vcc4.HOST_CONTROL)) == UNHEARD
    assert ask(head, vcc4.encode_command(Code.POWER, vcc4.ON), 1.1) == OK
    for request in (
        vcc4.encode_command(Code.INITIALISE, vcc4.START),
        vcc4.encode_command(Code.DIRECTION),
        vcc4.encode_command(Code.ZOOM, (5,)),
    ):
        assert ask(head, request) == UNHEARD
    assert ask(head, vcc4.encode_command(Code.CONTROL_MODE, vcc4.HOST_CONTROL)) == OK
    assert ask(head, vcc4.encode_command(Code.DIRECTION)) != UNHEARD
    assert ask(head, vcc4.encode_command(Code.POWER, vcc4.OFF)) == OK
    assert ask(head, vcc4.encode_command(Code.DIRECTION)) == UNHEARD


def test_head_that_looks_for_its_zero_is_busy(head: Vcc4) -> None:
    ask(head, vcc4.encode_command(Code.POWER, vcc4.ON), 1.1)
    ask(head, vcc4.encode_command(Code.CONTROL_MODE, vcc4.HOST_CONTROL))
    assert ask(head, vcc4.encode_command(Code.INITIALISE, vcc4.START)) == OK
    assert ask(head, vcc4.encode_command(Code.MOVE, (100, 0))) == BUSY
    assert ask(head, vcc4.encode_command(Code.STOP, vcc4.START)) == BUSY
    wait(head, 2.1)
    assert ask(head, vcc4.encode_command(Code.MOVE, (100, 0))) == OK


@pytest.mark.parametrize(
    "request_",
    [
        vcc4.encode_command(Code.MOVE, (872, 0)),  # 98.1 degrees
        vcc4.encode_command(Code.MOVE, (-872, 0)),
        vcc4.encode_command(Code.MOVE, (0, 791)),
        vcc4.encode_command(Code.MOVE, (0, -268)),
        vcc4.encode_command(Code.PAN_SLEW, (801,)),
        vcc4.encode_command(Code.PAN_SLEW, (7,)),
        vcc4.encode_command(Code.TILT_SLEW, (663,)),
        vcc4.encode_command(Code.ZOOM, (1961,)),
        vcc4.encode_command(Code.TILT_RANGE, (-300, 0)),
        vcc4.encode_command(Code.MOVE, b"80008"),
        vcc4.encode_command(Code.POWER, b"5"),
        vcc4.encode_command(Code.DIGITAL_ZOOM, b"09"),
        vcc4.encode_command(0x33),
    ],
)
def test_what_is_out_of_range_or_unknown_is_a_bad_parameter_and_moves_nothing(head: Vcc4, request_: bytes) -> None:
    start(head)
    assert ask(head, request_) == BAD
    assert not head.head.is_turning


def test_pan_takes_the_time_that_its_slew_gives_and_stops_when_told(head: Vcc4) -> None:
    start(head)
    ask(head, vcc4.encode_command(Code.PAN_SLEW, (400,)))  # 45 degrees/s
    ask(head, vcc4.encode_command(Code.MOVE, (-800, 0)), 1.0)
    assert degrees(head.head.pan.position) == pytest.approx(45.0, abs=0.5)
    assert ask(head, vcc4.encode_command(Code.STOP, vcc4.START)) == OK
    place = head.head.pan.position
    wait(head, 0.5)
    assert head.head.pan.position == place


def test_tilt_range_limits_what_a_move_may_ask_for(head: Vcc4) -> None:
    start(head)
    assert ask(head, vcc4.encode_command(Code.TILT_RANGE, (0, 100))) == OK
    assert ask(head, vcc4.encode_command(Code.MOVE, (0, 101))) == BAD
    assert ask(head, vcc4.encode_command(Code.MOVE, (0, 100))) == OK


def test_zoom_narrows_the_view_over_its_time(head: Vcc4) -> None:
    start(head)
    wide = head.head.field_of_view
    assert wide == pytest.approx(radians(47.5))
    ask(head, vcc4.encode_command(Code.ZOOM, (1960,)), 1.5)
    assert head.head.zoom == pytest.approx(4.0, rel=0.02)  # half the way of a lens whose counts magnify alike
    wait(head, 1.6)
    assert head.head.zoom == pytest.approx(16.0)
    assert head.head.field_of_view < wide / 15


def test_settings_without_a_picture_are_taken(head: Vcc4) -> None:
    start(head)
    for code, given in ((0x8E, b"1"), (0x76, b"6"), (0xB5, b"1"), (0xA1, b"0"), (0xB7, b"02")):
        assert ask(head, vcc4.encode_command(code, given)) == OK
    assert b"VC-C4" in ask(head, vcc4.encode_command(Code.PRODUCT))


def test_head_stands_until_it_is_switched_on_although_it_answers_at_once(head: Vcc4) -> None:
    for request in (
        vcc4.encode_command(Code.POWER, vcc4.ON),
        vcc4.encode_command(Code.CONTROL_MODE, vcc4.HOST_CONTROL),
        vcc4.encode_command(Code.MOVE, (100, 50)),
    ):
        assert ask(head, request) == OK
    wait(head, 0.9)
    assert head.head.pan.position == 0.0
    wait(head, 2.0)
    assert degrees(head.head.pan.position) == pytest.approx(-11.25)
