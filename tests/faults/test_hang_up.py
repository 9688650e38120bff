"""A port that vanishes and returns, with the programs themselves."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from acromovi.children import gateway
from bus import Bus, Refused, ZenohBus, keys, messages
from p2os_emu.robot_for_tests import RobotForTests, RobotTruth

EmulateRobots = Callable[..., tuple[RobotForTests, ...]]


@pytest.fixture
def bus() -> Iterator[Bus]:
    with ZenohBus.open() as session:
        yield session


def test_gateway_shows_a_port_that_vanished_refuses_commands_and_takes_it_up_again(
    robot: str, bus: Bus, emulate_robots: EmulateRobots, until: Callable[..., None], tmp_path: Path
) -> None:
    name = robot[:19]
    states: list[Any] = []
    bus.subscribe(keys.STATE.key(name), lambda each: states.append(messages.decode(each.type_name, each.payload)))

    def shows(connection: str) -> bool:
        return bool(states) and states[-1].connection == connection

    def drives(truth: RobotTruth) -> bool:
        bus.put(keys.CMD_VEL.key(name), messages.twist(0.3, 0.0))
        return truth.linear > 0.2

    (happy,) = emulate_robots(f"p3dx-sh:{name}", options=["--pty", str(tmp_path / "cable")])
    with gateway(happy.port, "--quiet"):
        until(lambda: shows("connected") and states[-1].motors, "the robot is ready")
        happy.wait_until(drives, what="it drove")
        fault = happy.fault("hang-up@0+1000")
        until(lambda: shows("disconnected"), "the port was missed")
        assert "the robot is not connected" in states[-1].faults
        with pytest.raises(Refused, match="the robot is not connected"):
            bus.query(keys.MOVE.key(name), {"distance": 0.1})
        place = happy.wait_until_it_stands()  # by its watchdog
        drives(place)  # it must not wait for the robot to return
        fault.clear()
        until(lambda: shows("connected") and states[-1].motors, "the robot came back")
        after = happy.wait_until_it_stands()
        assert (after.x, after.y) == pytest.approx((place.x, place.y), abs=0.003), "nobody asked it to move"
        happy.wait_until(drives, what="it drove again")
