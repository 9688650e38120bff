"""Both arms as the bus sees them: the Pioneer's in virtual time, and both as programs on real ports."""

from contextlib import ExitStack
from random import Random
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from acromovi.children import EmulatedRobots, emulator, gateway
from bus import Bus, NoAnswer, Refused, Sample, keys, messages
from configs import load
from gateway.settings import Settings
from p2os import RobotModel
from p2os_emu import fitting
from p2os_emu.fit import Fit
from tests.gateway.test_robot_on_bus import Office
from tests.p2os_emu.microcontroller.bench import PlainArm
from tests.waiting import wait_until

if TYPE_CHECKING:
    from tests.gateway.conftest import MakeBench


@pytest.fixture
def office(make_bench: "MakeBench") -> Office:
    """A Pioneer with an arm, whose power is on."""
    bench = make_bench("p3dx-sh")
    bench.body.arm = PlainArm(6)
    model = load(RobotModel, "robots", "p3dx-sh")
    fitting.plug_in("arm", fitting.FittingContext(model, Fit({"arm": "pioneer"}), bench.robot, bench.body, Random(1)))
    office = Office(bench, Settings())
    office.run(0.5)
    return office


@pytest.fixture
def powered(office: Office) -> Office:
    office.ask("command/arm", do="power", on=True)
    office.run(2.3)
    return office


def place(office: Office, joint: int) -> float:
    return float(office.last("joint_states").position[joint - 1])


def test_arm_is_described_with_its_joints(office: Office) -> None:
    (arm,) = (each for each in office.ask("description")["elements"] if each["name"] == "arm")
    assert arm["streams"] == ["happy/arm", "happy/joint_states"]
    assert arm["commands"] == ["happy/command/arm"]
    assert [joint["name"] for joint in arm["joints"]] == [f"happy/arm_joint_{number}" for number in range(1, 7)]
    assert arm["joints"][1]["lower"] == pytest.approx(np.radians(-27))
    assert [joint["unit"] for joint in arm["joints"]] == ["rad"] * 5 + ["m"]
    assert [joint["home"] for joint in arm["joints"]] == pytest.approx([0.0, np.pi / 2, np.pi / 2, 0.0, 0.0, 0.0])


def test_arm_and_joints_are_published_with_every_report(office: Office) -> None:
    arm, joints = office.last("arm"), office.last("joint_states")
    assert (arm.powered, arm.homed, list(arm.moving)) == (False, True, [False] * 6)
    assert joints.name[5] == "happy/arm_joint_6"
    assert list(joints.position) == pytest.approx([0.0, np.pi / 2, np.pi / 2, 0.0, 0.0, 0.0])


def test_joints_go_where_the_bus_sends_them(powered: Office) -> None:
    assert powered.ask("command/arm", do="move", joints={"1": 0.5, "6": 0.02}, speed=0.5) == {"accepted": True}
    powered.run(0.5)
    assert powered.last("arm").moving[0]
    powered.run(1.0)
    assert place(powered, 1) == pytest.approx(0.5, abs=np.radians(0.9))
    assert place(powered, 6) == pytest.approx(0.02, abs=0.001)
    powered.ask("command/arm", do="home")
    powered.run(1.5)
    assert place(powered, 1) == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("order", "why"),
    [
        ({"do": "move", "joints": {"1": 2.0}}, "joint 1 goes from -1.571 to 1.571 rad, and not to 2"),
        ({"do": "move", "joints": {"6": 0.2}}, "joint 6 goes from 0 to 0.05 m, and not to 0.2"),
        ({"do": "move", "joints": {"7": 0.2}}, "the arm has no joint '7'; its joints are 1 to 6"),
        ({"do": "move", "joints": {"1": True}}, "joint 1 needs a number, rad, not True"),
        ({"do": "move", "joints": {}}, 'arm move needs joints, such as {"1": 0.5}'),
        ({"do": "move"}, "arm move needs joints: an object"),
        ({"do": "move", "joints": {"1": 0.1}, "speed": 9}, "the joints turn at 0.124 to 3.491 rad/s, and not at 9"),
        ({"do": "move", "joints": {"1": 0.1}, "speed": 0}, "the joints turn at 0.124 to 3.491 rad/s, and not at 0"),
        ({"do": "home", "speed": 1}, "arm home does not take 'speed'; it takes nothing"),
        ({"do": "power"}, "arm power needs on: true or false"),
        ({"do": "dance"}, "an arm cannot 'dance'; use move, home, park, stop, power"),
        ({}, "arm needs do: text"),
    ],
)
def test_what_the_arm_cannot_do_is_refused_with_a_sentence(powered: Office, order: dict[str, Any], why: str) -> None:
    assert powered.refusal("command/arm", **order) == why


def test_arm_without_power_says_so(office: Office) -> None:
    assert "no power" in office.refusal("command/arm", do="move", joints={"1": 0.1})


