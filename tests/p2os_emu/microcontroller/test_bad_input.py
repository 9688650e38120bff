"""Whatever comes in, the firmware goes on; and the same input gives the same output, bit by bit."""

from collections.abc import Callable

from hypothesis import given, settings
from hypothesis import strategies as st

from p2os.command_table import COMMANDS, Command
from p2os.commands import encode_command
from p2os.configuration import Configuration
from p2os.framing import encode_frame
from p2os.packets import PacketType
from p2os.sip import StandardSip
from p2os_emu.microcontroller import EMULATED, EMULATED_PACKETS
from tests.p2os_emu.microcontroller.bench import STEP, MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]

SILENCING = (Command.CLOSE, Command.RESET, Command.MAINTENANCE)
payloads = st.binary(min_size=1, max_size=40).filter(lambda payload: payload[0] not in SILENCING)


@settings(max_examples=50, deadline=None)
@given(data=st.binary(max_size=300))
def test_random_bytes_do_not_keep_a_client_from_connecting(data: bytes, bench_of: BenchOf) -> None:
    robot = bench_of("p3dx-sh")
    robot.controller.receive(data)
    robot.run(0.25)  # a frame begun inside the noise is given up after 0.1 s
    assert robot.connect().controller.connected


@settings(max_examples=50, deadline=None)
@given(commands=st.lists(payloads, max_size=40))
def test_any_sound_frames_leave_a_robot_that_sends_sips(commands: list[bytes], bench_of: BenchOf) -> None:
    robot = bench_of("powerbot-sh").connect(motors=True)
    for payload in commands:
        robot.controller.receive(encode_frame(payload))
        robot.run(STEP)
    assert any(isinstance(sent.packet, StandardSip) for sent in robot.run(0.3))


def test_every_value_of_every_command_leaves_the_configuration_to_be_told(bench_of: BenchOf) -> None:
    robot = bench_of("powerbot-sh").connect()
    for number in set(range(256)) - set(SILENCING):
        for argument in (b"", *(bytes((kind, 0xFF, 0xFF)) for kind in (0x3B, 0x1B)), b"\x2b\x02\xff\xff"):
            robot.controller.receive(encode_frame(bytes((number,)) + argument))
            robot.run(STEP)
    robot.send(Command.CONFIG)
    assert any(isinstance(sent.packet, Configuration) for sent in robot.run(0.3))


@settings(max_examples=20, deadline=None)
@given(cuts=st.lists(st.integers(1, 12), min_size=1, max_size=30))
def test_how_the_stream_is_cut_does_not_matter(cuts: list[int], bench_of: BenchOf) -> None:
    stream = b"".join(encode_command(Command.VEL, n / 100) for n in range(1, 6))
    robot = bench_of("p3dx-sh").connect(motors=True)
    pieces = iter(cuts * len(stream))
    while stream:
        size = next(pieces)
        robot.controller.receive(stream[:size])
        stream = stream[size:]
        robot.run(STEP)
    robot.run(2.0)
    assert round(robot.body.velocity, 6) == 0.05


def test_every_corruption_of_one_byte_of_a_command_is_refused(robot: MicrocontrollerBench) -> None:
    frame = encode_command(Command.VEL, 0.3)
    for place in range(len(frame)):
        for flip in (0x01, 0x80, 0xFF):
            damaged = bytearray(frame)
            damaged[place] ^= flip
            robot.controller.receive(bytes(damaged))
            robot.run(0.15)
    assert robot.body.travel == 0.0


def test_the_same_bytes_at_the_same_steps_give_identical_output(bench_of: BenchOf) -> None:
    def drive() -> bytes:
        robot = bench_of("powerbot-sh", seed=7).connect(motors=True)
        out = bytearray()
        for step in range(2400):
            if step % 90 == 0:
                robot.send(Command.VEL, 0.1 + step / 10000)
                robot.send(Command.HEAD, step / 500)
            out += robot.step()
        return bytes(out)

    assert drive() == drive()


def test_the_seed_decides_only_what_chance_would(bench_of: BenchOf) -> None:
    first, second = (bench_of("powerbot-sh", seed=seed).connect().sip() for seed in (1, 2))
    assert first.battery_fine != second.battery_fine
    assert first._replace(battery=0, battery_fine=0) == second._replace(battery=0, battery_fine=0)


def test_what_is_emulated_is_known() -> None:
    assert COMMANDS.keys() >= EMULATED
    assert {Command.OPEN, Command.VEL, Command.HOSTBAUD} <= EMULATED
    assert Command.SRECORD not in EMULATED
    assert {PacketType.SIP_MOVING, PacketType.CONFIGURATION, PacketType.RESET} <= EMULATED_PACKETS
