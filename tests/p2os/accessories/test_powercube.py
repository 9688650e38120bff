"""Telegrams of PowerCube modules: golden bytes computed by hand from the codec's own description, and properties."""

from math import isfinite

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os import DecodeError, EncodeError
from p2os.accessories.powercube import (
    CubeCommand,
    CubeState,
    ModuleOutcome,
    ModuleParameter,
    ModuleReply,
    ModuleRequest,
    ModuleTelegram,
    ModuleTelegramDecoder,
    MotionKind,
)

REQUESTS = [  # header = identifier << 5 | length: 0E0 + module to one, 100 to all; then data, sum modulo 256
    ("02  1C 21  00  3D  03", 1, ModuleRequest(CubeCommand.RESET)),  # 1C + 21
    ("02  20 01  10 82  23  03", 0, ModuleRequest(CubeCommand.HALT)),  # to all; the 02 is stuffed
    ("02  1C 42  0A 3C  A4  03", 2, ModuleRequest(CubeCommand.GET, ModuleParameter.POSITION)),
    # 1.0 is 00 00 80 3F: 1C + 66 + 0B + 14 + 80 + 3F = 160
    ("02  1C 66  0B 14 00 00 80 3F  60  03", 3, ModuleRequest(CubeCommand.MOVE, MotionKind.RAMP_ACKNOWLEDGED, 1.0)),
    # 1.5 s are 1500 ms: DC 05
    (
        "02  1C 68  0B 16 00 00 80 3F DC 05  45  03",
        3,
        ModuleRequest(CubeCommand.MOVE, MotionKind.STEP_ACKNOWLEDGED, 1.0, 1.5),
    ),
    # -2.0 is 00 00 00 C0; module 16: 0F0 << 5 = 1E00
    ("02  1E 06  08 4F 00 00 00 C0  3B  03", 16, ModuleRequest(CubeCommand.SET, ModuleParameter.RAMP_VELOCITY, -2.0)),
]
REPLIES = [  # 0A0 + module
    ("02  14 22  01 64  9B  03", 1, ModuleReply(CubeCommand.HOME, outcome=ModuleOutcome.DONE)),
    ("02  14 26  0A 3C 00 00 80 3F  3F  03", 1, ModuleReply(CubeCommand.GET, ModuleParameter.POSITION, value=1.0)),
    (
        "02  14 E6  0A 27 12 00 00 00  3D  03",
        7,
        ModuleReply(CubeCommand.GET, ModuleParameter.STATE, state=CubeState.HOMED | CubeState.BRAKED),
    ),
    (
        "02  14 27  0B 14 00 00 80 3F 0A  23  03",
        1,
        ModuleReply(
            CubeCommand.MOVE, MotionKind.RAMP_ACKNOWLEDGED, value=1.0, state=CubeState.HOMED | CubeState.MOVING
        ),
    ),
    ("02  14 23  0B 04 65  AB  03", 1, ModuleReply(CubeCommand.MOVE, MotionKind.RAMP, ModuleOutcome.REFUSED)),
]

telegrams = st.builds(ModuleTelegram, st.integers(1, 31), st.booleans(), st.binary(max_size=8)) | st.builds(
    lambda data: ModuleTelegram(0, False, data), st.binary(max_size=8)
)


@pytest.mark.parametrize(("golden", "module", "request_"), REQUESTS)
def test_requests_are_written_and_read_as_computed_by_hand(golden: str, module: int, request_: ModuleRequest) -> None:
    wire = bytes.fromhex(golden)
    assert request_.encode(module) == wire
    (telegram,) = ModuleTelegramDecoder().receive(wire)
    assert telegram[:2] == (module, False)
    assert ModuleRequest.decode(telegram.data) == request_


@pytest.mark.parametrize(("golden", "module", "reply"), REPLIES)
def test_replies_are_written_and_read_as_computed_by_hand(golden: str, module: int, reply: ModuleReply) -> None:
    wire = bytes.fromhex(golden)
    assert reply.encode(module) == wire
    (telegram,) = ModuleTelegramDecoder().receive(wire)
    assert telegram[:2] == (module, True)
    assert ModuleReply.decode(telegram.data) == reply


@pytest.mark.parametrize(("plain", "stuffed"), [(0x02, "10 82"), (0x03, "10 83"), (0x10, "10 90")])
def test_framing_bytes_are_stuffed_as_the_sheet_says(plain: int, stuffed: str) -> None:
    assert bytes.fromhex(stuffed) in ModuleTelegram(1, False, bytes([plain])).encode()


@given(st.lists(telegrams, max_size=5), st.data())
def test_any_telegrams_come_through_however_the_stream_is_cut(sent: list[ModuleTelegram], data: st.DataObject) -> None:
    wire = b"".join(map(ModuleTelegram.encode, sent))
    cuts = sorted(data.draw(st.lists(st.integers(0, len(wire)), max_size=6)))
    decoder = ModuleTelegramDecoder()
    heard: list[ModuleTelegram] = []
    for start, end in zip([0, *cuts], [*cuts, len(wire)], strict=True):
        heard += decoder.receive(wire[start:end])
    assert heard == sent
    assert decoder.damaged == 0


@given(telegrams, st.data())
def test_no_telegram_with_one_wrong_byte_is_believed(sent: ModuleTelegram, data: st.DataObject) -> None:
    wire = bytearray(sent.encode())
    wire[data.draw(st.integers(0, len(wire) - 1))] ^= data.draw(st.integers(1, 255))
    assert ModuleTelegramDecoder().receive(bytes(wire)) == []


@given(st.binary(max_size=100), telegrams)
def test_telegram_is_found_behind_any_noise(noise: bytes, sent: ModuleTelegram) -> None:
    assert ModuleTelegramDecoder().receive(noise + sent.encode())[-1] == sent


@given(st.binary(max_size=8))
def test_any_data_is_read_or_refused(data: bytes) -> None:
    for read in (ModuleRequest.decode, ModuleReply.decode):
        try:
            read(data)
        except DecodeError:
            continue  # refused, as it may be


@given(st.floats(width=32).filter(isfinite), st.sampled_from([kind for kind in MotionKind if kind != 0x16]))
def test_targets_come_through_as_32_bits_carry_them(target: float, kind: MotionKind) -> None:
    request = ModuleRequest(CubeCommand.MOVE, kind, target)
    (telegram,) = ModuleTelegramDecoder().receive(request.encode(1))
    assert ModuleRequest.decode(telegram.data) == request


@pytest.mark.parametrize(
    ("module", "request_"),
    [
        (32, ModuleRequest(CubeCommand.HOME)),
        (-1, ModuleRequest(CubeCommand.HOME)),
        (1, ModuleRequest(CubeCommand.SET, ModuleParameter.RAMP_VELOCITY, 1e39)),
        (1, ModuleRequest(CubeCommand.MOVE, MotionKind.STEP_ACKNOWLEDGED, 1.0, 70.0)),
    ],
)
def test_what_does_not_fit_is_refused(module: int, request_: ModuleRequest) -> None:
    with pytest.raises(EncodeError):
        request_.encode(module)
