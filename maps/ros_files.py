"""The files of ROS map_server: YAML that describes a map, and PGM with the picture of its grid.

Source: nav2_map_server (keys, modes and thresholds), the Netpbm specification of PGM (P2 and P5).
"""

import io
import re
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from geometry.map_file import Cairn, MapError
from geometry.pose import Pose2D, wrap_angle
from geometry.segments import Segment
from maps.occupancy import FREE, OCCUPIED, PROBABLY_OCCUPIED, UNKNOWN, OccupancyGrid

OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196
"""Thresholds that are written: with 205 for unknown, which is 0.19608, all readers give the three values back."""
_DIGITS = 9  # of m and rad: more than anybody measures, and no 0.30000000000000004
_MOST_CELLS = 100_000_000
_MODES = ("trinary", "scale", "raw")
_BLACK, _GREY, _WHITE = 0, 205, 254
_TOKEN = re.compile(rb"(?:\s|#[^\n]*\n)*(\S+)")


@dataclass(frozen=True)
class MapYaml:
    """What a YAML file of map_server says.

    image: file with the picture, relative to the YAML file.
    resolution: edge of a cell, m.
    origin: pose of the lower left corner in `map`.
    occupied, free: occupancy in 0..1 above which a cell is occupied, and below which it is free.
    is_negated: whether white is occupied.
    mode: trinary, scale or raw.
    places: named places, an extension of this project; map_server ignores the key.
    """

    image: str
    resolution: float
    origin: Pose2D
    occupied: float = OCCUPIED_THRESH
    free: float = FREE_THRESH
    is_negated: bool = False
    mode: str = "trinary"
    places: tuple[Cairn, ...] = ()


def parse_map_yaml(text: str, source: str) -> MapYaml:
    """Read the YAML of a map; `source` is named in errors.

    Raises:
        MapError: the text is no YAML, or a key is missing, unknown to this reader with a bad value, or out of range.
    """
    try:
        table = YAML(typ="rt").load(text)  # the kind of loader that keeps the lines
    except MarkedYAMLError as err:
        line = f":{err.problem_mark.line + 1}" if err.problem_mark else ""
        raise MapError(f"{source}{line}: {err.problem or err.context}; a map needs rows `key: value`") from err
    except (YAMLError, ValueError) as err:  # a character that YAML does not allow, or a date that does not exist
        raise MapError(f"{source}: {str(err).splitlines()[0]}; a map needs rows `key: value`") from err
    if not isinstance(table, dict):
        raise MapError(f"{source}:1: no rows `key: value`; a map needs image, resolution and origin")
    return _Rows(table, source).to_yaml()


class _Rows:
    """The rows of a YAML file, with the file and the line for errors."""

    def __init__(self, table: Any, source: str) -> None:
        self._table = table
        self._source = source

    def to_yaml(self) -> MapYaml:
        """Check all rows."""
        image = self._table.get("image")
        if not isinstance(image, str) or not image:
            raise self._error("image", "must be the name of a PGM file")
        resolution = self._number("resolution", None, 1e-4, 100.0)
        occupied = self._number("occupied_thresh", OCCUPIED_THRESH, 0.0, 1.0)
        free = self._number("free_thresh", FREE_THRESH, 0.0, 1.0)
        if free >= occupied:
            raise self._error("free_thresh", f"{free} must be below occupied_thresh, which is {occupied}")
        negate = self._table.get("negate", 0)
        if negate not in (0, 1):
            raise self._error("negate", f"must be 0 or 1, found {negate!r}")
        mode = self._table.get("mode", "trinary")
        if mode not in _MODES:
            raise self._error("mode", f"must be one of {', '.join(_MODES)}, found {mode!r}")
        x, y, heading = self._floats("origin", self._table.get("origin"), 3, "x, y (m) and heading (rad)")
        origin = Pose2D(x, y, wrap_angle(heading))
        return MapYaml(image, resolution, origin, occupied, free, bool(negate), mode, self._places())

    def _error(self, key: str, reason: str) -> MapError:
        line = self._table.lc.key(key)[0] + 1 if key in self._table else 1
        missing = "" if key in self._table else " (the key is missing)"
        return MapError(f"{self._source}:{line}: {key}{missing} {reason}")

    def _number(self, key: str, default: float | None, least: float, most: float) -> float:
        value = self._table.get(key, default)
        if not isinstance(value, int | float) or isinstance(value, bool) or not least <= value <= most:
            raise self._error(key, f"must be a number from {least} to {most}, found {value!r}")
        return float(value)

    def _floats(self, key: str, value: Any, count: int, meaning: str) -> list[float]:
        if not isinstance(value, list) or len(value) != count:
            raise self._error(key, f"must be a list of {count} numbers: {meaning}")
        if not all(isinstance(each, int | float) and isfinite(each) and abs(each) < 1e6 for each in value):
            raise self._error(key, f"has a value that is no number or out of range; expected {meaning}")
        return [float(each) for each in value]

    def _places(self) -> tuple[Cairn, ...]:
        rows = self._table.get("places", [])
        if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
            raise self._error("places", "must be a list of rows with kind, name, pose and perhaps extent")
        return tuple(self._place(row) for row in rows)

    def _place(self, row: Any) -> Cairn:
        kind, name = row.get("kind"), row.get("name", "")
        if not isinstance(kind, str) or not kind or not isinstance(name, str):
            raise self._error("places", f"has a row without a kind, or with a name that is no text: {dict(row)!r}")
        x, y, heading = self._floats("places", row.get("pose"), 3, "a pose of x, y (m) and heading (rad)")
        extent = None
        if "extent" in row:
            extent = Segment(*self._floats("places", row["extent"], 4, "an extent of x1, y1, x2 and y2 (m)"))
        return Cairn(kind, Pose2D(x, y, wrap_angle(heading)), name, extent)


