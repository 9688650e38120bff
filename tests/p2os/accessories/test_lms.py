"""What telegrams of the laser say."""

from math import inf, isinf, isnan, nan, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os import DecodeError
from p2os.accessories.lms import (
    REFLECTOR_MODE,
    VARIANTS,
    LmsAnswerCode,
    LmsConfiguration,
    LmsRequestCode,
    Scan,
    Unit,
    Variant,
    read_segment,
)
from p2os.accessories.lms_framing import LmsTelegram

# source: accessory sheet, section 1, ARIA connect sequence, step 5: what follows the code, for 1 mm and 1 reflector bit
ARIA_CONFIGURATION = bytes.fromhex("00 00 46 00 00 05 01 00 00 02 02") + bytes(21)

configurations = st.builds(
    lambda bits, unit: LmsConfiguration(measuring_mode=REFLECTOR_MODE[bits], unit=unit),
    st.sampled_from([1, 2, 3]),
    st.sampled_from(Unit),
)


@pytest.mark.parametrize(("variant", "beams"), list(zip(VARIANTS, (181, 361, 101, 201, 401), strict=True)))
def test_beams_are_as_many_as_the_sheet_says(variant: Variant, beams: int) -> None:
    assert variant.beams == beams
    assert variant.first_bearing == -radians(variant.angle_deg / 2)
    assert variant.first_bearing + (beams - 1) * variant.resolution == pytest.approx(-variant.first_bearing)


def test_a_scan_of_one_degree_has_the_length_of_the_sheet() -> None:
    data = LmsConfiguration().scan_data(bytes(2 * 181))
    assert len(data) + 2 == 0x016E  # with code and status byte
    assert data[:2] == (181 | 0x4000).to_bytes(2, "little")


@given(configurations, st.lists(st.floats(0.0, 8.0), min_size=1, max_size=401), st.booleans())
def test_distances_come_back_within_half_a_unit(
    configuration: LmsConfiguration, ranges: list[float], is_reflector: bool
) -> None:
    given_ranges = np.array(ranges)
    flags = np.full(len(ranges), is_reflector, np.uint16)
    data = configuration.scan_data(configuration.pack_values(given_ranges, flags))
    scan = Scan.read(LmsTelegram(LmsAnswerCode.SCAN, data, 0x10))
    assert scan.unit is configuration.unit
    assert scan.ranges(configuration.flag_bits) == pytest.approx(given_ranges, abs=configuration.unit.metres * 0.501)
    assert list(scan.flags(configuration.flag_bits)) == list(flags)


@pytest.mark.parametrize("bits", [1, 2, 3])
def test_nothing_there_is_infinite_and_no_measurement_is_not_a_number(bits: int) -> None:
    configuration = LmsConfiguration(measuring_mode=REFLECTOR_MODE[bits])
    flags = np.zeros(3, np.uint16)
    values = configuration.pack_values(np.array([inf, nan, configuration.max_range]), flags)
    nothing, weak, farthest = Scan.read(LmsTelegram(LmsAnswerCode.SCAN, configuration.scan_data(values))).ranges(bits)
    assert isinf(nothing)
    assert isnan(weak)
    assert farthest == pytest.approx(configuration.max_range)


def test_three_reflector_bits_leave_eight_metres_in_millimetres() -> None:
    assert LmsConfiguration(measuring_mode=1).max_range == pytest.approx(8.18, abs=0.01)


def test_a_partial_scan_says_where_it_begins() -> None:
    configuration = LmsConfiguration()
    values = configuration.pack_values(np.array([1.0, 2.0]), np.zeros(2, np.uint16))
    scan = Scan.read(LmsTelegram(LmsAnswerCode.PARTIAL_SCAN, configuration.scan_data(values, 90)))
    assert scan.first == 90
    assert list(scan.ranges(1)) == [1.0, 2.0]
    assert read_segment(bytes.fromhex("5B 00 5C 00")) == range(90, 92)


@pytest.mark.parametrize("data", [b"", b"\1", b"\2\0\0\0", b"\1\0\0\0\0", bytes((1, 0xC0, 0, 0))])
@pytest.mark.parametrize("code", [LmsAnswerCode.SCAN, LmsAnswerCode.PARTIAL_SCAN, LmsAnswerCode.MODE])
def test_a_scan_whose_size_is_not_what_it_says_is_refused(code: int, data: bytes) -> None:
    with pytest.raises(DecodeError):
        Scan.read(LmsTelegram(code, data))


def test_configuration_is_that_of_the_sheet() -> None:
    assert LmsConfiguration().pack() == ARIA_CONFIGURATION
    assert LmsConfiguration.unpack(ARIA_CONFIGURATION) == LmsConfiguration()


def test_a_short_configuration_leaves_the_rest_as_it_was() -> None:
    before = LmsConfiguration(rest=bytes(range(25)))
    changed = LmsConfiguration.unpack(ARIA_CONFIGURATION[:7], before)
    assert changed == before


@pytest.mark.parametrize("data", [b"", bytes(6), bytes(33), bytes((0, 0, 0, 0, 0, 9, 0)), bytes((0, 0, 0, 0, 0, 5, 3))])
def test_a_configuration_that_makes_no_sense_is_refused(data: bytes) -> None:
    with pytest.raises(DecodeError):
        LmsConfiguration.unpack(data)


@pytest.mark.parametrize("variant", VARIANTS)
def test_status_holds_angle_and_resolution_where_clients_look(variant: Variant) -> None:
    data = variant.status_data(b"V02.10")
    whole = bytes((LmsAnswerCode.STATUS,)) + data  # clients count from the code on
    assert len(whole) + 1 == 152
    assert int.from_bytes(whole[107:109], "little") == variant.angle_deg
    assert int.from_bytes(whole[109:111], "little") == variant.resolution_cdeg
    assert Variant.read(LmsAnswerCode.STATUS, data) == variant


def test_answers_too_short_to_mean_anything_are_refused() -> None:
    with pytest.raises(DecodeError):
        Variant.read(LmsAnswerCode.STATUS, bytes(109))
    with pytest.raises(DecodeError):
        Variant.read(LmsAnswerCode.VARIANT, b"\1")
    variant = Variant(100, 25)
    assert Variant.read(LmsAnswerCode.VARIANT, b"\1" + variant.pack()) == variant
    assert Variant.read(LmsRequestCode.VARIANT, variant.pack()) == variant
