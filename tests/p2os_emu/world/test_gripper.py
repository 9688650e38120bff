"""A gripper closes on bodies, holds, lifts, carries and puts them down; and its robot drives as well as without."""

from collections.abc import Callable
from dataclasses import replace
from math import degrees, hypot, pi

import pytest

from geometry import Pose2D, wrap_angle
from p2os.robot_model import RobotModel
from p2os_emu.body import GripperMechanism
from p2os_emu.fit import Fit
from p2os_emu.world import STEP, Block, RobotBody, World, WorldError, WorldSpec
from p2os_emu.world.movable import Movable, Shape

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]
Roll = Callable[[World, RobotBody, float, float], None]

WITH_GRIPPER = {"p3dx-sh": Fit({"gripper": "pioneer"}), "peoplebot-sh": Fit({"gripper": "peoplebot"})}
BOX = Movable("box", Shape.BOX, Pose2D(), 0.06, 0.06, 0.12, 0.3, 0.5, "red")
TIN = replace(BOX, shape=Shape.CYLINDER)
RUN_UP = 0.2  # m
BETWEEN = 0.03 + 0.05  # m ahead of the hull: in the middle of the paddles, between the beams


class Hand:
    """A robot with a gripper that has driven up to something, which is between its paddles now."""

    def __init__(self, make_world: MakeWorld, model: RobotModel, thing: Movable, aside: float) -> None:
        there = replace(thing, pose=Pose2D(model.length_front + BETWEEN, aside))
        self.world = make_world(WorldSpec("hand", objects=(there,)))
        self.body = self.world.add_robot("robot", model, Pose2D(-RUN_UP), fit=WITH_GRIPPER[model.name])
        assert self.body.gripper is not None
        self.gripper: GripperMechanism = self.body.gripper
        while self.world.truth("robot").pose.x < 0.0:
            self.run(STEP, wheels=(0.1, 0.1))
        self.run(0.1)

    def run(
        self, seconds: float, *, paddles: float = 0.0, lift: float = 0.0, wheels: tuple[float, float] = (0, 0)
    ) -> None:
        self.gripper.drive(paddles, lift)
        self.body.drive(*wheels)
        for _ in range(round(seconds / STEP)):
            self.world.step()

    def grip(self) -> None:
        """As the firmware does: close until both contacts, then 0.2 s more."""
        while not (self.gripper.state.left_contact and self.gripper.state.right_contact):
            self.run(STEP, paddles=-1.0)
        self.run(0.2, paddles=-1.0)
        self.run(0.1)

    @property
    def thing(self) -> tuple[float, float, float]:
        """The thing as its robot sees it: m ahead of the axle, to the left, above the floor."""
        place = self.world.object_places()["box"]
        return (*self.world.truth("robot").pose.locate(place.x, place.y), place.z)


MakeHand = Callable[..., Hand]


@pytest.fixture
def make_hand(make_world: MakeWorld, model: Models) -> MakeHand:
    return lambda thing=BOX, name="p3dx-sh", aside=0.0: Hand(make_world, model(name), thing, aside)


@pytest.mark.parametrize("thing", [BOX, TIN, replace(BOX, mass=1.0), replace(BOX, width=0.15, length=0.05)])
@pytest.mark.parametrize("name", WITH_GRIPPER)
def test_a_body_is_gripped_lifted_carried_round_and_put_down(name: str, thing: Movable, make_hand: MakeHand) -> None:
    hand = make_hand(thing, name)
    before = hand.thing
    hand.grip()
    assert hand.gripper.state.holds is True
    hand.run(4.0, lift=1.0)
    assert hand.gripper.state.lift == pytest.approx(1.0, abs=0.01)
    assert hand.thing == pytest.approx((before[0], before[1], before[2] + 0.07), abs=0.004)
    for speeds in ((0.0, 0.0), (0.3, 0.3), (-0.2, 0.2), (-0.3, -0.2)):
        hand.run(2.0, wheels=speeds)
    assert hypot(*hand.world.object_places()["box"][:2]) > 0.3
    assert hand.thing == pytest.approx((before[0], before[1], before[2] + 0.07), abs=0.01)
    hand.run(1.0)
    hand.run(4.0, lift=-1.0)
    hand.run(2.5, paddles=1.0)
    stood = hand.world.object_places()["box"]
    assert hand.gripper.state.opening == pytest.approx(1.0, abs=0.01)
    assert stood.z == pytest.approx(0.06, abs=0.002)
    hand.run(2.0, wheels=(-0.2, -0.2))
    left = hand.world.object_places()["box"]
    assert (left.x, left.y) == pytest.approx((stood.x, stood.y), abs=0.005)


