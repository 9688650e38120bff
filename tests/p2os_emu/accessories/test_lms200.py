"""The scanner before hosts that were written by others: their connect sequences, byte by byte, in virtual time."""

from math import inf, isinf, pi, radians

import numpy as np
import pytest

import configs
from p2os import LaserMount
from p2os.accessories.lms import (
    LmsAnswerCode,
    LmsConfiguration,
    LmsMode,
    LmsRequestCode,
    Scan,
    Variant,
)
from p2os.accessories.lms_framing import Acknowledged, LmsTelegram, LmsTelegramDecoder, encode
from p2os_emu.accessories.lms200 import Lms200, ScannerModel
from p2os_emu.body import Echoes, ScanBeams
from tests.p2os_emu.microcontroller.bench import STEP, PlainBody

FORWARD = LaserMount("lms2xx", 0.1, 0.0)
STOP, START = "02 00 02 00 20 25 35 08", "02 00 02 00 20 24 34 08"


class Room(PlainBody):
    """A body in the middle of a round room, whose wall reflects on the left side of the robot.

    radius: of the room, m. asked: the beams of every scan. cosines: of every wall.
    """

    def __init__(self) -> None:
        super().__init__()
        self.radius = 3.0
        self.cosine = 1.0
        self.asked: list[ScanBeams] = []

    def scan(self, beams: ScanBeams) -> Echoes:
        self.asked.append(beams)
        bearings = beams.first + beams.step * np.arange(beams.count)
        # A little farther with the bearing, so that the order shows.
        ranges = np.asarray(self.radius + 0.1 * bearings, np.float64)
        return Echoes(ranges, np.full(beams.count, self.cosine), bearings > 0.5)


class Stranger:
    """A host that knows bytes only; time is virtual, and its port has no rate."""

    def __init__(self, mount: LaserMount = FORWARD, **changes: object) -> None:
        table = configs.read(configs.find("accessories", "lms200"))
        self.room = Room()
        self.has_power = True
        self.laser = Lms200(
            configs.build(ScannerModel, {**table, **changes}, "test"), mount, self.room, lambda: self.has_power
        )
        self.now = 0.0
        self.heard = bytearray()
        self._decoder = LmsTelegramDecoder(from_laser=True)

    def run(self, seconds: float) -> list[LmsTelegram]:
        telegrams = []
        for _ in range(round(seconds / STEP)):
            self.now += STEP
            data = self.laser.step(STEP)
            self.heard += data
            telegrams += [event for event in self._decoder.receive(data, self.now) if isinstance(event, LmsTelegram)]
        return telegrams

    def ask(self, frame: str, wait: float = 0.2) -> list[LmsTelegram]:
        self.laser.receive(bytes.fromhex(frame))
        return self.run(wait)

    def tell(self, code: int, data: bytes = b"", wait: float = 0.2) -> list[LmsTelegram]:
        return self.ask(encode(code, data).hex(), wait)

    def scans(self, seconds: float) -> list[Scan]:
        return [
            Scan.read(each)
            for each in self.run(seconds)
            if each.code in (LmsAnswerCode.SCAN, LmsAnswerCode.PARTIAL_SCAN)
        ]


@pytest.fixture
def stranger() -> Stranger:
    host = Stranger()
    host.run(0.1)
    return host


def codes(telegrams: list[LmsTelegram]) -> list[int]:
    return [telegram.code for telegram in telegrams]


def test_it_tells_its_type_when_it_has_power() -> None:
    (hello,) = Stranger().run(0.1)
    assert hello.code == 0x90
    assert b"LMS200" in hello.data


def test_it_boots_as_long_as_it_is_told_and_hears_nothing_meanwhile() -> None:
    host = Stranger(boot_s=2.0)
    assert host.ask(STOP, 1.9) == []
    assert codes(host.run(0.2)) == [0x90]
    assert codes(host.ask(STOP)) == [0xA0]