def format_map_yaml(yaml: MapYaml) -> str:
    """Write the YAML of a map."""
    table: dict[str, Any] = {
        "image": yaml.image,
        "resolution": yaml.resolution,
        "origin": _pose_row(yaml.origin),
        "occupied_thresh": yaml.occupied,
        "free_thresh": yaml.free,
        "negate": int(yaml.is_negated),
        "mode": yaml.mode,
    }
    if yaml.places:
        table["places"] = [_place_row(place) for place in yaml.places]
    text = io.StringIO()
    writer = YAML()
    writer.default_flow_style = None
    writer.width = 120
    writer.dump(table, text)
    return text.getvalue()


def _place_row(place: Cairn) -> dict[str, Any]:
    row = {"kind": place.kind, "name": place.name, "pose": _pose_row(place.pose)}
    return row if place.extent is None else row | {"extent": [round(end, _DIGITS) for end in place.extent]}


def _pose_row(pose: Pose2D) -> list[float]:
    return [round(value, _DIGITS) for value in (pose.x, pose.y, pose.heading)]


def grid_of_picture(picture: NDArray[np.float64], yaml: MapYaml) -> OccupancyGrid:
    """Make a grid of the brightness of pixels, 0 to 255, shape (rows, columns), row 0 at the top."""
    bright = picture[::-1]
    cells = np.full(bright.shape, UNKNOWN, np.int8)
    if yaml.mode == "raw":
        known = bright <= OCCUPIED
        cells[known] = bright[known].astype(np.int8)
        return OccupancyGrid(cells, yaml.resolution, yaml.origin)
    occupancy = (bright if yaml.is_negated else 255.0 - bright) / 255.0
    if yaml.mode == "scale":
        share = (occupancy - yaml.free) / (yaml.occupied - yaml.free)
        cells = (FREE + np.rint(np.clip(share, 0.0, 1.0) * (OCCUPIED - FREE))).astype(np.int8)
    cells[occupancy > yaml.occupied] = OCCUPIED
    cells[occupancy < yaml.free] = FREE
    return OccupancyGrid(cells, yaml.resolution, yaml.origin)


def picture_of_grid(grid: OccupancyGrid) -> NDArray[np.uint8]:
    """Make a picture of three brightnesses of a grid, row 0 at the top; shape (rows, columns)."""
    picture = np.full(grid.cells.shape, _GREY, np.uint8)
    picture[(grid.cells >= FREE) & (grid.cells < FREE_THRESH * OCCUPIED)] = _WHITE
    picture[grid.cells >= PROBABLY_OCCUPIED] = _BLACK
    return picture[::-1]


def parse_pgm(data: bytes, source: str) -> NDArray[np.float64]:
    """Read a PGM picture, binary (P5) or as text (P2): brightness 0 to 255, shape (rows, columns), row 0 at the top.

    Raises:
        MapError: it is no PGM, or pixels are missing.
    """
    magic, columns, rows, most, start = _pgm_header(data, source)
    count = rows * columns
    if magic == b"P5":
        kind = np.dtype(np.uint8 if most < 256 else ">u2")
        body = data[start + 1 :]  # one white space ends the header
        found = len(body) // kind.itemsize
        pixels = np.frombuffer(body, kind, min(found, count)).astype(np.float64)
    else:
        text = re.sub(rb"#[^\n]*", b"", data[start:])
        try:
            pixels = np.array(text.split(), np.float64)
        except ValueError as err:
            raise MapError(f"{source}: a pixel is no number: {err}") from err
        found = len(pixels)
    if found < count:
        raise MapError(f"{source}: the file has {found} of {count} pixels: it was not written completely")
    return pixels[:count].reshape(rows, columns) * (255.0 / most)


def _pgm_header(data: bytes, source: str) -> tuple[bytes, int, int, int, int]:
    """Magic number, columns, rows, the greatest value, and where the header ends."""
    words: list[bytes] = []
    at = 0
    while len(words) < 4 and (match := _TOKEN.match(data[: 4096 + at], at)):
        words.append(match[1])
        at = match.end()
    if not words or words[0] not in (b"P5", b"P2"):
        raise MapError(f"{source}: no PGM picture (P5 or P2); convert it, for example with: convert PICTURE {source}")
    numbers = [int(word) for word in words[1:] if word.isdigit() and len(word) < 10]
    if len(numbers) != 3 or not 0 < numbers[2] < 65536 or not 0 < numbers[0] * numbers[1] <= _MOST_CELLS:
        raise MapError(f"{source}: the header of a PGM needs width, height and greatest value (at most 65535)")
    columns, rows, most = numbers
    return words[0], columns, rows, most, at


def format_pgm(picture: NDArray[np.uint8]) -> bytes:
    """Write a picture of shape (rows, columns), row 0 at the top, as a binary PGM."""
    rows, columns = picture.shape
    return b"P5\n%d %d\n255\n" % (columns, rows) + picture.tobytes()
