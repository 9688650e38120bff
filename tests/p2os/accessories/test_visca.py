import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os.accessories import visca
from p2os.accessories.visca import ViscaDecoder, ViscaMessage

# Source: fact sheet of accessories, section 3. Computed, not captured.
MESSAGES = [
    ("88 01 00 01 FF", visca.encode(visca.CLEAR, header=visca.BROADCAST)),
    ("88 30 01 FF", visca.encode(visca.SET_ADDRESS, header=visca.BROADCAST)),
    ("81 01 04 00 02 FF", visca.encode(visca.POWER, visca.ON)),
    ("81 01 04 00 03 FF", visca.encode(visca.POWER, visca.OFF)),
    ("81 01 06 02 18 14 00 03 07 00 0F 0E 0D 04 FF", visca.encode(visca.MOVE, 0x18, 0x14, 0x370, -0x12C)),
    ("81 01 06 01 18 14 03 03 FF", visca.encode(visca.DRIVE, 0x18, 0x14, visca.STAY, visca.STAY)),
    ("81 01 04 47 00 03 0F 0F FF", visca.encode(visca.ZOOM_TO, 0x3FF)),
    ("81 01 04 07 00 FF", visca.encode(visca.ZOOM_DRIVE, visca.ZOOM_STOP)),
    ("81 09 04 00 FF", visca.encode(visca.ASK_POWER)),
    ("81 09 06 12 FF", visca.encode(visca.ASK_DIRECTION)),
    ("81 09 04 47 FF", visca.encode(visca.ASK_ZOOM)),
]


@pytest.mark.parametrize(("golden", "built"), MESSAGES)
def test_message_is_built_as_the_sheet_has_it_and_read_back(golden: str, built: bytes) -> None:
    assert built == bytes.fromhex(golden)
    [message] = ViscaDecoder().receive(built)
    assert visca.encode(message.payload, header=message.header) == built


def test_replies_are_read() -> None:
    direction = bytes.fromhex("90 50 0F 0C 09 00 01 02 0C 00 FF")
    [message] = ViscaDecoder().receive(direction)
    assert message.header == visca.FROM_CAMERA
    assert message.reply(visca.ASK_DIRECTION) == (-0x370, 0x12C0)
    [zoom] = ViscaDecoder().receive(bytes.fromhex("90 50 00 03 0F 0F FF"))
    assert zoom.reply(visca.ASK_ZOOM) == (0x3FF,)
    assert message.reply(visca.ASK_ZOOM) is None
    assert zoom.reply(visca.ASK_DIRECTION) is None


@pytest.mark.parametrize("payload", ["41", "51", "60 41", "50", "50 00 03 0F 1F", "51 00 03 0F 0F"])
def test_other_replies_are_no_position(payload: str) -> None:
    message = ViscaMessage(visca.FROM_CAMERA, bytes.fromhex(payload))
    assert message.reply(visca.ASK_ZOOM) is None
    assert message.reply(visca.ASK_DIRECTION) is None


def test_noise_is_passed_over_and_a_header_begins_anew() -> None:
    stream = (
        b"\xff\xff00\x00c\xef"
        + visca.encode(visca.SET_ADDRESS, header=visca.BROADCAST)
        + b"\x81\x01"
        + visca.encode(visca.POWER, visca.ON)
        + b"\x81"
        + bytes(40)
    )
    found = ViscaDecoder().receive(stream + visca.encode(visca.ASK_ZOOM))
    assert [visca.encode(each.payload, header=each.header) for each in found] == [
        visca.encode(visca.SET_ADDRESS, header=visca.BROADCAST),
        visca.encode(visca.POWER, visca.ON),
        visca.encode(visca.ASK_ZOOM),
    ]


@given(st.integers(-0x8000, 0x7FFF))
def test_number_survives_its_nibbles(value: int) -> None:
    assert visca.read_values(visca.ZOOM_TO, visca.pack_values(visca.ZOOM_TO, value)) == (value,)


@given(st.binary(max_size=200), st.integers(0, 200))
def test_any_splitting_of_a_stream_gives_the_same_messages(stream: bytes, cut: int) -> None:
    whole, parts = ViscaDecoder(), ViscaDecoder()
    found = whole.receive(stream)
    assert found == parts.receive(stream[:cut]) + parts.receive(stream[cut:])
    assert all(isinstance(each, ViscaMessage) and 1 <= len(each.payload) <= visca.LONGEST for each in found)
