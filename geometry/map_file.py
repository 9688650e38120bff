"""Reader of ARIA `.map` files: walls as lines, scanned points, and cairns (named places), in metres and radians.

A file is text: `Key: value` rows, then a row `LINES` with one segment a row, then a row `DATA` with one point a row.
The counts in the header are advisory: nothing here depends on them.
Source: the layout as seen in public map files; lengths in mm, headings in degrees.
"""

import io
import re
import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import isfinite, radians
from pathlib import Path

from geometry.pose import Pose2D, wrap_angle
from geometry.segments import Segment

MOST_POINTS = 200_000
"""Points kept of a map. A floor of a large building, scanned and thinned to 5 cm, has fewer."""
FINEST_CELL = 0.05
"""m; a map with more points is thinned to a grid of this pitch, or of one twice, four times … as coarse."""
_MANY = 1_000_000  # characters of points from which on they are read all at once
_FARTHEST = 1e6  # m; farther out the keys of cells would overlap
_SHIFT = 1 << 31
_MM = 1e-3
_SECTION = re.compile(r"[A-Za-z][\w .-]*")
_NUMBER = r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)"
_CAIRN = re.compile(rf'(\S+)\s+{_NUMBER}\s+{_NUMBER}\s+{_NUMBER}\s+"[^"]*"\s+\S+\s+"([^"]*)"\s*(.*)')


class MapError(ValueError):
    """A map file cannot be used; the message names file, line and reason."""


@dataclass(frozen=True, slots=True)
class Cairn:
    """A named place of a map.

    kind: what it is, e.g. `RobotHome`, `Goal`, `Dock`, `ForbiddenLine`.
    pose: where it is; of a line or an area, the heading its extent is turned by.
    name: the label people gave it, often empty.
    extent: end points of a line or opposite corners of an area; None for a point.
    """

    kind: str
    pose: Pose2D
    name: str
    extent: Segment | None = None


@dataclass(frozen=True, slots=True)
class MapFile:
    """What a map holds, in the map's frame.

    lines: walls, m.
    points: what a laser saw, (x, y) in m.
    cell: where the file has more than `MOST_POINTS`, one is kept in each square of this edge, m; 0 where all are kept.
    cairns: named places in the order of the file.
    kinds: what the file says of kinds of cairns of its own: attribute to value, by the kind's name.
    """

    lines: tuple[Segment, ...] = ()
    points: tuple[tuple[float, float], ...] = field(default=(), repr=False)
    cairns: tuple[Cairn, ...] = ()
    kinds: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    cell: float = 0.0

    def places(self, kind: str) -> tuple[Cairn, ...]:
        """All cairns of one kind, in the order of the file."""
        return tuple(cairn for cairn in self.cairns if cairn.kind == kind)

    @property
    def home(self) -> Pose2D | None:
        """Where a robot starts (the first `RobotHome`), or None where the map names no such place."""
        homes = self.places("RobotHome")
        return homes[0].pose if homes else None


def read_map(path: str | Path) -> MapFile:
    """Read a map file.

    Raises:
        MapError: the file cannot be read, is no map, or a row of it makes no sense.
    """
    try:
        text = Path(path).read_text(encoding="utf-8", errors="replace")  # older programs wrote names in Latin-1
    except OSError as err:
        raise MapError(f"{path}: cannot be read: {err.strerror}") from err
    return parse_map(text, str(path))


