"""The robot's knowledge: its pose and path, the grid, the doors, and places where it was stuck lately."""

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
from apps.indoor_navigation.data import ObstRead, Place, Pose
from geometry import wrap_angle

CRUMB_SPACING = 0.1  # m
LOOK_BACK = 4  # crumbs to the next target of the way back, so that this is smooth
RECENT, RECENT_RANGE = 6, 0.3  # newest crumbs that may be taken up at once, and m from them
MAX_CRUMBS = 100  # 10 m; farther back the robot never drives in reverse


class Breadcrumbs:
    """Places of the robot's path in odom, the last one at the robot; on the way back, passed crumbs are removed."""

    def __init__(self) -> None:
        self._places: list[Place] = []

    def __len__(self) -> int:
        return len(self._places)

    def __getitem__(self, number: int) -> Place:
        return self._places[number]

    def drop(self, place: Place) -> None:
        """Add the place of the robot."""
        places = self._places
        recent = places[-RECENT:]
        apart = [_apart(place, crumb) for crumb in recent]
        if recent and min(apart) < RECENT_RANGE:
            del places[len(places) - len(recent) + apart.index(min(apart)) + 1 :]
        if not places or _apart(place, places[-1]) >= CRUMB_SPACING:
            places.append(place)
        del places[:-MAX_CRUMBS]

    def forget(self) -> None:
        """Forget all crumbs, because the origin of odom has changed."""
        self._places.clear()

    def towards(self, number: int) -> Place:
        """Return the next target on the way back to a crumb."""
        return self._places[max(number, len(self._places) - 1 - LOOK_BACK)]


def _apart(one: Place, other: Place) -> float:
    return hypot(other[0] - one[0], other[1] - one[1])


UNKNOWN_MARGIN = 2.0  # m of unknown floor around the known floor through which a way may lead
TRAIL_SPACING = 0.1  # m between two points of the trail
MIN_BACK, MAX_BACK = 3, 30  # crumbs of a way back: 0.3 to 3 m
MAX_PENETRATION = 0.05  # m inside the turning outline; half a cell, so a cell deeper inside bars the turn
TURN_STEP = 0.15  # rad between checked headings of a turn; the corners move 0.1 m at most


@dataclass(frozen=True, slots=True)
class MemoryParameters:
    """near: m around the robot within which the way is checked at each step."""

    near: float
    grid: GridParameters
    cost: CostParameters
    doors: MapParameters


class Memory:
    """Knowledge in odom. outline: of the robot.

    pose: None before the first reading. travelled: m of this mission. crumbs: path over all missions. has_jumped:
    whether odom was set anew at least once.
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
        self._ways: tuple[Strip, ...] = ()  # of earlier missions
        self._node: int | None = None  # the door that was passed last
        self._since_node = 0  # the part of the trail since then

    @property
    def half_width(self) -> float:
        """Of the robot, m."""
        return self.outline.width / 2.0

    @property
    def place(self) -> Place:
        """The place of the robot."""
        assert self.pose is not None  # never used before the first reading
        return self.pose[:2]

    def see(self, reading: ObstRead) -> bool:
        """Take a reading; return True where odom was set anew and all places were forgotten."""
        jumped = self.pose is not None and is_pose_jump(self.pose, reading.pose, reading.stamp - self._stamp)
        if jumped:
            self.has_jumped = True
            self.forget()
        self._go(reading.pose)
        self._stamp = reading.stamp
        self.grid.see(reading)
        return jumped

    def forget(self) -> None:
        """Forget all places."""
        self.grid.forget()
        self.doors.forget()
        self.crumbs.forget()
        self.pose, self._avoided = None, []
        self.begin_trail()

    def begin_trail(self) -> None:
        """Begin the path of a mission."""
        self.trail = [self.pose[:2]] if self.pose is not None else []
        self._node, self._since_node = None, 0
        self._ways = self.doors.gone_before()
        self.travelled = 0.0

    def end_trail(self) -> None:
        """Remember the path of a mission that has reached its goal."""
        self.doors.gone(self._node, None, self.trail[self._since_node :])

    def avoid(self, place: Place, radius: float, until: float) -> None:
        """Raise the cost around a place where the robot was stuck, until s."""
        self._avoided.append((Strip(place, place, radius), until))

    def may_turn(self, place: Place, start: float, end: float) -> bool:
        """Return whether the grid allows a turn at a place from one heading to another, rad.

        In a door the corners must fit between the jambs, because cells are too coarse to show that.
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
        return not bool((self.outline.distances(poses, x, y) < -MAX_PENETRATION).any())

    def may_turn_to(self, place: Place, target: Place) -> bool:
        """Return whether the robot may turn at a place from its present heading to a target."""
        assert self.pose is not None  # never used before the first reading
        return self.may_turn(place, self.pose[2], atan2(target[1] - place[1], target[0] - place[0]))

    def way_back(self, target: Place) -> int | None:
        """Return the nearest crumb where the robot can turn to a target; None if there is none within reach."""
        last = len(self.crumbs) - 1
        numbers = range(last - MIN_BACK, max(last - MAX_BACK, 0) - 1, -1)
        return next((number for number in numbers if self.may_turn_to(self.crumbs[number], target)), None)

    def survey(self, goal: Place, now: float, *, hopes: float | None = None) -> Terrain | None:
        """Return the costs of the known floor with a margin; None where the goal is too far away to plan."""
        if not self.grid.include(goal, UNKNOWN_MARGIN):
            return None
        known = self.grid.area.known()
        height, width = known.evidence.shape
        corners = known.place(0, 0), known.place(height - 1, width - 1)
        for corner in corners:
            self.grid.include(corner, UNKNOWN_MARGIN)
        area = self.grid.area.around(*corners, self.place, goal, margin=UNKNOWN_MARGIN)
        return terrain(
            area, self.half_width, self.parameters.cost, hints=self._hints(now), robot=self.place, hopes=hopes
        )

    def survey_near(self) -> Terrain:
        """Return the costs of the floor near the robot, without hints."""
        area = self.grid.area.around(self.place, margin=self.parameters.near)
        return terrain(area, self.half_width, self.parameters.cost, robot=self.place)

    def picture(self) -> dict[str, Any]:
        """Return the knowledge for a picture, as JSON."""
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
        """Update the robot's path."""
        self.pose = pose
        self.crumbs.drop(pose[:2])
        before = self.trail[-1] if self.trail else None
        if before is None:
            self.trail.append(pose[:2])
            return
        step = hypot(pose[0] - before[0], pose[1] - before[1])
        if step < TRAIL_SPACING:
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
