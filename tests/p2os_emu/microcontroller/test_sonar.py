"""Which discs fire when, and what of it the SIP carries."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from itertools import chain, pairwise
from math import inf

import pytest

from p2os.command_table import Command
from p2os.sip import StandardSip
from p2os_emu.microcontroller.flash import Flash
from tests.p2os_emu.microcontroller.bench import MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]

POWERBOT_DISCS = [*range(7), *range(8, 15), *range(16, 23), *range(24, 31)]


def firings(robot: MicrocontrollerBench, seconds: float) -> list[tuple[int, ...]]:
    before = len(robot.body.pings)
    robot.run(seconds)
    return robot.body.pings[before:]


def test_a_powerbot_reports_its_28_discs_and_no_empty_slot(robot: MicrocontrollerBench) -> None:
    reported = {number for sip in robot.sips(1.0) for number, _ in sip.sonar}
    assert sorted(reported) == POWERBOT_DISCS


def test_one_disc_of_each_array_fires_every_40_ms_all_at_once_in_rising_order(robot: MicrocontrollerBench) -> None:
    fired = firings(robot, 2.0)
    assert len(fired) == 50
    assert all(len(discs) == 4 for discs in fired)
    first = [discs[0] for discs in fired]
    assert all(late == (early + 1) % 7 for early, late in pairwise(first))
    assert all(discs == (n, n + 8, n + 16, n + 24) for n, discs in zip(first, fired, strict=True))


def test_a_sip_carries_two_or_three_new_readings_of_each_array(robot: MicrocontrollerBench) -> None:
    robot.sip()
    counts = {len(sip.sonar) for sip in robot.sips(5.0)}
    assert counts == {8, 12}


def test_ranges_are_those_of_the_body(robot: MicrocontrollerBench) -> None:
    robot.body.ranges = lambda disc: 0.5 + disc / 100
    robot.sip()
    for number, distance in chain.from_iterable(sip.sonar for sip in robot.sips(1.0)):
        assert distance == pytest.approx(0.5 + number / 100, abs=0.001)


@pytest.mark.parametrize("subtype", ["p2dx", "p3at", "p3dx-sh"])
def test_no_echo_reports_the_maximum_range(bench_of: BenchOf, subtype: str) -> None:
    robot = bench_of(subtype).connect()
    robot.body.ranges = lambda disc: inf
    readings = [distance for sip in robot.sips(1.0) for _, distance in sip.sonar]
    assert readings
    assert readings == pytest.approx([5.0] * len(readings), abs=0.001)


class TestSonarCommand:
    def test_zero_and_one_switch_all_arrays(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.SONAR, 0)
        assert firings(robot, 1.0) == []
        assert robot.sip().sonar_arrays == 0
        robot.send(Command.SONAR, 1)
        assert robot.sip().sonar_arrays == 0b1111
        assert firings(robot, 0.5)

    def test_bits_name_one_array(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.SONAR, 0b0110)  # off, array 3
        assert robot.sip().sonar_arrays == 0b1011
        robot.send(Command.SONAR, 0)
        robot.send(Command.SONAR, 0b1001)  # on, array 4
        assert robot.sip().sonar_arrays == 0b1000
        assert {disc // 8 for disc in chain.from_iterable(firings(robot, 1.0))} == {3}

    @pytest.mark.parametrize("argument", [0b1011, 0b1110, 0b1111])
    def test_arrays_that_do_not_exist_are_ignored(self, robot: MicrocontrollerBench, argument: int) -> None:
        robot.send(Command.SONAR, argument)
        assert robot.sip().sonar_arrays == 0b1111

    def test_arrays_that_are_not_fitted_never_show(self, bench_of: BenchOf) -> None:
        assert bench_of("amigo-sh").connect().sip().sonar_arrays == 0b0001
        assert bench_of("p3at").connect().sip().sonar_arrays == 0b0011

    def test_p2os_knows_no_arrays(self, bench_of: BenchOf) -> None:
        robot = bench_of("p2dx").connect()
        robot.send(Command.SONAR, 0b0010)
        assert robot.sip().sonar_arrays == 0b0011
        robot.send(Command.SONAR, 0)
        assert robot.sip().sonar_arrays == 0

    def test_flash_decides_whether_open_starts_the_sonar(self, bench_of: BenchOf) -> None:
        model = bench_of("p3dx-sh").model
        robot = bench_of("p3dx-sh", flash=replace(Flash.of(model, "x"), sonar_enabled=False)).connect()
        assert robot.sip().sonar_arrays == 0
        assert robot.body.pings == []

    def test_nothing_fires_without_a_client(self, bench_of: BenchOf) -> None:
        assert firings(bench_of("powerbot-sh"), 1.0) == []


class TestPolling:
    def test_only_named_arrays_change_and_repeats_count(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.POLLING, bytes([1, 2, 1, 3, 12]))
        fired = firings(robot, 4.0)
        first = Counter(discs[0] for discs in fired)
        assert set(first) == {0, 1, 2}
        assert first[0] == pytest.approx(2 * first[1], abs=2)
        assert {discs[1] for discs in fired} == {11}
        assert {discs[2] for discs in fired} == set(range(16, 23)), "array 3 was not named"

    def test_an_empty_string_silences_everything(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.POLLING, b"")
        assert firings(robot, 1.0) == []
        assert robot.sip().sonar_arrays == 0

    @pytest.mark.parametrize(
        ("command", "argument", "arrays"), [(Command.SONAR, 1, 0b1111), (Command.POLLING, b"\x09", 0b0010)]
    )
    def test_silence_ends_by_sonar_or_by_another_sequence(
        self, robot: MicrocontrollerBench, command: Command, argument: int | bytes, arrays: int
    ) -> None:
        robot.send(Command.POLLING, b"")
        robot.run(0.5)
        robot.send(command, argument)
        assert robot.sip().sonar_arrays == arrays
        assert firings(robot, 0.5)

    def test_a_sequence_does_not_switch_on_what_sonar_switched_off(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.SONAR, 0)
        robot.send(Command.POLLING, bytes([1, 2, 3]))
        assert firings(robot, 1.0) == []

    def test_an_array_holds_16_firings(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.POLLING, bytes([1] * 16 + [2]))
        assert {discs[0] for discs in firings(robot, 2.0)} == {0}

    @pytest.mark.parametrize("sequence", [b"\x00", b"\x21", b"\x08", b"123"])
    def test_numbers_that_are_no_discs_change_nothing(self, robot: MicrocontrollerBench, sequence: bytes) -> None:
        robot.send(Command.POLLING, sequence)
        assert {disc for discs in firings(robot, 2.0) for disc in discs} == set(POWERBOT_DISCS)

    def test_the_next_client_finds_the_default_order(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.POLLING, bytes([1]))
        robot.send(Command.CLOSE)
        robot.step()
        robot.connect()
        assert {discs[0] for discs in firings(robot, 1.0)} == set(range(7))


class TestSonarCycle:
    @pytest.mark.parametrize(("period", "expected"), [(0.1, 20), (0.02, 100), (0.5, 2.0 / 0.12)])
    def test_it_changes_the_time_between_firings(
        self, robot: MicrocontrollerBench, period: float, expected: float
    ) -> None:
        robot.send(Command.SONARCYCLE, period)
        assert len(firings(robot, 2.0)) == pytest.approx(expected, abs=1)

    def test_the_fastest_cycle_keeps_frames_short_and_reports_each_disc_once(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.SONARCYCLE, 0.002)
        robot.run(0.3)
        fired = firings(robot, 1.0)
        assert len(fired) <= 120, "one firing for each step"
        for sent in robot.run(1.0):
            assert len(sent.payload) + 5 <= 208
            assert isinstance(sent.packet, StandardSip)
            assert sorted(number for number, _ in sent.packet.sonar) == POWERBOT_DISCS

    def test_the_newest_reading_of_a_disc_wins(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.SONARCYCLE, 0.002)
        robot.run(0.3)
        calls = iter(range(10**6))
        robot.body.ranges = lambda disc: next(calls) / 1000
        (sip,) = robot.sips(0.1)
        latest = dict(sip.sonar)
        assert max(latest.values()) - min(latest.values()) < 0.028, "the last 28 of more than 100"
