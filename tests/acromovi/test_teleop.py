import threading
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from acromovi.presence import RobotPresence, UnknownRobot
from acromovi.teleop import Teleop
from bus import KeyNotValid, MemoryBus, MemoryNetwork, Refused, Sample
from bus.messages import (
    BatteryState,
    Odometry,
    Point,
    Pose,
    PoseWithCovariance,
    RobotState,
    TwistWithCovariance,
    decode,
    header,
    quaternion,
    twist,
)
from tests.waiting import DEADLINE

Until = Callable[..., None]


class Robot:
    """The robot's side: notes what it is asked."""

    def __init__(self, network: MemoryNetwork) -> None:
        self.bus = MemoryBus(network)
        self.twists: list[tuple[float, float]] = []
        self.asked: list[tuple[str, dict[str, Any]]] = []
        self.bus.declare_alive("happy/alive")
        self.bus.subscribe("happy/cmd_vel", self._drive)
        for command in ("enable", "stop", "estop"):
            self.bus.serve(f"happy/command/{command}", self._answer(command))

    def _drive(self, sample: Sample) -> None:
        read = decode("geometry_msgs/msg/Twist", sample.payload)
        self.twists.append((read.linear.x, read.angular.z))

    def _answer(self, command: str) -> Callable[[dict[str, Any]], dict[str, Any]]:
        def answer(arguments: dict[str, Any]) -> dict[str, Any]:
            self.asked.append((command, arguments))
            if command == "stop":
                raise Refused("this robot never stops")
            return {"accepted": True}

        return answer


@pytest.fixture
def network() -> MemoryNetwork:
    return MemoryNetwork()


@pytest.fixture
def robot(network: MemoryNetwork) -> Robot:
    return Robot(network)


@pytest.fixture
def teleop(network: MemoryNetwork, robot: Robot) -> Iterator[Teleop]:
    with Teleop(MemoryBus(network), "happy", 0.3, 0.8) as teleop:
        yield teleop


def test_keys_become_twists_and_leaving_stops_the_robot(network: MemoryNetwork, robot: Robot) -> None:
    with Teleop(MemoryBus(network), "happy", 0.3, 0.8) as teleop:
        assert teleop.press("w", 1.0)
        teleop.step(1.0)
        teleop.step(1.05)
        teleop.step(1.11)
    assert robot.twists == [(0.3, 0.0), (0.3, 0.0), (0.0, 0.0)]


def test_leaving_by_an_error_stops_the_robot_too(network: MemoryNetwork, robot: Robot) -> None:
    def interrupted() -> None:
        with Teleop(MemoryBus(network), "happy", 0.3, 0.8) as teleop:
            teleop.press("a", 1.0)
            teleop.step(1.0)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert robot.twists == [(0.0, 0.8), (0.0, 0.0)]


def test_e_switches_the_motors_the_other_way(teleop: Teleop, robot: Robot, until: Until) -> None:
    teleop.press("e", 0.0)
    until(lambda: "motors switched on" in teleop.view.note)
    robot.bus.put("happy/state", RobotState(header(0, ""), "connected", motors=True))
    teleop.press("e", 1.0)
    until(lambda: "motors switched off" in teleop.view.note)
    assert robot.asked == [("enable", {"on": True}), ("enable", {"on": False})]


def test_x_is_always_an_emergency_stop_and_only_c_clears_it(teleop: Teleop, robot: Robot, until: Until) -> None:
    for key in "xxc":
        teleop.press(key, 0.0)
    until(lambda: len(robot.asked) == 3)
    assert robot.asked == [("estop", {"on": True}), ("estop", {"on": True}), ("estop", {"on": False})]


def test_a_refusal_is_shown(teleop: Teleop, robot: Robot, until: Until) -> None:
    teleop.press(" ", 0.0)
    until(lambda: "stop: this robot never stops" in teleop.view.note)


def test_q_quits(teleop: Teleop) -> None:
    assert not teleop.press("q", 0.0)


def test_the_screen_shows_what_the_robot_publishes(teleop: Teleop, robot: Robot) -> None:
    assert teleop.view.screen(200, 24)[0] == "happy"
    robot.bus.put("happy/odom", odometry())
    robot.bus.put("happy/battery", battery(12.6))
    robot.bus.put("happy/state", RobotState(header(0, ""), "connected", motors=True, estop=True))
    assert teleop.view.screen(200, 24)[:2] == [
        "happy | E-STOP | connected | motors on | 12.6 V",
        "+0.30 m/s | -0.10 rad/s | x 1.00 m | y -2.00 m | heading 0.50 rad",
    ]
    teleop.view.is_there = False
    assert teleop.view.screen(200, 24)[0].startswith("happy IS GONE | ")


