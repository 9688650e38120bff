"""Kinematics of both arms: the tip by the joints as in the emulator's physics, and joints for a point, or a refusal."""

from contextlib import suppress
from dataclasses import replace
from math import atan2, cos, pi, sin

import numpy as np
import pytest

from agents.components.arm_kinematics import ArmKinematics
from agents.components.hand_direction import ReachError
from configs import load
from gateway.elements.arm.adapter import _chain
from p2os.accessories.arm_model import ArmModel
from p2os.robot_model import RobotModel
from p2os_emu.fit import Fit
from p2os_emu.world import World
from p2os_emu.world.engine import engine
from p2os_emu.world.links import FIRST
from p2os_emu.world.spec import WorldSpec

ROBOTS = {"pioneer": "p3dx-sh", "powercube": "powerbot"}
SEED = 5


def kinematics(variant: str) -> ArmKinematics:
    model = load(ArmModel, "accessories", f"{variant}-arm")
    robot = load(RobotModel, "robots", ROBOTS[variant])
    hull = {"length_front": robot.length_front, "length_rear": robot.length_rear, "width": robot.width}
    rows = [{"unit": "rad", "lower": each.lower, "upper": each.upper, "home": each.home} for each in model.joints]
    found = ArmKinematics.of({"joints": rows, "chain": _chain(model), "hull": hull})
    assert found is not None
    return found


