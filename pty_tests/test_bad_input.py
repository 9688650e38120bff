"""Bytes and commands a robot must survive: noise, lies, damage and clients that hurry.

Nothing here holds a sound frame that could move a robot, so it may be sent to a real robot.
"""

import random

import pytest

from pty_tests.client import (
    CONFIG,
    ENABLE,
    ENCODER,
    IOREQUEST,
    PULSE,
    SONAR,
    SYNC,
    Client,
    Silence,
    checksum,
    command,
    frame,
)
from pty_tests.packets import CONFIGPAC, ENCODERPAC, IOPAC, Sip

pytestmark = pytest.mark.emulate("powerbot")  # no model differs in what it survives

PARTIAL_FRAME_S = 0.1  # a receiver drops what it has after this long without a byte
TRIES = 3
UNKNOWN = (16, 94, 99, 200)  # in nobody's command table


def assert_obeys(robot: Client) -> None:
    """The stream runs and a command has its effect, both ways."""
    for wanted in (1, 0):
        robot.send(ENABLE, wanted)
        robot.motors_become(bool(wanted))


def pause(robot: Client) -> None:
    """Leave the line alone for more than the partial-frame time."""
    list(robot.hear(2.5 * PARTIAL_FRAME_S, pulse=False))


def test_unknown_commands_are_ignored(robot: Client) -> None:
    robot.forget()
    for number in UNKNOWN:
        for value in (None, 1, -1, b"hello"):
            robot.send(number, value)
    assert all(Sip.is_one(heard.payload) for heard in robot.record(2)), "an unknown command was answered"
    assert_obeys(robot)


def test_battery_request_is_not_taken_for_the_end_of_a_simulation(robot: Client) -> None:
    robot.send(62, 1)
    assert_obeys(robot)


@pytest.mark.parametrize(
    "payload",
    [bytes([ENABLE]), bytes([ENABLE, 0x3B]), bytes([ENABLE, 0x2B])],
    ids=["no argument", "type without value", "another type without value"],
)
def test_a_missing_value_is_zero(robot: Client, payload: bytes) -> None:
    robot.send(ENABLE, 1)
    robot.motors_become(True)
    robot.write(frame(payload))
    robot.motors_become(False)


def test_bytes_after_the_argument_are_ignored(robot: Client) -> None:
    robot.write(frame(bytes([ENABLE, 0x3B, 1, 0]) + b"\x55" * 40))
    robot.motors_become(True)


def test_strings_that_lie_about_their_length_are_survived(robot: Client) -> None:
    for payload in (b"\x03\x2b\xff\x01", b"\x0f\x2b\x00\x01\x02", b"\x2a\x2b", b"\x03\x2b" + b"\x7f" * 200):
        robot.write(frame(payload))
    assert_obeys(robot)
    robot.send(SONAR, 1)


@pytest.mark.parametrize("count", [0, 2, 0x80, 0xFF])
def test_a_count_that_lies_loses_no_more_than_what_comes_within_100_ms(robot: Client, count: int) -> None:
    robot.write(SYNC + bytes([count]) + b"\x04\x3b")
    pause(robot)
    assert_obeys(robot)


def test_a_damaged_command_is_not_executed(robot: Client) -> None:
    sound = command(ENABLE, 1)
    for at in range(2, len(sound)):
        damaged = bytearray(sound)
        damaged[at] ^= 0x20
        robot.write(bytes(damaged))
        if at == 2:
            pause(robot)  # this one damaged COUNT
    assert not any(sip.motors for sip in robot.sips(3))
    assert_obeys(robot)


def test_a_sound_frame_behind_a_damaged_one_is_found(robot: Client) -> None:
    sound = command(ENABLE, 1)
    robot.write(sound[:-1] + bytes([sound[-1] ^ 1]) + sound)
    robot.motors_become(True)


def test_a_frame_split_at_every_place_still_works(robot: Client) -> None:
    wanted = True
    for at in range(1, len(command(ENABLE, 1))):
        raw = command(ENABLE, int(wanted))
        for left in reversed(range(TRIES)):
            robot.write(raw[:at])
            list(robot.hear(PARTIAL_FRAME_S / 4, pulse=False))  # let the first part arrive alone
            robot.write(raw[at:])
            try:
                robot.motors_become(wanted)
                break
            except Silence:  # between two turns of a busy machine a robot may give the first part up
                if not left:
                    raise
        wanted = not wanted


@pytest.mark.needs(CONFIG, ENCODER, IOREQUEST)
def test_ten_frames_in_one_write_are_all_executed_in_order(robot: Client) -> None:
    robot.forget()
    robot.write(
        command(PULSE)
        + command(ENABLE, 1)
        + command(SONAR, 1)
        + command(CONFIG)
        + command(ENCODER, 1)
        + command(62, 1)
        + command(IOREQUEST, 1)
        + command(SONAR, 0)
        + command(ENABLE, 0)
        + command(ENABLE, 1)
    )
    heard = [item.payload for item in robot.record(4)]
    assert {CONFIGPAC, ENCODERPAC, IOPAC} <= {payload[0] for payload in heard}
    last = Sip.parse(heard[-1])
    assert last.motors
    assert not last.arrays
    robot.send(SONAR, 1)


def test_random_bytes_are_survived(robot: Client) -> None:
    dice = random.Random(8101)  # a fixed seed: the same noise in every run
    likely = bytes(dice.choice(b"\xfa\xfb\x03\x06\x00\x3b\x20\x55\xff") for _ in range(1200))
    noise = harmless(likely + dice.randbytes(1200))
    for at in range(0, len(noise), 60):
        robot.write(noise[at : at + 60])
    pause(robot)
    assert_obeys(robot)


def harmless(noise: bytes) -> bytes:
    """The same noise with every frame in it that happens to be sound broken."""
    raw = bytearray(noise)
    for at in range(len(raw) - 6):
        count = raw[at + 2]
        if raw[at : at + 2] == SYNC and count >= 3 and at + count + 3 <= len(raw):
            end = at + count + 3
            if checksum(bytes(raw[at + 3 : end - 2])) == raw[end - 2] * 256 + raw[end - 1]:
                raw[end - 1] ^= 0xFF
    return bytes(raw)
