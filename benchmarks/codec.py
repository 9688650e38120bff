"""Time to decode and encode one standard SIP of 94 bytes, framing and checksum included."""

import argparse
import timeit
from collections.abc import Callable

import configs
from benchmarks.figures import Figure
from p2os import Damaged, FrameDecoder, RobotModel, SipCodec, StandardSip, encode_frame

READINGS = 19  # an ARCOS SIP of 94 bytes carries 19 sonar readings
LOOPS = 2_000
REPEATS = 15


def measure(options: argparse.Namespace) -> list[Figure]:
    """Decode and encode in a loop; the median of several runs."""
    codec = SipCodec(configs.load(RobotModel, "robots", "p3dx-sh"))
    sip = example_sip(codec)
    wire = encode_frame(codec.encode(sip))
    if len(wire) != 94:
        raise AssertionError(f"the SIP of this benchmark should be 94 bytes long and is {len(wire)}")
    decoder = FrameDecoder()

    def decode() -> None:
        for frame in decoder.receive(wire, 0.0):
            assert not isinstance(frame, Damaged), "the wire is sound"
            codec.decode(frame.payload)

    def encode() -> None:
        encode_frame(codec.encode(sip))

    return [
        Figure("codec", "decode one 94-byte SIP into SI fields", microseconds(decode), 5.0, "us", LOOPS * REPEATS),
        Figure("codec", "encode one 94-byte SIP from SI fields", microseconds(encode), 5.0, "us", LOOPS * REPEATS),
    ]


def example_sip(codec: SipCodec) -> StandardSip:
    """A SIP of a robot that drives past something."""
    empty = codec.decode(bytes([0x33]) + bytes(31))
    sonar = tuple((number % 16, 0.5 + 0.1 * number) for number in range(READINGS))
    return empty._replace(moving=True, x=1.2, y=0.4, heading=0.7, left_velocity=0.3, right_velocity=0.31, sonar=sonar)


def microseconds(task: Callable[[], None]) -> float:
    """The time one call takes: the median of several runs, us."""
    runs = sorted(timeit.repeat(task, number=LOOPS, repeat=REPEATS))
    return runs[len(runs) // 2] / LOOPS * 1e6