@pytest.fixture(params=ROBOTS)
def variant(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_tip_is_where_the_physics_have_the_fingers(variant: str) -> None:
    arm, model = kinematics(variant), load(ArmModel, "accessories", f"{variant}-arm")
    rng = np.random.default_rng(SEED)
    with World(WorldSpec("empty"), perfect=True) as world:
        robot = world.add_robot("robot", load(RobotModel, "robots", ROBOTS[variant]), fit=Fit({"arm": variant}))
        client, body = robot._client, robot.body_id  # the physics themselves are the truth
        pose = world.truth("robot").pose
        fingers = FIRST + len(model.joints)
        ahead = np.array(model.gripper.offset_m) / np.linalg.norm(model.gripper.offset_m)
        half = abs(ahead @ np.array(model.gripper.finger_m)) / 2.0
        for _ in range(20):
            angles = arm.lower + (arm.upper - arm.lower) * rng.random(len(arm.lower))
            for number, angle in enumerate(angles):
                client.resetJointState(body, FIRST + number, angle)
            ends = []
            for finger in (fingers, fingers + 1):
                state = client.getLinkState(body, finger, computeForwardKinematics=True)
                turned = np.array(engine.getMatrixFromQuaternion(state[1])).reshape(3, 3)
                ends.append(np.array(state[0]) + turned @ ahead * half)
            x, y, z = (ends[0] + ends[1]) / 2.0
            assert arm.forward(angles) == pytest.approx((*pose.locate(x, y), z), abs=0.002)


def test_points_that_a_posture_has_are_reached(variant: str) -> None:
    arm, rng = kinematics(variant), np.random.default_rng(SEED)
    reached = 0
    for _ in range(12):
        posture = arm.lower + (arm.upper - arm.lower) * rng.random(len(arm.lower))
        point = arm.forward(posture)
        if arm._meets(posture) or arm.hull.contains(point[None])[0]:
            continue
        with suppress(ReachError):  # a way on which it meets nothing was not found
            angles = arm.reach(point, arm.home)
            reached += 1
            assert np.all(angles >= arm.lower)
            assert np.all(angles <= arm.upper)
            assert np.linalg.norm(arm.forward(angles) - point) < 0.003
    assert reached >= 4


def test_same_question_has_the_same_answer(variant: str) -> None:
    arm = kinematics(variant)
    point = arm.forward(arm.home + 0.2 * (arm.lower < arm.home - 0.3) * -1.0)
    assert np.array_equal(arm.reach(point, arm.home), arm.reach(point, arm.home))


def test_present_posture_is_kept_where_the_tip_is_there_already(variant: str) -> None:
    arm = kinematics(variant)
    begin = arm.home - 0.3 * (arm.upper - arm.lower) * (np.arange(len(arm.home)) == 1)
    begin = np.clip(begin, arm.lower, arm.upper)
    assert arm.reach(arm.forward(begin), begin) == pytest.approx(begin, abs=0.01)


@pytest.mark.parametrize(
    ("point", "why"),
    [
        ((2.0, 0.0, 0.5), "it is out of the arm's reach; the nearest point that it reaches is 1"),
        ((0.3, 0.0, -0.1), "is below the floor; the nearest one is 0.1 m above it"),
        ((0.0, 0.0, 0.15), "is inside the robot's own body; its surface is 0"),
        ((float("nan"), 0.0, 0.3), "a point is x, y and z in m"),
    ],
)
def test_refusal_has_the_reason_and_the_nearest_distance(variant: str, point: tuple[float, ...], why: str) -> None:
    arm = kinematics(variant)
    with pytest.raises(ReachError) as refused:
        arm.reach(point, arm.home)
    assert why in str(refused.value)


WORKSPACE = {  # x, y, z, m, and pitch, rad: from and to
    "pioneer": ((0.42, 0.55), (-0.15, 0.15), (0.12, 0.35), (0.0, 0.6)),
    "powercube": ((0.45, 0.58), (-0.2, 0.2), (0.37, 0.5), (0.6, pi / 2)),
}


def test_hand_points_where_it_is_told_with_level_fingers_and_the_tip_at_the_point(variant: str) -> None:
    arm, rng = kinematics(variant), np.random.default_rng(SEED)
    reached = 0
    for _ in range(16):
        x, y, z, pitch = (float(rng.uniform(*ends)) for ends in WORKSPACE[variant])
        with suppress(ReachError):  # not every direction is in reach everywhere; enough are, as counted below
            angles = arm.reach((x, y, z), arm.home, pitch)
            reached += 1
            assert np.all((angles >= arm.lower) & (angles <= arm.upper))
            assert np.linalg.norm(arm.forward(angles) - (x, y, z)) < 0.003
            hand, yaw = arm.direction(angles), atan2(y - arm.base[1], x - arm.base[0])
            assert hand.ahead == pytest.approx((cos(pitch) * cos(yaw), cos(pitch) * sin(yaw), -sin(pitch)), abs=0.012)
            assert abs(hand.across @ (-sin(yaw), cos(yaw), 0.0)) > 0.999, "the fingers part level"
    assert reached >= 10


def test_hand_turns_to_a_yaw_that_is_not_that_of_the_point() -> None:
    arm = kinematics("powercube")
    hand = arm.direction(arm.reach((0.5, 0.0, 0.45), arm.home, 1.2, 0.5))
    assert atan2(hand.ahead[1], hand.ahead[0]) == pytest.approx(0.5, abs=0.03)
    assert hand.across[2] == pytest.approx(0.0, abs=0.012)


def test_arm_that_reaches_straight_ahead_is_not_twisted() -> None:
    arm = kinematics("powercube")
    low = arm.reach((0.53, 0.0, 0.38), arm.home, pi / 2)
    high = arm.reach((0.53, 0.0, 0.55), low, pi / 2)
    for angles in (low, high):
        assert angles[[0, 2, 4]] == pytest.approx((0.0, 0.0, 0.0), abs=0.02)


@pytest.mark.parametrize(
    ("pitch", "yaw", "why"),
    [
        (1.8, None, "pitch must be -1.571 to 1.571 rad, not 1.8"),
        (float("nan"), None, "pitch must be -1.571 to 1.571 rad, not nan"),
        (0.5, 4.0, "yaw must be -3.142 to 3.142 rad, not 4"),
        (None, 0.5, "yaw 0.5 rad needs a pitch"),
        (-1.5, None, "with the hand in this direction; the nearest posture that was found is 0"),
    ],
)
def test_refusal_of_a_direction_has_the_reason(pitch: float | None, yaw: float | None, why: str) -> None:
    arm = kinematics("powercube")
    with pytest.raises(ReachError) as refused:
        arm.reach((0.53, 0.0, 0.38), arm.home, pitch, yaw)
    assert why in str(refused.value)


def test_arm_that_does_not_tell_how_its_fingers_part_takes_no_direction() -> None:
    arm = replace(kinematics("powercube"), fingers=np.zeros(3))
    with pytest.raises(ReachError, match="is not known; leave out pitch and yaw"):
        arm.reach((0.53, 0.0, 0.38), arm.home, 1.5)


def test_limit_of_a_joint_is_the_reason_where_it_is() -> None:
    arm = kinematics("pioneer")
    behind = arm.forward(np.array([pi, 0.6, 0.3, 0.0, 0.0]))  # the base turns a quarter only
    with pytest.raises(ReachError, match=r"the limit of joint .* is in the way; the nearest point"):
        arm.reach(behind, arm.home)


def test_arm_without_lengths_has_no_kinematics() -> None:
    assert ArmKinematics.of({"joints": []}) is None
