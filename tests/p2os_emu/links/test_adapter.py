"""A USB adapter: full blocks at once, the rest when the timer runs out."""

from hypothesis import given
from hypothesis import strategies as st

import configs
from p2os_emu.links.adapter import Adapter, Blocks
from p2os_emu.links.line import EmulatedLine, LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.links.stage import Rates

STEP = 1 / 120
RATES = Rates(115200, 115200)
# Source: FTDI application note AN232B-04: 16 ms, and 62 bytes of data in a packet of 64.
FTDI = Adapter(latency_timer=0.016, block_bytes=62)


def test_full_blocks_are_handed_on_at_once() -> None:
    assert Blocks(FTDI).carry(b"x" * 130, 0.0, RATES) == b"x" * 124


def test_rest_comes_when_the_timer_runs_out() -> None:
    blocks = Blocks(FTDI)
    assert blocks.carry(b"sip", 5.0, RATES) == b""
    assert blocks.carry(b"", 5.015, RATES) == b""
    assert blocks.carry(b"", 5.016, RATES) == b"sip"


def test_timer_starts_again_with_every_block() -> None:
    blocks = Blocks(FTDI)
    blocks.carry(b"x" * 60, 0.0, RATES)
    assert blocks.carry(b"y" * 10, 0.010, RATES) == b"x" * 60 + b"yy"
    assert blocks.carry(b"", 0.020, RATES) == b""
    assert blocks.carry(b"", 0.026, RATES) == b"y" * 8


@given(st.lists(st.integers(0, 200), max_size=50))
def test_no_byte_is_lost_and_none_waits_longer_than_the_timer(sizes: list[int]) -> None:
    blocks, sent, heard = Blocks(FTDI), b"", b""
    for step, size in enumerate([*sizes, 0, 0, 0]):
        piece = bytes([step % 256]) * size
        sent += piece
        heard += blocks.carry(piece, step * STEP, RATES)
    assert heard == sent


def test_profile_brings_bunches_from_the_robot_and_none_towards_it() -> None:
    link = MemoryLink(client_rate=115200)
    line = EmulatedLine(link, configs.load(LinkProfile, "links", "usb-serial"))
    link.client_write(b"x" * 20)
    line.receive(0.0, 115200)
    assert line.receive(STEP, 115200) == b"x" * 20
    sip = b"\xfa\xfb\x5b" + b"s" * 91
    for step in range(24):
        line.send(sip if step == 0 else b"", step * STEP, 115200)
    # 11520 bytes a second: 94 bytes arrive within one step, one block of 62 and a rest of 32.
    assert [len(piece) for piece in link.client_read_pieces()] == [62, 32]