def test_without_power_it_is_deaf_and_dumb_and_then_as_after_the_power_switch() -> None:
    host = Stranger()
    host.run(0.1)
    host.ask("02 00 02 00 20 40 50 08")
    host.ask(START)
    host.has_power = False
    assert host.ask(STOP, 1.0) == []
    host.has_power = True
    assert codes(host.run(1.0)) == [0x90]
    assert host.laser.baud == 9600


def test_arias_connect_sequence_ends_in_scans(stranger: Stranger) -> None:
    """Source: accessory sheet, section 1, ARIA connect sequence; the frames are those of the sheet."""
    stranger.laser.receive(bytes.fromhex("02 00 02 00 20 40 50 08"))
    stranger.run(0.4)  # it does not wait for the answer
    assert stranger.laser.baud == 38400
    (variant,) = stranger.ask("02 00 05 00 3B B4 00 00 00 5F 2D")  # its resolution of zero
    assert (variant.code, variant.data) == (0xBB, bytes.fromhex("01 B4 00 64 00"))
    (installed,) = stranger.ask("02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5")
    assert (installed.code, installed.data) == (0xA0, b"\0")
    configured = stranger.tell(0x77, bytes.fromhex("00 00 46 00 00 05 01 00 00 02 02") + bytes(21))
    assert codes(configured) == [0xF7]
    started = stranger.ask(START)
    assert (started[0].code, started[0].data) == (0xA0, b"\0")
    first = Scan.read(started[1])
    assert len(first.words) == 181
    assert first.ranges(1)[[0, 90, 180]] == pytest.approx([3.0 - 0.05 * pi, 3.0, 3.0 + 0.05 * pi], abs=0.001)
    assert codes(stranger.ask(STOP, 1.0))[-1] == 0xA0
    stranger.ask("02 00 02 00 20 42 52 08")
    assert stranger.laser.baud == 9600


def test_players_connect_sequence_ends_in_scans(stranger: Stranger) -> None:
    """Source: accessory sheet, section 1, Player's connect sequence."""
    (silent,) = stranger.ask(STOP)
    assert silent.code == 0xA0
    assert codes(stranger.ask("02 00 02 00 20 48 58 08")) == [0xA0]
    assert stranger.laser.baud == 500000
    (kind,) = stranger.ask("02 00 01 00 3A 1E 12")
    assert kind.code == 0xBA
    assert codes(stranger.ask("02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5")) == [0xA0]
    (status,) = stranger.ask("02 00 01 00 31 15 12")
    whole = bytes((status.code,)) + status.data
    assert len(status.data) >= 111
    assert whole[107:111] == bytes.fromhex("B4 00 64 00")
    (variant,) = stranger.ask("02 00 05 00 3B B4 00 32 00 3B 1F")
    assert variant.data == bytes.fromhex("01 B4 00 32 00")
    (configuration,) = stranger.ask("02 00 01 00 74 50 12")
    edited = bytearray(bytes((0x77,)) + configuration.data[:7])
    edited[6:8] = bytes((1, 1))  # three reflector bits, millimetres
    assert codes(stranger.tell(edited[0], bytes(edited[1:]))) == [0xF7]
    assert stranger.laser.configuration == LmsConfiguration(measuring_mode=1)
    started = stranger.ask(START)
    assert codes(started)[:2] == [0xA0, 0xB0]
    scan = Scan.read(started[1])
    assert len(scan.words) == 361
    assert (scan.words[-1] & 0x1FFF) / 1000 == pytest.approx(3.0 + 0.05 * pi, abs=0.001)
    assert scan.words[-1] >> 13 == 7  # the wall on the left reflects
    assert scan.words[0] >> 13 == 0


def test_player_may_ask_for_a_part_of_the_beams(stranger: Stranger) -> None:
    stranger.tell(LmsRequestCode.MODE, bytes((LmsMode.CONTINUOUS_PARTIAL,)) + bytes.fromhex("2E 00 88 00"), wait=0.02)
    scan = stranger.scans(1.0)[0]
    assert (scan.first, len(scan.words)) == (45, 91)
    assert stranger.room.asked[-1].first == pytest.approx(-pi / 4)


