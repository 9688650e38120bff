"""What the robot knows: where it is and was, what it has seen, its doors, and where it came no farther lately."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import atan2, ceil, hypot
from typing import Any

import numpy as np

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.doors_map import DoorsMap, MapParameters
from apps.indoor_navigation.algorithms.planning.grid import Grid, GridParameters
from apps.indoor_navigation.algorithms.planning.terrain import CostParameters, Hints, Strip, Terrain, terrain
from apps.indoor_navigation.algorithms.pose_history import is_pose_jump
from apps.indoor_navigation.data import DLEData, ObstRead, Place
from geometry import wrap_angle

STEP = 0.1  # m between two
AT_ONCE = 4  # of them, to the next one to go back to, so that the way is smooth
RECENT, BESIDE = 6, 0.3  # how many may be taken up at once, and m beside them
MOST = 100


class Breadcrumbs:
    """Places in odom, the last one where the robot is; going back takes up those that it comes past."""

    def __init__(self) -> None:
        self._places: list[Place] = []

    def __len__(self) -> int:
        return len(self._places)

    def __getitem__(self, number: int) -> Place:
        return self._places[number]

    def drop(self, place: Place) -> None:
        """The robot is here now."""
        places = self._places
        recent = places[-RECENT:]
        apart = [_apart(place, crumb) for crumb in recent]
        if recent and min(apart) < BESIDE:
            del places[len(places) - len(recent) + apart.index(min(apart)) + 1 :]
        if not places or _apart(place, places[-1]) >= STEP:
            places.append(place)
        del places[:-MOST]

    def forget(self) -> None:
        """The robot's pose was set anew."""
        self._places.clear()

    def towards(self, number: int) -> Place:
        """Where to go next, on the way back to one of them."""
        return self._places[max(number, len(self._places) - 1 - AT_ONCE)]


def _apart(one: Place, other: Place) -> float:
    return hypot(other[0] - one[0], other[1] - one[1])


Pose = tuple[float, float, float]

BEYOND = 2.0  # m of unknown floor around all that is known through which a way may lead
STEP = 0.1  # m between two points of the trail
LEAST_BACK, MOST_BACK = 3, 30  # breadcrumbs
DEEP = 0.05  # m within a robot that turns, where a cell of the grid surely is in its way
TURN_STEP = 0.15  # rad


@dataclass(frozen=True, slots=True)
class MemoryParameters:
    """near: m around the robot within which the way is watched at each step."""

    near: float
    grid: GridParameters
    cost: CostParameters
    doors: MapParameters


