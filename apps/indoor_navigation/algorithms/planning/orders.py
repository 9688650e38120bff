"""Parameters of missions, orders to the reactive components, and messages for people."""

from dataclasses import dataclass

from apps.indoor_navigation.algorithms.planning.guide import GuideParameters
from apps.indoor_navigation.algorithms.planning.progress import ProgressParameters


@dataclass(frozen=True, slots=True)
class MissionParameters:
    """Parameters of missions.

    speed, back_speed: maximum m/s, forward and backward. face: rad off a barred place, above which the waiting robot
    turns to it. heading: tolerance of the heading at the goal, rad. silence: s without a reading after which
    the robot stops. look: s between two searches for a better way. detour: m of a detour that is taken at once; for a
    longer one the robot waits as long as the detour takes, but at most `patience` s. hope: s to wait for an obstacle
    where there is no other way. ask: s between two requests to people to let the robot pass, of which there are at most
    `asks` while it waits. sure: s without any way after which the mission fails. courtesy: s of waiting after which the
    robot goes aside, at most `courtesies` times in one neighbourhood, to wait there for `aside` s or longer. seek: s
    for which a robot that has lost its place on the map drives about to find it, at half speed; then the mission fails.
    """

    speed: float
    back_speed: float
    face: float
    heading: float
    silence: float
    look: float
    detour: float
    patience: float
    hope: float
    sure: float
    ask: float
    asks: int
    courtesy: float
    courtesies: int
    aside: float
    seek: float
    progress: ProgressParameters
    guide: GuideParameters


@dataclass(frozen=True, slots=True)
class Order:
    """An order to the reactive components: a WorldCoord without stamp and number."""

    aim: str
    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0
    speed: float = 0.0
    is_last: bool = True
    path: tuple[float, ...] = ()
    barred: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class MissionNote:
    """A message for people."""

    mission: str
    level: str
    what: str


REST = Order("rest")
