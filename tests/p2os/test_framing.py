import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os import PARTIAL_TIMEOUT, Damage, Damaged, EncodeError, Frame, FrameDecoder, checksum, encode_frame
from p2os.framing import MAX_PAYLOAD, NOISE_BLOCK

PAYLOADS = st.binary(min_size=1, max_size=MAX_PAYLOAD)

# Source: protocol description, worked checksum examples; payload, checksum.
CHECKSUMS = [
    ("00", 0x0000),
    ("01", 0x0001),  # an odd byte goes into the low byte
    ("01 3B 01 00", 0x023B),  # 0x013B + 0x0100
    ("07 3B", 0x073B),
    ("03 2B 08 31 32 33 34 35 36 37 38", 0xA7C3),  # odd: 0x38 is XORed
    ("FF FF FF FF FF FF", 0xFFFD),  # the sum is kept modulo 65536
]


def decode(*chunks: bytes, silence: bool = True) -> list[Frame | Damaged]:
    """Everything a new decoder makes of these chunks, and of the silence behind them."""
    decoder = FrameDecoder()
    events = [event for chunk in chunks for event in decoder.receive(chunk, 0.0)]
    return events + decoder.receive(b"", PARTIAL_TIMEOUT) if silence else events


def frames(events: list[Frame | Damaged]) -> list[bytes]:
    return [event.payload for event in events if isinstance(event, Frame)]


def reasons(events: list[Frame | Damaged]) -> list[Damage]:
    return [event.reason for event in events if isinstance(event, Damaged)]


def sum_word_by_word(payload: bytes) -> int:
    """The checksum as its description reads, step by step."""
    total = 0
    for i in range(0, len(payload) - 1, 2):
        total = (total + (payload[i] << 8) + payload[i + 1]) & 0xFFFF
    return total ^ payload[-1] if len(payload) % 2 else total


@pytest.mark.parametrize(("payload", "expected"), CHECKSUMS)
def test_checksum_matches_the_worked_examples(payload: str, expected: int) -> None:
    assert checksum(bytes.fromhex(payload)) == expected


@given(st.binary(max_size=255))
def test_checksum_equals_the_sum_word_by_word(payload: bytes) -> None:
    assert checksum(payload) == sum_word_by_word(payload)


def test_frame_is_sync_count_payload_and_checksum_high_byte_first() -> None:
    assert encode_frame(bytes.fromhex("01 3B 01 00")) == bytes.fromhex("FA FB 06 01 3B 01 00 02 3B")


@pytest.mark.parametrize("size", [0, MAX_PAYLOAD + 1])
def test_payload_that_no_frame_carries_is_refused(size: int) -> None:
    with pytest.raises(EncodeError, match=f"payload of {size} bytes does not fit a frame, which carries 1 to 250"):
        encode_frame(bytes(size))


@given(st.lists(PAYLOADS, max_size=5))
def test_frames_back_to_back_are_all_found(payloads: list[bytes]) -> None:
    assert decode(b"".join(map(encode_frame, payloads))) == [Frame(payload) for payload in payloads]


def test_every_single_byte_corruption_of_a_sip_is_caught() -> None:
    sound = encode_frame(bytes([0x32, *range(88)]))
    for position in range(len(sound)):
        for value in range(256):
            if value != sound[position]:
                damaged = bytearray(sound)
                damaged[position] = value
                events = decode(bytes(damaged))
                assert frames(events) == [], f"byte {position} set to {value}"
                assert reasons(events), f"byte {position} set to {value}"


def test_a_frame_split_at_every_place_is_found() -> None:
    frame = encode_frame(bytes([0x32, 0xFA, 0xFB, *range(40)]))
    for cut in range(len(frame) + 1):
        assert decode(frame[:cut], frame[cut:]) == [Frame(frame[3:-2])]


