"""The floor plan of the console: from a team's world, a world file, or a map."""

from math import radians
from pathlib import Path

from acromovi.process_pool import process_pool
from apps.console.floor import FloorPlan
from configs.extras import require
from configs.loader import ConfigError
from configs.team_file import read_team
from geometry.map_file import MapError, read_map

_MAP = ".map"
_MOST_POINTS = 20_000  # of a map, that are sent to a browser


def floor_plan(file: Path) -> FloorPlan:
    """Return the walls of an ARIA `.map` file or of a world file.

    Raises:
        ConfigError: The file cannot be used.
    """
    if file.suffix == _MAP:
        try:
            found = read_map(file)
        except (MapError, OSError) as err:
            raise ConfigError(f"{file} cannot be used as a map: {err}") from err
        lines = [(line.x1, line.y1, line.x2, line.y2) for line in found.lines]
        points = found.points[:: max(1, -(-len(found.points) // _MOST_POINTS))]
        places = [(goal.name, goal.pose.x, goal.pose.y) for goal in found.cairns if goal.name]
        return FloorPlan(file.name, lines, points=points, places=places, map_file=file.name)
    return _of_world(str(file))


def floor_plan_of_team(team: str | None) -> FloorPlan:
    """Return the walls of the world of a team's emulated robots; none without a team, or with real robots only.

    Raises:
        ConfigError: The team or its world cannot be used.
    """
    if team is None:
        return FloorPlan()
    file = read_team(team)
    return _of_world(file.world) if any(robot.is_emulated for robot in file.robots) else FloorPlan()


def starts_of_team(team: str | None) -> dict[str, tuple[float, float, float]]:
    """Return where robots began by a team's file: x and y, m, and heading, rad, by name.

    Raises:
        ConfigError: The team cannot be used.
    """
    robots = read_team(team).robots if team is not None else ()
    return {robot.name: (*robot.at_m, radians(robot.heading_deg)) for robot in robots if robot.at_m is not None}


def _of_world(name: str) -> FloorPlan:
    """Read a world in a process of its own, since its reader loads the emulator's physics, which takes memory."""
    require("the walls of a world file", "emu")
    with process_pool(1) as process:
        return process.submit(_read_world, name).result()


def _read_world(name: str) -> FloorPlan:
    from p2os_emu.world import WorldError, load_world

    try:
        spec = load_world(name)
    except WorldError as err:
        raise ConfigError(str(err)) from err
    walls, things = ([list(block.footprint) for block in blocks] for blocks in (spec.walls, spec.furniture))
    places = [(name, x, y) for name, (x, y) in spec.places.items()]
    map_file = Path(name).name if name.endswith(_MAP) else ""
    return FloorPlan(spec.name, shapes=walls, things=things, places=places, map_file=map_file)
