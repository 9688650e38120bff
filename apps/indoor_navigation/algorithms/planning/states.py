"""The states of a mission, and what leads from one to another."""

from collections.abc import Mapping
from enum import StrEnum
from typing import Final

from apps.indoor_navigation.state_machine import from_each


class State(StrEnum):
    """What the robot is about."""

    IDLE = "idle"
    TURNING = "turning"
    GOING = "going"
    PASSING = "passing a door"
    BACKING = "backing"
    WAITING = "waiting"
    REPLANNING = "re-planning"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


class Event(StrEnum):
    """What happens to a mission."""

    TOLD = "told"
    CALLED_OFF = "called off"
    WAY_FOUND = "way found"
    WAY_BARRED = "way barred"
    CAME_NO_FARTHER = "came no farther"
    HAS_TO_TURN = "has to turn"
    HAS_TURNED = "has turned"
    HAS_TO_BACK = "has to back"
    HAS_BACKED = "has backed"
    DOOR_AHEAD = "door ahead"
    DOOR_PASSED = "door passed"
    WAITED_ENOUGH = "waited enough"
    BLIND = "blind"
    SEES_AGAIN = "sees again"
    POSE_JUMPED = "pose jumped"
    ARRIVED = "arrived"
    GIVEN_UP = "given up"


MOVING: Final = (State.TURNING, State.GOING, State.PASSING, State.BACKING)
ACTIVE: Final = (*MOVING, State.WAITING, State.REPLANNING)

TRANSITIONS: Final[Mapping[tuple[State, Event], State]] = {
    **from_each(State, Event.TOLD, State.REPLANNING),
    **from_each(ACTIVE, Event.CALLED_OFF, State.CANCELLED),
    **from_each(ACTIVE, Event.GIVEN_UP, State.FAILED),
    **from_each(ACTIVE, Event.BLIND, State.WAITING),
    **from_each(ACTIVE, Event.POSE_JUMPED, State.REPLANNING),
    **from_each((State.REPLANNING, State.WAITING, State.GOING), Event.WAY_FOUND, State.GOING),
    (State.TURNING, Event.WAY_FOUND): State.TURNING,
    (State.PASSING, Event.WAY_FOUND): State.PASSING,
    **from_each((*MOVING, State.REPLANNING), Event.WAY_BARRED, State.WAITING),
    **from_each(MOVING, Event.CAME_NO_FARTHER, State.REPLANNING),
    **from_each((State.WAITING,), Event.WAITED_ENOUGH, State.REPLANNING),
    **from_each((State.WAITING,), Event.SEES_AGAIN, State.REPLANNING),
    **from_each((State.GOING, State.PASSING), Event.HAS_TO_TURN, State.TURNING),
    (State.TURNING, Event.HAS_TURNED): State.GOING,
    **from_each((State.TURNING, State.GOING, State.PASSING), Event.HAS_TO_BACK, State.BACKING),
    (State.BACKING, Event.HAS_BACKED): State.REPLANNING,
    (State.GOING, Event.DOOR_AHEAD): State.PASSING,
    (State.PASSING, Event.DOOR_PASSED): State.GOING,
    **from_each(MOVING, Event.ARRIVED, State.DONE),
}
