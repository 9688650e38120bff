"""Ten million generated frames into every parser of bytes from outside: no crash, and memory stays flat.

Then a million mutated payloads from the bus into a gateway (`fuzz_bus`).

Frames are made many at a time: a sound one is repeated, a part of its bytes is replaced, the checksums are computed
anew, and of every fourth lot some bytes are then damaged, lost or doubled on the wire. So most frames are sound and
bring their strange contents past the checksum, and the rest tries the search for the next frame.
"""

import argparse
import resource
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import configs
from benchmarks import fuzz_bus
from benchmarks.codec import example_sip
from benchmarks.figures import Figure
from p2os import (
    Argument,
    Command,
    Configuration,
    DecodeError,
    Encoders,
    Frame,
    FrameDecoder,
    IoReport,
    RobotModel,
    SipCodec,
    decode_command,
    decode_packet,
    encode_command,
    encode_packet,
)
from p2os.accessories import lms, lms_framing, vcc4, visca
from p2os.accessories.vcc4 import Code
from p2os.packets import PacketType

FRAMES = 10_000_000
LOT = 1024  # frames made together
REPLACED = (0.0, 0.02, 0.1, 0.5, 1.0)  # fraction of a frame's bytes, by lot
LONGEST_READ = 4096  # bytes handed over at once
WARM_UP = 0.2  # of the frames, before memory is measured
FLAT = 4.0  # MB that the interpreter's own store may come to need behind that
SEED = 4
_MB = 1024  # kB

Bytes = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Parser:
    """What is fed.

    name: for people. corpus: contents of sound frames. keep: bytes at their front that say what they are, and stay in
    most lots. seal: contents, one a row, to whole frames. feed: takes bytes as they come.
    """

    name: str
    corpus: Sequence[bytes]
    keep: int
    seal: Callable[[Bytes], Bytes]
    feed: Callable[[bytes], None]


MakeParser = Callable[[], Parser]


def measure(options: argparse.Namespace) -> list[Figure]:
    """Feed every parser; a crash ends the benchmark with its traceback."""
    figures = []
    for make in PARSERS:
        parser = make()
        fed, growth = feed(parser, FRAMES)
        name = f"{parser.name}: {fed / 1e6:.1f} million generated frames without a crash, memory grown by"
        figures.append(Figure("fuzz", name, growth, FLAT, "MB", fed))
    return [*figures, _bus_figure()]


def _bus_figure() -> Figure:
    outcome = fuzz_bus.feed(fuzz_bus.PAYLOADS)
    name = f"gateway: {outcome.count / 1e6:.1f} million mutated payloads on its keys, errors that are no refusal"
    return Figure("fuzz", name, sum(outcome.failures.values()), 0.0, "", outcome.count)


def feed(parser: Parser, frames: int, seed: int = SEED) -> tuple[int, float]:
    """Feed a parser.

    Returns:
        How many frames it got, and by how many MB the process grew behind the warm-up.
    """
    fed, before = 0, 0.0
    for count, wire in lots(parser, seed):
        if fed < WARM_UP * frames:
            before = _used()
        for start in range(0, len(wire), LONGEST_READ):
            parser.feed(wire[start : start + LONGEST_READ])
        fed += count
        if fed >= frames:
            return fed, _used() - before
    raise AssertionError("lots never end")


def lots(parser: Parser, seed: int = SEED) -> Iterator[tuple[int, bytes]]:
    """Generated frames without end: how many, and their bytes on the wire."""
    rng = np.random.default_rng(seed)
    while True:
        content = parser.corpus[int(rng.integers(len(parser.corpus)))]
        rows = np.tile(np.frombuffer(content, np.uint8), (LOT, 1))
        mask = rng.random(rows.shape, np.float32) < rng.choice(REPLACED)
        if rng.random() < 0.8:
            mask[:, : parser.keep] = False
        np.copyto(rows, rng.integers(0, 256, rows.shape, np.uint8), where=mask)
        wire = parser.seal(rows).reshape(-1)
        yield LOT, (_damaged(wire, rng) if rng.random() < 0.25 else wire).tobytes()


