"""What outlives the client, the power switch and the emulator."""

import json
from collections.abc import Callable
from dataclasses import replace

import pytest

from p2os.command_table import Command
from p2os.configuration import Configuration
from p2os.errors import EncodeError
from p2os_emu.microcontroller.flash import Flash
from tests.p2os_emu.microcontroller.bench import MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]


@pytest.fixture
def flash(bench_of: BenchOf) -> Flash:
    return Flash.of(bench_of("powerbot-sh").model, "PowerBot1")


def test_it_survives_a_file(flash: Flash) -> None:
    kept = replace(flash, watchdog=0.5, serial="PB17", e_stall=False, bump_stall=2)
    assert flash.changed(json.loads(json.dumps(kept.to_table()))) == kept


@pytest.mark.parametrize(("command", "stored"), [(0, 3), (1, 2), (2, 1), (3, 0)])
def test_bump_stall_is_stored_the_other_way_round(flash: Flash, command: int, stored: int) -> None:
    assert replace(flash, bump_stall=command).to_table()["bump_stall"] == stored
    assert flash.changed({"bump_stall": stored}).bump_stall == command


def test_a_whole_number_may_stand_for_a_quantity(flash: Flash) -> None:
    assert flash.changed({"watchdog": 3}).watchdog == 3.0


@pytest.mark.parametrize("table", [{"watch_dog": 2.0}, {"watchdog": "2"}, {"stall_value": 1.5}, {"e_stall": 1}])
def test_unknown_parameters_and_wrong_types_are_refused(flash: Flash, table: dict[str, float | str]) -> None:
    with pytest.raises(ValueError, match="FLASH"):
        flash.changed(table)


@pytest.mark.parametrize("table", [{"sip_cycle": 0.0}, {"deceleration": -0.3}, {"rev_count": 0}, {"host_baud": 1200}])
def test_values_that_no_controller_could_run_with_are_refused(flash: Flash, table: dict[str, float | str]) -> None:
    with pytest.raises(ValueError, match="FLASH"):
        flash.changed(table)


def test_a_parameter_that_no_packet_could_carry_is_refused_at_once(bench_of: BenchOf, flash: Flash) -> None:
    with pytest.raises(EncodeError, match="sip_cycle"):
        bench_of("powerbot-sh", flash=replace(flash, sip_cycle=1.0))


def test_a_serial_number_belongs_to_one_name_and_one_seed(bench_of: BenchOf) -> None:
    model = bench_of("p3dx-sh").model
    assert Flash.of(model, "happy").serial == Flash.of(model, "happy").serial
    many = [Flash.of(model, f"robot{number}", seed).serial for number in range(5000) for seed in range(2)]
    assert len(set(many)) == len(many)


def test_a_robot_starts_from_its_flash(bench_of: BenchOf, flash: Flash) -> None:
    kept = replace(flash, acceleration=0.5, max_velocity=0.4, sip_cycle=0.05, serial="PB17", rot_kp=40)
    robot = bench_of("powerbot-sh", flash=kept).connect(motors=True)
    assert len(robot.sips(1.0)) == 20
    robot.send(Command.CONFIG)
    (configuration,) = robot.packets(Configuration, 0.2)
    assert (configuration.serial, configuration.rot_kp) == ("PB17", 40)
    robot.send(Command.VEL, 1.0)
    robot.run(0.5)
    assert robot.body.velocity == pytest.approx(0.25, abs=0.01)
    robot.run(2.0)
    assert robot.body.velocity == pytest.approx(0.4)