def test_a_key_without_effect_says_why(teleop: Teleop, robot: Robot) -> None:
    robot.bus.put("happy/state", RobotState(header(0, ""), "connected", motors=True, estop=True))
    teleop.press("w", 0.0)
    assert teleop.view.note == "no effect: the e-stop is latched; press c to release it, then e to switch the motors on"
    robot.bus.put("happy/state", RobotState(header(0, ""), "connected", motors=False))
    teleop.press("left", 0.0)
    assert teleop.view.note == "no effect: the motors are off; press e to switch them on"
    robot.bus.put("happy/state", RobotState(header(0, ""), "connected", motors=True))
    teleop.press("left", 0.0)
    assert teleop.view.note == ""
    teleop.press("z", 0.0)
    assert teleop.view.note == "the key 'z' has no function"
    teleop.press("special key", 0.0)
    assert teleop.view.note == "this key has no function"


def test_c_without_an_e_stop_says_that_there_was_none(teleop: Teleop, robot: Robot, until: Until) -> None:
    robot.bus.put("happy/state", RobotState(header(0, ""), "connected", motors=True))
    teleop.press("c", 0.0)
    until(lambda: teleop.view.note == "there was no e-stop to release")
    assert robot.asked == [("estop", {"on": False})]


def test_another_holder_is_known_from_the_start_and_when_it_changes(network: MemoryNetwork, until: Until) -> None:
    bus = MemoryBus(network)
    bus.serve("happy/lease/state", lambda given: {"holder": "anna@lab", "elements": {}})
    with Teleop(MemoryBus(network), "happy", 0.3, 0.8) as teleop:
        bus.put("happy/state", RobotState(header(0, ""), "connected", motors=True))
        until(lambda: "anna@lab holds the lease on the robot" in teleop.view.obstacle())
        bus.put("happy/lease/state", {"holder": None, "elements": {"base": {"holder": "bob@lab"}}})
        assert "bob@lab holds the lease on the base" in teleop.view.obstacle()
        bus.put("happy/lease/state", {"holder": None, "elements": {}})
        assert teleop.view.obstacle() == ""


class SlowToEnable(MemoryBus):
    """A bus on which the answer to `enable` takes until it is allowed."""

    def __init__(self, network: MemoryNetwork) -> None:
        super().__init__(network)
        self.may_answer = threading.Event()

    def query(self, key: str, *arguments: Any, **more: Any) -> Any:  # type: ignore[override]  # passed on as it is
        if key.endswith("/enable"):
            self.may_answer.wait(DEADLINE)
        return super().query(key, *arguments, **more)


def test_an_e_stop_waits_for_no_other_answer(network: MemoryNetwork, robot: Robot, until: Until) -> None:
    bus = SlowToEnable(network)
    with Teleop(bus, "happy", 0.3, 0.8) as teleop:
        teleop.press("e", 0.0)
        teleop.press("x", 0.0)
        until(lambda: ("estop", {"on": True}) in robot.asked)
        assert robot.asked == [("estop", {"on": True})]
        bus.may_answer.set()
    assert robot.asked == [("estop", {"on": True}), ("enable", {"on": True})]


def odometry() -> Odometry:
    pose = Pose(position=Point(x=1.0, y=-2.0, z=0.0), orientation=quaternion(0.5))
    return Odometry(
        header=header(0, "happy/odom"),
        child_frame_id="happy/base_link",
        pose=PoseWithCovariance(pose=pose, covariance=np.zeros(36)),
        twist=TwistWithCovariance(twist=twist(0.3, -0.1), covariance=np.zeros(36)),
    )


def battery(voltage: float) -> BatteryState:
    nan, none = float("nan"), np.zeros(0, np.float32)
    return BatteryState(
        header=header(0, ""),
        voltage=voltage,
        temperature=nan,
        current=nan,
        charge=nan,
        capacity=nan,
        design_capacity=nan,
        percentage=nan,
        power_supply_status=0,
        power_supply_health=0,
        power_supply_technology=0,
        present=True,
        cell_voltage=none,
        cell_temperature=none,
        location="",
        serial_number="",
    )


def test_robots_come_and_go(network: MemoryNetwork, robot: Robot) -> None:
    presence = RobotPresence(MemoryBus(network))
    presence.expect("happy", 0.0)
    assert presence.robots == ["happy"]
    robot.bus.close()
    assert presence.robots == []


def test_a_robot_that_is_not_there_is_told_in_one_sentence(network: MemoryNetwork, robot: Robot) -> None:
    presence = RobotPresence(MemoryBus(network))
    with pytest.raises(UnknownRobot, match=r"no robot 'hapy' is seen; did you mean 'happy'\?"):
        presence.expect("hapy", 0.0)
    with pytest.raises(UnknownRobot, match="the robots seen are happy"):
        presence.expect("zzz", 0.0)
    with pytest.raises(KeyNotValid):
        presence.expect("a/b")