class Memory:
    """All in odom. outline: of the robot.

    pose: None until something was seen. travelled: m of this mission. crumbs: where it was, over all missions.
    has_jumped: its odometry was set anew at least once.
    """

    def __init__(self, parameters: MemoryParameters, outline: Outline) -> None:
        self.parameters = parameters
        self.outline = outline
        self.grid = Grid(parameters.grid)
        self.doors = DoorsMap(parameters.doors)
        self.pose: Pose | None = None
        self.travelled = 0.0
        self.has_jumped = False
        self.trail: list[Place] = []
        self.crumbs = Breadcrumbs()
        self._stamp = 0.0
        self._avoided: list[tuple[Strip, float]] = []
        self._ways: tuple[Strip, ...] = ()  # gone before this mission
        self._node: int | None = None  # the door that was passed last
        self._since_node = 0  # the part of the trail since then

    @property
    def half_width(self) -> float:
        """Of the robot, m."""
        return self.outline.width / 2.0

    @property
    def place(self) -> Place:
        """Where the robot is."""
        assert self.pose is not None  # nobody asks before something was seen
        return self.pose[:2]

    def see(self, reading: ObstRead) -> bool:
        """Note a reading. True where the robot's pose was set anew, and all that was known of places is void."""
        jumped = self.pose is not None and is_pose_jump(self.pose, reading.pose, reading.stamp - self._stamp)
        if jumped:
            self.has_jumped = True
            self.forget()
        self._go(reading.pose)
        self._stamp = reading.stamp
        self.grid.see(reading)
        return jumped

    def see_doors(self, data: DLEData) -> None:
        """Note doors."""
        self.doors.see(data)

    def forget(self) -> None:
        """All places are void."""
        self.grid.forget()
        self.doors.forget()
        self.crumbs.forget()
        self.pose, self._avoided = None, []
        self.begin_trail()

    def begin_trail(self) -> None:
        """A mission begins here."""
        self.trail = [self.pose[:2]] if self.pose is not None else []
        self._node, self._since_node = None, 0
        self._ways = self.doors.gone_before()
        self.travelled = 0.0

    def end_trail(self) -> None:
        """A mission has ended here as it should: remember how the robot came here."""
        self.doors.gone(self._node, None, self.trail[self._since_node :])

    def avoid(self, place: Place, radius: float, until: float) -> None:
        """The robot has come no farther here; ways elsewhere are better for a while."""
        self._avoided.append((Strip(place, place, radius), until))

    def may_turn(self, place: Place, start: float, end: float) -> bool:
        """Whether the robot may be able to turn here from one heading to another, rad, as far as cells can tell.

        In a door it is not, if its corners do not fit between the jambs, since cells are too coarse to tell that.
        """
        door = self.doors.around(place, self.outline.sweep)
        if door is not None and self.doors.doors[door].width / 2.0 < self.outline.sweep:
            return False
        near = self.grid.area.around(place, margin=self.outline.sweep)
        rows, columns = near.occupied.nonzero()
        x = np.asarray(near.x + (columns + 0.5) * near.resolution, np.float64)
        y = np.asarray(near.y + (rows + 0.5) * near.resolution, np.float64)
        turn = wrap_angle(end - start)
        headings = np.asarray(start + np.linspace(0.0, turn, max(2, ceil(abs(turn) / TURN_STEP))), np.float64)
        poses = np.zeros(len(headings)) + place[0], np.zeros(len(headings)) + place[1], headings
        return not bool((self.outline.distances(poses, x, y) < -DEEP).any())

    def may_turn_to(self, place: Place, target: Place) -> bool:
        """Likewise, from the present heading to where another place is from there."""
        assert self.pose is not None  # nobody asks before something was seen
        return self.may_turn(place, self.pose[2], atan2(target[1] - place[1], target[0] - place[0]))

    def way_back(self, target: Place) -> int | None:
        """The nearest breadcrumb to go back to, to turn towards a place there; None if there is none near."""
        last = len(self.crumbs) - 1
        numbers = range(last - LEAST_BACK, max(last - MOST_BACK, 0) - 1, -1)
        return next((number for number in numbers if self.may_turn_to(self.crumbs[number], target)), None)

    def survey(self, goal: Place, now: float, *, hopes: float | None = None) -> Terrain | None:
        """All that is known, and some of the unknown around it; None where the goal is too far away to plan."""
        if not self.grid.include(goal, BEYOND):
            return None
        known = self.grid.area.known()
        height, width = known.evidence.shape
        corners = known.place(0, 0), known.place(height - 1, width - 1)
        for corner in corners:
            self.grid.include(corner, BEYOND)
        area = self.grid.area.around(*corners, self.place, goal, margin=BEYOND)
        return terrain(
            area, self.half_width, self.parameters.cost, hints=self._hints(now), robot=self.place, hopes=hopes
        )

    def survey_near(self, *, hopes: float | None = None) -> Terrain:
        """What is near the robot, without hints."""
        area = self.grid.area.around(self.place, margin=self.parameters.near)
        return terrain(area, self.half_width, self.parameters.cost, robot=self.place, hopes=hopes)

    def picture(self) -> dict[str, Any]:
        """What is known, as JSON."""
        return {"grid": self.grid.area.drawn(), "trail": [list(place) for place in self.trail], **self._doors_drawn()}

    def _doors_drawn(self) -> Mapping[str, Any]:
        told = self.doors.to_json()
        believed = {number for number, _ in self.doors.believed}
        return {
            "doors": [
                {
                    "x": door.x,
                    "y": door.y,
                    "width": door.width,
                    "normal": door.normal,
                    "confidence": door.confidence,
                    "sightings": door.sightings,
                    "passed": door.passed,
                    "is_believed": number in believed,
                }
                for number, door in enumerate(self.doors.doors)
            ],
            "ways": told["ways"],
        }

    def _hints(self, now: float) -> Hints:
        self._avoided = [(strip, until) for strip, until in self._avoided if until > now]
        return Hints(self._ways, self.doors.walls(), tuple(strip for strip, _ in self._avoided))

    def _go(self, pose: Pose) -> None:
        """The robot has come here."""
        self.pose = pose
        self.crumbs.drop(pose[:2])
        before = self.trail[-1] if self.trail else None
        if before is None:
            self.trail.append(pose[:2])
            return
        step = hypot(pose[0] - before[0], pose[1] - before[1])
        if step < STEP:
            return
        self.travelled += step
        self.trail.append(pose[:2])
        crossing = self.doors.crossed(before, pose[:2])
        if crossing is not None:
            self._pass(crossing[0])

    def _pass(self, door: int) -> None:
        self.doors.passed(door)
        self.doors.gone(self._node, door, self.trail[self._since_node :])
        self._node, self._since_node = door, len(self.trail) - 1
