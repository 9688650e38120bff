"""Maps on disk: reads and writes ARIA `.map` and ROS `.yaml` with `.pgm`, chosen by the name of the file."""

import secrets
from contextlib import suppress
from pathlib import Path

from geometry.map_file import MapError
from maps.aria_files import format_aria_map, parse_aria_map
from maps.building_map import BuildingMap
from maps.rasterization import RESOLUTION, grid_of
from maps.ros_files import (
    MapYaml,
    format_map_yaml,
    format_pgm,
    grid_of_picture,
    parse_map_yaml,
    parse_pgm,
    picture_of_grid,
)

ARIA, ROS = (".map",), (".yaml", ".yml")


def read_building_map(path: str | Path) -> BuildingMap:
    """Read a map: `.map` of ARIA, or `.yaml` of ROS with the picture that it names.

    Raises:
        MapError: a file cannot be read, has an error or was not written completely; names file, line and reason.
    """
    path = Path(path)
    if path.suffix in ARIA:
        return parse_aria_map(_read(path).decode(errors="replace"), str(path))  # names in Latin-1
    if path.suffix in ROS:
        yaml = parse_map_yaml(_read(path).decode(errors="replace"), str(path))  # likewise
        picture = path.parent / yaml.image
        return BuildingMap(grid=grid_of_picture(parse_pgm(_read(picture), str(picture)), yaml), places=yaml.places)
    raise _unknown_kind(path)


def write_building_map(map_: BuildingMap, path: str | Path, resolution: float = RESOLUTION) -> tuple[Path, ...]:
    """Write a map as `.map` of ARIA, or as `.yaml` of ROS with a `.pgm` beside it. A file never exists in part.

    Args:
        map_: The map. Its lines and points become a grid where ROS needs one, and its grid points where ARIA does.
        path: File to write or to replace.
        resolution: Edge of the cells of a grid that is made of lines and points, m.
    Returns:
        The files that were written.
    Raises:
        MapError: the map cannot be expressed in the format, or a file cannot be written.
    """
    path = Path(path)
    if path.suffix in ARIA:
        _write(path, format_aria_map(map_, map_.grid.resolution if map_.grid else 0.02).encode())
        return (path,)
    if path.suffix not in ROS:
        raise _unknown_kind(path)
    try:
        grid = map_.grid or grid_of(map_, resolution)
    except ValueError as err:
        raise MapError(f"{path}: {err}") from err
    picture = path.with_suffix(".pgm")
    _write(picture, format_pgm(picture_of_grid(grid)))
    _write(path, format_map_yaml(MapYaml(picture.name, grid.resolution, grid.origin, places=map_.places)).encode())
    return path, picture


def _unknown_kind(path: Path) -> MapError:
    return MapError(f"{path}: a map is a file .map (ARIA) or .yaml (ROS, with a .pgm beside it)")


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as err:
        raise MapError(f"{path}: cannot be read: {err.strerror}") from err


def _write(path: Path, data: bytes) -> None:
    """Write a file beside, and let it take the place of the old one at once."""
    beside = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with beside.open("xb") as file:
            file.write(data)
        beside.replace(path)
    except OSError as err:
        raise MapError(f"{path}: cannot be written: {err.strerror}") from err
    finally:
        with suppress(OSError):  # it has taken the place, or was never there
            beside.unlink()
