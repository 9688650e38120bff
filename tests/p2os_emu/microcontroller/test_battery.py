from collections.abc import Callable

import pytest

from p2os.command_table import Command
from p2os.sip import ChargeState
from p2os_emu.microcontroller.battery import BatteryModel
from tests.p2os_emu.microcontroller.bench import MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]

HOUR = 3600.0


def test_it_starts_near_full_and_the_seed_decides_how_near() -> None:
    charges = [BatteryModel(12.0, seed).charge for seed in (1, 1, 2)]
    assert all(0.9 <= charge <= 1.0 for charge in charges)
    assert charges[0] == charges[1] != charges[2]


def test_it_drains_at_rest_and_faster_under_load() -> None:
    resting, working = BatteryModel(12.0, 0), BatteryModel(12.0, 0)
    resting.advance(HOUR, 0.0, False)
    working.advance(HOUR, 0.8, False)
    assert working.charge < resting.charge < BatteryModel(12.0, 0).charge
    assert working.voltage < resting.voltage


def test_an_empty_battery_stays_at_zero() -> None:
    battery = BatteryModel(24.0, 0)
    battery.advance(100 * HOUR, 1.0, False)
    assert battery.charge == 0.0
    assert battery.voltage == pytest.approx(24 * 0.85)


def test_a_charger_fills_it_stage_by_stage() -> None:
    battery = BatteryModel(12.0, 0)
    battery.advance(5 * HOUR, 0.0, False)
    stages = []
    for _ in range(8):
        battery.advance(HOUR, 0.0, True)
        stages.append(battery.charging)
    assert sorted(stages) == stages
    assert set(stages) == {ChargeState.BULK, ChargeState.OVERCHARGE, ChargeState.FLOAT}
    assert battery.charge == 1.0


def test_the_sip_shows_24_volts_twice_because_its_byte_ends_at_25_5(robot: MicrocontrollerBench) -> None:
    robot.controller.panel.battery = 26.4
    sip = robot.sip()
    assert sip.battery == pytest.approx(25.5)
    assert sip.battery_fine == pytest.approx(26.4)


def test_driving_empties_the_battery_faster_than_standing(bench_of: BenchOf) -> None:
    standing, driving = (bench_of("p3dx-sh", seed=3).connect(motors=True) for _ in range(2))
    driving.send(Command.VEL, 0.5)
    for robot in (standing, driving):
        robot.run(60.0)
    assert driving.controller.board.battery.charge < standing.controller.board.battery.charge


def test_a_plugged_charger_shows_in_flags_and_charge_state(robot: MicrocontrollerBench) -> None:
    assert not robot.sip().charger_good
    robot.controller.panel.charger_plugged = True
    robot.run(0.2)
    sip = robot.sip()
    assert sip.charger_good
    assert sip.charge_state == ChargeState.OVERCHARGE


def test_battest_pretends_a_voltage_until_zero(robot: MicrocontrollerBench) -> None:
    real = robot.sip().battery_fine
    robot.controller.receive(bytes.fromhex("FA FB 06  FA 3B D6 00  D0 3B"))  # 214: the unit is 0.1 V
    assert robot.sip().battery_fine == pytest.approx(21.4)
    robot.send(Command.BATTEST, 0)
    assert robot.sip().battery_fine == pytest.approx(real, abs=0.1)


def test_the_number_of_battest_is_another_command_on_aros(bench_of: BenchOf) -> None:
    robot = bench_of("p3at").connect()
    real = robot.sip().battery
    robot.send(Command.BATTEST, 2)
    assert robot.sip().battery == pytest.approx(real)
