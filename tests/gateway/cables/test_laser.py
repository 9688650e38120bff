"""The laser's driver before an emulated laser, in virtual time."""

from typing import TYPE_CHECKING

import pytest

from configs import ConfigError
from gateway.elements.laser.driver import RATES, LaserDriver
from gateway.events import ElementFound, ElementLost, ElementSilent, LaserScanned
from gateway.settings import LaserSettings, LaserUnit
from p2os.accessories.lms import MODE_OF_BAUD, LmsAnswerCode, LmsMode, LmsRequestCode, Variant
from p2os.accessories.lms_framing import encode
from p2os_emu.accessories.lms200 import Lms200

if TYPE_CHECKING:
    from tests.gateway.cables.conftest import LaserBench, MakeLaserBench


class StubbornLaser(Lms200):
    """It refuses every configuration."""

    def _configure(self, inside: bytes) -> None:
        self._answer(LmsAnswerCode.CONFIGURED, self.configuration.answer(accepted=False))


SCANNING = encode(LmsRequestCode.MODE, bytes((LmsMode.CONTINUOUS,)))


def leave(bench: "LaserBench", baud: int, variant: Variant, *, scans: bool) -> None:
    """Leave the laser as some client did."""
    for frame in (
        encode(LmsRequestCode.VARIANT, variant.pack()),
        encode(LmsRequestCode.MODE, bytes((MODE_OF_BAUD[baud],))),
        *([SCANNING] if scans else []),
    ):
        bench.laser.receive(frame)
        for _ in range(60):
            bench.laser.step(1 / 120)
    assert bench.laser.baud == baud


@pytest.mark.parametrize("scans", [False, True])
@pytest.mark.parametrize("baud", RATES)
def test_it_finds_the_laser_in_whatever_state_it_was_left(bench: "LaserBench", baud: int, scans: bool) -> None:
    leave(bench, baud, Variant(180, 50), scans=scans)
    assert bench.connect() < 5.0
    bench.run(2.0)
    assert bench.laser.baud == bench.driver.baud == 38400
    assert bench.laser.variant == Variant(180, 100)
    assert bench.of(ElementFound) == [ElementFound("laser", 38400)]
    assert len(bench.of(LaserScanned)) > 15
    assert bench.driver.faults() == []


def test_half_a_command_in_the_lasers_ear_does_not_keep_it_deaf(bench: "LaserBench") -> None:
    bench.laser.receive(encode(LmsRequestCode.MODE, b"\0SICK_LMS")[:9])
    assert bench.connect() < 5.0


def test_a_laser_that_was_scanning_is_not_set_up_anew_where_nothing_differs(bench: "LaserBench") -> None:
    leave(bench, 38400, Variant(180, 100), scans=True)
    bench.connect()
    assert encode(LmsRequestCode.VARIANT, Variant().pack()) not in bench.sent
    assert encode(LmsRequestCode.MODE, b"\0SICK_LMS") not in bench.sent


def test_it_sets_the_laser_up_as_the_settings_want_it(make_laser_bench: "MakeLaserBench") -> None:
    settings = LaserSettings(500000, 100, 0.25, LaserUnit.CENTIMETRE, reflector_bits=3)
    bench = make_laser_bench(settings)
    bench.connect()
    bench.run(1.0)
    scan = bench.of(LaserScanned)[-1]
    assert bench.laser.baud == 500000
    assert len(scan.scan.words) == 401
    assert scan.scan.unit.metres == 0.01
    assert bench.laser.configuration.measuring_mode == 1
    assert scan.configuration == bench.laser.configuration


def test_a_laser_that_refuses_its_configuration_is_read_by_its_own(
    make_laser_bench: "MakeLaserBench",
) -> None:
    bench = make_laser_bench(LaserSettings(unit=LaserUnit.CENTIMETRE))
    bench.laser = StubbornLaser(bench.laser._model, bench.laser._mount, bench.laser._body)
    own = bench.laser.configuration
    bench.connect()
    bench.run(1.0)
    assert bench.laser.configuration == bench.of(LaserScanned)[-1].configuration == own
    assert bench.driver.faults() == [
        "the laser refuses the unit or the reflector bits of its settings, and keeps its own; "
        "change unit or reflector_bits"
    ]


def test_without_a_rate_the_laser_keeps_the_one_it_has(make_laser_bench: "MakeLaserBench") -> None:
    bench = make_laser_bench(has_rate=False)
    leave(bench, 19200, Variant(180, 100), scans=False)
    bench.connect()
    bench.run(1.0)
    assert bench.laser.baud == 19200
    assert bench.of(ElementFound) == [ElementFound("laser", 0)]