@pytest.mark.parametrize(
    ("baud", "variant", "rate"),
    [
        (9600, Variant(180, 100), 2.6),
        (38400, Variant(180, 100), 9.9),
        (38400, Variant(180, 50), 5.1),
        (500000, Variant(180, 100), 55.7),
        (500000, Variant(180, 50), 32.0),
        (500000, Variant(100, 25), 17.2),
    ],
)
def test_scans_come_as_fast_as_mirror_and_line_allow(
    stranger: Stranger, baud: int, variant: Variant, rate: float
) -> None:
    mode = {9600: 0x42, 38400: 0x40, 500000: 0x48}[baud]
    stranger.tell(LmsRequestCode.MODE, bytes((mode,)))
    stranger.tell(LmsRequestCode.VARIANT, variant.pack())
    stranger.ask(START)
    assert len(stranger.scans(10.0)) / 10.0 == pytest.approx(rate, rel=0.03, abs=0.11)


def test_a_new_rate_holds_only_after_its_answer_has_left(stranger: Stranger) -> None:
    stranger.laser.receive(bytes.fromhex("02 00 02 00 20 40 50 08"))
    while not (answer := stranger.laser.step(STEP)):
        pass
    assert answer.startswith(b"\x06\x02")
    assert stranger.laser.baud == 9600
    stranger.run(len(answer) * 10 / 9600 + 2 * STEP)
    assert stranger.laser.baud == 38400


def test_an_answer_waits_for_the_end_of_the_scan_on_the_line(stranger: Stranger) -> None:
    stranger.ask(START, 0.1)
    assert codes(stranger.ask(STOP, 0.2)) == []
    assert codes(stranger.run(0.4)) == [0xA0]
    assert stranger.scans(1.0) == []


def test_a_wrong_password_opens_nothing(stranger: Stranger) -> None:
    (answer,) = stranger.tell(LmsRequestCode.MODE, b"\0SICK_PLS")
    assert answer.data == b"\1"
    assert codes(stranger.tell(LmsRequestCode.SET_CONFIGURATION, LmsConfiguration().pack())) == [0x92]


def test_scanning_again_ends_the_installation_mode(stranger: Stranger) -> None:
    stranger.tell(LmsRequestCode.MODE, b"\0SICK_LMS")
    stranger.ask(STOP)
    assert codes(stranger.tell(LmsRequestCode.SET_CONFIGURATION, LmsConfiguration().pack())) == [0x92]


@pytest.mark.parametrize("variant", [Variant(180, 25), Variant(90, 100), Variant(100, 10)])
def test_beams_that_it_does_not_have_are_refused(stranger: Stranger, variant: Variant) -> None:
    (answer,) = stranger.tell(LmsRequestCode.VARIANT, variant.pack())
    assert answer.data == b"\0" + Variant(180, 100).pack()


def test_a_zero_resolution_keeps_the_one_that_there_is(stranger: Stranger) -> None:
    stranger.tell(LmsRequestCode.VARIANT, Variant(180, 50).pack())
    (answer,) = stranger.tell(LmsRequestCode.VARIANT, Variant(180, 0).pack())
    assert answer.data == b"\1" + Variant(180, 50).pack()


def test_what_it_does_not_know_it_does_not_understand(stranger: Stranger) -> None:
    assert codes(stranger.tell(0x55)) == [0x92]
    assert stranger.tell(LmsRequestCode.MODE, b"\x99")[0].data == b"\2"


def test_a_damaged_command_is_answered_with_nak(stranger: Stranger) -> None:
    stranger.heard.clear()
    stranger.ask("02 00 02 00 20 25 35 09")
    assert stranger.heard == b"\x15"


