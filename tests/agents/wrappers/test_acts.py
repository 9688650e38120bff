"""The colour protocol of ACTS: golden bytes, any portions, any blobs, nonsense."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.wrappers.acts import FIELDS, ActsCodec
from agents.wrappers.codec import Answered, NonsenseHeard
from tests.agents.wrappers import acts_server

NOTHING = b"\x01\x01\x01\x01" * 32  # no channel has a blob: index 0, count 0


def blobs_in(data: bytes, version: str = "") -> list[dict[str, int]]:
    (event,) = ActsCodec(version).receive(data)
    assert isinstance(event, Answered)
    found: list[dict[str, int]] = event.value["blobs"]
    return found


def test_a_blob_is_read_byte_by_byte_as_the_sheet_says() -> None:
    header = bytearray(NOTHING)
    header[4 * 2 : 4 * 3] = b"\x01\x01\x01\x02"  # channel 3: first blob is number 0, one blob
    data = (
        b"\x01\x02\x0f\x09"  # area: 0, 1, 14, 8 -> 1 * 4096 + 14 * 64 + 8 = 5000
        b"\x02\x11"  # x: 1, 16 -> 80
        b"\x01\x3d"  # y: 60
        b"\x01\x29"  # left: 40
        b"\x02\x39"  # right: 1, 56 -> 120
        b"\x01\x1f"  # top: 30
        b"\x02\x1b"  # bottom: 1, 26 -> 90
    )
    expected = {"channel": 3, "area": 5000, "x": 80, "y": 60, "left": 40, "right": 120, "top": 30, "bottom": 90}
    assert blobs_in(bytes(header) + data) == [expected]


def test_the_oldest_version_has_a_byte_for_each_coordinate() -> None:
    header = bytearray(b"\x01\x01" * 32)
    header[0:2] = b"\x01\x02"  # channel 1: one blob
    blob = b"\x01\x01\x02\x03" + bytes([160, 120, 2, 160, 1, 120])  # area 64 + 2, and each coordinate one less
    expected = {"channel": 1, "area": 66, "x": 159, "y": 119, "left": 1, "right": 159, "top": 0, "bottom": 119}
    assert blobs_in(bytes(header) + blob, "1.0") == [expected]


def test_no_blobs_is_an_answer_too() -> None:
    assert blobs_in(NOTHING) == []


COORDINATE = st.integers(0, 64 * 64 - 1)
BLOB = st.tuples(st.integers(0, 64**4 - 1), *[COORDINATE] * 6)


@given(st.dictionaries(st.integers(1, 32), st.lists(BLOB, min_size=1, max_size=10), max_size=6), st.data())
def test_what_a_server_sees_arrives_in_whatever_portions(
    channels: dict[int, list[tuple[int, ...]]], data: st.DataObject
) -> None:
    said = acts_server.packet({number: [acts_server.blob(*one) for one in blobs] for number, blobs in channels.items()})
    cut = data.draw(st.integers(0, len(said)))
    codec = ActsCodec()
    events = [*codec.receive(said[:cut]), *codec.receive(said[cut:])]
    seen = [
        {"channel": number} | dict(zip(FIELDS, blob, strict=True))
        for number in sorted(channels)
        for blob in channels[number]
    ]
    assert events == [Answered({"blobs": seen})]


@pytest.mark.parametrize(
    ("said", "why"),
    [
        (b"\x00" + NOTHING[1:], "the byte 0"),
        (b"HTTP/1.1 400 Bad Request\r\n" * 8, "the byte 72"),
        (b"\x01\x01\x01\x0c" + NOTHING[4:], "does not fit"),  # eleven blobs in one channel
        (b"\x01\x05\x01\x02" + NOTHING[4:], "does not fit"),  # the first blob is number 4
    ],
)
def test_what_is_not_its_language_is_told(said: bytes, why: str) -> None:
    with pytest.raises(NonsenseHeard, match=why):
        ActsCodec().receive(said)
