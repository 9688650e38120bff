"""The fuzz benchmark in small: its frames are sound where they should be, and nothing crashes on them."""

import numpy as np
import pytest

from benchmarks import fuzz
from p2os import Frame, FrameDecoder, encode_frame
from p2os.accessories import lms_framing


@pytest.mark.parametrize("make", fuzz.PARSERS)
def test_nothing_crashes(make: fuzz.MakeParser) -> None:
    fed, _ = fuzz.feed(make(), 4 * fuzz.LOT)
    assert fed == 4 * fuzz.LOT


@pytest.mark.parametrize("size", [1, 2, 31, 250])
def test_frames_made_many_at_a_time_are_those_of_the_codec(size: int) -> None:
    contents = np.random.default_rng(size).integers(0, 256, (5, size), np.uint8)
    sealed = fuzz.seal_frames(contents)
    assert [row.tobytes() for row in sealed] == [encode_frame(row.tobytes()) for row in contents]


@pytest.mark.parametrize("size", [1, 2, 60])
def test_telegrams_made_many_at_a_time_have_the_right_crc(size: int) -> None:
    contents = np.random.default_rng(size).integers(0, 256, (5, size), np.uint8)
    for row in fuzz.seal_telegrams(contents):
        assert int.from_bytes(row[-2:].tobytes(), "little") == lms_framing.crc(row[:-2].tobytes())


def test_most_frames_come_past_the_checksum() -> None:
    decoder, sent, found = FrameDecoder(), 0, 0
    for count, wire in fuzz.lots(fuzz.robot_parser()):
        found += sum(isinstance(event, Frame) for event in decoder.receive(wire, 0.0))
        sent += count
        if sent >= 20 * fuzz.LOT:
            break
    assert found > 0.6 * sent
