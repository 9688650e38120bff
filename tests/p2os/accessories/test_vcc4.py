import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os.accessories import vcc4
from p2os.accessories.vcc4 import Code, HeadFrame, Status, Vcc4Decoder

# Source: fact sheet of accessories, section 3: FF 30 30 00, code, parameters, EF. Computed, not captured.
COMMANDS = [
    ("FF 30 30 00 A0 31 EF", vcc4.encode_command(Code.POWER, vcc4.ON)),
    ("FF 30 30 00 A0 30 EF", vcc4.encode_command(Code.POWER, vcc4.OFF)),
    ("FF 30 30 00 90 30 EF", vcc4.encode_command(Code.CONTROL_MODE, vcc4.HOST_CONTROL)),
    ("FF 30 30 00 58 30 EF", vcc4.encode_command(Code.INITIALISE, vcc4.START)),
    ("FF 30 30 00 50 33 32 30 EF", vcc4.encode_command(Code.PAN_SLEW, (800,))),  # 0x320: 90 degrees/s
    ("FF 30 30 00 51 32 39 36 EF", vcc4.encode_command(Code.TILT_SLEW, (662,))),  # 0x296
    (
        "FF 30 30 00 64 31 37 45 46 35 38 33 31 36 EF",
        vcc4.encode_command(Code.TILT_RANGE, (-267, 790)),
    ),  # 0x7EF5, 0x8316
    ("FF 30 30 00 62 38 30 30 30 38 30 30 30 EF", vcc4.encode_command(Code.MOVE, (0, 0))),  # 0x8000 is straight ahead
    (
        "FF 30 30 00 62 38 31 39 30 37 46 30 42 EF",
        vcc4.encode_command(Code.MOVE, (400, -245)),
    ),  # 45 degrees right, 27.6 down
    ("FF 30 30 00 63 EF", vcc4.encode_command(Code.DIRECTION)),
    ("FF 30 30 00 53 30 EF", vcc4.encode_command(Code.STOP, vcc4.START)),
    ("FF 30 30 00 B3 30 37 41 38 EF", vcc4.encode_command(Code.ZOOM, (1960,))),
    ("FF 30 30 00 B4 30 EF", vcc4.encode_command(Code.ZOOM_REQUEST, vcc4.START)),
    ("FF 30 30 00 A2 30 EF", vcc4.encode_command(Code.STOP_ZOOM, vcc4.START)),
]
ANSWERS = [
    ("FE 30 30 30 30 EF", HeadFrame(Status.OK, b"")),
    ("FE 30 30 31 30 EF", HeadFrame(Status.BUSY, b"")),
    ("FE 30 30 35 30 EF", HeadFrame(Status.BAD_PARAMETER, b"")),
    ("FE 30 30 39 30 EF", HeadFrame(Status.NOT_HOST_CONTROLLED, b"")),
    ("FE 30 30 30 30 38 31 39 30 37 46 30 42 EF", HeadFrame(Status.OK, vcc4.pack_counts(Code.DIRECTION, 400, -245))),
    ("FE 30 30 30 30 30 37 41 38 EF", HeadFrame(Status.OK, b"07A8")),
]


@pytest.mark.parametrize(("golden", "built"), COMMANDS)
def test_command_is_built_as_the_sheet_has_it_and_read_back(golden: str, built: bytes) -> None:
    assert built == bytes.fromhex(golden)
    [command] = Vcc4Decoder(from_head=False).receive(built)
    assert vcc4.encode_command(*command) == built


@pytest.mark.parametrize(("golden", "answer"), ANSWERS)
def test_answer_is_read_as_the_sheet_has_it_and_built_back(golden: str, answer: HeadFrame) -> None:
    assert Vcc4Decoder(from_head=True).receive(bytes.fromhex(golden)) == [answer]
    assert vcc4.encode_answer(*answer) == bytes.fromhex(golden)


def test_answers_have_the_lengths_that_clients_ask_for() -> None:
    assert len(vcc4.encode_answer(Status.OK)) == vcc4.PLAIN_LENGTH == 6
    assert len(vcc4.encode_answer(Status.OK, vcc4.pack_counts(Code.DIRECTION, 0, 0))) == vcc4.DIRECTION_LENGTH == 14
    assert len(vcc4.encode_answer(Status.OK, vcc4.pack_counts(Code.ZOOM_REQUEST, 0))) == vcc4.ZOOM_LENGTH == 10


def test_noise_between_frames_is_passed_over() -> None:
    stream = (
        b"\x00\xff\xef30"
        + vcc4.encode_command(Code.POWER, vcc4.ON)
        + b"\xff00"
        + vcc4.encode_command(Code.STOP, vcc4.START)
        + b"\xff"
        + bytes(100)
        + vcc4.encode_command(Code.INITIALISE, vcc4.START)
    )
    commands = Vcc4Decoder(from_head=False).receive(stream)
    assert [command.kind for command in commands] == [Code.POWER, Code.STOP, Code.INITIALISE]


@given(st.lists(st.sampled_from([bytes.fromhex(each) for each, _ in COMMANDS]) | st.binary(max_size=30)), st.data())
def test_any_splitting_of_a_stream_gives_the_same_commands(pieces: list[bytes], data: st.DataObject) -> None:
    stream = b"".join(pieces)
    cut = data.draw(st.integers(0, len(stream)))
    whole, parts = Vcc4Decoder(from_head=False), Vcc4Decoder(from_head=False)
    assert whole.receive(stream) == parts.receive(stream[:cut]) + parts.receive(stream[cut:])


@given(st.integers(-0x8000, 0x7FFF), st.integers(-0x8000, 0x7FFF))
def test_pair_of_counts_survives_the_wire(pan: int, tilt: int) -> None:
    [command] = Vcc4Decoder(from_head=False).receive(vcc4.encode_command(Code.MOVE, (pan, tilt)))
    assert command == HeadFrame(Code.MOVE, vcc4.pack_counts(Code.DIRECTION, pan, tilt))
    assert vcc4.read_counts(Code.MOVE, command.data) == (pan, tilt)


@pytest.mark.parametrize("data", [b"", b"8000", b"8000800", b"80008G00", b" 800+800", b"800080000"])
def test_what_is_no_pair_of_numbers_is_none(data: bytes) -> None:
    assert vcc4.read_counts(Code.DIRECTION, data) is None


def test_number_that_does_not_fit_its_digits_is_refused() -> None:
    with pytest.raises(ValueError, match="4096 does not fit 3"):
        vcc4.encode_command(Code.PAN_SLEW, (4096,))
