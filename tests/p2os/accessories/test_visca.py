import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os.accessories import visca
from p2os.accessories.visca import ViscaDecoder, ViscaMessage

# Source: fact sheet of accessories, section 3. Computed, not captured.
MESSAGES = [
    ("88 01 00 01 FF", visca.clear()),
    ("88 30 01 FF", visca.set_address()),
    ("81 01 04 00 02 FF", visca.power(True)),
    ("81 01 04 00 03 FF", visca.power(False)),
    ("81 01 06 02 18 14 00 03 07 00 0F 0E 0D 04 FF", visca.move(0x370, -0x12C, 0x18, 0x14)),
    ("81 01 06 01 18 14 03 03 FF", visca.stop(0x18, 0x14)),
    ("81 01 04 47 00 03 0F 0F FF", visca.zoom(0x3FF)),
    ("81 01 04 07 00 FF", visca.stop_zoom()),
    ("81 09 04 00 FF", visca.request_power()),
    ("81 09 06 12 FF", visca.request_direction()),
    ("81 09 04 47 FF", visca.request_zoom()),
]


@pytest.mark.parametrize(("golden", "built"), MESSAGES)
def test_message_is_built_as_the_sheet_has_it_and_read_back(golden: str, built: bytes) -> None:
    assert built == bytes.fromhex(golden)
    [message] = ViscaDecoder().receive(built)
    assert visca.encode(message.payload, message.header) == built


def test_replies_are_read() -> None:
    direction = bytes.fromhex("90 50 0F 0C 09 00 01 02 0C 00 FF")
    [message] = ViscaDecoder().receive(direction)
    assert message.header == visca.reply_header(visca.CAMERA)
    assert visca.read_direction(message.payload) == (-0x370, 0x12C0)
    [zoom] = ViscaDecoder().receive(bytes.fromhex("90 50 00 03 0F 0F FF"))
    assert visca.read_zoom(zoom.payload) == 0x3FF
    assert visca.read_zoom(message.payload) is None
    assert visca.read_direction(zoom.payload) is None


@pytest.mark.parametrize("payload", ["41", "51", "60 41", "50", "50 00 03 0F 1F", "51 00 03 0F 0F"])
def test_other_replies_are_no_position(payload: str) -> None:
    assert visca.read_zoom(bytes.fromhex(payload)) is None
    assert visca.read_direction(bytes.fromhex(payload)) is None


def test_noise_is_passed_over_and_a_header_begins_anew() -> None:
    stream = b"\xff\xff00\x00c\xef" + visca.set_address() + b"\x81\x01" + visca.power(True) + b"\x81" + bytes(40)
    found = ViscaDecoder().receive(stream + visca.request_zoom())
    assert [visca.encode(each.payload, each.header) for each in found] == [
        visca.set_address(),
        visca.power(True),
        visca.request_zoom(),
    ]


@given(st.integers(-0x8000, 0x7FFF))
def test_number_survives_its_nibbles(value: int) -> None:
    assert visca.number(visca.nibbles(value)) == value


@given(st.binary(max_size=200), st.integers(0, 200))
def test_any_splitting_of_a_stream_gives_the_same_messages(stream: bytes, cut: int) -> None:
    whole, parts = ViscaDecoder(), ViscaDecoder()
    found = whole.receive(stream)
    assert found == parts.receive(stream[:cut]) + parts.receive(stream[cut:])
    assert all(isinstance(each, ViscaMessage) and 1 <= len(each.payload) <= visca.LONGEST for each in found)
