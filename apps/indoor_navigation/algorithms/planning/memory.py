"""The robot's knowledge: its pose and trail, the grid, the doors, and places where it was stuck lately."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import hypot
from typing import Any

import numpy as np

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.area import Area
from apps.indoor_navigation.algorithms.planning.doors_map import DoorsMap, MapParameters
from apps.indoor_navigation.algorithms.planning.floor import FloorMap
from apps.indoor_navigation.algorithms.planning.grid import Grid, GridParameters
from apps.indoor_navigation.algorithms.planning.ground import Ground
from apps.indoor_navigation.algorithms.planning.terrain import CostParameters, Hints, Strip, Terrain, terrain
from apps.indoor_navigation.algorithms.pose_history import is_pose_jump
from apps.indoor_navigation.data import Bools, Floats, ObstRead, Place, Pose

UNKNOWN_MARGIN = 2.0  # m of unknown floor around the known floor through which a way may lead
ASIDE_RANGE = 5.0  # m around the robot where it may go aside
FORBIDDEN_RANGE = 2.5  # m around the robot within which goto is told of forbidden places
IN_VIEW = 1.5  # s since the last hit, within which an obstacle is in view
TRAIL_SPACING = 0.1  # m between two points of the trail


@dataclass(frozen=True, slots=True)
class MemoryParameters:
    """Ranges and times.

    near: m around the robot within which the way is checked at each step, and within which people bar it. remember: s
    for which an obstacle that the map does not show is remembered from one mission to the next, such as a closed door.
    """

    near: float
    remember: float
    grid: GridParameters
    cost: CostParameters
    doors: MapParameters


class Memory:
    """Knowledge in the frame of planning. outline: of the robot.

    pose: None before the first reading. travelled: m of this mission. has_jumped: whether odom was set anew at least
    once.
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
        self._stamp = 0.0
        self._has_begun = False  # a mission, since the last reading
        self._avoided: list[tuple[Strip, float]] = []
        self._held: list[tuple[Place, float]] = []
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
        return self._robot[:2]

    @property
    def _robot(self) -> Pose:
        assert self.pose is not None  # never used before the first reading
        return self.pose

    def see(self, reading: ObstRead) -> bool:
        """Take a reading; return True where odom was set anew and all places were forgotten."""
        jumped = self.pose is not None and is_pose_jump(self.pose, reading.pose, reading.stamp - self._stamp)
        if jumped:
            self.has_jumped = True
            self.forget()
        self._go(reading.pose)
        self._stamp = reading.stamp
        if self._has_begun:  # only now it is known how much time has passed since the mission before
            self._has_begun = False
            self.forget_transient(self.parameters.remember)
        self.grid.see(reading)
        return jumped

    def forget(self) -> None:
        """Forget all places."""
        self.grid.forget()
        self.doors.forget()
        self.pose, self._avoided, self._held = None, [], []
        self.begin_trail()

    def use_map(self, floor: FloorMap | None) -> None:
        """Forget all places, and begin with what a map shows; without a map, with nothing."""
        self.grid.use_map(floor)
        self.has_jumped = True  # the frame of planning is another one
        self.forget()

    def forget_transient(self, age: float, *, with_panes: bool = False) -> bool:
        """Forget obstacles that may have gone since they were seen, s ago; return whether there were any.

        with_panes: also what only sonar hears.
        """
        return self.grid.forget_transient(self._stamp - age, with_panes=with_panes)

    def doubt(self, place: Place, radius: float) -> bool:
        """Forget the obstacles within m of a place that were seen once and are out of view; return whether any were."""
        return self.grid.doubt_unseen(*place, radius, self._stamp - IN_VIEW)

    def doubt_map(self) -> bool:
        """Forget what only the map shows, if sensors contradict much of it; return whether that was so."""
        return self.grid.doubt_map()

    def begin_trail(self) -> None:
        """Begin the path of a mission."""
        self.trail = [self.pose[:2]] if self.pose is not None else []
        self._node, self._since_node = None, 0
        self._ways = self.doors.gone_before()
        self.travelled = 0.0
        self._has_begun = True

    def end_trail(self) -> None:
        """Remember the path of a mission that has reached its goal."""
        self.doors.gone(self._node, None, self.trail[self._since_node :])

    def avoid(self, place: Place, radius: float, until: float) -> None:
        """Raise the cost around a place where the robot was stuck, until s."""
        self._avoided.append((Strip(place, place, radius), until))

    def hold_up(self, place: Place, until: float) -> None:
        """Plan with more room around a place where the robot was held up although its way seemed free, until s."""
        self._held.append((place, until))

    def survey(
        self,
        goal: Place,
        now: float,
        *,
        standing: Callable[[Area], Bools] | None = None,
        hope: float = 0.0,
        barred: Place | None = None,
    ) -> Ground | None:
        """Return the costs of the known floor with a margin; None where the goal is too far away to plan.

        Args:
            goal: In odom.
            now: s.
            standing: Cells with obstacles that do not go away; by default all but what may be people far away.
            hope: Cost of the others.
            barred: A place where somebody was in the way; those who are still near it bar ways, however far the robot
                has made way.
        """
        if not self.grid.include(goal):
            return None
        self.grid.include(goal, UNKNOWN_MARGIN, always=True)
        known = self.grid.area.known()
        height, width = known.evidence.shape
        corners = known.place(0, 0), known.place(height - 1, width - 1)
        for corner in corners:
            self.grid.include(corner, UNKNOWN_MARGIN, always=True)
        area = self.grid.area.around(*corners, self.place, goal, margin=UNKNOWN_MARGIN)
        if standing is not None:
            stands = standing(area)
        else:  # who is far away will be elsewhere when the robot comes there
            places = (self.place,) if barred is None else (self.place, barred)
            people = area.people(places, self.parameters.near)
            stands, hope = area.occupied & ~people, self.parameters.cost.person if people.any() else 0.0
        return Ground.of(
            area,
            self.outline,
            self.parameters.cost,
            self._robot,
            hints=self._hints(now),
            standing=stands,
            hope=hope,
            held=self._held_at(now),
        )

    def survey_near(self) -> Ground:
        """Return the costs of the floor near the robot, without hints."""
        area = self.grid.area.around(self.place, margin=self.parameters.near + self.outline.sweep)
        return Ground.of(area, self.outline, self.parameters.cost, self._robot)

    def survey_flat(self) -> Terrain:
        """Return the costs of the floor near the robot for any heading, without hints."""
        area = self.grid.area.around(self.place, margin=ASIDE_RANGE)
        return terrain(area, self.half_width, self.parameters.cost, robot=self.place)

    def is_forbidden(self, place: Place) -> bool:
        """Return whether the map forbids a place."""
        return bool(self.grid.area.around(place, margin=0.0).forbidden.any())

    def forbidden_near(self) -> Floats:
        """Return places along the edges of forbidden cells near the robot, m, shape (n, 2)."""
        area = self.grid.area.around(self.place, margin=FORBIDDEN_RANGE)
        is_edge = area.forbidden.copy()
        is_edge[1:-1, 1:-1] &= ~(
            area.forbidden[:-2, 1:-1] & area.forbidden[2:, 1:-1] & area.forbidden[1:-1, :-2] & area.forbidden[1:-1, 2:]
        )
        rows, columns = np.nonzero(is_edge)
        return np.stack((area.x + (columns + 0.5) * area.resolution, area.y + (rows + 0.5) * area.resolution), axis=1)

    def picture(self, in_odom: Callable[[Pose], Pose]) -> dict[str, Any]:
        """Return the knowledge for a picture, as JSON; in_odom: converts a pose of the frame of planning."""

        def placed(place: Place) -> list[float]:
            return list(in_odom((*place, 0.0))[:2])

        trail = [placed(place) for place in self.trail]
        return {"grid": self.grid.area.drawn(), "trail": trail, **self._doors_drawn(in_odom, placed)}

    def _doors_drawn(
        self, in_odom: Callable[[Pose], Pose], placed: Callable[[Place], list[float]]
    ) -> Mapping[str, Any]:
        ways = self.doors.to_json()["ways"]
        believed = {number for number, _ in self.doors.believed}
        return {
            "doors": [
                {
                    **dict(zip(("x", "y", "normal"), in_odom((door.x, door.y, door.normal)), strict=True)),
                    "width": door.width,
                    "confidence": door.confidence,
                    "sightings": door.sightings,
                    "passed": door.passed,
                    "is_believed": number in believed,
                }
                for number, door in enumerate(self.doors.doors)
            ],
            "ways": [{**way, "points": [placed(point) for point in way["points"]]} for way in ways],
        }

    def _held_at(self, now: float) -> tuple[Place, ...]:
        self._held = [(place, until) for place, until in self._held if until > now]
        return tuple(place for place, _ in self._held)

    def _hints(self, now: float) -> Hints:
        self._avoided = [(strip, until) for strip, until in self._avoided if until > now]
        return Hints(self._ways, self.doors.walls(), tuple(strip for strip, _ in self._avoided))

    def _go(self, pose: Pose) -> None:
        """Update the robot's path."""
        self.pose = pose
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
