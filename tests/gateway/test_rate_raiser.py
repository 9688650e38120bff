"""HOSTBAUD: driver, a serial line with rates, and firmware in virtual time."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from configs import ConfigError
from gateway.events import HandshakeCompleted, LinkLost
from gateway.settings import Settings, load_settings
from p2os import Command
from tests.gateway.conftest import Bench

if TYPE_CHECKING:
    from tests.gateway.conftest import MakeBench


@dataclass
class SlowBench(Bench):
    """The line garbles what is not sent at the rate that the robot's port has. stays: the port does not change."""

    stays: bool = False

    @property
    def _same_rate(self) -> bool:
        return self.driver.baud == (self.robot_baud if self.stays else self.robot.board.host_baud)


@pytest.fixture
def make_slow(make_bench: "MakeBench") -> "MakeBench":
    def make(settings: Settings, *, stays: bool = False, model: str = "p3dx-sh") -> SlowBench:
        bench = make_bench(model, settings=settings)
        return SlowBench(bench.robot, bench.driver, robot_baud=9600, stays=stays)

    return make


def test_rate_stays_as_it_is_unless_the_settings_want_another(make_slow: "MakeBench") -> None:
    bench = make_slow(Settings())
    bench.connect()
    bench.run(2.0)
    assert Command.HOSTBAUD not in bench.commands()
    assert bench.driver.baud == bench.robot.board.host_baud == 9600


@pytest.mark.parametrize("wanted", [19200, 38400, 57600, 115200])
def test_robot_is_told_the_rate_and_goes_on_at_it_without_being_lost(make_slow: "MakeBench", wanted: int) -> None:
    bench = make_slow(Settings(raise_baud_to=wanted))
    bench.connect()
    bench.run(3.0)
    assert bench.driver.baud == bench.robot.board.host_baud == wanted
    assert bench.of(LinkLost) == []
    assert bench.robot.board.motors.enabled
    bench.driver.set_velocity(0.2, 0.0, bench.now)
    bench.run(0.3)
    assert bench.body.is_turning()
    since = bench.now - 1.0
    assert len([at for at, event in bench.events if event in bench.sips and at > since]) >= 9


def test_robot_whose_port_does_not_change_is_talked_to_at_the_old_rate_and_not_told_again(
    make_slow: "MakeBench",
) -> None:
    bench = make_slow(Settings(raise_baud_to=38400), stays=True)
    bench.connect()
    bench.run(5.0)
    assert bench.driver.baud == 9600
    assert bench.of(LinkLost) == []
    assert bench.commands().count(Command.HOSTBAUD) == 1
    assert bench.driver.is_connected


def test_robot_at_a_raised_rate_is_found_again_by_a_gateway_that_was_given_one_rate(make_bench: "MakeBench") -> None:
    bench = make_bench("p3dx-sh", rates=(9600,), settings=Settings(raise_baud_to=38400))
    bench = SlowBench(bench.robot, bench.driver, robot_baud=9600)
    bench.connect()
    bench.run(3.0)
    assert bench.driver.baud == 38400
    bench.cut = True
    bench.run(4.0)
    bench.cut = False
    bench.run_until(lambda: bench.driver.is_connected)
    assert bench.driver.baud == 38400


def test_robot_left_at_a_raised_rate_is_found_by_any_client_that_sweeps(
    make_slow: "MakeBench", make_bench: "MakeBench"
) -> None:
    former = make_slow(Settings(raise_baud_to=115200))
    former.connect()
    former.run(1.0)
    bench = make_slow(Settings())
    bench.robot, bench.body = former.robot, former.body
    bench.connect()
    assert bench.of(HandshakeCompleted)[0].baud == 115200


def test_cut_in_mid_change_ends_with_a_sweep_that_finds_the_robot(make_slow: "MakeBench") -> None:
    bench = make_slow(Settings(raise_baud_to=57600))
    bench.start()
    bench.run_until(lambda: Command.HOSTBAUD in bench.commands())
    bench.cut = True
    bench.run(3.0)
    bench.cut = False
    bench.run_until(lambda: bench.driver.is_connected)
    bench.run(2.0)
    assert bench.driver.is_connected
    assert bench.driver.baud == bench.robot.board.host_baud
    assert bench.commands().count(Command.HOSTBAUD) == 1


def test_rate_that_no_robot_knows_is_refused_with_those_that_it_does(tmp_path: Path) -> None:
    file = tmp_path / "happy.toml"
    file.write_text("raise_baud_to = 12345")
    with pytest.raises(ConfigError, match="9600, 19200, 38400, 57600, 115200, not 12345"):
        load_settings(file)
