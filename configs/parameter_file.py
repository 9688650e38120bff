"""Robot parameter files (`.p`) as ARIA's programs keep them: read into the table that a `configs/robots` file has.

Such a file is lines of `Key value ; comment` in named sections, in mm and degrees. It says nothing of mass, wheels,
encoders and firmware: those come from the model of `configs/robots` that it names or is most like.
"""

import difflib
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from configs.defaults import ROBOT

Row = tuple[int, str, list[str]]
"""Number of the line, section, and the line's words."""

_MM = 1000  # in a m
_P2OS_RANGE = 0.3  # mm per count; finer ones are timer units of P2OS


class ParameterError(ValueError):
    """A line that cannot be read; the message names it."""


def parse(text: str, known: Callable[[str], Mapping[str, Any]], names: Sequence[str]) -> dict[str, Any]:
    """Read a parameter file.

    Args:
        text: Of the file.
        known: Gives the table of a model by its name.
        names: Of the models there are.
    Returns:
        A table as `RobotModel.from_table` takes it.
    Raises:
        ParameterError: A value is missing or no number.
    """
    values: dict[str, Row] = {}
    sonar, infrared = [], []
    lasers: dict[str, dict[str, Row]] = {}
    for row in _rows(text):
        _, section, words = row
        match words[0].lower():
            case "sonarunit":
                number, x, y, heading = _numbers(row, 4)
                sonar.append([int(number), x / _MM, y / _MM, heading])
            case "irunit":
                number, kind, cycles, x, y = _numbers(row, 5)
                infrared.append([int(number), int(kind), int(cycles), x / _MM, y / _MM])
            case key if section.startswith("laser"):
                lasers.setdefault(section, {})[key] = row
            case key:
                values.setdefault(key, row)
    base = _base(values, names)
    table = {**known(base), **_converted(values)}
    table |= {"name": _text(values, "subclass"), "robot_class": _text(values, "class") or "Pioneer"}
    if table["name"].lower() != base:
        table["full_name"] = table["name"]
    if not table["name"]:
        raise ParameterError("there is no Subclass; is this a robot's parameter file?")
    table |= {"sonar": sorted(each for each in sonar if each[1:3] != [0.0, 0.0]), "ir": infrared}
    table["laser"] = [_laser(rows) for rows in lasers.values() if _text(rows, "lasertype")]
    return table


def _rows(text: str) -> Iterator[Row]:
    section = ""
    for number, line in enumerate(text.splitlines(), 1):
        words = line.partition(";")[0].split()
        if words and words[0].lower() == "section":
            section = " ".join(words[1:]).lower()
        elif words:
            yield number, section, words


def _base(values: Mapping[str, Row], names: Sequence[str]) -> str:
    """The model that answers what the file does not say: the same, one of the like, or a Pioneer 3-DX."""
    subclass = _text(values, "subclass").lower()
    if subclass in names:
        return subclass
    shorter = [name for name in names if subclass.startswith(name)]
    near = [max(shorter, key=len)] if shorter else difflib.get_close_matches(subclass, names, 1, 0.6)
    return near[0] if near else ROBOT


def _converted(values: Mapping[str, Row]) -> dict[str, Any]:
    """What the file says, under the keys and in the units of a `configs/robots` file."""
    table: dict[str, Any] = {}
    for key, (name, per_unit) in _SCALED.items():
        if name in values:
            table[key] = _numbers(values[name], 1)[0] / per_unit
    for key, name in _FLAGS.items():
        if name in values:
            table[key] = _flag(values, name)
    for end in ("front", "rear"):
        if not table.get(f"length_{end}_m", 1.0):
            table[f"length_{end}_m"] = table["length_m"] / 2
        if f"num{end}bumpers" in values:
            count = int(_numbers(values[f"num{end}bumpers"], 1)[0])
            table[f"{end}_bumpers"] = count if _flag(values, f"{end}bumpers") else 0
    if "diffconvfactor" in values:
        table["wheel_track_m"] = 2 / _MM / _positive(values["diffconvfactor"])
    if "vel2divisor" in values:
        table["vel2_m_s_per_count"] = _positive(values["vel2divisor"]) / _MM
    table["firmware"] = _firmware(values, table)
    return table