def _damaged(wire: Bytes, rng: np.random.Generator) -> Bytes:
    """Some bytes replaced, some lost, some doubled."""
    places = rng.integers(0, len(wire), (3, max(1, len(wire) // 300)))
    wire = wire.copy()
    wire[places[0]] = rng.integers(0, 256, places.shape[1], np.uint8)
    repeats = np.ones(len(wire), np.int64)
    repeats[places[1]] = 0
    repeats[places[2]] = 2
    return np.repeat(wire, repeats)


def _used() -> float:
    """The most memory that this process has needed so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / _MB


def host_parser() -> Parser:
    """What a robot's firmware does with a host's bytes."""
    decoder = FrameDecoder()

    def take(data: bytes) -> None:
        for event in decoder.receive(data, 0.0):
            if isinstance(event, Frame):
                decode_command(event.payload)

    examples = {
        Argument.NONE: None,
        Argument.INT: -3,
        Argument.UINT: 3,
        Argument.STRING: b"a string",
        Argument.TWO_BYTES: (1, 2),
        Argument.DATA: bytes(20),
    }
    frames = [encode_command(command, examples[command.argument]) for command in Command]
    return Parser("host to robot", [*(frame[3:-2] for frame in frames), bytes(250)], 1, seal_frames, take)


def robot_parser() -> Parser:
    """What a host does with a robot's bytes."""
    model = configs.load(RobotModel, "robots", "powerbot-sh")
    codec, decoder = SipCodec(model), FrameDecoder()

    def take(data: bytes) -> None:
        for event in decoder.receive(data, 0.0):
            if isinstance(event, Frame):
                with suppress(DecodeError):  # the one that is allowed: garbage is refused
                    decode_packet(event.payload, model, codec)

    sip = example_sip(codec)
    packets = (
        sip,
        sip._replace(sonar=()),
        Configuration(subtype="powerbot-sh", name="happy", firmware_version="2.8"),
        Encoders(-5, 70000),
        IoReport(bytes(4), bytes(1), (1.0, 2.5)),
    )
    corpus = [encode_packet(packet, model) for packet in packets]
    corpus += [bytes([kind]) + bytes(size) for kind in PacketType for size in (1, 7, 30, 120)]
    return Parser("robot to host", corpus, 1, seal_frames, take)


def laser_parser() -> Parser:
    """What a host does with a laser's bytes."""
    decoder = lms_framing.LmsTelegramDecoder(from_laser=True)

    def take(data: bytes) -> None:
        for event in decoder.receive(data, 0.0):
            if isinstance(event, lms_framing.LmsTelegram):
                for code in (lms.LmsAnswerCode.STATUS, lms.LmsAnswerCode.VARIANT):
                    with suppress(DecodeError):  # likewise
                        lms.Variant.read(code, event.data)
                with suppress(DecodeError):  # likewise
                    lms.LmsConfiguration.unpack(event.data)
                with suppress(DecodeError):  # likewise
                    scan = lms.Scan.read(event)
                    scan.ranges(1), scan.flags(1)

    values, configuration = bytes(2 * 61), lms.LmsConfiguration()
    contents = (
        (lms.LmsAnswerCode.SCAN, configuration.scan_data(values)),
        (lms.LmsAnswerCode.PARTIAL_SCAN, configuration.scan_data(values, 60)),
        (lms.LmsAnswerCode.STATUS, lms.VARIANTS[0].status_data(b"X1.27")),
        (lms.LmsAnswerCode.VARIANT, b"\1" + lms.VARIANTS[1].pack()),
        (lms.LmsAnswerCode.CONFIGURATION, lms.LmsConfiguration().pack()),
        (lms.LmsAnswerCode.MODE, bytes(1)),
    )
    telegrams = [lms_framing.encode(code, data, lms.STATUS_OK) for code, data in contents]
    return Parser("LMS to host", [telegram[:-2] for telegram in telegrams], 5, seal_telegrams, take)


def laser_host_parser() -> Parser:
    """What a laser does with a host's bytes."""
    decoder = lms_framing.LmsTelegramDecoder(from_laser=False)

    def take(data: bytes) -> None:
        for event in decoder.receive(data, 0.0):
            if isinstance(event, lms_framing.LmsTelegram):
                lms.read_segment(event.data)
                with suppress(DecodeError):  # likewise
                    lms.LmsConfiguration.unpack(event.data)

    contents = (
        (lms.LmsRequestCode.MODE, bytes([lms.LmsMode.INSTALLATION]) + lms.PASSWORD),
        (lms.LmsRequestCode.MODE, bytes([lms.LmsMode.CONTINUOUS_PARTIAL]) + bytes.fromhex("3D 00 78 00")),
        (lms.LmsRequestCode.VARIANT, lms.VARIANTS[0].pack()),
        (lms.LmsRequestCode.SET_CONFIGURATION, lms.LmsConfiguration().pack()),
        (lms.LmsRequestCode.STATUS, b""),
    )
    telegrams = [lms_framing.encode(code, data) for code, data in contents]
    return Parser("host to LMS", [telegram[:-2] for telegram in telegrams], 5, seal_telegrams, take)


def visca_parser() -> Parser:
    """What either end of a VISCA line does with the other's bytes."""
    decoder = visca.ViscaDecoder()

    def take(data: bytes) -> None:
        for message in decoder.receive(data):
            message.reply(visca.ASK_DIRECTION)
            message.reply(visca.ASK_ZOOM)

    done = bytes([visca.COMPLETION])
    corpus = [
        visca.encode(visca.MOVE, 10, 10, 100, -50),
        visca.encode(visca.ZOOM_TO, 500),
        visca.encode(visca.POWER, visca.ON),
        visca.encode(visca.CLEAR, header=visca.BROADCAST),
        visca.encode(visca.ASK_DIRECTION),
        visca.encode(done + visca.pack_values(visca.ASK_DIRECTION, -300, 100)),
        visca.encode(done + visca.pack_values(visca.ASK_ZOOM, 512)),
        visca.encode(done),
    ]
    return Parser("VISCA", corpus, 1, as_it_is, take)


def canon_parser() -> Parser:
    """What either end of a VC-C4's line does with the other's bytes."""
    commands, answers = vcc4.Vcc4Decoder(from_head=False), vcc4.Vcc4Decoder(from_head=True)

    def take(data: bytes) -> None:
        for frame in commands.receive(data) + answers.receive(data):
            vcc4.read_counts(Code.DIRECTION, frame.data)
            vcc4.read_counts(Code.ZOOM_REQUEST, frame.data)

    corpus = [
        vcc4.encode_command(Code.MOVE, (100, -50)),
        vcc4.encode_command(Code.ZOOM, (20,)),
        vcc4.encode_command(Code.POWER, vcc4.ON),
        vcc4.encode_command(Code.DIRECTION),
        vcc4.encode_answer(vcc4.Status.OK, vcc4.pack_counts(Code.DIRECTION, 300, -200)),
        vcc4.encode_answer(vcc4.Status.OK),
        vcc4.encode_answer(vcc4.Status.BUSY),
    ]
    return Parser("VC-C4", corpus, 3, as_it_is, take)


def seal_frames(contents: Bytes) -> Bytes:
    """Sync bytes, count and checksum of many payloads of one length."""
    rows, size = contents.shape
    frames = np.empty((rows, size + 5), np.uint8)
    frames[:, :3] = 0xFA, 0xFB, size + 2
    frames[:, 3:-2] = contents
    pairs = contents[:, : size // 2 * 2].astype(np.uint32)
    total = pairs[:, ::2].sum(axis=1) * 256 + pairs[:, 1::2].sum(axis=1) & 0xFFFF
    if size % 2:
        total ^= contents[:, -1]
    frames[:, -2], frames[:, -1] = total >> 8, total & 0xFF
    return frames


def seal_telegrams(contents: Bytes) -> Bytes:
    """The CRC behind many telegrams of one length."""
    register = np.zeros(len(contents), np.uint32)
    before = np.zeros(len(contents), np.uint32)
    for column in contents.T.astype(np.uint32):
        register = np.where(register & 0x8000, (register & 0x7FFF) << 1 ^ 0x8005, register << 1) ^ (
            column | before << 8
        )
        before = column
    return np.column_stack([contents, register & 0xFF, register >> 8]).astype(np.uint8)


def as_it_is(contents: Bytes) -> Bytes:
    """Where nothing seals a message."""
    return contents


PARSERS: Sequence[MakeParser] = (robot_parser, host_parser, laser_parser, laser_host_parser, visca_parser, canon_parser)
"""Each from nothing."""
