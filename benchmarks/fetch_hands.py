"""Gripper and arm of a robot in lockstep, as its agents move them: motions begin over the bus, and end by readings."""

from collections.abc import Mapping
from contextlib import suppress
from typing import Any, Protocol

from agents.components.arm import ArmAgent
from agents.components.arm_kinematics import ArmKinematics
from agents.components.gripper import GripperAgent
from agents.components.hand_direction import ReachError
from apps.fetch.hands import ArmHand, Hand, PaddleHand
from apps.fetch.settings import FetchSettings
from apps.fetch.states import HandMotion
from bus import Bus, Refused, Sample, keys
from bus.messages import decode

_BEGINS = 0.4  # s in which an arm begins to move
_RESTS = 0.4  # s that it rests at the end of a motion


class LockstepHand(Protocol):
    """Makes the motions of a hand."""

    hand: Hand

    def begin(self, motion: HandMotion, now: float) -> None:
        """Begin a motion; now: s."""

    def step(self, now: float) -> None:
        """See whether the motion has ended; now: s."""


class LockstepGripper:
    """A gripper with paddles."""

    def __init__(self, bus: Bus, robot: str) -> None:
        self.hand: Hand = PaddleHand()
        self._bus, self._robot = bus, robot
        self._agent = GripperAgent(f"gripper@{robot}")
        bus.subscribe(keys.GRIPPER.key(robot), self._take)

    def begin(self, motion: HandMotion, now: float) -> None:
        """As `LockstepHand.begin`."""
        with suppress(Refused):  # it is reported by the gripper, that it does not move
            self._bus.query(keys.GRIP.key(self._robot), {"do": motion.request, "detach": True})

    def step(self, now: float) -> None:
        """As `LockstepHand.step`; the readings show it."""

    def _take(self, sample: Sample) -> None:
        self.hand.take(self._agent.result(decode(sample.type_name, sample.payload)))


class LockstepArm:
    """An arm, which is sent home at the start."""

    def __init__(self, bus: Bus, robot: str, description: Mapping[str, Any], settings: FetchSettings) -> None:
        row = next(row for row in description["elements"] if row["name"] == "arm")
        properties = ArmAgent.properties_of(description, row)
        hand, kinematics = ArmHand.of(settings, properties), ArmKinematics.of(properties)
        assert hand is not None
        assert kinematics is not None
        self.hand: Hand = hand
        self._kinematics = kinematics
        self._turning = len(kinematics.axes)
        self._bus, self._robot = bus, robot
        self._places: list[float] = []
        self._motion: HandMotion | None = None
        self._is_moving, self._rested_at, self._began_at = False, 0.0, 0.0
        bus.subscribe(keys.ARM.key(robot), self._take_arm)
        bus.subscribe(keys.JOINT_STATES.key(robot), self._take_joints)
        self._send({"do": "home"})

    def begin(self, motion: HandMotion, now: float) -> None:
        """As `LockstepHand.begin`."""
        self._motion, self._began_at, self._rested_at = motion, now, now
        given = dict(motion.arguments)
        try:
            if motion.request == "reach":
                point = given.pop("x"), given.pop("y"), given.pop("z")
                angles = self._kinematics.reach(
                    point, self._places[: self._turning], given.pop("pitch"), given.pop("yaw")
                )
                given["joints"] = {str(number): float(angle) for number, angle in enumerate(angles, 1)}
            self._send({"do": "move", **given})
        except (ReachError, Refused) as err:
            self._end(str(err))

    def step(self, now: float) -> None:
        """As `LockstepHand.step`."""
        if self._is_moving or now - self._began_at < _BEGINS:
            self._rested_at = now
        elif self._motion is not None and now - self._rested_at >= _RESTS:
            self._end()

    def _end(self, error: str = "") -> None:
        motion, self._motion = self._motion, None
        if motion is not None:
            self.hand.ended(motion, error)

    def _send(self, order: Mapping[str, Any]) -> None:
        self._bus.query(keys.REACH.key(self._robot), {**order, "detach": True})

    def _take_arm(self, sample: Sample) -> None:
        self._is_moving = any(decode(sample.type_name, sample.payload).moving)

    def _take_joints(self, sample: Sample) -> None:
        joints = decode(sample.type_name, sample.payload)
        if len(joints.name) == self._turning + 1 and "arm_joint_" in joints.name[0]:
            self._places = joints.position.tolist()
            self.hand.take({"joints": dict(enumerate(self._places, 1))})
