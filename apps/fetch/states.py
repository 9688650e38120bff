"""What a robot that fetches knows, does, and is to do."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any, Self

from geometry import Pose2D, Twist2D


class FetchState(Enum):
    """What the robot does."""

    SEARCH = "looks about"
    WANDER = "drives to look from another place"
    APPROACH = "drives to the object"
    ALIGN = "turns to the object"
    ADVANCE = "drives the object between the paddles"
    GRIP = "closes the gripper"
    LIFT = "raises the object"
    CARRY = "carries the object"
    TURN_BACK = "backs off with the object"
    DELIVER = "brings the object over the place"
    LOWER = "lowers the object"
    RELEASE = "opens the gripper"
    BACK_OFF = "backs off"
    RETRY = "backs off to try again"
    DELIVERED = "has delivered"
    GIVEN_UP = "has given up"


@dataclass(frozen=True, slots=True)
class GripperState:
    """The gripper as its agent reports it: places in a word each, its beams, and whether it holds something."""

    paddles: str
    lift: str
    outer_beam: bool
    inner_beam: bool
    holds: bool

    @classmethod
    def of(cls, result: Mapping[str, Any]) -> Self:
        """Return the state that a result of the gripper's agent describes."""
        beams = bool(result["outer_beam"]), bool(result["inner_beam"])
        return cls(str(result["paddles"]), str(result["lift"]), *beams, bool(result["holds"]))


@dataclass(frozen=True, slots=True)
class FetchReadings:
    """What is known at one moment.

    time: s. pose: in odom. gripper: None before its first report. images: usable ones so far. blind: why the camera is
    of no use, in words; empty if it is. has_stalled: the wheels stall, or a bumper is pressed.
    """

    time: float
    pose: Pose2D
    gripper: GripperState | None
    images: int
    blind: str = ""
    has_stalled: bool = False


@dataclass(frozen=True, slots=True)
class FetchOrders:
    """What to do: velocity, and what the gripper is to do in a word, empty for nothing new. reason: in words."""

    twist: Twist2D
    gripper: str
    state: FetchState
    reason: str
    changed: bool
