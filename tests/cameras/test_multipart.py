from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cameras.jpeg import picture_size
from cameras.multipart import MOST, MultipartDecoder, NoPictures, boundary_of

TIMES = [b"", b"X-Timestamp: 1763812800.250000\r\n", b"x-timestamp:3.5\r\n"]  # as mjpg-streamer writes them
PICTURES = [b"\xff\xd8first\xff\xd9", b"\xff\xd8\r\n--not the end\r\n\xff\xd9", b"\xff\xd8third\xff\xd9"]


def stream(with_length: bool, boundary: bytes = b"frame") -> bytes:
    parts = []
    for picture, when in zip(PICTURES, TIMES, strict=True):
        length = b"Content-Length: %d\r\n" % len(picture) if with_length else b""
        head = b"--" + boundary + b"\r\nContent-Type: image/jpeg\r\n" + length + when
        parts.append(head + b"\r\n" + picture + b"\r\n")
    return b"".join(parts) + b"--" + boundary + b"\r\n"


@pytest.mark.parametrize(
    ("content_type", "boundary"),
    [
        ("multipart/x-mixed-replace; boundary=frame", b"frame"),
        ("multipart/x-mixed-replace;boundary=--frame", b"frame"),
        ('multipart/x-mixed-replace; boundary="the frame"', b"the frame"),
        ("image/jpeg", None),
        ("multipart/x-mixed-replace", None),
        ("", None),
    ],
)
def test_boundary_is_found_in_the_ways_that_cameras_write_it(content_type: str, boundary: bytes | None) -> None:
    assert boundary_of(content_type) == boundary


@pytest.mark.parametrize("with_length", [True, False])
@given(cuts=st.lists(st.integers(0, 300), max_size=8))
def test_any_splitting_of_a_stream_gives_the_same_pictures(with_length: bool, cuts: list[int]) -> None:
    data = stream(with_length)
    decoder = MultipartDecoder(b"frame")
    edges = [0, *sorted(min(cut, len(data)) for cut in cuts), len(data)]
    found = [picture for begin, end in pairwise(edges) for picture in decoder.receive(data[begin:end])]
    assert [picture.jpeg for picture in found] == PICTURES
    assert [picture.taken for picture in found] == [None, 1763812800.25, 3.5]


@pytest.mark.parametrize("time", [b"", b"now", b"nan", b"1e999", b"-inf"])
def test_a_time_that_is_none_is_ignored(time: bytes) -> None:
    [picture] = MultipartDecoder(b"frame").receive(b"--frame\r\nContent-Length: 1\r\nX-Timestamp: %s\r\n\r\nx" % time)
    assert picture.taken is None


def test_a_length_of_thousands_of_digits_is_waited_for_like_any_other() -> None:
    decoder = MultipartDecoder(b"frame")
    assert decoder.receive(b"--frame\r\nContent-Length: %s\r\n\r\n" % (b"9" * 5000)) == []
    assert decoder.receive(bytes(1000)) == []


@given(st.lists(st.binary(max_size=60) | st.just(b"--frame\r\nContent-Length: 9\r\n\r\n"), max_size=20))
def test_garbage_is_survived(pieces: list[bytes]) -> None:
    decoder = MultipartDecoder(b"frame")
    for piece in pieces:
        decoder.receive(piece)


def test_stream_without_an_end_to_its_picture_is_given_up() -> None:
    decoder = MultipartDecoder(b"frame")
    decoder.receive(b"--frame\r\n\r\n")
    with pytest.raises(NoPictures, match="32 MB"):
        decoder.receive(bytes(MOST + 100))


@pytest.mark.parametrize(
    ("data", "size"),
    [
        # Start, an APP0 segment of 4 bytes, a baseline frame of 120 rows and 160 columns, end. Source: ITU-T T.81.
        ("FF D8  FF E0 00 04 00 00  FF C0 00 0B 08 00 78 00 A0 01 11 00  FF D9", (160, 120)),
        ("FF D8  FF FF C2 00 0B 08 00 78 00 A0 01 11 00  FF D9", (160, 120)),  # filled up, progressive
        ("FF D8  FF C4 00 04 00 00  FF C0 00 0B 08 00 78 00 A0 01 11 00  FF D9 00 00", (160, 120)),
        ("FF D8  FF C0 00 0B 08 00 78 00 A0 01 11 00", None),  # cut off
        ("FF D8  00 C0 00 0B 08 00 78 00 A0 01 11 00  FF D9", None),
        ("FF D8 FF D9", None),
        ("", None),
    ],
)
def test_size_of_a_whole_jpeg_is_read_from_its_frame(data: str, size: tuple[int, int] | None) -> None:
    assert picture_size(bytes.fromhex(data)) == size


@given(st.binary(max_size=100))
def test_size_of_garbage_is_none_or_two_numbers(data: bytes) -> None:
    size = picture_size(b"\xff\xd8" + data + b"\xff\xd9")
    assert size is None or all(0 <= each <= 0xFFFF for each in size)
