"""`gateway.start` runs `p2os-gateway` as a child process for as long as a block lasts."""

from pathlib import Path

import pytest

import gateway
from bus import ZenohBus
from bus.keys import DESCRIPTION
from p2os_emu import RobotForTests
from tests.waiting import wait_until


def is_on_bus(bus: ZenohBus, robot: str) -> bool:
    try:
        (answer,) = bus.query(DESCRIPTION.key(robot))
    except TimeoutError:  # nobody has answered
        return False
    return bool(answer.value["model"] == "p3dx")


def test_gateway_serves_the_robot_until_the_block_ends(emulated_robot: RobotForTests, robot: str) -> None:
    with ZenohBus.open() as bus:
        with gateway.start(emulated_robot.port, name=robot) as running:
            assert (running.robot, running.model) == (robot, "p3dx")
            wait_until(lambda: is_on_bus(bus, robot), "the robot is on the bus")
        assert running.process.returncode is not None
        assert not is_on_bus(bus, robot)


def test_gateway_that_cannot_start_raises_its_own_message(tmp_path: Path) -> None:
    with pytest.raises(gateway.GatewayError, match=r"^there is no port .*/nothing; plug the robot in"):
        gateway.start(f"{tmp_path}/nothing").__enter__()


def test_an_unknown_option_is_reported_by_the_gateway() -> None:
    with pytest.raises(gateway.GatewayError, match="did you mean --baud"):
        gateway.start("/dev/ttyUSB0", options=["--baudd"]).__enter__()


def test_a_port_must_be_a_text() -> None:
    with pytest.raises(TypeError, match="port is a text, not 3"):
        gateway.start(3).__enter__()  # type: ignore[arg-type]  # this is what is tested


def test_options_must_be_a_list() -> None:
    with pytest.raises(TypeError, match=r"options is a list of texts, as \['--wait'\]"):
        gateway.start("/dev/ttyUSB0", options="--wait").__enter__()