def test_every_answer_is_acknowledged_first(stranger: Stranger) -> None:
    events = []
    stranger.laser.receive(bytes.fromhex(STOP))
    decoder = LmsTelegramDecoder(from_laser=True)
    for _ in range(10):
        events += decoder.receive(stranger.laser.step(STEP), 0.0)
    assert events[0] == Acknowledged(ok=True)


def test_reset_brings_back_the_state_after_the_power_switch(stranger: Stranger) -> None:
    stranger.ask("02 00 02 00 20 40 50 08")
    stranger.tell(LmsRequestCode.VARIANT, Variant(100, 25).pack())
    stranger.ask(START)
    assert codes(stranger.ask("02 00 01 00 10 34 12"))[-1] == 0x90
    assert (stranger.laser.baud, stranger.laser.variant) == (9600, Variant(180, 100))
    assert stranger.scans(1.0) == []


def test_a_flipped_scanner_sends_the_leftmost_beam_first() -> None:
    host = Stranger(LaserMount("lms2xx", 0.1, 0.0, flipped=True))
    host.run(0.1)
    host.ask(START, 0.02)
    ranges = host.scans(1.0)[0].ranges(1)
    assert ranges[0] == pytest.approx(3.0 + 0.05 * pi, abs=0.001)
    assert ranges[-1] == pytest.approx(3.0 - 0.05 * pi, abs=0.001)


def test_a_mount_that_looks_aside_turns_the_beams() -> None:
    host = Stranger(LaserMount("lms2xx", 0.1, 0.2, heading=radians(90)))
    host.run(0.1)
    host.ask(START, 1.0)
    beams = host.room.asked[0]
    assert (beams.x, beams.y) == (0.1, 0.2)
    assert beams.first == pytest.approx(0.0)


def test_walls_beyond_its_reach_give_no_distance(stranger: Stranger) -> None:
    stranger.room.radius = 31.0
    stranger.ask(START, 0.02)
    ranges = stranger.scans(1.0)[0].ranges(1)
    assert isinf(ranges[90])
    assert ranges[-1] == pytest.approx(31.0 + 0.05 * pi, abs=0.001)  # reflectors shine from farther


def test_walls_met_at_a_slant_give_no_distance_from_far(stranger: Stranger) -> None:
    stranger.room.radius, stranger.room.cosine = 4.0, 0.01
    stranger.ask(START, 0.02)
    assert np.all(np.isinf(stranger.scans(1.0)[0].ranges(1)))


def test_a_dirty_window_takes_reach_and_is_told(stranger: Stranger) -> None:
    stranger.room.radius = 20.0
    stranger.laser.dirt = 0.5
    stranger.ask(START, 0.02)
    scan = stranger.scans(1.0)[0]
    assert scan.status == 0x90
    assert isinf(scan.ranges(1)[90])
    stranger.laser.dirt = 0.0
    clean = stranger.scans(1.0)[-1]
    assert clean.status == 0x10
    assert clean.ranges(1)[90] == pytest.approx(20.0)


def test_a_window_that_lets_nothing_through_measures_nothing(stranger: Stranger) -> None:
    stranger.laser.dirt = 1.0
    stranger.ask(START, 0.02)
    assert np.all(np.isnan(stranger.scans(1.0)[0].ranges(1)))


def test_centimetres_reach_farther_and_are_coarser(stranger: Stranger) -> None:
    stranger.room.radius = 50.001
    stranger.tell(LmsRequestCode.MODE, b"\0SICK_LMS")
    stranger.tell(LmsRequestCode.SET_CONFIGURATION, bytes.fromhex("00 00 46 00 00 05 00"))
    stranger.ask(START, 0.02)
    scan = stranger.scans(1.0)[0]
    assert scan.unit.metres == 0.01
    assert scan.ranges(1)[150] == pytest.approx(50.001 + 0.1 * radians(60), abs=0.0051)
    assert np.max(np.where(np.isinf(scan.ranges(1)), 0.0, scan.ranges(1))) < inf