def test_only_the_leases_holder_moves_the_arm(powered: Office) -> None:
    token = powered.ask("lease", do="take", holder="me")["token"]
    assert "lease" in powered.refusal("command/arm", do="home")
    powered.ask("command/arm", do="move", joints={"1": 0.5}, token=token)
    powered.run(0.3)
    powered.ask("lease", do="release", token=token)
    powered.run(0.3)
    stood = place(powered, 1)
    powered.run(1.0)
    assert 0.0 < place(powered, 1) == stood < 0.4


@pytest.mark.parametrize("command", ["stop", "estop"])
def test_whoever_stops_the_robot_stops_its_arm(powered: Office, command: str) -> None:
    powered.ask("command/arm", do="move", joints={"1": 1.5})
    powered.run(0.5)
    powered.ask(f"command/{command}", **({"on": True} if command == "estop" else {}))
    powered.run(0.3)
    stood = place(powered, 1)
    powered.run(1.0)
    assert place(powered, 1) == stood < 0.8
    if command == "estop":
        assert "e-stop" in powered.refusal("command/arm", do="home")


def test_silent_gateway_lets_the_arm_go_home_and_lose_its_power(powered: Office) -> None:
    powered.ask("command/arm", do="move", joints={"1": 0.9})
    powered.run(1.5)
    powered.bench.cut = True
    powered.run(6.0)
    arm = powered.bench.body.arm
    assert isinstance(arm, PlainArm)
    assert arm.braked == set(range(6))
    assert arm.positions[0] == pytest.approx(0.0)


# As programs.


class Watcher:
    """Hears one robot's arm, and orders it."""

    def __init__(self, bus: Bus, name: str) -> None:
        self.arm: Any = None
        self.joints: Any = None
        self._bus = bus
        self._name = name
        bus.subscribe(keys.ARM.key(name), self._on_arm)
        bus.subscribe(keys.JOINT_STATES.key(name), self._on_joints)

    def _on_arm(self, sample: Sample) -> None:
        self.arm = messages.decode(sample.type_name, sample.payload)

    def _on_joints(self, sample: Sample) -> None:
        self.joints = messages.decode(sample.type_name, sample.payload)

    def order(self, **order: Any) -> bool:
        """Whether it was accepted."""
        try:
            self._bus.query(keys.REACH.key(self._name), order)
        except (Refused, NoAnswer):  # that is what is asked
            return False
        return True

    def is_at(self, joint: int, place: float) -> bool:
        return self.joints is not None and abs(self.joints.position[joint - 1] - place) < 0.02


def test_pioneers_arm_moves_and_is_parked_when_its_gateway_is_killed(name: str, bus: Bus) -> None:
    with emulator("--robot", f"p3dx-sh:{name}", "--fit", "arm", "--world", "empty") as robots:
        watcher = Watcher(bus, name)
        with gateway(robots.port, "--quiet") as process:
            wait_until(lambda: watcher.order(do="power", on=True))

            def is_there() -> bool:
                """Whether it is; one that stands elsewhere, as after an interrupted motion, is sent again.

                On a busy machine the gateway may fall silent for longer than the arm's watchdog keeps its power on.
                """
                if watcher.arm is not None and not any(watcher.arm.moving):
                    if not watcher.arm.powered:
                        watcher.order(do="power", on=True)
                    watcher.order(do="move", joints={"1": 0.5, "2": 1.2})
                return watcher.is_at(1, 0.5) and watcher.is_at(2, 1.2)

            wait_until(is_there)
            process.kill()
            process.wait()
        with gateway(robots.port, "--quiet"):  # its first words are STOP and CLOSE
            wait_until(lambda: watcher.is_at(1, 0.0) and watcher.arm is not None and not watcher.arm.powered)


def test_powerbots_arm_moves_and_halts_when_its_gateway_is_killed(name: str, bus: Bus) -> None:
    with ExitStack() as stack:
        robots: EmulatedRobots = stack.enter_context(
            emulator("--robot", f"powerbot:{name}", "--fit", "arm", "--world", "empty", "--link", "rs232")
        )
        ports = (robots.port, "--arm", robots.robots[0]["arm_port"], "--quiet")
        watcher = Watcher(bus, name)
        with gateway(*ports) as process:
            wait_until(lambda: watcher.order(do="home"))
            wait_until(lambda: watcher.arm is not None and watcher.arm.homed)
            assert watcher.order(do="move", joints={"2": 0.4, "8": 0.05})
            wait_until(lambda: watcher.is_at(2, 0.4) and watcher.is_at(8, 0.05))
            assert watcher.order(do="move", joints={"2": 1.6}, speed=0.2, detach=True)
            wait_until(lambda: watcher.joints.position[1] > 0.45)  # it is on its way
            process.kill()
            process.wait()
        killed_at = robots.ask("truth")["time"]
        wait_until(lambda: robots.ask("truth")["time"] > killed_at + 1.2)  # longer than the modules wait for a host
        watcher.arm = None
        with gateway(*ports):
            wait_until(lambda: watcher.arm is not None)
            assert not watcher.arm.powered
            assert 0.4 < watcher.joints.position[1] < 1.0
            assert watcher.order(do="power", on=True)
            wait_until(lambda: watcher.order(do="move", joints={"2": 0.4}))
            wait_until(lambda: watcher.is_at(2, 0.4))
