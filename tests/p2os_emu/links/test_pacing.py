"""A full line: standard SIPs first, frames whole, other packets dropped."""

from hypothesis import given
from hypothesis import strategies as st

from p2os import encode_frame
from p2os.framing import split_frames
from p2os_emu.links.pacing import HostQueue, RobotQueue
from p2os_emu.links.stage import Rates

RATES = Rates(9600, 9600)
SIP = encode_frame(b"\x32" + b"s" * 90)
SIP_MOVING = encode_frame(b"\x33" + b"m" * 90)
ENCODERS = encode_frame(b"\x90" + b"e" * 8)
GYRO = encode_frame(b"\x98" + b"g" * 13)
SCAN = b"\x02\x80" + b"scan" * 200  # another device's telegram: no frame of this protocol


def drain(queue: RobotQueue, start: float) -> list[bytes]:
    """All that waits, in the order of the line."""
    queue.carry(b"", start, RATES)
    return list(split_frames(queue.carry(b"", start + 100.0, RATES)))


def test_sip_overtakes_what_waits_from_earlier_steps() -> None:
    queue = RobotQueue(512)
    queue.carry(ENCODERS * 5, 0.0, RATES)
    queue.carry(SIP, 0.0, RATES)
    assert drain(queue, 0.0) == [SIP, *[ENCODERS] * 5]


def test_frame_that_was_begun_is_finished_first() -> None:
    queue = RobotQueue(512)
    queue.carry(ENCODERS * 2, 0.0, RATES)
    begun = queue.carry(b"", 0.005, RATES)
    assert begun
    assert ENCODERS.startswith(begun)
    queue.carry(SIP, 0.005, RATES)
    rest = queue.carry(b"", 100.0, RATES)
    assert begun + rest == ENCODERS + SIP + ENCODERS


def test_gyro_packet_stays_in_front_of_its_sip() -> None:
    queue = RobotQueue(512)
    queue.carry(ENCODERS, 0.0, RATES)
    queue.carry(GYRO + SIP + ENCODERS, 0.0, RATES)
    assert drain(queue, 0.0) == [GYRO, SIP, ENCODERS, ENCODERS]


def test_full_line_drops_other_packets_and_keeps_every_sip() -> None:
    queue, heard = RobotQueue(512), b""
    # Every 100 ms a SIP of 96 bytes and as much again of other packets: twice what 9600 baud carries.
    for cycle in range(50):
        heard += queue.carry(SIP_MOVING + ENCODERS * 7, cycle * 0.1, RATES)
    frames = list(split_frames(heard))
    assert frames.count(SIP_MOVING) >= 47
    assert queue.dropped > 200
    assert set(frames[:-1]) <= {SIP_MOVING, ENCODERS}, "what arrives is whole"


def test_sips_that_are_too_much_by_themselves_are_dropped_whole() -> None:
    queue, heard = RobotQueue(300), b""
    long = encode_frame(b"\x32" + b"s" * 150)
    for cycle in range(50):
        heard += queue.carry(long, cycle * 0.1, RATES)
    assert queue.dropped
    assert all(frame == long for frame in list(split_frames(heard))[:-1])


def test_telegram_larger_than_the_buffer_may_wait_alone() -> None:
    queue = RobotQueue(512)
    queue.carry(SCAN, 0.0, RATES)
    queue.carry(SCAN, 0.0, RATES)
    assert drain(queue, 0.0) == [SCAN]
    assert queue.dropped == 1


@given(st.lists(st.sampled_from([SIP, ENCODERS, GYRO, SIP + ENCODERS, GYRO + SIP, SCAN]), max_size=40))
def test_whatever_is_sent_arrives_whole_or_not_at_all(writes: list[bytes]) -> None:
    queue, heard = RobotQueue(512), b""
    for step, write in enumerate(writes):
        heard += queue.carry(write, step * 0.03, RATES)
    heard += queue.carry(b"", 1000.0, RATES)
    frames = [frame for write in writes for frame in split_frames(write)]
    arrived = heard
    for whole in (SCAN, SIP, GYRO, ENCODERS):
        arrived = arrived.replace(whole, b"")
    assert arrived == b""
    assert len(b"".join(frames)) - len(heard) >= 0
    assert queue.dropped == len(frames) - sum(heard.count(whole) for whole in (SCAN, SIP, GYRO, ENCODERS))


def test_client_that_writes_more_than_its_buffer_holds_loses_whole_writes() -> None:
    queue = HostQueue(100)
    queue.carry(b"a" * 60, 0.0, RATES)
    queue.carry(b"b" * 60, 0.0, RATES)
    queue.carry(b"c" * 40, 0.0, RATES)
    assert queue.carry(b"", 10.0, RATES) == b"a" * 60 + b"c" * 40
    assert queue.dropped == 1
