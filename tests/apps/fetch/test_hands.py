"""An arm as a hand: which motions it makes of the fetcher's words, and what it concludes from its readings."""

from itertools import pairwise
from math import pi

import pytest

from apps.fetch.hands import ArmHand
from apps.fetch.settings import FetchSettings
from apps.fetch.states import HandMotion
from tests.agents.components.test_arm_kinematics import kinematics as arm_kinematics

SETTINGS = FetchSettings.load_for_arm()
OPENING = 0.07
JOINTS = [*({"name": f"max/arm_joint_{number}", "unit": "rad", "upper": 1.7} for number in range(1, 8))]
FINGERS = {"name": "max/arm_joint_8", "unit": "m", "upper": OPENING}
HEIGHT = 0.4  # m, of the object


class ToyArm:
    """Makes the motions of a hand at once.

    width: of what is between the fingers, m; 0 for nothing. refuses: the reason for which it makes no motion of the
    hand. motions: what it was told.
    """

    def __init__(self, width: float = 0.0) -> None:
        hand = ArmHand.of(SETTINGS, {"joints": [*JOINTS, FINGERS]})
        assert hand is not None
        self.hand, self.width, self.refuses = hand, width, ""
        self.opening = 0.0
        self.motions: list[HandMotion] = []
        self.read()

    def read(self) -> None:
        self.hand.take({"joints": {1: 0.0, 8: self.opening}})

    def make(self) -> bool:
        """Make the next motion; returns whether there was one."""
        motion = self.hand.motion()
        if motion is None:
            return False
        self.motions.append(motion)
        if motion.request == "move":
            self.opening = max(self.width, motion.arguments["joints"]["8"])
            self.read()
        self.hand.ended(motion, self.refuses if motion.request == "reach" else "")
        return True

    def do(self, word: str) -> None:
        self.hand.order(word, HEIGHT)
        while self.make():
            pass

    @property
    def tips(self) -> list[float]:
        """Heights to which the hand was sent, m."""
        return [motion.arguments["z"] for motion in self.motions if motion.request == "reach"]

    @property
    def words(self) -> tuple[str, str, bool]:
        assert self.hand.state is not None
        return self.hand.state.fingers, self.hand.state.height, self.hand.state.holds


def test_hand_grips_near_the_top_of_the_object_and_points_down() -> None:
    arm = ToyArm()
    arm.do("deploy")
    assert [motion.request for motion in arm.motions] == ["move", "reach"]
    place = arm.motions[-1].arguments
    assert place["z"] == pytest.approx(HEIGHT - SETTINGS.arm.overlap_m)
    assert (place["x"], place["y"], place["yaw"]) == (SETTINGS.robot.grip_m, 0.0, 0.0)
    assert place["pitch"] == pytest.approx(pi / 2, abs=0.001)
    assert arm.words == ("open", "down", False)


def test_fingers_close_by_small_steps_and_hold_what_stops_them() -> None:
    arm = ToyArm(width=0.043)
    arm.do("deploy")
    arm.do("close")
    assert arm.words == ("between", "down", True)
    targets = [motion.arguments["joints"]["8"] for motion in arm.motions if motion.request == "move"]
    assert arm.opening - targets[-1] < SETTINGS.arm.step_m + 0.004, "they press with a bounded lag"
    assert arm.opening - targets[-1] > 0.0025


def test_fingers_that_close_on_nothing_hold_nothing() -> None:
    arm = ToyArm()
    arm.do("deploy")
    arm.do("close")
    assert arm.words == ("closed", "down", False)


def test_object_is_raised_and_lowered_by_small_steps_to_where_it_was_gripped() -> None:
    arm = ToyArm(width=0.043)
    for word in ("deploy", "close", "up"):
        arm.do(word)
    tips = arm.tips
    assert arm.words == ("between", "up", True)
    assert tips[-1] == pytest.approx(tips[0] + SETTINGS.robot.lift_m)
    assert max(b - a for a, b in pairwise(tips)) < 1.3 * SETTINGS.arm.raise_m
    arm.do("down")
    assert arm.tips[-1] == pytest.approx(tips[0])
    assert arm.words == ("between", "down", True)


