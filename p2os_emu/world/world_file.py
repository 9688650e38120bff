"""World files: loading them by name, what their tables and keys mean, and the world that they describe."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, TypeVar

import configs
from geometry import MapError, Pose2D, read_map, wrap_angle
from p2os_emu.world.aria_map import MOST_WALLS, world_of
from p2os_emu.world.colours import check_colour
from p2os_emu.world.docks import Dock
from p2os_emu.world.errors import WorldError
from p2os_emu.world.floor import Floor
from p2os_emu.world.light import Light
from p2os_emu.world.magnets import MagnetEntry
from p2os_emu.world.movable import ObjectEntry
from p2os_emu.world.moving_doors import MovingDoorEntry
from p2os_emu.world.people import PersonEntry
from p2os_emu.world.spec import Block, WallEntry, WorldSpec
from p2os_emu.world.tables import TableEntry
from p2os_emu.world.textures import Textures

_FURNITURE_COLOUR = "brown"
_STATION_SIZE = 0.2, 0.4, 0.4
"""Length, width and height of the station at a dock, m; assumed."""


def load_world(name: str | Path) -> WorldSpec:
    """Load a world.

    Args:
        name: Of a world in `configs/worlds` ("office"), the path of a `.toml` or `.map` file, or of a floor made up by
            a seed: "plan:7", "hall:7" and the other families in `p2os_emu.world.floors.families`.
    Raises:
        WorldError: there is no such world, or its file has an error; says which file, where and why.
    """
    if ":" in str(name):
        # Here and not at the top: they are eleven modules, and most worlds are files.
        from p2os_emu.world.floors.families import floor

        if (made_up := floor(str(name))) is not None:
            return made_up
    try:
        path = _find(str(name))
        if path.suffix == ".map":
            return world_of(read_map(path), path.stem)
        file = configs.build(WorldFile, configs.read(path), str(path))
    except (configs.ConfigError, MapError) as err:
        raise WorldError(str(err)) from err
    spec = file.to_spec(path.stem, str(path))
    if (count := len(spec.walls) + len(spec.furniture)) > MOST_WALLS:
        raise WorldError(f"{path}: {count} walls and pieces of furniture are too many; use at most {MOST_WALLS}")
    return spec


def _find(name: str) -> Path:
    """Return the file of a world.

    Raises:
        ConfigError: There is none.
        WorldError: The name is that of a family of floors.
    """
    try:
        return configs.find("worlds", name)
    except configs.ConfigError:
        from p2os_emu.world.floors.families import FAMILIES

        if name in FAMILIES:
            raise WorldError(f"{name} is a family of floors: write a whole number behind it, as in {name}:7") from None
        raise


_FEWEST_CORNERS, _MOST_CORNERS = 3, 20  # of a chessboard, along and up


@dataclass(frozen=True, slots=True)
class _FurnitureEntry:
    """A box: centre, size (length, width, height) and heading of its length."""

    at_m: tuple[float, float]
    size_m: tuple[float, float, float]
    name: str = ""
    heading_deg: float = 0.0
    reflector: bool = False
    colour: str = _FURNITURE_COLOUR
    bottom_m: float = 0.0
    glass: bool = False
    board: tuple[int, int] = (0, 0)

    def block(self) -> Block:
        """The box in SI."""
        check_colour(self.colour)
        if not min(self.size_m) > 0.0:
            raise ValueError("length, width and height must be above 0 m")
        if not 0.0 <= self.bottom_m < math.inf:
            raise ValueError(f"bottom_m must be 0 m or more, not {self.bottom_m}")
        if any(self.board) and not all(_FEWEST_CORNERS <= each <= _MOST_CORNERS for each in self.board):
            raise ValueError(
                f"board is the number of inner corners along and up, {_FEWEST_CORNERS} to {_MOST_CORNERS} each, "
                f"as in [9, 6]; not {list(self.board)}"
            )
        if any(self.board) and self.glass:
            raise ValueError("a board is not made of glass; leave out board or glass")
        heading = math.radians(self.heading_deg)
        return Block(
            *self.at_m,
            heading,
            *self.size_m,
            self.name,
            self.reflector,
            self.colour,
            self.bottom_m,
            self.glass,
            self.board,
        )


@dataclass(frozen=True, slots=True)
class _DropEntry:
    """An area without floor: centre, size (length, width) and heading of its length."""

    at_m: tuple[float, float]
    size_m: tuple[float, float]
    name: str = ""
    heading_deg: float = 0.0

    def block(self) -> Block:
        """The area in SI."""
        if not min(self.size_m) > 0.0:
            raise ValueError("length and width must be above 0 m")
        return Block(*self.at_m, math.radians(self.heading_deg), *self.size_m, 0.0, self.name)


@dataclass(frozen=True, slots=True)
class _DockEntry:
    """A charging dock: pose of a robot that is charged, and how far ahead of its axle the station stands."""

    at_m: tuple[float, float]
    heading_deg: float = 0.0
    name: str = "dock"
    station_m: float = 0.45

    @property
    def dock(self) -> Dock:
        """The dock in SI."""
        return Dock(self.name, Pose2D(*self.at_m, wrap_angle(math.radians(self.heading_deg))))

    def station(self) -> Block:
        """The box in front of a robot that is charged."""
        if not 0.0 < self.station_m < math.inf:
            raise ValueError(f"station_m must be above 0 m, not {self.station_m}")
        pose = self.dock.pose
        place = pose.transform(self.station_m + _STATION_SIZE[0] / 2, 0.0)
        return Block(*place, pose.heading, *_STATION_SIZE, self.name, colour="black")


@dataclass(frozen=True, slots=True)
class _StartEntry:
    """Where a robot may begin."""

    at_m: tuple[float, float]
    heading_deg: float = 0.0


@dataclass(frozen=True, slots=True)
class WorldFile:
    """A file of `configs/worlds`, key by key."""

    about: str = ""
    walls: tuple[WallEntry, ...] = ()
    furniture: tuple[_FurnitureEntry, ...] = ()
    tables: tuple[TableEntry, ...] = ()
    objects: tuple[ObjectEntry, ...] = ()
    drops: tuple[_DropEntry, ...] = ()
    magnets: tuple[MagnetEntry, ...] = ()
    floor: Floor = field(default_factory=Floor)
    starts: tuple[_StartEntry, ...] = (_StartEntry((0.0, 0.0)),)
    routes_m: Mapping[str, tuple[tuple[float, float], ...]] = field(default_factory=dict)
    places_m: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    people: tuple[PersonEntry, ...] = ()
    moving_doors: tuple[MovingDoorEntry, ...] = ()
    textures: Textures = field(default_factory=Textures)
    light: Light | None = None
    docks: tuple[_DockEntry, ...] = ()

    def to_spec(self, name: str, source: str) -> WorldSpec:
        """Turn the entries into a world.

        Raises:
            WorldError: an entry makes no sense; names file, entry and reason.
        """
        try:
            walls = _made("walls", self.walls, lambda wall: tuple(wall.blocks()))
            furniture = _made("furniture", self.furniture, _FurnitureEntry.block)
            tables = _made("tables", self.tables, TableEntry.blocks)
            objects = _made("objects", self.objects, ObjectEntry.movable, apart=True)
            drops = _made("drops", self.drops, _DropEntry.block)
            stations = _made("docks", self.docks, _DockEntry.station, apart=True)
            people = _made("people", self.people, PersonEntry.person, apart=True)
            moving_doors = _made("moving_doors", self.moving_doors, MovingDoorEntry.door, apart=True)
        except ValueError as err:
            raise WorldError(f"{source}: {err}") from err
        try:
            self.floor.check()
        except ValueError as err:
            raise WorldError(f"{source}: floor: {err}") from err
        try:
            if self.light is not None:
                self.light.check()
        except ValueError as err:
            raise WorldError(f"{source}: light: {err}") from err
        if not self.starts:
            raise WorldError(f"{source}: starts must hold at least one place for a robot")
        starts = tuple(Pose2D(*start.at_m, math.radians(start.heading_deg)) for start in self.starts)
        return WorldSpec(
            name,
            self.about,
            tuple(block for wall in walls for block in wall),
            (*furniture, *(block for table in tables for block in table), *stations),
            starts,
            self.routes_m,
            objects=objects,
            drops=drops,
            magnets=tuple(magnet.magnet() for magnet in self.magnets),
            floor=self.floor,
            places=self.places_m,
            people=people,
            moving_doors=moving_doors,
            textures=self.textures,
            light=self.light,
            docks=tuple(entry.dock for entry in self.docks),
        )


class _Named(Protocol):
    @property
    def name(self) -> str: ...


E = TypeVar("E", bound=_Named)
T = TypeVar("T")


def _made(key: str, entries: Sequence[E], make: Callable[[E], T], *, apart: bool = False) -> tuple[T, ...]:
    """What the entries under a key stand for.

    Args:
        key: In the file.
        entries: Under it.
        make: Makes one; raises ValueError where the entry makes no sense.
        apart: No two may have one name.
    Raises:
        ValueError: With the place in the file.
    """
    made = []
    names: set[str] = set()
    for number, entry in enumerate(entries):
        try:
            if apart and entry.name in names:
                raise ValueError("there is one of this name already; give each its own")
            made.append(make(entry))
        except ValueError as err:
            raise ValueError(f"{key}[{number}] {entry.name}".strip() + f": {err}") from err
        names.add(entry.name)
    return tuple(made)