def test_held_for_long_it_stays_in_the_paddles_and_its_robot_stands(make_hand: MakeHand) -> None:
    hand = make_hand()
    hand.grip()
    hand.run(4.0, lift=1.0)
    before, stood = hand.thing, hand.world.truth("robot").pose
    hand.run(20.0)
    pose = hand.world.truth("robot").pose
    assert hand.thing == pytest.approx(before, abs=0.003)
    assert hypot(pose.x - stood.x, pose.y - stood.y) < 0.02
    assert abs(wrap_angle(pose.heading - stood.heading)) < 0.02


def test_what_is_too_heavy_for_the_paddles_slips_out_of_them(make_hand: MakeHand) -> None:
    hand = make_hand(replace(BOX, mass=4.0))
    hand.grip()
    hand.run(4.0, lift=1.0)
    assert hand.thing[2] < 0.08


def test_more_grasp_time_holds_more(make_hand: MakeHand) -> None:
    hand = make_hand(replace(BOX, mass=1.5))
    hand.grip()
    hand.run(1.0, paddles=-1.0)
    hand.run(4.0, lift=1.0)
    assert hand.thing[2] == pytest.approx(0.13, abs=0.005)


def test_a_body_that_stands_aside_is_pushed_to_the_middle(make_hand: MakeHand) -> None:
    hand = make_hand(aside=0.04)
    hand.grip()
    assert abs(hand.thing[1]) < 0.01


def test_beams_and_contacts_see_what_stands_between_the_paddles(make_hand: MakeHand) -> None:
    hand = make_hand(replace(BOX, length=0.08))
    seen = hand.gripper.state
    assert (seen.outer_beam, seen.inner_beam) == (True, True)
    assert (seen.left_contact, seen.right_contact, seen.holds) == (False, False, False)
    hand.run(1.0, wheels=(-0.04, -0.04))
    seen = hand.gripper.state
    assert (seen.outer_beam, seen.inner_beam) == (True, False)
    hand.run(2.0, wheels=(-0.1, -0.1))
    seen = hand.gripper.state
    assert (seen.outer_beam, seen.inner_beam) == (False, False)


def test_empty_paddles_close_on_each_other_and_open_again(make_hand: MakeHand) -> None:
    hand = make_hand()
    hand.run(2.0, wheels=(-0.2, -0.2))
    assert hand.gripper.state.opening == pytest.approx(1.0, abs=0.01)
    hand.run(1.0, paddles=-1.0)
    halfway = hand.gripper.state
    assert halfway.opening == pytest.approx(0.5, abs=0.05)
    assert halfway.opening_speed == pytest.approx(-0.5, abs=0.05)
    hand.run(1.5, paddles=-1.0)
    closed = hand.gripper.state
    assert closed.opening == pytest.approx(0.0, abs=0.01)
    assert closed.left_contact
    assert closed.right_contact
    assert not closed.holds
    hand.run(2.5, paddles=1.0)
    assert hand.gripper.state.opening == pytest.approx(1.0, abs=0.01)


def test_the_lift_takes_three_and_a_half_seconds_and_stops_on_the_way(make_hand: MakeHand) -> None:
    hand = make_hand()
    hand.run(1.75, lift=1.0)
    assert hand.gripper.state.lift == pytest.approx(0.5, abs=0.03)
    assert hand.gripper.state.lift_speed == pytest.approx(1 / 3.5, abs=0.02)
    hand.run(1.0)
    assert hand.gripper.state.lift == pytest.approx(0.5, abs=0.03)
    hand.run(1.9, lift=1.0)
    assert hand.gripper.state.lift == pytest.approx(1.0, abs=0.01)


