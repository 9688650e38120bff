"""The states of a mission, and the transitions between them."""

from collections.abc import Mapping
from enum import StrEnum
from typing import Final

from apps.indoor_navigation.state_machine import from_each


class MissionState(StrEnum):
    """The state of a mission; the values are part of its JSON."""

    IDLE = "idle"
    TURNING = "turning"
    GOING = "going"
    PASSING = "passing a door"
    BACKING = "backing"
    WAITING = "waiting"
    REPLANNING = "re-planning"
    LOST = "lost"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


class MissionEvent(StrEnum):
    """An event of a mission."""

    TOLD = "told"
    CALLED_OFF = "called off"
    WAY_FOUND = "way found"
    WAY_BARRED = "way barred"
    CAME_NO_FARTHER = "came no farther"
    HAS_TO_TURN = "has to turn"
    HAS_TO_BACK = "has to back"
    LEADS_ON = "leads on"
    DOOR_AHEAD = "door ahead"
    DOOR_PASSED = "door passed"
    WAITED_ENOUGH = "waited enough"
    BLIND = "blind"
    SEES_AGAIN = "sees again"
    POSE_JUMPED = "pose jumped"
    LOST = "lost"
    SEEKS = "seeks"
    ARRIVED = "arrived"
    GIVEN_UP = "given up"


MOVING: Final = (MissionState.TURNING, MissionState.GOING, MissionState.PASSING, MissionState.BACKING)
ACTIVE: Final = (*MOVING, MissionState.WAITING, MissionState.REPLANNING, MissionState.LOST)

TRANSITIONS: Final[Mapping[tuple[MissionState, MissionEvent], MissionState]] = {
    **from_each(MissionState, MissionEvent.TOLD, MissionState.REPLANNING),
    **from_each(ACTIVE, MissionEvent.CALLED_OFF, MissionState.CANCELLED),
    **from_each(ACTIVE, MissionEvent.GIVEN_UP, MissionState.FAILED),
    **from_each(ACTIVE, MissionEvent.BLIND, MissionState.WAITING),
    **from_each(ACTIVE, MissionEvent.POSE_JUMPED, MissionState.REPLANNING),
    **from_each(ACTIVE, MissionEvent.LOST, MissionState.LOST),
    (MissionState.LOST, MissionEvent.SEEKS): MissionState.REPLANNING,
    **from_each(
        (MissionState.REPLANNING, MissionState.WAITING, MissionState.GOING), MissionEvent.WAY_FOUND, MissionState.GOING
    ),
    **{(state, MissionEvent.WAY_FOUND): state for state in MOVING if state is not MissionState.GOING},
    **from_each((*MOVING, MissionState.REPLANNING), MissionEvent.WAY_BARRED, MissionState.WAITING),
    **from_each(MOVING, MissionEvent.CAME_NO_FARTHER, MissionState.REPLANNING),
    **from_each((MissionState.WAITING,), MissionEvent.WAITED_ENOUGH, MissionState.REPLANNING),
    **from_each((MissionState.WAITING,), MissionEvent.SEES_AGAIN, MissionState.REPLANNING),
    **from_each(MOVING, MissionEvent.HAS_TO_TURN, MissionState.TURNING),
    **from_each(MOVING, MissionEvent.HAS_TO_BACK, MissionState.BACKING),
    **from_each((MissionState.TURNING, MissionState.BACKING), MissionEvent.LEADS_ON, MissionState.GOING),
    (MissionState.GOING, MissionEvent.DOOR_AHEAD): MissionState.PASSING,
    (MissionState.PASSING, MissionEvent.DOOR_PASSED): MissionState.GOING,
    **from_each(MOVING, MissionEvent.ARRIVED, MissionState.DONE),
}
