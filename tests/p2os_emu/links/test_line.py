"""The line model: frames, pacing by baud, noise on a rate mismatch; time is stepped."""

from hypothesis import given
from hypothesis import strategies as st

import configs
from p2os.framing import split_frames
from p2os_emu.links.line import EmulatedLine, LinkProfile
from p2os_emu.links.memory import MemoryLink

STEP = 1 / 120
SYNC0 = bytes.fromhex("FA FB 03 00 00 00")
VEL = bytes.fromhex("FA FB 06 0B 3B C8 00 D3 3B")
IDEAL = configs.load(LinkProfile, "links", "ideal")
RS232 = configs.load(LinkProfile, "links", "rs232")
PACED = LinkProfile("paced", paces=True)


def frame_of(size: int) -> bytes:
    """Something with the outline of a frame, of `size` bytes in all."""
    return b"\xfa\xfb" + bytes([size - 3]) + b"s" * (size - 3)


def test_ideal_line_writes_each_frame_by_itself_in_the_same_step() -> None:
    link = MemoryLink()
    EmulatedLine(link, IDEAL).send(SYNC0 + VEL + SYNC0, 0.0, 9600)
    assert link.client_read_pieces() == [SYNC0, VEL, SYNC0]


def test_ideal_line_understands_a_client_of_any_rate() -> None:
    link = MemoryLink(client_rate=115200)
    line = EmulatedLine(link, IDEAL)
    link.client_write(VEL)
    assert line.receive(0.0, 9600) == VEL


@given(st.lists(st.integers(5, 255).map(frame_of)))
def test_run_of_frames_is_cut_where_frames_end(frames: list[bytes]) -> None:
    assert list(split_frames(b"".join(frames))) == frames


@given(st.binary())
def test_cutting_loses_no_byte_of_anything(data: bytes) -> None:
    assert b"".join(split_frames(data)) == data


def test_paced_sip_takes_its_time_on_the_line() -> None:
    link = MemoryLink()
    line = EmulatedLine(link, PACED)
    sip = frame_of(94)
    line.send(sip, 0.0, 9600)
    arrival = {}
    received = b""
    for step in range(1, 20):
        line.send(b"", step * STEP, 9600)
        received += link.client_read()
        arrival[step] = len(received)
    # 960 bytes a second: 8 bytes a step, 94 bytes in 97.9 ms, complete at the 12th step.
    assert arrival[1] == 8
    assert arrival[11] == 88
    assert arrival[12] == 94
    assert received == sip


def test_paced_line_carries_both_directions_at_once() -> None:
    link = MemoryLink()
    line = EmulatedLine(link, PACED)
    link.client_write(VEL)
    assert line.receive(0.0, 9600) == b""
    line.send(SYNC0, 0.0, 9600)
    assert line.receive(1.0, 9600) == VEL
    line.send(b"", 1.0, 9600)
    assert link.client_read() == SYNC0


@given(st.lists(st.integers(5, 120), max_size=30), st.sampled_from([9600, 19200, 38400, 57600, 115200]))
def test_paced_line_never_exceeds_its_rate_and_keeps_the_order(sizes: list[int], baud: int) -> None:
    link = MemoryLink()
    line = EmulatedLine(link, PACED)
    sent = b""
    received = b""
    for step in range(600):
        frame = frame_of(sizes[step]) if step < len(sizes) else b""
        sent += frame
        line.send(frame, step * STEP, baud)
        received += link.client_read()
        assert len(received) <= step * STEP * baud / 10 + 1e-3
    assert received == sent


def test_line_rested_does_not_hurry_afterwards() -> None:
    link = MemoryLink()
    line = EmulatedLine(link, PACED)
    line.send(b"", 0.0, 9600)
    line.send(frame_of(94), 100.0, 9600)
    line.send(b"", 100.0 + STEP, 9600)
    assert len(link.client_read()) == 8


def test_full_buffer_drops_whole_frames() -> None:
    link = MemoryLink()
    line = EmulatedLine(link, LinkProfile("small", paces=True, buffer_bytes=200))
    line.send(frame_of(94) * 5, 0.0, 9600)
    line.send(b"", 10.0, 9600)
    assert link.client_read() == frame_of(94) * 2


def test_faster_rate_set_by_the_robot_holds_at_once() -> None:
    link = MemoryLink()
    line = EmulatedLine(link, PACED)
    line.send(frame_of(94), 0.0, 115200)
    line.send(b"", STEP, 115200)
    assert len(link.client_read()) == 94


def test_client_at_another_rate_hears_noise_and_is_heard_as_noise() -> None:
    link = MemoryLink(client_rate=57600)
    line = EmulatedLine(link, RS232, seed=1)
    link.client_write(VEL)
    line.receive(0.0, 9600)
    heard = line.receive(1.0, 9600)
    assert len(heard) == len(VEL)
    assert heard != VEL
    line.send(SYNC0, 1.0, 9600)
    line.send(b"", 2.0, 9600)
    assert link.client_read() != SYNC0


def test_client_is_understood_as_soon_as_its_rate_is_right() -> None:
    link = MemoryLink(client_rate=57600)
    line = EmulatedLine(link, RS232)
    link.client_rate = 9600
    link.client_write(VEL)
    line.receive(0.0, 9600)
    assert line.receive(1.0, 9600) == VEL


def test_port_without_a_rate_is_never_garbled() -> None:
    link = MemoryLink(client_rate=None)
    line = EmulatedLine(link, RS232)
    link.client_write(VEL)
    line.receive(0.0, 9600)
    assert line.receive(1.0, 9600) == VEL


def test_noise_repeats_with_the_seed() -> None:
    def noise(seed: int) -> bytes:
        link = MemoryLink(client_rate=57600)
        line = EmulatedLine(link, RS232, seed)
        link.client_write(VEL)
        line.receive(0.0, 9600)
        return line.receive(1.0, 9600)

    assert noise(7) == noise(7)
    assert noise(7) != noise(8)


def test_cut_line_delivers_nothing_either_way_and_works_again_afterwards() -> None:
    link = MemoryLink()
    line = EmulatedLine(link, IDEAL)
    line.is_cut = True
    link.client_write(VEL)
    assert line.receive(0.0, 9600) == b""
    line.send(SYNC0, 0.0, 9600)
    assert link.client_read() == b""
    line.is_cut = False
    assert line.receive(1.0, 9600) == b""
    line.send(SYNC0, 1.0, 9600)
    assert link.client_read() == SYNC0