def parse_map(text: str, source: str) -> MapFile:
    """Read the text of a map file; `source` is named in errors.

    Raises:
        MapError: the text is no map, or a row of it makes no sense.
    """
    points, cell, text = _plain_points(text)
    rows = [(number, row.strip()) for number, row in enumerate(text.splitlines(), start=1) if row.strip()]
    if not rows or not rows[0][1].startswith("2D-Map"):
        raise MapError(f"{source}:1: not an ARIA map: the first line must be 2D-Map")
    lines: list[Segment] = []
    cairns: list[Cairn] = []
    kinds: dict[str, Mapping[str, str]] = {}
    section = ""
    for number, row in rows[1:]:
        if row[0].isalpha():
            key, colon, value = row.partition(":")
            if not colon:
                section = _section(row, f"{source}:{number}")
            elif key == "Cairn":
                cairns.append(_cairn(value.strip(), f"{source}:{number}"))
            elif key == "MapInfo":
                attributes = _attributes(value, f"{source}:{number}")
                kinds[attributes.get("Name", "")] = attributes
        elif section == "LINES":
            x1, y1, x2, y2 = _numbers(row, 4, f"{source}:{number}", "a line needs x1 y1 x2 y2")
            lines.append(Segment(x1 * _MM, y1 * _MM, x2 * _MM, y2 * _MM))
        elif section == "DATA":
            x, y = _numbers(row, 2, f"{source}:{number}", "a point needs x y")
            points.append((x * _MM, y * _MM))
        elif not section:
            raise MapError(f"{source}:{number}: expected `Key: value`, LINES or DATA, found {row[:40]!r}")
    return MapFile(tuple(lines), tuple(points), tuple(cairns), kinds, cell)


def _plain_points(text: str) -> tuple[list[tuple[float, float]], float, str]:
    """Take the points off the end of a map that has many, all at once; return them, their cell and the rest.

    Where the last section is no list of pairs of numbers, nothing is taken: the parser of rows finds the place.
    """
    head, section, tail = text.rpartition("\nDATA\n")
    if not section or len(tail) < _MANY:
        return [], 0.0, text
    import numpy as np  # here and not at the top: a program that reads no large map starts sooner

    try:
        table = np.loadtxt(io.StringIO(tail), comments=None, ndmin=2) * _MM
    except ValueError:
        return [], 0.0, text
    if table.shape[1] != 2 or not np.isfinite(table).all() or np.abs(table).max() > _FARTHEST:
        return [], 0.0, text
    cell = 0.0
    while len(table) > MOST_POINTS:
        cell = 2.0 * cell or FINEST_CELL
        columns = np.round(table / cell).astype(np.int64)
        keys = np.sort(columns[:, 0] * _SHIFT + columns[:, 1] + _SHIFT // 2)  # one number for each cell
        keys = keys[np.append(True, np.diff(keys) != 0)]
        table = np.stack((keys // _SHIFT, keys % _SHIFT - _SHIFT // 2), axis=1) * cell
    return [(x, y) for x, y in table.tolist()], cell, f"{head}{section}"


def _section(row: str, where: str) -> str:
    """Name of the section that a row opens; rows of sections other than LINES and DATA are passed over."""
    if not _SECTION.fullmatch(row):
        raise MapError(f"{where}: expected `Key: value`, LINES or DATA, found {row[:40]!r}")
    return row


def _numbers(row: str, count: int, where: str, expected: str) -> list[float]:
    words = row.split()
    if len(words) != count:
        raise MapError(f"{where}: {expected} (mm), found {row[:40]!r}")
    return _floats(words, where)


def _floats(words: Iterable[str], where: str) -> list[float]:
    try:
        values = [float(word) for word in words]
    except ValueError as err:
        raise MapError(f"{where}: {err}") from err
    if not all(map(isfinite, values)):
        raise MapError(f"{where}: a coordinate is not finite")
    return values


def _attributes(value: str, where: str) -> dict[str, str]:
    """The `key=value` pairs of a row, each of which may stand in quotes as a whole."""
    try:
        words = shlex.split(value)
    except ValueError as err:
        raise MapError(f"{where}: {err}") from err
    return {key: text for key, equals, text in (word.partition("=") for word in words) if equals}


def _cairn(value: str, where: str) -> Cairn:
    match = _CAIRN.fullmatch(value)
    if match is None:
        raise MapError(f'{where}: a cairn needs TYPE x y heading "description" ICON "name", found {value[:40]!r}')
    kind, *pose, name, rest = match.groups()
    x, y, degrees = _floats(pose, where)
    extent = None
    if rest:
        ends = _numbers(rest, 4, where, "the extent of a cairn needs x1 y1 x2 y2")
        extent = Segment(*(_MM * end for end in ends))
    return Cairn(kind, Pose2D(x * _MM, y * _MM, wrap_angle(radians(degrees))), name, extent)
