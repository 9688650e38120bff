"""What missions are gone about with, and what comes out: orders, and notes for people."""

from dataclasses import dataclass

from apps.indoor_navigation.algorithms.planning.guide import GuideParameters
from apps.indoor_navigation.algorithms.planning.progress import ProgressParameters
from apps.indoor_navigation.data import Place


@dataclass(frozen=True, slots=True)
class MissionParameters:
    """How missions are gone about.

    speed, door_speed, back_speed: m/s at most, through doors, and backward. turn_from, turn_until: rad off the next
    sub-target, from which the robot turns on its place, and until which. door_from, door_until: likewise where it goes
    through a door next. heading: rad off the heading that is wanted at the end. silence: s without a reading after
    which the robot rests. look: s between two looks for a better way. detour: m of a detour that is not worth waiting;
    a longer one is worth waiting as long as it takes, at most `patience` s. hope: s that the robot waits for something
    in its way to go where there is no other way. sure: s after which no way is no way. courtesy: s of waiting, after
    which the robot goes aside, at most `courtesies` times on a mission, and waits there for `aside` s or longer.
    """

    speed: float
    door_speed: float
    back_speed: float
    turn_from: float
    turn_until: float
    door_from: float
    door_until: float
    heading: float
    silence: float
    look: float
    detour: float
    patience: float
    hope: float
    sure: float
    courtesy: float
    courtesies: int
    aside: float
    progress: ProgressParameters
    guide: GuideParameters


@dataclass(frozen=True, slots=True)
class Order:
    """What the reactive components are to do; as WorldCoord, without stamp and number."""

    aim: str
    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0
    speed: float = 0.0
    is_last: bool = True
    then: Place | None = None


@dataclass(frozen=True, slots=True)
class MissionNote:
    """Something that a person may want to know."""

    mission: str
    level: str
    what: str


REST = Order("rest")