@given(st.lists(st.binary(max_size=40) | PAYLOADS.map(encode_frame) | st.just(b"\xfa\xfb"), max_size=8), st.data())
def test_any_splitting_of_a_stream_gives_the_same_events(pieces: list[bytes], data: st.DataObject) -> None:
    stream = b"".join(pieces)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=10)))
    chunks = [stream[a:b] for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    assert decode(*chunks) == decode(stream)


@pytest.mark.parametrize("size", [255, 256, 257, 300, 512, 700])
def test_long_noise_comes_in_blocks_however_it_is_cut(size: int) -> None:
    stream = b"~" * size + encode_frame(b"\x1d")
    whole = decode(stream)
    assert [len(event.raw) for event in whole if isinstance(event, Damaged)][:-1] == [256] * ((size - 1) // 256)
    assert decode(stream[:260], stream[260:]) == decode(*(bytes([byte]) for byte in stream)) == whole


@given(st.binary(max_size=600).filter(lambda noise: b"\xfa" not in noise), PAYLOADS)
def test_a_sound_frame_behind_garbage_is_found(garbage: bytes, payload: bytes) -> None:
    events = decode(garbage + encode_frame(payload))
    assert frames(events) == [payload]
    assert b"".join(event.raw for event in events if isinstance(event, Damaged)) == garbage


@given(st.lists(st.binary(max_size=300), max_size=5), st.lists(st.floats(0, 1), min_size=5, max_size=5))
def test_no_input_makes_the_decoder_fail(chunks: list[bytes], pauses: list[float]) -> None:
    decoder = FrameDecoder()
    now = 0.0
    for chunk, pause in zip(chunks, pauses, strict=False):
        now += pause
        for event in decoder.receive(chunk, now):
            assert isinstance(event, Frame | Damaged)
    decoder.receive(b"", now + 1)
    assert decoder.receive(b"", now + 2) == []


@given(st.binary(max_size=100), PAYLOADS)
def test_a_sound_frame_behind_anything_is_found_once_the_line_is_silent(garbage: bytes, payload: bytes) -> None:
    # Unless the garbage happens to be a sound frame that takes our frame's bytes for its own.
    events = decode(garbage + encode_frame(payload))
    eaten = any(len(found) > len(payload) for found in frames(events))
    assert payload in frames(events) or eaten


def test_the_sound_frame_inside_a_damaged_one_is_found() -> None:
    inner = encode_frame(b"\x0b\x3b\xc8\x00")
    outer = encode_frame(b"\x32" + inner + b"\x00")
    damaged = outer[:-1] + bytes([outer[-1] ^ 1])
    assert decode(damaged) == [Damaged(damaged, Damage.CHECKSUM), Frame(inner[3:-2])]


def test_a_damaged_frame_is_one_event_and_not_noise_as_well() -> None:
    damaged = bytes.fromhex("FA FB 06 0B 3B C8 00 D3 3C")
    assert decode(damaged) == [Damaged(damaged, Damage.CHECKSUM)]


def test_a_count_too_large_swallows_no_frame_that_follows() -> None:
    lying = bytes.fromhex("FA FB FF 0B 3B C8 00 D3 3B")
    follower = encode_frame(b"\x1d")
    events = decode(lying + follower * 3)
    assert frames(events) == [b"\x1d"] * 3
    assert reasons(events) == [Damage.PARTIAL]


def test_a_count_too_small_swallows_no_frame_that_follows() -> None:
    lying = bytes.fromhex("FA FB 04 0B 3B C8 00 D3 3B")
    events = decode(lying + encode_frame(b"\x1d"))
    assert frames(events) == [b"\x1d"]
    assert reasons(events) == [Damage.CHECKSUM, Damage.NOISE]


@pytest.mark.parametrize("count", [0, 1, 2])
def test_a_count_without_room_for_a_payload_is_damage_by_length(count: int) -> None:
    events = decode(bytes([0xFA, 0xFB, count]) + encode_frame(b"\x00"))
    assert events == [Damaged(bytes([0xFA, 0xFB, count]), Damage.LENGTH), Frame(b"\x00")]


def test_a_partial_frame_is_dropped_after_silence() -> None:
    decoder = FrameDecoder()
    frame = encode_frame(bytes(20))
    assert decoder.receive(frame[:10], 5.0) == []
    assert decoder.receive(b"", 5.09) == []
    assert decoder.receive(frame, 5.11) == [Damaged(frame[:10], Damage.PARTIAL), Frame(bytes(20))]


def test_a_slow_frame_is_whole_while_no_pause_is_too_long() -> None:
    decoder = FrameDecoder()
    frame = encode_frame(bytes(20))
    events = [event for i, byte in enumerate(frame) for event in decoder.receive(bytes([byte]), i * 0.09)]
    assert events == [Frame(bytes(20))]


def test_a_lone_first_sync_byte_is_noise_after_silence() -> None:
    assert decode(b"\xfa") == [Damaged(b"\xfa", Damage.NOISE)]


def test_endless_noise_comes_in_blocks_and_fills_no_memory() -> None:
    decoder = FrameDecoder()
    events = [event for _ in range(100) for event in decoder.receive(bytes(100), 0.0)]
    assert {(len(event.raw), event.reason) for event in events if isinstance(event, Damaged)} == {
        (NOISE_BLOCK, Damage.NOISE)
    }
    assert len(events) == 10_000 // NOISE_BLOCK


def test_the_radio_dial_of_a_client_is_noise() -> None:
    assert decode(b"WMS2\r" + encode_frame(b"\x00")) == [Damaged(b"WMS2\r", Damage.NOISE), Frame(b"\x00")]
