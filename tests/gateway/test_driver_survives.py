"""Noise, lies and cuts on the line: nothing crashes, nothing wrong is reported."""

import random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from configs import load
from gateway.driver import Driver
from gateway.events import HandshakeCompleted, SipReceived
from gateway.plausibility import Plausibility
from p2os import Identity, RobotHandshake, RobotModel, SipCodec, StandardSip, encode_frame

MODEL = load(RobotModel, "robots", "p3dx-sh")
CODEC = SipCodec(MODEL)
STEPS = 20


def sip(step: int) -> StandardSip:
    return StandardSip(
        x=1.0 + step / 100,
        left_velocity=0.1,
        right_velocity=0.1,
        moving=True,
        battery=12.5,
        flags=0x1F,
        sonar=((1, 1.5), (9, 5.0)),
        battery_fine=12.5,
        charge_state=0,
        rotational_velocity=0.0,
        fault_flags=0,
    )


def connected() -> tuple[Driver, float]:
    """A driver whose robot has just been opened."""
    driver = Driver(lambda identity: MODEL, (0,), rng=random.Random(1))
    robot = RobotHandshake(Identity("happy", "Pioneer", MODEL.name))
    now = 10.0
    driver.port_opened(now)
    while True:
        now += 0.01
        events = driver.receive(b"", now)
        data = driver.bytes_due(now)
        answer = robot.receive(data[3:-2]) if data else None
        if answer is not None:
            events += driver.receive(encode_frame(answer), now)
        if any(isinstance(event, HandshakeCompleted) for event in events):
            return driver, now


def played(driver: Driver, now: float, pieces: list[bytes], period: float) -> list[SipReceived]:
    found = []
    for piece in pieces:
        now += period
        found += [event for event in driver.receive(piece, now) if isinstance(event, SipReceived)]
        driver.bytes_due(now)
    return found


@given(st.binary(max_size=400), st.integers(1, 50))
def test_random_bytes_report_no_pose_and_break_nothing(noise: bytes, size: int) -> None:
    driver, now = connected()
    pieces = [noise[at : at + size] for at in range(0, len(noise), size)]
    assert played(driver, now, pieces, 0.002) == []
    frames = [encode_frame(CODEC.encode(sip(step))) for step in range(STEPS)]
    assert len(played(driver, now + 0.4, frames, 0.05)) >= STEPS - 2


@given(st.lists(st.binary(min_size=1, max_size=100), max_size=5))
def test_sound_frames_of_any_type_and_content_break_nothing(payloads: list[bytes]) -> None:
    driver, now = connected()
    played(driver, now, [encode_frame(payload) for payload in payloads], 0.02)
    assert driver.deadline < now + 10.0, "the driver goes on talking to the robot, or looking for it"


@pytest.mark.parametrize("packet_type", [t for t in range(256) if t >> 4 != 3 and t < 0xFE])
def test_packets_of_other_types_are_no_reason_to_lose_the_robot(packet_type: int) -> None:
    driver, now = connected()
    stranger = encode_frame(bytes([packet_type]) + bytes(12))
    frames = [encode_frame(CODEC.encode(sip(0))), stranger, encode_frame(CODEC.encode(sip(1)))]
    assert len(played(driver, now, frames, 0.05)) == 2
    assert driver.is_connected


def test_sips_give_the_same_poses_however_the_line_cuts_them() -> None:
    stream = b"".join(encode_frame(CODEC.encode(sip(step))) for step in range(3))
    driver, now = connected()
    whole = [event.pose for event in played(driver, now, [stream], 0.0)]
    assert len(whole) == 3
    for cut in range(1, len(stream)):
        driver, now = connected()
        assert [event.pose for event in played(driver, now, [stream[:cut], stream[cut:]], 0.0)] == whole
    driver, now = connected()
    assert [event.pose for event in played(driver, now, [bytes([byte]) for byte in stream], 0.0)] == whole


@pytest.mark.parametrize("flip", [0x01, 0x80, 0xFF])
def test_no_damaged_byte_of_a_sip_becomes_data(flip: int) -> None:
    good = encode_frame(CODEC.encode(sip(1)))
    for index in range(len(good)):
        driver, now = connected()
        damaged = bytes([*good[:index], good[index] ^ flip, *good[index + 1 :]])
        found = played(driver, now, [encode_frame(CODEC.encode(sip(0))), damaged], 0.1)
        assert [event.sip.x for event in found] == [pytest.approx(1.0)]


def test_damaged_frames_are_counted_by_reason() -> None:
    driver, now = connected()
    good = bytearray(encode_frame(CODEC.encode(sip(0))))
    good[10] ^= 1
    played(driver, now, [bytes(good), b"\xfa\xfb\x01"], 0.2)
    assert driver.damaged["checksum"] == 1
    assert driver.damaged["length"] == 1


IMPOSSIBLE: dict[str, dict[str, Any]] = {
    "speed": {"left_velocity": 20.0},
    "jump": {"x": 9.0},
    "turn": {"heading": 2.5},
    "sonar number": {"sonar": ((99, 1.0),)},
    "voltage": {"battery_fine": 99.0},
    "length": {"fault_flags": None},
}


@pytest.mark.parametrize("reason", IMPOSSIBLE)
def test_sip_that_cannot_be_true_is_counted_and_not_reported(reason: str) -> None:
    driver, now = connected()
    lie = sip(1)._replace(**IMPOSSIBLE[reason])
    frames = [encode_frame(CODEC.encode(each)) for each in (sip(0), lie, sip(2))]
    found = played(driver, now, frames, 0.1)
    assert [event.sip.x for event in found] == [pytest.approx(1.0), pytest.approx(1.02)]
    assert driver.implausible == {reason: 1}


def test_robot_that_insists_on_a_new_position_is_believed_and_the_pose_does_not_jump() -> None:
    driver, now = connected()
    there = [sip(step)._replace(x=20.0 + step / 100) for step in range(4)]
    found = played(driver, now, [encode_frame(CODEC.encode(each)) for each in (sip(0), sip(1), *there)], 0.1)
    assert len(found) == 4
    assert found[2].pose.x == pytest.approx(found[1].pose.x)
    assert found[3].pose.x == pytest.approx(found[1].pose.x + 0.01)
    assert driver.implausible == {"jump": 2}


def test_roll_over_of_the_position_counter_is_no_jump() -> None:
    judge = Plausibility(MODEL)
    assert judge.judge(sip(0)._replace(x=32.76), 0.0).doubt is None
    assert judge.judge(sip(0)._replace(x=0.01), 0.1) == (None, True)
