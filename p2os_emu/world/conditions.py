"""Harder variants of worlds, by a seed: obstacles that no plan shows, and people who walk between places.

Both are put where robots go: on shortest ways between the named places of a world.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from math import dist, pi
from random import Random

from geometry import Point, Pose2D
from p2os_emu.world.errors import WorldError
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.moving_doors import MovingDoor
from p2os_emu.world.people import BODY_RADIUS, Person, PersonRoute
from p2os_emu.world.shortest_path import Path, are_connected, path_in
from p2os_emu.world.spec import WorldSpec

RADIUS = 0.42
"""m, of the disc that still gets everywhere: wider than any robot, and less than a door of 0.9 m."""
NARROW = 0.4
"""Likewise in worlds that are too narrow for that one before anything is put there."""
WALKING_RADIUS = BODY_RADIUS + 0.15
"""m that the middle of somebody who walks keeps from walls."""
WAYS = 12
"""Shortest ways to choose from."""
SIZES = (0.25, 0.6)
"""m, of the edge of a box and the diameter of a cylinder."""
SPREAD = 0.8
"""m, standard deviation of an obstacle's distance from a shortest way."""
ROOM = 0.8
"""m that stay free round places and starts, so that robots can turn there."""
OBSTACLE_HEIGHT = 1.0
OBSTACLE_MASS = 200.0
"""kg; no robot pushes that."""
TRIES = 200
"""For each obstacle or person, before there is no room for it."""
SPEEDS = (0.5, 1.0)
PAUSES = (1.0, 4.0)
LEAST_WALK = 3.0
"""m; nobody walks up and down on the spot."""
APART = 2.0
"""m from a robot's start at which people begin."""
NAMES = ("Anna", "Bert", "Carla", "David", "Eva", "Frank", "Greta", "Hugo")
CLOTHES = ("blue", "green", "orange", "purple", "teal", "pink", "red", "yellow")


def with_obstacles(
    spec: WorldSpec, seed: int, count: int, *, radius: float | None = None, keep_clear: Sequence[Point] = ()
) -> WorldSpec:
    """Put boxes and cylinders into a world; places and starts keep room to turn, and people their routes.

    Args:
        spec: A world with two named places or more.
        seed: Of where they stand and how large they are.
        count: How many.
        radius: Of the disc for which all places and starts stay within reach of each other, m: `RADIUS` or, where they
            are not for that one, `NARROW`.
        keep_clear: Further points with room to turn, m.
    Raises:
        WorldError: The world has no named places, or there is no room for so many.
    """
    random = Random(f"{seed} obstacles {spec.name}")
    reached = [*spec.places.values(), *((start.x, start.y) for start in spec.starts)]
    if radius is None:
        radius = RADIUS if are_connected(FreeSpace(spec, RADIUS), reached) else NARROW
    ways = _ways(spec, random, radius)
    clear = [*reached, *keep_clear, *(_middle(door) for door in spec.moving_doors)]
    for number in range(1, count + 1):
        candidates = (_obstacle(f"obstacle {number}", random.choice(ways), random) for _ in range(TRIES))
        more = (
            _added(spec, thing)
            for thing in candidates
            if _leaves_room(thing, clear) and FreeSpace(spec, thing.reach).is_free((thing.pose.x, thing.pose.y))
        )
        fitting = next((world for world in more if _is_passable(world, reached, radius)), None)
        if fitting is None:
            raise WorldError(f"world {spec.name!r} has no room for {count} obstacles: ask for {number - 1} or fewer")
        spec = fitting
    return spec


def with_people(spec: WorldSpec, seed: int, count: int, *, keep_clear: Sequence[Point] = ()) -> WorldSpec:
    """Let people walk back and forth between places of a world; they give way.

    Args:
        spec: A world with two named places or more; obstacles in it are walked round.
        seed: Of routes, speeds and where on their routes they begin.
        count: How many.
        keep_clear: Where nobody begins, m: starts of robots. Without any, the first start of the world.
    Raises:
        WorldError: The world has no named places, or too little room.
    """
    random = Random(f"{seed} people {spec.name}")
    clear = keep_clear or [(spec.starts[0].x, spec.starts[0].y)]
    ways = [way for way in _ways(spec, random, WALKING_RADIUS) if way.length >= LEAST_WALK]
    first = len(spec.people)
    people = (_person(number, ways, clear, random) for number in range(first, first + count))
    return replace(spec, people=(*spec.people, *people))


def _ways(spec: WorldSpec, random: Random, radius: float) -> list[Path]:
    """Some of the shortest ways between places."""
    if len(spec.places) < 2:
        raise WorldError(f"world {spec.name!r} needs two places or more under [places_m] to put something between")
    space = FreeSpace(spec, radius)
    path = cache(partial(path_in, space))
    pairs = (random.sample(list(spec.places.values()), 2) for _ in range(WAYS))
    ways = [way for start, goal in pairs if (way := path(start, goal))]
    if not ways:
        raise WorldError(f"world {spec.name!r} has no way of {2 * radius:.2f} m between its places")
    return ways


def _obstacle(name: str, way: Path, random: Random) -> Movable:
    """Something beside a way, or on it."""
    x, y = _somewhere(way, random)
    is_round = random.random() < 0.5
    length, width = random.uniform(*SIZES), random.uniform(*SIZES)
    return Movable(
        name,
        Shape.CYLINDER if is_round else Shape.BOX,
        Pose2D(x + random.gauss(0.0, SPREAD), y + random.gauss(0.0, SPREAD), random.uniform(-pi, pi)),
        length,
        length if is_round else width,
        OBSTACLE_HEIGHT,
        OBSTACLE_MASS,
        1.0,
        "orange",
    )


def _leaves_room(thing: Movable, clear: Sequence[Point]) -> bool:
    return all(dist((thing.pose.x, thing.pose.y), place) >= ROOM + thing.reach for place in clear)


def _added(spec: WorldSpec, thing: Movable) -> WorldSpec:
    return replace(spec, objects=(*spec.objects, thing))


def _is_passable(spec: WorldSpec, places: Sequence[Point], radius: float) -> bool:
    walking = FreeSpace(spec, BODY_RADIUS)
    routes = [(*person.route, person.route[0]) if person.loops else person.route for person in spec.people]
    return all(walking.has_way(route) for route in routes) and are_connected(FreeSpace(spec, radius), places)


def _person(number: int, ways: Sequence[Path], clear: Sequence[Point], random: Random) -> Person:
    for way in (random.choice(ways) for _ in range(TRIES)):
        route = PersonRoute(way.points, loops=False)
        begin = random.uniform(0.0, route.length)
        here = route.at(begin)
        if all(dist((here.x, here.y), place) >= APART for place in clear):
            name, clothes = NAMES[number % len(NAMES)], CLOTHES[number % len(CLOTHES)]
            name = name if number < len(NAMES) else f"{name} {number // len(NAMES) + 1}"
            return Person(name, way.points, False, begin, random.uniform(*SPEEDS), PAUSES, colour=clothes)
    raise WorldError(f"there is no room for one more person {APART} m from where robots start: ask for fewer")


def _somewhere(way: Path, random: Random) -> Point:
    here = PersonRoute(way.points, loops=False).at(random.uniform(0.0, way.length))
    return here.x, here.y


def _middle(door: MovingDoor) -> Point:
    (x1, y1), (x2, y2) = door.jamb, door.post
    return (x1 + x2) / 2, (y1 + y2) / 2
