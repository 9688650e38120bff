"""Telegrams on the wire: golden frames, and what noise may and may not do."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os import Damage, Damaged
from p2os.accessories.lms_framing import (
    LONGEST_FROM_LASER,
    LONGEST_TELEGRAM,
    PARTIAL_TIMEOUT,
    Acknowledged,
    LmsTelegram,
    LmsTelegramDecoder,
    crc,
    encode,
)

TO_LASER = [  # source: accessory sheet, section 1, frames; wire bytes, code, data
    ("02 00 02 00 20 25 35 08", 0x20, "25"),
    ("02 00 02 00 20 24 34 08", 0x20, "24"),
    ("02 00 02 00 20 42 52 08", 0x20, "42"),
    ("02 00 02 00 20 41 51 08", 0x20, "41"),
    ("02 00 02 00 20 40 50 08", 0x20, "40"),
    ("02 00 02 00 20 48 58 08", 0x20, "48"),
    ("02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5", 0x20, "00 53 49 43 4B 5F 4C 4D 53"),
    ("02 00 05 00 3B B4 00 64 00 97 49", 0x3B, "B4 00 64 00"),
    ("02 00 05 00 3B B4 00 32 00 3B 1F", 0x3B, "B4 00 32 00"),
    ("02 00 05 00 3B 64 00 19 00 E7 72", 0x3B, "64 00 19 00"),
    ("02 00 05 00 3B B4 00 00 00 5F 2D", 0x3B, "B4 00 00 00"),  # as one client sends it, by mistake
    ("02 00 01 00 3A 1E 12", 0x3A, ""),
    ("02 00 01 00 31 15 12", 0x31, ""),
    ("02 00 01 00 74 50 12", 0x74, ""),
    ("02 00 01 00 10 34 12", 0x10, ""),
]
FROM_LASER = [  # likewise; the status byte is 10
    ("02 80 03 00 A0 00 10 16 0A", 0xA0, "00"),
    ("02 80 07 00 BB 01 B4 00 64 00 10 5B 30", 0xBB, "01 B4 00 64 00"),
]

Event = LmsTelegram | Acknowledged | Damaged
telegrams = st.builds(encode, st.integers(0, 255), st.binary(max_size=LONGEST_FROM_LASER - 2), st.integers(0, 255))


def heard(*pieces: bytes, from_laser: bool = True, silence: bool = True) -> list[Event]:
    """Everything that a decoder makes of bytes, and of the silence after them."""
    decoder = LmsTelegramDecoder(from_laser=from_laser)
    events = [event for piece in pieces for event in decoder.receive(piece, 1.0)]
    return events + (decoder.receive(b"", 1.0 + PARTIAL_TIMEOUT) if silence else [])


def sound(events: list[Event]) -> list[LmsTelegram]:
    return [event for event in events if isinstance(event, LmsTelegram)]


@pytest.mark.parametrize(("frame", "code", "data"), TO_LASER)
def test_golden_commands_are_written_and_read(frame: str, code: int, data: str) -> None:
    wire, inside = bytes.fromhex(frame), bytes.fromhex(data)
    assert encode(code, inside) == wire
    assert heard(wire, from_laser=False) == [LmsTelegram(code, inside, 0, 1.0)]


@pytest.mark.parametrize(("frame", "code", "data"), FROM_LASER)
def test_golden_answers_are_written_and_read(frame: str, code: int, data: str) -> None:
    wire, inside = bytes.fromhex(frame), bytes.fromhex(data)
    assert encode(code, inside, 0x10) == wire
    assert heard(wire) == [LmsTelegram(code, inside, 0x10, 1.0)]


@given(st.binary(min_size=1, max_size=LONGEST_TELEGRAM))
def test_crc_is_that_of_the_register_of_the_sheet(data: bytes) -> None:
    register = previous = 0
    for byte in data:
        register = (register & 0x7FFF) << 1 ^ (0x8005 if register & 0x8000 else 0) ^ (byte | previous << 8)
        previous = byte
    assert crc(data) == register


@given(telegrams, st.integers(0), st.integers(1, 255))
def test_any_single_wrong_byte_is_noticed(wire: bytes, place: int, change: int) -> None:
    damaged = bytearray(wire)
    damaged[place % len(wire)] ^= change
    assert bytes(damaged) not in [encode(t.code, t.data, t.status) for t in sound(heard(bytes(damaged)))]


@given(st.binary(max_size=60), telegrams, st.binary(max_size=60), st.data())
def test_how_the_stream_is_cut_does_not_matter(before: bytes, wire: bytes, after: bytes, data: st.DataObject) -> None:
    stream = before + wire + after
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=8)))
    pieces = [stream[a:b] for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    assert heard(*pieces) == heard(stream)


@given(st.binary(max_size=100).filter(lambda noise: 0x02 not in noise), telegrams)
def test_a_telegram_is_found_behind_noise(noise: bytes, wire: bytes) -> None:
    assert [encode(t.code, t.data, t.status) for t in sound(heard(noise, wire))][:1] == [wire]


def test_a_telegram_inside_a_damaged_one_is_found_and_the_damage_told_once() -> None:
    inner = encode(0xB0, b"\0\0", 0x10)
    broken = bytearray(encode(0xB0, b"\1" * 4 + inner + b"\1" * 4, 0x10))
    broken[6] ^= 0xFF
    events = heard(bytes(broken))
    assert len(sound(events)) == 1
    assert [event for event in events if isinstance(event, Damaged)] == [Damaged(bytes(broken), Damage.CHECKSUM)]


def test_acknowledgements_between_telegrams_are_told_apart_from_noise() -> None:
    answer = encode(0xA0, b"\0", 0x10)
    events = heard(b"\x06" + answer + b"\x15zz")
    assert events == [
        Acknowledged(ok=True),
        LmsTelegram(0xA0, b"\0", 0x10, 1.0),
        Acknowledged(ok=False),
        Damaged(b"zz", Damage.NOISE),
    ]


def test_a_telegram_that_stops_half_way_does_not_swallow_the_next() -> None:
    decoder = LmsTelegramDecoder(from_laser=True)
    answer = encode(0xA0, b"\0", 0x10)
    assert decoder.receive(answer[:5], 1.0) == []
    assert decoder.receive(answer, 1.0 + PARTIAL_TIMEOUT)[-1] == LmsTelegram(0xA0, b"\0", 0x10, 1.0 + PARTIAL_TIMEOUT)


def test_a_telegram_knows_when_its_first_byte_came() -> None:
    decoder = LmsTelegramDecoder(from_laser=True)
    first, second = encode(0xB0, b"\0\0", 0x10), encode(0xA0, b"\0", 0x10)
    assert [t.began for t in sound(decoder.receive(first + second[:3], 1.0))] == [1.0]
    assert decoder.receive(second[3:6], 1.02) == []
    assert [t.began for t in sound(decoder.receive(second[6:] + first, 1.04))] == [1.0, 1.04]


@given(st.lists(st.binary(max_size=200), max_size=30))
def test_noise_does_not_pile_up(pieces: list[bytes]) -> None:
    decoder = LmsTelegramDecoder(from_laser=True)
    for piece in pieces:
        decoder.receive(piece, 1.0)
    assert len(decoder._buffer) <= LONGEST_TELEGRAM
    assert len(decoder._reads) <= len(pieces)
