"""What a robot that fetches knows, does, and is to do."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from geometry import Pose2D, Twist2D


class FetchState(Enum):
    """What the robot does."""

    SEARCH = "looks about"
    WANDER = "drives to look from another place"
    APPROACH = "drives to the object"
    ALIGN = "turns to the object"
    ADVANCE = "drives the object between the fingers"
    GRIP = "closes the fingers"
    LIFT = "raises the object"
    CARRY = "carries the object"
    TURN_BACK = "backs off with the object"
    DELIVER = "brings the object over the place"
    LOWER = "lowers the object"
    RELEASE = "opens the fingers"
    BACK_OFF = "backs off"
    RETRY = "backs off to try again"
    DELIVERED = "has delivered"
    GIVEN_UP = "has given up"


@dataclass(frozen=True, slots=True)
class HandState:
    """A hand as it reports itself.

    fingers: `open`, `closed`, `moving` or `between`. height: `up`, `down`, `moving` or `between`. has_beam_broken:
    something is in the beam between the fingers, for hands with a beam. holds: it holds something.
    """

    fingers: str
    height: str
    has_beam_broken: bool
    holds: bool


@dataclass(frozen=True, slots=True)
class HandMotion:
    """A request for the agent of a gripper or an arm, with its arguments."""

    element: str
    request: str
    arguments: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class FetchReadings:
    """What is known at one moment.

    time: s. pose: in odom. hand: None before its first report. images: usable ones so far. blind: why the camera is
    of no use, in words; empty if it is. has_stalled: the wheels stall, or a bumper is pressed.
    """

    time: float
    pose: Pose2D
    hand: HandState | None
    images: int
    blind: str = ""
    has_stalled: bool = False


@dataclass(frozen=True, slots=True)
class FetchOrders:
    """What to do: velocity, and the motion that the hand is to begin, None for nothing new. reason: in words."""

    twist: Twist2D
    motion: HandMotion | None
    state: FetchState
    reason: str
    changed: bool
