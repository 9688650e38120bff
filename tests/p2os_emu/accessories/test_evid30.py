"""The emulated Sony EVI-D30: dialogues as clients hold them, from the fact sheet of accessories, section 3."""

from math import degrees

import pytest

from configs import load
from p2os.accessories import visca
from p2os.accessories.head_model import HeadModel
from p2os_emu.accessories.evid30 import EviD30

STEP = 1 / 120
ACK_1, ACK_2 = bytes.fromhex("90 41 FF"), bytes.fromhex("90 42 FF")
DONE_1, DONE_2 = bytes.fromhex("90 51 FF"), bytes.fromhex("90 52 FF")


@pytest.fixture
def head() -> EviD30:
    return EviD30(load(HeadModel, "accessories", "evid30"))


def ask(head: EviD30, request: bytes, seconds: float = STEP) -> bytes:
    head.receive(request)
    return wait(head, seconds)


def wait(head: EviD30, seconds: float) -> bytes:
    return b"".join(head.step(STEP) for _ in range(max(1, round(seconds / STEP))))


def refusal(code: int, socket: int = 0) -> bytes:
    return bytes([0x90, 0x60 | socket, code, 0xFF])


def test_cameras_are_cleared_and_numbered_by_broadcast(head: EviD30) -> None:
    assert ask(head, visca.encode(visca.CLEAR, header=visca.BROADCAST)) == bytes.fromhex("88 01 00 01 FF")
    assert ask(head, visca.encode(visca.SET_ADDRESS, header=visca.BROADCAST)) == bytes.fromhex("88 30 02 FF")


def test_move_is_acknowledged_at_once_and_completed_on_arrival(head: EviD30) -> None:
    assert ask(head, visca.encode(visca.MOVE, 0x18, 0x14, -440, 150)) == ACK_1
    assert wait(head, 0.55) == b""
    assert degrees(head.head.pan.position) == pytest.approx(45.0, abs=1.5)  # 80 degrees/s for 0.56 s, to the left
    assert wait(head, 0.2) == DONE_1
    assert degrees(head.head.pan.position) == pytest.approx(50.0)
    assert degrees(head.head.tilt.position) == pytest.approx(12.5)


def test_inquiries_are_answered_also_while_it_moves(head: EviD30) -> None:
    ask(head, visca.encode(visca.MOVE, 0x18, 0x14, 0x370, -0x12C), 2.0)
    assert ask(head, visca.encode(visca.ASK_DIRECTION)) == bytes.fromhex("90 50 00 03 07 00 0F 0E 0D 04 FF")
    ask(head, visca.encode(visca.ZOOM_TO, 0x3FF))
    assert ask(head, visca.encode(visca.ASK_ZOOM))[:2] == bytes.fromhex("90 50")
    assert ask(head, visca.encode(visca.ASK_POWER)) == bytes.fromhex("90 50 02 FF")
    assert ask(head, visca.encode(visca.ASK_VERSION))[:6] == bytes.fromhex("90 50 00 20 04 02")


def test_pan_and_zoom_take_two_sockets_and_a_third_command_finds_none(head: EviD30) -> None:
    assert ask(head, visca.encode(visca.MOVE, 1, 1, 880, 0)) == ACK_1
    assert ask(head, visca.encode(visca.ZOOM_TO, 0x3FF)) == ACK_2
    assert ask(head, visca.encode(visca.BACKLIGHT + b"\x02")) == refusal(0x03)
    assert not head.has_backlight


def test_new_target_takes_the_place_of_the_one_before(head: EviD30) -> None:
    ask(head, visca.encode(visca.MOVE, 1, 1, 880, 0))
    assert ask(head, visca.encode(visca.MOVE, 0x18, 0x14, 0, 0), 0.2) == DONE_1 + ACK_2 + DONE_2


def test_cancel_stops_what_its_socket_does(head: EviD30) -> None:
    ask(head, visca.encode(visca.MOVE, 1, 1, 880, 0), 0.2)
    assert ask(head, visca.encode(bytes([visca.CANCEL | 1]))) == refusal(0x04, 1)
    assert not head.head.is_turning
    assert ask(head, visca.encode(bytes([visca.CANCEL | 1]))) == refusal(0x05, 1)


def test_drive_goes_on_until_it_is_stopped(head: EviD30) -> None:
    left_and_up = visca.encode(visca.DRIVE + bytes([0x18, 0x14, visca.LEFT, visca.UP]))
    assert ask(head, left_and_up, 0.25) == ACK_1
    assert head.head.pan.position > 0 < head.head.tilt.position
    assert ask(head, visca.encode(visca.DRIVE, 0x18, 0x14, visca.STAY, visca.STAY)) == DONE_1 + ACK_2 + DONE_2
    assert not head.head.is_turning


@pytest.mark.parametrize(
    "request_",
    [
        visca.encode(visca.MOVE, 1, 1, 881, 0),
        visca.encode(visca.MOVE, 1, 1, 0, 301),
        visca.encode(visca.MOVE, 0x19, 1, 0, 0),
        visca.encode(visca.MOVE, 1, 0, 0, 0),
        visca.encode(visca.ZOOM_TO, 0x400),
        visca.encode(visca.MOVE),
        visca.encode(visca.DRIVE + b"\x01\x01\x05\x03"),
        visca.encode(visca.POWER + b"\x07"),
        visca.encode(b"\x01\x09\x09"),
    ],
)
def test_what_makes_no_sense_is_a_syntax_error_and_moves_nothing(head: EviD30, request_: bytes) -> None:
    assert ask(head, request_, 0.1) == refusal(0x02)
    assert head.head.pan.position == head.head.tilt.position == 0.0


def test_without_power_only_the_power_command_is_obeyed(head: EviD30) -> None:
    assert ask(head, visca.encode(visca.POWER, visca.OFF)) == ACK_1 + DONE_1
    assert ask(head, visca.encode(visca.MOVE, 1, 1, 0, 0)) == refusal(0x41)
    assert ask(head, visca.encode(visca.ASK_DIRECTION)) == refusal(0x41)
    assert ask(head, visca.encode(visca.ASK_POWER)) == bytes.fromhex("90 50 03 FF")
    assert ask(head, visca.encode(visca.POWER, visca.ON)) == ACK_1
    assert wait(head, 2.1) == DONE_1


def test_other_cameras_commands_pass_by(head: EviD30) -> None:
    assert ask(head, visca.encode(visca.ASK_POWER, header=0x82), 0.1) == b""
