"""A small building for the tests: four rooms round a crossing, as a world, as a map, and as a file."""

from functools import cache
from pathlib import Path

from apps.surveillance.algorithms.floor import PatrolFloor
from benchmarks.localization_drives import map_of_world
from configs.loader import build
from geometry import Cairn, Point, Pose2D
from maps.building_map import BuildingMap
from maps.map_files import write_building_map
from p2os_emu.world import WorldSpec
from p2os_emu.world.world_file import WorldFile

ROOMS: dict[str, Point] = {"South": (2.0, 1.2), "North": (2.0, 4.6), "East": (6.0, 1.5), "Far": (6.0, 4.8)}
HAPPY, DOC = Pose2D(1.0, 1.0, 0.0), Pose2D(6.0, 1.8, 1.57)
_WALLS = (
    ((0, 0), (8, 0)),
    ((8, 0), (8, 6)),
    ((8, 6), (0, 6)),
    ((0, 6), (0, 0)),
    ((4, 0), (4, 2)),
    ((4, 3.2), (4, 6)),
    ((0, 3), (1.2, 3)),
    ((2.4, 3), (4, 3)),
    ((4, 3.2), (5.4, 3.2)),
    ((6.6, 3.2), (8, 3.2)),
    ((7, 0.3), (7, 1.2)),
)


@cache
def world() -> WorldSpec:
    """Return it for the emulator."""
    walls = [
        {"name": f"wall {number}", "from_m": list(begin), "to_m": list(end)}
        for number, (begin, end) in enumerate(_WALLS)
    ]
    table = {"walls": walls, "starts": [{"at_m": [1.0, 1.0]}]}
    return build(WorldFile, table, "test").to_spec("building", "test")


@cache
def building_map() -> BuildingMap:
    """Return its true map, with the rooms as goals."""
    goals = tuple(Cairn("Goal", Pose2D(*place), name) for name, place in ROOMS.items())
    return map_of_world(world()).with_places(Cairn("RobotHome", HAPPY, ""), *goals)


@cache
def floor() -> PatrolFloor:
    """Return its floor for a robot of 0.4 m."""
    return PatrolFloor(building_map(), 0.25)


def map_file(folder: Path) -> Path:
    """Write the map into a folder."""
    return write_building_map(building_map(), folder / "building.map")[0]
