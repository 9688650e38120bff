"""Arms with physics: where their joints end up, what they lift, and what they do to the robot that carries them."""

from collections.abc import Callable, Sequence
from math import degrees, hypot, radians

import pytest

from configs import load
from geometry import wrap_angle
from p2os.accessories.arm_model import ArmModel
from p2os.accessories.powercube import (
    CubeCommand,
    CubeState,
    ModuleParameter,
    ModuleRequest,
    MotionKind,
)
from p2os.robot_model import RobotModel
from p2os_emu.accessories.powercube import PowerCubeArm
from p2os_emu.body import ArmMechanism
from p2os_emu.fit import Fit
from p2os_emu.world import STEP, RobotBody, World
from p2os_emu.world.links import FIRST

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]
Roll = Callable[[World, RobotBody, float, float], None]

PIONEER, POWERCUBE = ("p3dx", "pioneer"), ("powerbot", "powercube")
STRETCHED = {"pioneer": (0.0,) * 6, "powercube": (0.0, radians(90), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)}
"""Level and ahead, where it weighs most."""


class Armed:
    """A robot with an arm in a world."""

    def __init__(self, world: World, model: RobotModel, variant: str) -> None:
        self.world = world
        self.model = load(ArmModel, "accessories", f"{variant}-arm")
        self.body = world.add_robot("robot", model, fit=Fit({"arm": variant}))
        assert self.body.arm is not None
        self.arm: ArmMechanism = self.body.arm

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            self.world.step()

    def reach(self, places: Sequence[float], speed: float = 1.0, seconds: float = 4.0) -> None:
        for joint, place in enumerate(places):
            self.arm.move(joint, place, speed if joint < len(places) - 1 else 0.05)
        self.run(seconds)

    def errors_deg(self, places: Sequence[float]) -> list[float]:
        """Of the turning joints."""
        return [abs(degrees(is_ - want)) for is_, want in zip(self.arm.positions, places, strict=True)][:-1]


@pytest.fixture
def make_armed(make_world: MakeWorld, model: Models) -> Callable[[tuple[str, str]], Armed]:
    return lambda which: Armed(make_world(), model(which[0]), which[1])


MakeArmed = Callable[[tuple[str, str]], Armed]


@pytest.mark.parametrize("which", [PIONEER, POWERCUBE])
def test_arm_without_power_rests_at_home(which: tuple[str, str], make_armed: MakeArmed) -> None:
    armed = make_armed(which)
    armed.run(5.0)
    assert max(armed.errors_deg(armed.model.home)) < 1.0


@pytest.mark.parametrize(
    ("which", "places"),
    [
        (PIONEER, (0.7, 0.2, -0.3, 0.5, -0.4, 0.03)),
        (PIONEER, STRETCHED["pioneer"]),
        (POWERCUBE, (0.5, 1.2, 0.4, -0.8, 0.3, 0.9, -0.7, 0.05)),
        (POWERCUBE, STRETCHED["powercube"]),
    ],
)
def test_joints_reach_their_targets_within_a_degree(
    which: tuple[str, str], places: tuple[float, ...], make_armed: MakeArmed
) -> None:
    armed = make_armed(which)
    armed.reach(places)
    assert max(armed.errors_deg(places)) < 1.0
    assert armed.arm.positions[-1] == pytest.approx(places[-1], abs=0.001)
    assert max(map(abs, armed.arm.velocities)) < 0.01


@pytest.mark.parametrize("which", [PIONEER, POWERCUBE])
def test_joints_turn_as_fast_as_they_are_told_and_stop_at_their_ends(
    which: tuple[str, str], make_armed: MakeArmed
) -> None:
    armed = make_armed(which)
    armed.arm.move(0, 9.0, 0.5)
    armed.run(1.0)
    assert armed.arm.velocities[0] == pytest.approx(0.5, abs=0.02)
    assert degrees(armed.arm.positions[0]) == pytest.approx(degrees(0.5), abs=1.0)
    armed.arm.move(0, 9.0, 2.0)
    armed.run(2.0)
    assert armed.arm.positions[0] == pytest.approx(armed.model.joints[0].upper, abs=radians(1))


