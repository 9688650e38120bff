"""Fingers of both arms close on objects, hold, raise and carry them, and let them go."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import hypot, radians

import pytest

from configs import load
from geometry import Pose2D
from p2os.accessories.arm_model import ArmModel
from p2os.robot_model import RobotModel
from p2os_emu.body import ArmMechanism
from p2os_emu.fit import Fit
from p2os_emu.world import STEP, World, WorldSpec
from p2os_emu.world.movable import Movable, Shape

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]

RUN_UP = 0.25  # m
TURNED = 2.0  # s for one motion of the arm


@dataclass(frozen=True)
class Case:
    """An arm, and how it grips: degrees of the joints, of those when it has raised, and what stands between fingers."""

    robot: str
    variant: str
    grips: tuple[float, ...]
    raised: tuple[float, ...]
    thing: Movable


POST = Movable("thing", Shape.CYLINDER, Pose2D(0.53), 0.045, 0.045, 0.38, 0.4, 0.5, "red")
TIN = Movable("thing", Shape.CYLINDER, Pose2D(0.45), 0.035, 0.035, 0.12, 0.05, 0.5, "red")
POWERCUBE = Case("powerbot-sh", "powercube", (0, 100, 0, 60, 0, 20, 90), (0, 70, 0, 90, 0, 20, 90), POST)
PIONEER = Case("p3dx-sh", "pioneer", (0, -15, -65, 0, 60), (0, 10, -65, 0, 60), TIN)


class Hand:
    """A robot with an arm that has driven up to something, which is between the open fingers now."""

    def __init__(self, make_world: MakeWorld, model: RobotModel, case: Case, thing: Movable) -> None:
        self.arm_model = load(ArmModel, "accessories", f"{case.variant}-arm")
        self.case = case
        self.world = make_world(WorldSpec("hand", objects=(thing,)))
        self.body = self.world.add_robot("robot", model, Pose2D(-RUN_UP), fit=Fit({"arm": case.variant}))
        assert self.body.arm is not None
        self.arm: ArmMechanism = self.body.arm
        self.open = self.arm_model.gripper.opening_m
        self.move(self.arm_model.home[:-1], tuple(map(radians, case.grips)))
        self.fingers(self.open)
        while self.world.truth("robot").pose.x < 0.0:
            self.run(STEP, wheels=(0.1, 0.1))
        self.run(0.3)

    def run(self, seconds: float, wheels: tuple[float, float] = (0.0, 0.0)) -> None:
        self.body.drive(*wheels)
        for _ in range(round(seconds / STEP)):
            self.world.step()

    def move(self, begin: Sequence[float], end: Sequence[float]) -> None:
        """Turn all joints evenly."""
        moments = round(TURNED / 0.05)
        for moment in range(1, moments + 1):
            share = moment / moments
            for joint, (a, b) in enumerate(zip(begin, end, strict=True)):
                self.arm.move(joint, a + share * (b - a), 1.5)
            self.run(0.05)
        self.run(0.3)

    def fingers(self, opening: float) -> None:
        self.arm.move(len(self.case.grips), opening, 0.05)
        self.run(1.5)

    def raise_it(self, down: bool = False) -> None:
        ends = self.case.grips, self.case.raised
        begin, end = (tuple(map(radians, each)) for each in (ends[::-1] if down else ends))
        self.move(begin, end)

    @property
    def thing(self) -> tuple[float, float, float]:
        """The thing as its robot sees it: m ahead of the axle, to the left, above the floor."""
        place = self.world.object_places()["thing"]
        return (*self.world.truth("robot").pose.locate(place.x, place.y), place.z)


MakeHand = Callable[..., Hand]


@pytest.fixture
def make_hand(make_world: MakeWorld, model: Models) -> MakeHand:
    return lambda case, thing=None: Hand(make_world, model(case.robot), case, thing or case.thing)


@pytest.mark.parametrize("case", [PIONEER, POWERCUBE], ids=lambda case: str(case.variant))
def test_a_body_is_gripped_raised_carried_round_and_put_down(case: Case, make_hand: MakeHand) -> None:
    hand = make_hand(case)
    assert hand.world.held("robot") is None
    hand.fingers(case.thing.width - 0.01)
    assert hand.arm.holds
    assert hand.world.held("robot") == "thing"
    assert hand.arm.positions[-1] == pytest.approx(case.thing.width, abs=0.002), "the fingers are stopped by it"
    hand.raise_it()
    before = hand.thing
    assert before[2] > case.thing.height / 2.0 + 0.03
    for speeds in ((0.0, 0.0), (0.3, 0.3), (-0.2, 0.2), (-0.3, -0.2)):
        hand.run(2.0, wheels=speeds)
    hand.run(1.0)
    assert hypot(*hand.world.object_places()["thing"][:2]) > 0.3
    assert hand.thing == pytest.approx(before, abs=0.01)
    hand.raise_it(down=True)
    hand.fingers(hand.open)
    assert hand.world.held("robot") is None
    hand.run(2.0, wheels=(-0.2, -0.2))
    assert hand.world.object_places()["thing"].z == pytest.approx(case.thing.height / 2.0, abs=0.002)


def test_held_for_long_it_stays_between_the_fingers(make_hand: MakeHand) -> None:
    hand = make_hand(POWERCUBE)
    hand.fingers(POST.width - 0.01)
    hand.raise_it()
    before = hand.thing
    hand.run(20.0)
    assert hand.thing == pytest.approx(before, abs=0.003)


def test_fingers_without_power_keep_what_they_hold(make_hand: MakeHand) -> None:
    hand = make_hand(POWERCUBE)
    hand.fingers(POST.width - 0.01)
    hand.raise_it()
    for joint in range(8):
        hand.arm.release(joint)
    hand.run(3.0)
    assert hand.world.held("robot") == "thing"
    assert hand.thing[2] > POST.height / 2.0 + 0.03


def test_what_is_too_heavy_for_the_friction_of_the_fingers_stays_on_the_floor(make_hand: MakeHand) -> None:
    hand = make_hand(PIONEER, replace(TIN, mass=1.5))
    hand.fingers(TIN.width - 0.01)
    hand.raise_it()
    assert hand.thing[2] < TIN.height / 2.0 + 0.02


def test_fingers_that_close_on_nothing_hold_nothing(make_hand: MakeHand) -> None:
    hand = make_hand(POWERCUBE, replace(POST, pose=Pose2D(1.5)))
    hand.fingers(0.0)
    assert hand.world.held("robot") is None
    assert not hand.arm.holds
    assert hand.arm.positions[-1] == pytest.approx(0.0, abs=0.001)


def test_a_robot_that_is_lifted_off_leaves_what_it_held(make_hand: MakeHand) -> None:
    hand = make_hand(POWERCUBE)
    hand.fingers(POST.width - 0.01)
    hand.world.place("robot", Pose2D(3.0))
    assert hand.world.held("robot") is None
