"""The text of ARIA `.map` files: strict writing, and reading that refuses half-written files.

A file is a header, a row `LINES` with one segment a row, and a row `DATA` with one point a row; lengths in mm,
headings in degrees. `geometry.map_file` parses the rows; this module adds what a map that was written here must have.
Source: the layout of public map files.
"""

from collections.abc import Iterator
from math import degrees

import numpy as np
from numpy.typing import NDArray

from geometry.map_file import Cairn, MapError, parse_map
from maps.building_map import BuildingMap

_MM = 1000.0
_MOST_MM = 2**31 - 1
_SECTIONS = {"LINES": "NumLines", "DATA": "NumPoints"}


def parse_aria_map(text: str, source: str) -> BuildingMap:
    """Read the text of an ARIA map; `source` is named in errors.

    Raises:
        MapError: the text is no map, a row of it makes no sense, or rows are missing at its end.
    """
    file = parse_map(text, source)
    rows = text.splitlines()
    _refuse_half_a_file(rows, text.endswith("\n"), source)
    info = tuple(row.partition(":")[2].strip() for row in rows if row.startswith("MapInfo:"))
    return BuildingMap.of_file(file, info)


def _refuse_half_a_file(rows: list[str], is_ended: bool, source: str) -> None:
    """Compare the rows of each section with the counts in the header.

    Maps drawn by hand often have more rows than their header says, so only missing rows are an error.
    """
    promised: dict[str, int] = {}
    found = dict.fromkeys(_SECTIONS.values(), 0)
    section = ""
    for row in rows:
        if row[:1].isalpha():
            key, colon, value = row.partition(":")
            if not colon:
                section = row.strip()
            elif key in found and value.strip().isdecimal():
                promised[key] = int(value)
        elif section in _SECTIONS and row.strip():
            found[_SECTIONS[section]] += 1
    if section not in _SECTIONS:
        raise MapError(f"{source}:{len(rows)}: the file ends before a row LINES or DATA: it was not written completely")
    for key, count in promised.items():
        if found[key] < count:
            raise MapError(
                f"{source}:{len(rows)}: the file ends after {found[key]} of {count} rows ({key} in its header): it was"
                " not written completely. Use a complete copy"
            )
    if promised and not is_ended:
        raise MapError(f"{source}:{len(rows)}: the last row has no end of line: the file was not written completely")


def format_aria_map(map_: BuildingMap, resolution: float = 0.02) -> str:
    """Write a map as the text of an ARIA map.

    Of a map without points, the centres of occupied cells of its grid are written. Points are rounded to mm and sorted,
    equal ones are written once.

    Args:
        map_: What to write.
        resolution: Distance of neighbouring points, written to the header, m.
    Raises:
        MapError: a name has a character that the format cannot hold, or a coordinate does not fit it.
    """
    points, lines = _in_mm(_points_of(map_), 2), _in_mm(np.array(map_.lines, np.float64), 4)
    if len(points):
        points = np.unique(points, axis=0)
    cairns = [_cairn(each) for each in map_.places]
    head = ["2D-Map", *_limits(points, ""), f"NumPoints: {len(points)}", "PointsAreSorted: true"]
    head += [
        f"Resolution: {round(resolution * _MM)}",
        *_limits(lines.reshape(-1, 2), "Line"),
        f"NumLines: {len(lines)}",
    ]
    head += [f"MapInfo: {info}" for info in map_.info]
    rows = [*head, *cairns, "LINES", *_rows(lines), "DATA", *_rows(points)]
    return "\n".join(rows) + "\n"


def _points_of(map_: BuildingMap) -> NDArray[np.float64]:
    if len(map_.points) or map_.grid is None:
        return map_.points
    return map_.grid.centres(map_.grid.is_occupied())


def _in_mm(values: NDArray[np.float64], columns: int) -> NDArray[np.int64]:
    table = values.reshape(-1, columns) * _MM
    if table.size and not np.abs(table).max() <= _MOST_MM:  # false for NaN as well
        raise MapError(f"a coordinate of the map is not finite or beyond {_MOST_MM / _MM:.0f} m; it cannot be written")
    return np.rint(table).astype(np.int64)


def _limits(points: NDArray[np.int64], prefix: str) -> Iterator[str]:
    """The rows with the least and the greatest coordinates, mm; 0 0 where there is nothing."""
    for name, corner in (("MinPos", np.min), ("MaxPos", np.max)):
        x, y = corner(points, axis=0) if len(points) else (0, 0)
        yield f"{prefix}{name}: {x} {y}"


def _rows(table: NDArray[np.int64]) -> Iterator[str]:
    return (" ".join(map(str, row)) for row in table.tolist())


def _cairn(place: Cairn) -> str:
    if any(char in place.name for char in '"\n\r') or not place.kind or any(char.isspace() for char in place.kind):
        raise MapError(
            f"the place {place.kind!r} {place.name!r} cannot be written: a kind has no spaces, a name no quotes"
        )
    x, y = _in_mm(np.array([[place.pose.x, place.pose.y]]), 2)[0].tolist()
    extent = "" if place.extent is None else " " + " ".join(_rows(_in_mm(np.array(place.extent), 4)))
    return f'Cairn: {place.kind} {x} {y} {degrees(place.pose.heading):.6f} "" ICON "{place.name}"{extent}'
