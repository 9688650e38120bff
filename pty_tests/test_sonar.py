"""Which discs fire, in which order and how often (Pioneer 3 operations manual, sonar chapter)."""

from collections.abc import Iterator

import pytest

from pty_tests.client import POLLING, SONAR, SONARCYCLE, Client, frame
from pty_tests.firmware import ONE_ARRAY
from pty_tests.models import Model
from pty_tests.packets import Sip

CYCLE_MS, SIP_MS = 40, 100  # every array fires one disc per cycle
FARTHEST_MM = 5100  # "about 5 m" at 40 ms, the largest count of any family included


# Which discs there are differs by model; how they are told to fire does not.
ONE_MODEL = pytest.mark.emulate("powerbot")


@pytest.fixture
def pinging(robot: Client, model: Model) -> Iterator[Client]:
    """A robot whose discs all fire in ascending order every 40 ms; left the same way."""

    def all_in_order() -> None:
        robot.send(POLLING, bytes(disc + 1 for disc in sorted(model.discs)))
        robot.send(SONARCYCLE, CYCLE_MS)
        robot.send(SONAR, 1)
        robot.sip(lambda sip: bool(sip.sonar) and sip.arrays >= set(model.arrays), "SIP with sonar", 3.0)
        robot.fresh_sip()

    all_in_order()
    yield robot
    all_in_order()


def readings(sips: list[Sip], array: int) -> list[list[int]]:
    """The disc numbers one array reported, SIP by SIP."""
    return [[number for number, _ in sip.sonar if number // 8 == array - 1] for sip in sips]


def assert_follows(reported: list[list[int]], sequence: list[int]) -> None:
    """Each SIP holds the next few discs of the sequence, in any order; the first says where it began."""
    starts = []
    for start in range(len(sequence)):
        at = start
        for numbers in reported:
            expected = [sequence[(at + i) % len(sequence)] for i in range(len(numbers))]
            if sorted(expected) != sorted(numbers):
                break
            at += len(numbers)
        else:
            starts.append(start)
    assert starts, f"{reported} does not follow {sequence}"


def test_all_discs_of_the_model_report_and_no_others_in_turn_and_at_their_rate(pinging: Client, model: Model) -> None:
    sips = pinging.sips(12)
    assert {number for sip in sips for number, _ in sip.sonar} == model.discs
    for array, discs in model.arrays.items():
        reported = readings(sips, array)
        assert {len(numbers) for numbers in reported} <= {2, 3}, "one disc per array and 40 ms makes 2 or 3 per 100 ms"
        assert sum(map(len, reported)) == pytest.approx(len(sips) * SIP_MS / CYCLE_MS, abs=1)
        assert_follows(reported, discs)
    for sip in sips:
        assert all(0 < reading.range * model.echo <= FARTHEST_MM for reading in sip.sonar), sip.sonar


@ONE_MODEL
def test_sonar_0_silences_all_and_1_brings_all_back(pinging: Client, model: Model) -> None:
    pinging.send(SONAR, 0)
    pinging.sip(lambda sip: not sip.arrays, "SIP with no array on")
    assert not any(sip.sonar for sip in pinging.sips(3))
    pinging.send(SONAR, 1)
    assert pinging.sip(lambda sip: bool(sip.sonar), "SIP with sonar").arrays >= set(model.arrays)


@ONE_MODEL
@pytest.mark.needs(ONE_ARRAY)
def test_each_array_has_a_switch_of_its_own(pinging: Client, model: Model) -> None:
    for array in model.arrays:
        pinging.send(SONAR, array << 1)
        pinging.fresh_sip()
        sips = pinging.sips(3)
        assert all(array not in sip.arrays for sip in sips)
        assert not any(readings(sips, array))
        assert all(readings(sips, other)[-1] for other in model.arrays if other != array)
        pinging.send(SONAR, array << 1 | 1)
        pinging.fresh_sip()
        last = pinging.sip()
        assert array in last.arrays
        assert any(readings([last], array))


@ONE_MODEL
def test_polling_chooses_the_discs_of_an_array_and_their_order(pinging: Client, model: Model) -> None:
    pinging.send(POLLING, bytes([4, 2, 7, 5]))
    pinging.fresh_sip()
    sips = pinging.sips(8)
    assert_follows(readings(sips, 1), [3, 1, 6, 4])
    for array, discs in model.arrays.items():
        if array != 1:
            assert_follows(readings(sips, array), discs)


@ONE_MODEL
def test_polling_may_name_a_disc_twice(pinging: Client) -> None:
    pinging.send(POLLING, bytes([1, 2, 1, 3]))
    pinging.fresh_sip()
    reported = [number for numbers in readings(pinging.sips(12), 1) for number in numbers]
    assert set(reported) == {0, 1, 2}
    # Every other firing is its own, though a SIP holds one reading of a disc at most.
    assert reported.count(0) > 1.3 * max(reported.count(1), reported.count(2))


@ONE_MODEL
def test_empty_polling_silences_the_sonar(pinging: Client) -> None:
    pinging.send(POLLING, b"")
    pinging.fresh_sip()
    assert not any(sip.sonar for sip in pinging.sips(3))


@ONE_MODEL
@pytest.mark.needs(SONARCYCLE)
def test_sonarcycle_sets_the_rate(pinging: Client, model: Model) -> None:
    pinging.send(SONARCYCLE, 2 * CYCLE_MS)
    pinging.fresh_sip()
    sips = pinging.sips(16)
    for array in model.arrays:
        assert sum(map(len, readings(sips, array))) == pytest.approx(16 * SIP_MS / (2 * CYCLE_MS), abs=1)


@ONE_MODEL
def test_the_nul_that_aria_adds_to_a_string_is_not_part_of_it(pinging: Client) -> None:
    string = bytes([POLLING, 0x2B, 2, 6, 3]) + b"\0"
    pinging.write(frame(string))
    pinging.fresh_sip()
    assert_follows(readings(pinging.sips(6), 1), [5, 2])
