from math import degrees, pi, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os import COMMANDS, Argument, Command, CommandValue, EncodeError, ReceivedCommand, decode_command, encode_command
from p2os.fields import FIXED_SCALES, Quantity

# Source: transcripts of existing clients; wire bytes, command, value in SI.
GOLDEN = [
    ("FA FB 03  00  00 00", Command.PULSE, None),
    ("FA FB 03  01  00 01", Command.OPEN, None),
    ("FA FB 03  02  00 02", Command.CLOSE, None),
    ("FA FB 06  28 3B 02 00  2A 3B", Command.IOREQUEST, 2),
    ("FA FB 06  32 3B 02 00  34 3B", Command.HOSTBAUD, 2),  # code 2: 38400
    ("FA FB 06  3E 3B 01 00  3F 3B", Command.BATTERYINFO, 1),
    ("FA FB 06  1C 3B 00 00  1C 3B", Command.SONAR, 0),
    ("FA FB 06  04 3B 01 00  05 3B", Command.ENABLE, 1),
    ("FA FB 06  0B 3B C8 00  D3 3B", Command.VEL, 0.2),  # 0x3B: positive argument
    ("FA FB 06  0B 1B C8 00  D3 1B", Command.VEL, -0.2),  # 0x1B: magnitude of a negative one
    ("FA FB 06  15 3B 1E 00  33 3B", Command.RVEL, radians(30)),
    ("FA FB 06  15 1B 1E 00  33 1B", Command.RVEL, radians(-30)),
    ("FA FB 06  20 3B 0A 0A  2A 45", Command.VEL2, (10, 10)),
    ("FA FB 06  20 3B FB 0A  1B 45", Command.VEL2, (10, 0xFB)),  # left 10, right -5
    ("FA FB 03  1D  00 1D", Command.STOP, None),
    ("FA FB 06  2B 3B 00 00  2B 3B", Command.GETAUX, 0),
    ("FA FB 0C  2A 2B 07 FF 30 30 00 A0 31 EF  94 E9", Command.TTY2, bytes.fromhex("FF 30 30 00 A0 31 EF")),
    ("FA FB 06  2B 3B 06 00  31 3B", Command.GETAUX, 6),
]

# Source: the same, and what the protocol description says that robots must bear; payload, command, value in SI.
TOLERATED = [
    ("01 3B 01 00", Command.OPEN, None),  # OPEN with an argument
    ("02 3B 01 00", Command.CLOSE, None),
    ("12 3B 01 00", Command.CONFIG, None),
    ("07 3B", Command.SETO, None),  # a type and no value
    ("0B", Command.VEL, 0.0),  # no argument at all
    ("0B 3B", Command.VEL, 0.0),
    ("0B 3B C8", Command.VEL, 0.2),  # half of one
    ("0B 1B C8 00 FF FF", Command.VEL, -0.2),  # more than one
    ("0B 3B 38 FF", Command.VEL, -0.2),  # two's complement under the positive type: a C library of 2024 for the P3-DX
    ("0B 1B 38 FF", Command.VEL, 0.2),  # and under the negative one: a probe in Python of 2025; MobileSim reads it so
    ("04 1B 01 00", Command.ENABLE, -1),  # 1 under the negative type: the same C library
    ("2B 3B FF FF", Command.GETAUX, 0xFFFF),  # what has no sign keeps its range
    ("2A 2B 03 61 62 63 00", Command.TTY2, b"abc"),  # a NUL behind the counted characters
    ("2A 2B 09 61 62 63", Command.TTY2, b"abc"),  # a length that lies
    ("2A 2B", Command.TTY2, b""),
    ("2A", Command.TTY2, b""),
    ("03 2B 00", Command.POLLING, b""),
    ("20 3B FB 0A", Command.VEL2, (10, 0xFB)),
    ("20 1B 05 00", Command.VEL2, (0xFF, 0xFB)),  # -5 in two's complement is FF FB
    ("20 1B F6 09", Command.VEL2, (0xF6, 0x0A)),  # left -10, right 10: -2550 is F6 0A
    ("20", Command.VEL2, (0, 0)),
    ("E0 00 01 00 00 00", Command.SIM_SET_POSE, bytes([1, 0, 0, 0])),
]


def wire(text: str) -> bytes:
    return bytes.fromhex(text)


def near(value: CommandValue | None) -> object:
    return pytest.approx(value) if isinstance(value, float) else value


@pytest.mark.parametrize(("frame", "command", "value"), GOLDEN)
def test_commands_are_written_as_existing_clients_do(frame: str, command: Command, value: CommandValue | None) -> None:
    assert encode_command(command, value) == wire(frame)


@pytest.mark.parametrize(("frame", "command", "value"), GOLDEN)
def test_commands_of_existing_clients_are_read(frame: str, command: Command, value: CommandValue | None) -> None:
    assert decode_command(wire(frame)[3:-2]) == (command, command, near(value))


@pytest.mark.parametrize(("payload", "command", "value"), TOLERATED)
def test_odd_arguments_are_read_as_robots_do(payload: str, command: Command, value: CommandValue | None) -> None:
    assert decode_command(wire(payload)) == (command, command, near(value))


def test_polling_carries_sonar_numbers() -> None:
    assert encode_command(Command.POLLING, b"12345678")[3:] == wire("03 2B 08 31 32 33 34 35 36 37 38 A7 C3")