def _firmware(values: Mapping[str, Row], table: Mapping[str, Any]) -> str:
    """The family, by what its units and its name give away."""
    subclass = _text(values, "subclass").lower()
    if subclass.endswith("uarcs"):
        return "uARCS"
    if "-sh" in subclass or table.get("distance_m_per_count") == 1 / _MM:
        return "ARCOS"
    if subclass.startswith("amigo"):
        return "AmigOS"
    return "P2OS" if table.get("range_m_per_count", 1.0) < _P2OS_RANGE / _MM else "AROS"


def _laser(rows: Mapping[str, Row]) -> dict[str, Any]:
    def number(name: str) -> float:
        return _numbers(rows[name], 1)[0] if len(rows.get(name, (0, "", []))[2]) > 1 else 0.0

    return {
        "kind": _text(rows, "lasertype"),
        "x_m": number("laserx") / _MM,
        "y_m": number("lasery") / _MM,
        "heading_deg": number("laserth"),
        "flipped": _flag(rows, "laserflipped"),
        "autoconnect": _flag(rows, "laserautoconnect"),
        "power_controlled": _flag(rows, "laserpowercontrolled"),
        "ignore_deg": [_range(word) for word in rows.get("laserignore", (0, "", []))[2][1:]],
    }


def _range(text: str) -> list[float]:
    """Bearings from and to, deg, of `72-76` or `-76--72`; a single one means a degree on either side."""
    match = _BEARINGS.fullmatch(text)
    if match is None:
        raise ParameterError(f"LaserIgnore {text!r} is no bearing and no range of bearings such as 72-76")
    low, high = match["low"], match["high"]
    return [float(low), float(high)] if high else [float(low) - 1.0, float(low) + 1.0]


_BEARINGS = re.compile(r"(?P<low>-?\d+(\.\d+)?)(-(?P<high>-?\d+(\.\d+)?))?")
_SCALED: Mapping[str, tuple[str, int]] = {
    "radius_m": ("robotradius", _MM),
    "width_m": ("robotwidth", _MM),
    "length_m": ("robotlength", _MM),
    "length_front_m": ("robotlengthfront", _MM),
    "length_rear_m": ("robotlengthrear", _MM),
    "max_velocity_m_s": ("maxvelocity", _MM),
    "max_rotation_deg_s": ("maxrvelocity", 1),
    "distance_m_per_count": ("distconvfactor", _MM),
    "velocity_m_s_per_count": ("velconvfactor", _MM),
    "range_m_per_count": ("rangeconvfactor", _MM),
}
_FLAGS: Mapping[str, str] = {
    "request_io_packets": "requestiopackets",
    "table_sensing_ir": "tablesensingir",
    "new_table_sensing_ir": "newtablesensingir",
}


def _text(values: Mapping[str, Row], name: str) -> str:
    """The first word of a value; empty where there is none."""
    _, _, words = values.get(name, (0, "", []))
    return words[1] if len(words) > 1 else ""


def _flag(values: Mapping[str, Row], name: str) -> bool:
    return _text(values, name).lower() in ("true", "1", "yes")


def _positive(row: Row) -> float:
    number = _numbers(row, 1)[0]
    if number <= 0.0:
        raise ParameterError(f"line {row[0]}: {row[2][0]} must be above zero, not {number:g}")
    return number


def _numbers(row: Row, count: int) -> list[float]:
    line, _, words = row
    try:
        numbers = [float(word) for word in words[1 : count + 1]]
    except ValueError:
        numbers = []
    if len(numbers) < count or not all(map(math.isfinite, numbers)):
        raise ParameterError(f"line {line}: {words[0]} needs {count} numbers, not {' '.join(words[1:]) or 'nothing'}")
    return numbers