def test_a_robot_that_is_lifted_or_taken_away_lets_go(make_hand: MakeHand) -> None:
    hand = make_hand()
    hand.grip()
    hand.run(4.0, lift=1.0)
    hand.world.place("robot", Pose2D(3.0, 3.0, 0.0))
    hand.run(1.0)
    assert not hand.gripper.state.holds
    assert hand.world.object_places()["box"].x < 1.0
    again = make_hand()
    again.grip()
    again.world.remove_robot("robot")
    for _ in range(60):
        again.world.step()
    assert again.world.object_places()["box"].z == pytest.approx(0.06, abs=0.002)


def test_a_wall_stops_the_paddles(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WorldSpec("walled", walls=(Block(1.05, 0.0, 0.0, 0.1, 8.0, 2.0, "wall"),)))
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D(), fit=WITH_GRIPPER["p3dx-sh"])
    for _ in range(600):
        body.drive(0.2, 0.2)
        world.step()
    assert world.truth("robot").pose.x == pytest.approx(1.0 - 0.21 - 0.13, abs=0.01)
    assert body.state.left_load > 0.9


def test_a_gripper_needs_room_ahead(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WorldSpec("walled", walls=(Block(0.35, 0.0, 0.0, 0.1, 8.0, 2.0, "wall"),)))
    world.add_robot("bare", model("p3dx-sh"), Pose2D())
    with pytest.raises(WorldError, match="wall is in the way"):
        world.add_robot("robot", model("p3dx-sh"), Pose2D(0.0, 1.0, 0.0), fit=WITH_GRIPPER["p3dx-sh"])
    assert world.add_robot("other", model("p3dx-sh"), Pose2D(-0.05, 2.0, pi), fit=WITH_GRIPPER["p3dx-sh"]).gripper


@pytest.mark.parametrize("name", WITH_GRIPPER)
def test_a_robot_with_a_gripper_drives_as_accurately_as_one_without(
    name: str, model: Models, make_world: MakeWorld, roll: Roll
) -> None:
    world = make_world()
    body = world.add_robot("robot", model(name), fit=WITH_GRIPPER[name])
    roll(world, body, 2.0, 2.0)
    straight = world.truth("robot").pose
    assert (straight.x, straight.y) == pytest.approx((2.0, 0.0), abs=0.003)
    assert degrees(straight.heading) == pytest.approx(0.0, abs=0.1)
    begin = body.state
    arc = body.model.wheel_track * pi / 4
    roll(world, body, -arc, arc)
    turned = (
        body.state.right_travel - begin.right_travel - body.state.left_travel + begin.left_travel
    ) / body.model.wheel_track
    pose = world.truth("robot").pose
    assert degrees(turned) == pytest.approx(90.0, abs=0.2)
    assert degrees(wrap_angle(pose.heading - straight.heading - turned)) == pytest.approx(0.0, abs=0.3)


@pytest.mark.parametrize("name", WITH_GRIPPER)
def test_a_robot_with_a_gripper_stays_where_it_rests(name: str, model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    body = world.add_robot("robot", model(name), Pose2D(1.0, 2.0, 0.5), fit=WITH_GRIPPER[name])
    body.drive(0.0, 0.0)
    for _ in range(1200):
        world.step()
    pose = world.truth("robot").pose
    assert hypot(pose.x - 1.0, pose.y - 2.0) < 0.002
    assert pose.heading == pytest.approx(0.5, abs=0.002)


def test_the_same_calls_give_the_same_bits(make_hand: MakeHand) -> None:
    def run() -> object:
        hand = make_hand()
        hand.grip()
        hand.run(2.0, lift=1.0, wheels=(0.1, 0.2))
        return hand.thing, hand.gripper.state, hand.body.state

    assert run() == run()


def test_a_robot_without_gripper_has_none(model: Models, make_world: MakeWorld) -> None:
    assert make_world().add_robot("robot", model("p3dx-sh")).gripper is None
