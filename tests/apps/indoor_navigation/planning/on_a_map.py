"""A robot with a map of the house of `house.py`, whose odometry drifts; a test speaks for its localization."""

from base64 import b64encode
from cmath import exp, phase
from collections.abc import Sequence
from dataclasses import replace
from typing import Any
from zlib import compress

import numpy as np

from agents.platform import Agent, request
from apps.indoor_navigation.algorithms.planning.floor import FloorMap
from apps.indoor_navigation.algorithms.planning.mission import MapFix, Navigator
from apps.indoor_navigation.algorithms.planning.orders import Order
from apps.indoor_navigation.data import DLEData, GoalPoint, ObstRead
from apps.indoor_navigation.parameters import shipped_parameters
from bus import Refused
from geometry import Cairn, Pose2D, Segment
from maps.building_map import BuildingMap
from maps.rasterization import forbidden_cells, grid_of
from tests.apps.indoor_navigation.planning.house import HALF_WIDTH, House, Walker
from tests.apps.indoor_navigation.site import ROBOT, Site

LOST = MapFix(None, None, "the readings fit no place")


def floor_of(plan: House, places: Sequence[Cairn] = ()) -> FloorMap:
    """The map that the localization has of a house; doors are open on it."""
    map_ = BuildingMap(tuple(Segment(*line) for line in plan.walls), places=tuple(places))
    grid = grid_of(map_)
    return FloorMap(grid, forbidden_cells(map_, grid))


def told(floor: FloorMap) -> dict[str, Any]:
    """What the localization's request `floor` returns of it."""
    rows, columns = floor.grid.cells.shape
    packed = {"cells": floor.grid.cells, "forbidden": floor.forbidden}
    about = {"x": floor.grid.origin.x, "y": floor.grid.origin.y, "resolution": floor.grid.resolution}
    coded = {name: b64encode(compress(cells.tobytes())).decode() for name, cells in packed.items()}
    return {**about, "rows": rows, "columns": columns, **coded}


class Drifting:
    """Stands between a walker, whose places are those of the house, and its navigator, whose places are in odom.

    turned, shifted: where odom truly is in the house, rad and m. fix: what the localization says of that instead of the
    truth; None for the truth.
    """

    def __init__(self, navigator: Navigator, floor: FloorMap | None) -> None:
        self.inner, self.floor = navigator, floor
        self.turned, self.shifted = 0.4, 3.0 - 2.0j
        self.fix: MapFix | None = None
        self.is_silent = False

    def see(self, reading: ObstRead, now: float) -> None:
        """Convert a reading to odom, after the localization has spoken."""
        if not self.is_silent and self.floor is not None:
            origin = Pose2D(self.shifted.real, self.shifted.imag, self.turned)
            self.inner.localize(self.fix or MapFix(origin, self.floor), now)
        x, y, heading = reading.pose
        at = self._in_odom(x, y)
        origins, ends = self._in_odom(reading.origin_x, reading.origin_y), self._in_odom(reading.end_x, reading.end_y)
        pose = float(at.real), float(at.imag), heading - self.turned
        places = {"origin_x": origins.real, "origin_y": origins.imag, "end_x": ends.real, "end_y": ends.imag}
        self.inner.see(replace(reading, pose=pose, **places), now)

    def see_doors(self, data: DLEData) -> None:
        """Doors are not used here."""

    def step(self, now: float) -> Order:
        """Convert an order to the house."""
        order = self.inner.step(now)
        path = np.array(order.path).reshape(-1, 2)
        placed = exp(1j * self.turned) * (path[:, 0] + 1j * path[:, 1]) + self.shifted
        end = exp(1j * self.turned) * complex(order.x, order.y) + self.shifted
        heading = phase(exp(1j * (order.heading + self.turned)))
        flat = tuple(np.stack((placed.real, placed.imag), axis=1).ravel().tolist())
        return replace(order, x=end.real, y=end.imag, heading=heading, path=flat)

    def in_house(self, x: float, y: float) -> tuple[float, float]:
        """A place in odom as one of the house."""
        place = exp(1j * self.turned) * complex(x, y) + self.shifted
        return place.real, place.imag

    def in_odom(self, x: float, y: float) -> tuple[float, float]:
        """A place of the house in odom."""
        place = self._in_odom(x, y)
        return place.real, place.imag

    def __getattr__(self, name: str) -> Any:
        return getattr(self.inner, name)

    def _in_odom(self, x: Any, y: Any) -> Any:
        return (x + 1j * y - self.shifted) * exp(-1j * self.turned)


class MapWalker(Walker):
    """Drives in a house; its odometry turns away by so many rad/m, and measures distances too long by a share."""

    navigator: Drifting  # type: ignore[assignment]  # it has all that a walker calls

    def __init__(
        self,
        plan: House,
        pose: tuple[float, float, float],
        floor: FloorMap | None,
        *,
        drift: float = 0.0,
        seek: float = 180.0,
    ) -> None:
        parameters = replace(shipped_parameters("path_planning").mission, seek=seek, sure=2.0)
        super().__init__(plan, Drifting(Navigator(parameters, HALF_WIDTH), floor), pose)  # type: ignore[arg-type]  # it drives as a Navigator does
        self._drift = drift

    def go_to(self, x: float, y: float, heading: float | None = None, mission: str = "m1") -> None:
        """A mission to a place of the map begins."""
        self.navigator.begin(GoalPoint(mission, x, y, heading, frame="map"), self.time)

    def step(self) -> None:
        """A tenth of a second; then odometry has drifted."""
        before = complex(self.x, self.y)
        super().step()
        here = complex(self.x, self.y)
        turn = self._drift * abs(here - before)
        # The house turns about the robot, as its odometry has it.
        self.navigator.shifted = here + (self.navigator.shifted - here) * exp(1j * turn)
        self.navigator.turned += turn


class Localization(Agent):
    """The agent of localization, as a test has it: its map, and what it says of the place of odom."""

    def __init__(self, site: Site, floor: FloorMap, number: int = 1) -> None:
        super().__init__(f"localization@{ROBOT}")
        self._site, self._floor, self._number = site, floor, number
        self.place: list[float] | None = [1.0, 2.0, 0.5]
        self.refuses = ""
        self.asked = 0

    @request("floor")
    async def floor(self) -> dict[str, Any]:
        """Its map."""
        self.asked += 1
        if self.refuses:
            raise Refused(self.refuses)
        return told(self._floor)

    @request("goal")
    async def goal(self, place: str = "", x: Any = None, y: Any = None, heading: Any = None) -> dict[str, Any]:
        """A goal; none called `Nowhere`."""
        if place == "Nowhere":
            raise Refused('the map has no goal "Nowhere"')
        at = [4.0, 5.0, 1.5] if place else [x, y, heading or 0.0]
        return {"name": place, "map": at, "x": 0.0, "y": 0.0, "heading": 0.0 if place or heading is not None else None}

    def say(self) -> None:
        """Publish a result."""
        is_known = self.place is not None
        about = {"state": "localized" if is_known else "searching", "reason": None if is_known else "it fits no place"}
        self.publish({**about, "odom_in_map": self.place, "started": self._number})