def test_without_a_rate_the_settings_may_still_name_one(make_laser_bench: "MakeLaserBench") -> None:
    bench = make_laser_bench(LaserSettings(baud=500000), has_rate=False)
    bench.connect()
    bench.run(1.0)
    assert bench.laser.baud == 500000
    assert len(bench.of(LaserScanned)) > 40


def test_the_age_of_a_scan_counts_from_its_first_beam(bench: "LaserBench") -> None:
    bench.connect()
    bench.run(3.0)
    scan = bench.of(LaserScanned)[-1]
    # 372 bytes at 38400 bit/s take 97 ms, and the mirror turned for 13 ms before.
    assert scan.age == pytest.approx(0.097 + 0.013, abs=0.009)
    assert scan.period == pytest.approx(0.1015, abs=0.005)


def test_a_laser_that_falls_silent_is_lost_and_found_again_after_its_power_failed(bench: "LaserBench") -> None:
    bench.connect()
    bench.run(1.0)
    bench.is_cut = True
    bench.run_until(lambda: bool(bench.of(ElementLost)), 2.0)
    assert bench.driver.faults() == ["the laser does not answer"]
    assert bench.driver.lost == {"the laser fell silent": 1}
    bench.laser = type(bench.laser)(bench.laser._model, bench.laser._mount, bench.laser._body)
    bench.run(10.0)
    assert bench.of(ElementSilent)
    bench.is_cut = False
    bench.run_until(lambda: bench.driver.is_connected, 10.0)
    bench.run(1.0)
    assert bench.laser.baud == 38400
    assert len(bench.of(ElementFound)) == 2


def test_a_laser_that_was_switched_on_again_is_set_up_at_once(make_laser_bench: "MakeLaserBench") -> None:
    bench = make_laser_bench(LaserSettings(baud=9600))
    bench.connect()
    bench.run(1.0)
    bench.laser.receive(encode(LmsRequestCode.RESET))
    bench.run_until(lambda: bool(bench.of(ElementLost)), 1.0)
    bench.run_until(lambda: bench.driver.is_connected, 3.0)


def test_a_port_that_vanishes_is_said_and_taken_up_again(bench: "LaserBench") -> None:
    bench.connect()
    bench.run(0.5)
    bench.driver.port_lost("the cable was pulled", bench.now)
    assert bench.driver.faults() == ["the laser's port is gone"]
    bench.run(1.0)
    assert bench.of(ElementLost) == [ElementLost("laser", "the cable was pulled")]
    assert bench.connect() < 3.0


def test_damaged_telegrams_are_counted_by_reason_and_not_reported(bench: "LaserBench") -> None:
    bench.connect()
    bench.run(1.0)
    bench.spoiled = 2
    bench.run(1.0)
    assert bench.driver.damaged == {"checksum": 2}
    assert bench.driver.is_connected
    assert len(bench.of(LaserScanned)) == pytest.approx(20 - 2, abs=2)


def test_what_waited_while_the_gateway_was_frozen_is_not_taken_for_new(bench: "LaserBench") -> None:
    bench.connect()
    bench.run(1.0)
    bench.run(3.0, is_frozen=True)
    thawed = bench.now
    bench.run(0.05)
    assert not bench.of(LaserScanned, since=thawed)
    bench.run(1.0)
    assert len(bench.of(LaserScanned, since=thawed)) > 5
    assert not bench.of(ElementLost)


def test_a_dirty_window_is_a_fault_as_long_as_it_is_dirty(bench: "LaserBench") -> None:
    bench.connect()
    bench.laser.dirt = 0.6
    bench.run(1.0)
    assert bench.driver.faults() == ["the laser's window is dirty"]
    bench.laser.dirt = 0.0
    bench.run(1.0)
    assert bench.driver.faults() == []


def test_on_leaving_it_falls_silent_and_is_as_after_the_power_switch(bench: "LaserBench") -> None:
    bench.connect()
    bench.run(1.0)
    assert bench.driver.is_moving
    bench.laser.receive(bench.driver.stopping_bytes)
    bench.run_until(lambda: not bench.driver.is_moving, 0.5)
    bench.laser.receive(bench.driver.closing_bytes)
    for _ in range(30):
        bench.laser.step(1 / 120)
    assert bench.laser.baud == 9600
    assert bench.laser._segment is None


@pytest.mark.parametrize(
    "settings",
    [LaserSettings(baud=57600), LaserSettings(angle_deg=180, resolution_deg=0.25), LaserSettings(reflector_bits=4)],
)
def test_what_no_laser_can_do_is_refused_at_the_start(settings: LaserSettings) -> None:
    with pytest.raises(ConfigError):
        LaserDriver(settings)