def test_an_unknown_command_is_told_by_its_number() -> None:
    assert decode_command(b"\xc7\x3b\x01\x00") == ReceivedCommand(0xC7, None, None)


def test_signed_bytes_are_written_in_twos_complement() -> None:
    assert encode_command(Command.VEL2, (-10, 10)) == encode_command(Command.VEL2, (0xF6, 0x0A))


@pytest.mark.parametrize(
    ("command", "value", "message"),
    [
        (Command.VEL, 70.0, "speed 70.0 m/s does not fit VEL, which carries at most 32.767 m/s"),
        (Command.SETA, -66.0, "acceleration -66.0 m/s² does not fit SETA, which carries at most 32.767 m/s²"),
        (Command.HEAD, float("nan"), "angle nan rad does not fit HEAD"),
        (Command.MOVE, float("inf"), "length inf m does not fit MOVE"),
        (Command.GETAUX, -1, "count -1 does not fit GETAUX, which carries at most 65535, none below zero"),
        (Command.STOP, 1, "STOP takes no argument, not 1"),
        (Command.VEL, None, "VEL takes an int, not None"),
        (Command.VEL, b"1", "VEL takes an int, not b'1'"),
        (Command.VEL2, 5, "VEL2 takes two bytes, not 5"),
        (Command.VEL2, (256, 0), "bytes 256, 0 do not fit VEL2"),
        (Command.TTY2, bytes(197), "string of 197 bytes does not fit TTY2, which carries at most 196"),
        (Command.SIM_CTRL, bytes(249), "raw data of 249 bytes does not fit SIM_CTRL, which carries at most 248"),
    ],
)
def test_a_value_that_does_not_fit_is_refused_in_a_sentence(
    command: Command, value: CommandValue | None, message: str
) -> None:
    with pytest.raises(EncodeError) as caught:
        encode_command(command, value)
    assert str(caught.value).startswith(message)


def test_every_command_has_a_row_and_every_row_a_command() -> None:
    assert set(COMMANDS) == {command.value for command in Command}
    assert all(command.value == number for number, command in COMMANDS.items())


def test_the_table_names_all_numbers_of_the_command_list() -> None:
    listed = {*range(16), 17, *range(18, 24), 26, *range(28, 34), *range(35, 54), *range(55, 94), *range(95, 99), 110}
    listed |= {113, 120, *range(123, 130), 149, 150, *range(210, 221), *range(224, 227), *range(230, 234)}
    listed |= {*range(236, 240), *range(250, 254), 255}
    assert set(COMMANDS) == listed


INTS = [command for command in COMMANDS.values() if command.argument in (Argument.INT, Argument.UINT)]


@given(st.sampled_from(INTS), st.integers(-32767, 32767))
def test_ints_come_back_within_one_count(command: Command, count: int) -> None:
    if command.argument is Argument.UINT:
        count = 2 * abs(count)
    scale = FIXED_SCALES[command.quantity]
    value = count if command.quantity is Quantity.COUNT else count * scale
    received = decode_command(encode_command(command, value)[3:-2])
    assert isinstance(received.value, int | float)
    assert received.value == pytest.approx(value, abs=scale / 2)


@given(
    st.sampled_from([command for command in COMMANDS.values() if command.argument is Argument.STRING]),
    st.binary(max_size=196),
)
def test_strings_come_back(command: Command, text: bytes) -> None:
    assert decode_command(encode_command(command, text)[3:-2]).value == text


@given(
    st.sampled_from([command for command in COMMANDS.values() if command.argument is Argument.DATA]),
    st.binary(max_size=200),
)
def test_raw_data_comes_back(command: Command, data: bytes) -> None:
    assert decode_command(encode_command(command, data)[3:-2]).value == data


@given(st.integers(0, 255), st.integers(0, 255))
def test_two_bytes_come_back(high: int, low: int) -> None:
    assert decode_command(encode_command(Command.DIGOUT, (high, low))[3:-2]).value == (high, low)


@given(st.integers(0, 255), st.integers(0, 255))
def test_two_bytes_through_a_signed_int_come_back(high: int, low: int) -> None:
    # The client library at fault hands the 16-bit number to its signed encoder.
    number = high << 8 | low
    signed = number - 65536 if number >= 32768 else number
    argument = bytes([0x1B if signed < 0 else 0x3B]) + abs(signed).to_bytes(2, "little")
    assert decode_command(bytes([Command.VEL2]) + argument).value == (high, low)


@given(st.binary(max_size=255))
def test_no_payload_makes_the_reader_fail(payload: bytes) -> None:
    received = decode_command(payload)
    assert received.number == (payload[0] if payload else 0)


def test_angles_are_degrees_on_the_wire() -> None:
    assert encode_command(Command.HEAD, pi / 2)[3:-2] == wire("0C 3B 5A 00")
    value = decode_command(wire("0C 1B B4 00")).value
    assert isinstance(value, float)
    assert degrees(value) == pytest.approx(-180)


@pytest.mark.parametrize(
    ("given", "meant"), [("VEL", r"'VEL' is not a command; give Command\.VEL"), (9999, "a member of Command")]
)
def test_what_is_no_command_is_told_what_to_give(given: object, meant: str) -> None:
    with pytest.raises(EncodeError, match=meant):
        encode_command(given, 1)  # type: ignore[arg-type]  # as somebody without a type checker may do