def test_stretched_arm_without_power_sinks_to_the_end_of_its_shoulder(make_armed: MakeArmed) -> None:
    armed = make_armed(PIONEER)
    armed.reach(STRETCHED["pioneer"])
    for joint in range(6):
        armed.arm.release(joint)
    armed.run(3.0)
    assert degrees(armed.arm.positions[1]) == pytest.approx(-27, abs=1.0)


def _lift(armed: Armed, load_kg: float) -> tuple[PowerCubeArm, float]:
    """Let the shoulder of the stretched arm raise a load that hangs at its finger tips; its modules, and deg raised."""
    device = PowerCubeArm(armed.model, armed.arm)

    def tell(module: int, request: ModuleRequest, seconds: float) -> None:
        device.receive(request.encode(module))
        for step in range(round(seconds / STEP)):
            if step % 60 == 0:
                device.receive(ModuleRequest(CubeCommand.GET, ModuleParameter.STATE).encode(1))
            device.step(STEP)
            armed.world.step()

    tell(0, ModuleRequest(CubeCommand.HOME), 0.5)
    tell(2, ModuleRequest(CubeCommand.MOVE, MotionKind.RAMP_ACKNOWLEDGED, radians(90)), 3.5)
    finger = armed.model.gripper.mass_kg
    for link in (FIRST + 7, FIRST + 8):
        armed.world._client.changeDynamics(armed.body.body_id, link, mass=finger + load_kg / 2)
    before = armed.arm.positions[1]
    tell(2, ModuleRequest(CubeCommand.MOVE, MotionKind.RAMP_ACKNOWLEDGED, radians(45)), 2.5)
    return device, degrees(before - armed.arm.positions[1])


def test_powercube_arm_lifts_three_kilograms_at_full_stretch(make_armed: MakeArmed) -> None:
    device, raised = _lift(make_armed(POWERCUBE), 3.0)
    assert raised == pytest.approx(45, abs=1.0)
    assert device.cubes[1].state == CubeState.HOMED


def test_powercube_arm_does_not_lift_more_and_says_so(make_armed: MakeArmed) -> None:
    device, raised = _lift(make_armed(POWERCUBE), 4.0)
    assert raised < 2.0
    assert CubeState.LAGS | CubeState.ERROR | CubeState.HALTED in device.cubes[1].state


@pytest.mark.parametrize("which", [PIONEER, POWERCUBE])
def test_robot_drives_as_exactly_with_its_arm_stretched_out(
    which: tuple[str, str], make_armed: MakeArmed, roll: Roll
) -> None:
    armed = make_armed(which)
    armed.reach(STRETCHED[which[1]], seconds=2.0)
    body, start = armed.body, armed.world.truth("robot").pose
    rolled = body.state
    roll(armed.world, body, 1.0, 1.0)
    travelled = (body.state.left_travel + body.state.right_travel - rolled.left_travel - rolled.right_travel) / 2
    there = armed.world.truth("robot").pose
    assert hypot(there.x - start.x, there.y - start.y) == pytest.approx(travelled, abs=0.002)
    arc = body.model.wheel_track * radians(90) / 2
    rolled = body.state
    roll(armed.world, body, -arc, arc)
    turned = (
        body.state.right_travel - rolled.right_travel - body.state.left_travel + rolled.left_travel
    ) / body.model.wheel_track
    true = wrap_angle(armed.world.truth("robot").pose.heading - there.heading)
    assert degrees(true - turned) == pytest.approx(0.0, abs=0.3)


@pytest.mark.parametrize("which", [PIONEER, POWERCUBE])
def test_robot_stays_where_it_is_while_its_arm_swings(which: tuple[str, str], make_armed: MakeArmed) -> None:
    armed = make_armed(which)
    armed.reach(STRETCHED[which[1]])
    armed.reach(armed.model.home)
    pose = armed.world.truth("robot").pose
    assert hypot(pose.x, pose.y) < 0.003
    assert abs(degrees(pose.heading)) < 0.3
    armed.run(10.0)
    rest = armed.world.truth("robot").pose
    assert hypot(rest.x - pose.x, rest.y - pose.y) < 0.0005


def test_robot_without_an_arm_has_none(make_world: MakeWorld, model: Models) -> None:
    world = make_world()
    body = world.add_robot("robot", model("p3dx"))
    assert body.arm is None
    assert world._client.getNumJoints(body.body_id) == 2