def test_object_that_slips_out_is_held_no_more() -> None:
    arm = ToyArm(width=0.043)
    for word in ("deploy", "close", "up"):
        arm.do(word)
    arm.opening -= SETTINGS.arm.step_m  # what the fingers were still told
    arm.read()
    assert not arm.words[2]


def test_hand_opens_before_it_is_raised_from_what_it_has_put_down() -> None:
    arm = ToyArm(width=0.043)
    for word in ("deploy", "close", "up", "down"):
        arm.do(word)
    arm.motions.clear()
    arm.width = 0.0
    arm.do("open")
    assert arm.motions[0].arguments == {"joints": {"8": OPENING}}
    assert arm.words == ("open", "up", False)


def test_hand_that_is_up_is_not_lowered_to_be_raised() -> None:
    arm = ToyArm(width=0.043)
    for word in ("deploy", "close", "up"):
        arm.do(word)
    highest = arm.tips[-1]
    arm.motions.clear()
    arm.do("open")
    assert arm.tips == [highest]


def test_robot_may_back_off_when_the_hand_has_moved() -> None:
    arm = ToyArm()
    arm.do("deploy")
    arm.hand.order("open", HEIGHT)
    assert arm.hand.state is not None
    assert not arm.hand.is_clear(arm.hand.state)
    while arm.make():
        pass
    assert arm.hand.is_clear(arm.hand.state)


def test_motion_that_is_refused_ends_its_order_and_leaves_the_reason() -> None:
    arm = ToyArm()
    arm.refuses = "it is out of the arm's reach"
    arm.do("deploy")
    assert arm.words == ("open", "between", False)
    assert arm.hand.trouble == "it is out of the arm's reach"
    arm.refuses = ""
    arm.do("deploy")
    assert (arm.words[1], arm.hand.trouble) == ("down", "")


def test_end_of_a_motion_that_another_order_has_replaced_is_ignored() -> None:
    arm = ToyArm()
    arm.hand.order("deploy", HEIGHT)
    before = arm.hand.motion()
    assert before is not None
    arm.hand.order("close", HEIGHT)
    assert arm.hand.motion() is not None
    arm.hand.ended(before)
    assert arm.hand.motion() is None, "the newer one is still under way"


def test_object_beside_the_fingers_is_missed_before_they_touch_it() -> None:
    hand = ToyArm().hand
    near, width = SETTINGS.arm.check_m - 0.01, 0.05
    assert not hand.misses(near, 0.009, width)
    assert hand.misses(near, -0.011, width)
    assert not hand.misses(near + 0.2, -0.011, width), "the robot still steers"


def test_low_object_is_gripped_no_lower_than_the_hand_gets() -> None:
    arm = ToyArm()
    arm.hand.order("deploy", 0.2)
    while arm.make():
        pass
    assert arm.tips == [SETTINGS.arm.lowest_m]


@pytest.mark.parametrize("height", [SETTINGS.object.lowest_m, SETTINGS.object.highest_m])
def test_arm_of_a_powerbot_gets_to_every_place_of_the_hand(height: float) -> None:
    arm, kinematics = ToyArm(width=0.043), arm_kinematics("powercube")
    for word in ("deploy", "close", "up", "down"):
        arm.hand.order(word, height)
        while arm.make():
            pass
    angles = kinematics.home
    for motion in arm.motions:
        if motion.request == "reach":
            x, y, z, pitch, yaw = (motion.arguments[name] for name in ("x", "y", "z", "pitch", "yaw"))
            angles = kinematics.reach((x, y, z), angles, pitch, yaw)


def test_arm_whose_last_joint_opens_no_fingers_is_no_hand() -> None:
    assert ArmHand.of(SETTINGS, {"joints": JOINTS}) is None
    assert ArmHand.of(SETTINGS, {}) is None


def test_hand_before_its_first_reading_has_no_state() -> None:
    hand = ArmHand.of(SETTINGS, {"joints": [*JOINTS, FINGERS]})
    assert hand is not None
    assert hand.state is None
    hand.take({"joints": {8: None}})
    assert hand.state is None
