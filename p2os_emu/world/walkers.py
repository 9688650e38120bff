"""People under physics: upright cylinders to touch and to hear, legs that step for scanners to see."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import pairwise
from math import dist, inf
from random import Random
from typing import NamedTuple

from geometry import Point, Polygon, Pose2D, polygons_overlap
from p2os_emu.world.collision import build_person, put
from p2os_emu.world.engine import STEP, PhysicsClient
from p2os_emu.world.errors import WorldError
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.objects import MovingObject
from p2os_emu.world.people import BODY_RADIUS, HEIGHT, HIP, LEG_HEIGHT, LEG_RADIUS, Person
from p2os_emu.world.presence import Footprint
from p2os_emu.world.spec import WorldSpec, rectangle
from p2os_emu.world.stepping_aside import BERTH, MORE_BERTH, WALL_BERTH, Asker, place_aside, place_away
from p2os_emu.world.walk import Walk

LOOK_AHEAD = 0.8
"""m ahead of the body within which people stop for what stands in their way."""
ELBOW_ROOM = 0.1
"""m on each side that must be free for them to walk on."""
STEP_BACK = 0.1
"""m that must be free ahead of somebody who has bumped into something, before they walk on."""
PASSED = 1.0
"""m by which a robot that asked somebody is farther away than it has been, before they go back to their route."""
LOOK_PERIOD = 3
"""Steps from one look at what is ahead to the next."""
_CORNERS = 12  # of the polygon that stands for a circle
_CIRCLE = [(math.cos(math.tau * i / _CORNERS), math.sin(math.tau * i / _CORNERS)) for i in range(_CORNERS)]


class PersonPlace(NamedTuple):
    """Where somebody is, m, rad, and whether they walk or stand."""

    x: float
    y: float
    heading: float
    walks: bool


class Walker:
    """One person."""

    def __init__(self, client: PhysicsClient, person: Person, random: Random) -> None:
        self.person = person
        self.walks = True
        self._is_blocked = False
        self._asker: Callable[[], Asker | None] = lambda: None
        self._times_asked = 0  # again, while they stand aside
        self._nearest = inf  # m that the robot that asked them has come to them
        self._client = client
        self._walk = Walk(person, random)
        self.body = build_person(client, BODY_RADIUS, HEIGHT)
        self._put()

    @property
    def place(self) -> Pose2D:
        """Where they are, heading the way they walk."""
        return self._walk.place

    def look(self, others: Sequence[Footprint]) -> None:
        """See whether others are in the way, and whether a robot for which they stepped aside has passed."""
        self._is_blocked = self._meets(others)
        if self._walk.is_aside and self._walk.is_resting:
            asker = self._asker()
            away = inf if asker is None else dist((asker.pose.x, asker.pose.y), (self.place.x, self.place.y))
            self._nearest = min(self._nearest, away)
            if away > self._nearest + PASSED or asker is None:
                self._walk.go_back()

    def hear(self, asker: Callable[[], Asker | None], walking: FreeSpace, passing: FreeSpace) -> None:
        """Let a robot pass that asks for it by a sound: step aside, or walk away where there is no room for that."""
        robot, here = asker(), (self.place.x, self.place.y)
        if robot is None or not self.person.gives_way or not robot.means(here):
            return
        is_aside = self._walk.is_aside
        self._times_asked = min(self._times_asked + 1, 2) if is_aside else 0
        route = self._walk.on_route
        place = place_aside(here, route, robot, walking, passing, BERTH + MORE_BERTH * self._times_asked)
        if place is None and not is_aside and self._walk.walk_away((robot.pose.x, robot.pose.y)):
            return
        self._asker, self._nearest = asker, inf
        self._walk.step_aside(place or place_away(here, route, robot, walking))

    def step(self) -> None:
        """Let `STEP` seconds pass."""
        self.walks = not (self._walk.is_resting or self._is_blocked)
        self._walk.advance(STEP, is_blocked=self._is_blocked)
        if self.walks:
            self._put()

    def moving(self) -> Iterator[MovingObject]:
        """Two legs and what is above them."""
        pose, ahead = self.place, self._walk.stride
        for along, side in ((ahead, HIP), (-ahead, -HIP)):
            yield MovingObject(self.person.name, _disc(pose.transform(along, side), LEG_RADIUS), 0.0, LEG_HEIGHT)
        yield MovingObject(self.person.name, _disc((pose.x, pose.y), BODY_RADIUS), LEG_HEIGHT, HEIGHT)

    def presence(self) -> Footprint:
        """What they take up on the floor."""
        return Footprint(self.place.x, self.place.y, BODY_RADIUS, _disc((self.place.x, self.place.y), BODY_RADIUS))

    @property
    def _room_wanted(self) -> tuple[float, float]:
        """What must be free ahead and on each side, m; who does not give way stops when they have bumped."""
        if self._walk.is_aside:
            return STEP_BACK, 0.0
        if self.person.gives_way:
            return LOOK_AHEAD, ELBOW_ROOM
        return (0.0 if self.walks else STEP_BACK), 0.0

    def _meets(self, others: Sequence[Footprint]) -> bool:
        ahead, beside = self._room_wanted
        front, width = BODY_RADIUS + ahead, 2 * (BODY_RADIUS + beside)
        x, y = self.place.transform(front / 2, 0.0)
        near = [other for other in others if other.is_near(x, y, math.hypot(front, width) / 2)]
        if not near:
            return False
        way = rectangle(self.place, front, 0.0, width)
        return any(polygons_overlap(way, other.outline) for other in near)

    def _put(self) -> None:
        put(self._client, self.body, self.place, HEIGHT)


class Walkers:
    """All people in one world. stand_still: nobody takes a step."""

    def __init__(self, client: PhysicsClient, spec: WorldSpec, seed: int) -> None:
        self.stand_still = False
        self._steps = 0
        self._free_space = cache(partial(FreeSpace, spec))
        self._walkers = [Walker(client, person, Random(f"{seed} {person.name} walk")) for person in spec.people]

    def __bool__(self) -> bool:
        return bool(self._walkers)

    @property
    def bodies(self) -> Mapping[int, Person]:
        """Body ids of the engine, and who they are."""
        return {walker.body: walker.person for walker in self._walkers}

    def places(self) -> dict[str, PersonPlace]:
        """Where each of them is."""
        return {
            walker.person.name: PersonPlace(
                walker.place.x, walker.place.y, walker.place.heading, walker.walks and not self.stand_still
            )
            for walker in self._walkers
        }

    def step(self, others: Callable[[], Iterable[Footprint]]) -> None:
        """Let `STEP` seconds pass among robots and doors; people walk through each other."""
        if self.stand_still:
            return
        if self._steps % LOOK_PERIOD == 0:
            ahead = tuple(others())
            for walker in self._walkers:
                walker.look(ahead)
        self._steps += 1
        for walker in self._walkers:
            walker.step()

    def hear(self, asker: Callable[[], Asker | None]) -> None:
        """Let everybody hear the sound of a robot; asker: where it is, None when it has gone."""
        robot = asker()
        if robot is None or not self._walkers:
            return
        walking, passing = self._free_space(BODY_RADIUS), self._free_space(robot.width / 2.0 + WALL_BERTH)
        for walker in self._walkers:
            walker.hear(asker, walking, passing)

    def moving(self) -> Iterator[MovingObject]:
        """Each leg and each body where it is now."""
        for walker in self._walkers:
            yield from walker.moving()

    def presences(self) -> dict[str, Footprint]:
        """What each takes up on the floor."""
        return {walker.person.name: walker.presence() for walker in self._walkers}


def check_routes(spec: WorldSpec) -> None:
    """See that nobody's route leads through what stands still.

    Raises:
        WorldError: Somebody's does.
    """
    if not spec.people:
        return
    space = FreeSpace(spec, BODY_RADIUS)
    for person in spec.people:
        points = (*person.route, person.route[0]) if person.loops else person.route
        for a, b in pairwise(points):
            if not space.has_way((a, b)):
                raise WorldError(
                    f"world {spec.name!r}: {person.name} cannot walk from {list(a)} to {list(b)} m: something stands "
                    f"within {BODY_RADIUS} m of the way; move a waypoint of the route"
                )


def _disc(middle: Point, radius: float) -> Polygon:
    x, y = middle
    return tuple((x + radius * c, y + radius * s) for c, s in _CIRCLE)
