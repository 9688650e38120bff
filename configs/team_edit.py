"""Writes the calibration of a camera into a team file, which keeps its comments and its order."""

import os
import re
import shutil
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from configs.camera_calibration import CameraCalibration
from configs.loader import ConfigError, build, read
from configs.team_file import TeamFile

_KEY = "camera_calibration"
_ROBOT = re.compile(r"""\s*\[\[\s*["']?robots["']?\s*\]\]\s*(#.*)?$""")
_HEADER = re.compile(r"""\s*\[{1,2}[\w\s."'-]+\]{1,2}\s*(#.*)?$""")
_OLD = re.compile(rf"""\s*["']?{_KEY}["']?\s*=""")


def write_calibration(team: Path, robot: str, calibration: CameraCalibration) -> None:
    """Add one line to a robot of a team file, or replace the one that it has.

    The new file is read before it takes the place of the old one: it says what the old one says, and the calibration.

    Raises:
        ConfigError: There is no such robot, the file cannot be written, or it has a form that cannot be edited here;
            the message contains the line to add by hand.
    """
    before = read(team)
    rows = before.get("robots")
    names = [row.get("name") for row in rows if isinstance(row, Mapping)] if isinstance(rows, list) else []
    if robot not in names:
        known = ", ".join(map(str, names)) or "none"
        raise ConfigError(f"{team}: there is no robot {robot!r} in this team; its robots are {known}")
    line = f"{_KEY} = {calibration.toml}"
    wanted = {**before, "robots": [dict(row) for row in before["robots"]]}
    wanted["robots"][names.index(robot)] |= tomllib.loads(line)
    build(TeamFile, wanted, str(team))
    try:
        with team.open(encoding="utf-8", newline="") as file:
            edited = _edited(file.read(), names.index(robot), line)
        if not _says(edited, wanted):
            raise ConfigError(f"{team} has a form that cannot be edited here; add to the robot {robot} by hand: {line}")
        _replace(team.resolve(), edited)
    except OSError as err:
        raise ConfigError(f"{team} cannot be written: {err.strerror}") from err


def _edited(text: str, number: int, line: str) -> str:
    """Return a team file with a line in the table of a robot; unchanged if the table is not found."""
    lines = text.splitlines(keepends=True)
    robots = [at for at, each in enumerate(lines) if _ROBOT.match(each.rstrip())]
    if number >= len(robots):
        return text
    begin = robots[number] + 1
    end = next((at for at in range(begin, len(lines)) if _HEADER.match(lines[at].rstrip())), len(lines))
    ending = "\r\n" if lines[robots[number]].endswith("\r\n") else "\n"
    old = next((at for at in range(begin, end) if _OLD.match(lines[at])), None)
    if old is not None:
        lines[old] = line + ending
        return "".join(lines)
    last = max((at for at in range(begin, end) if lines[at].strip() and lines[at].strip()[0] != "#"), default=begin - 1)
    if not lines[last].endswith(("\n", "\r")):
        lines[last] += ending
    return "".join((*lines[: last + 1], line + ending, *lines[last + 1 :]))


def _says(text: str, wanted: object) -> bool:
    try:
        return tomllib.loads(text) == wanted
    except tomllib.TOMLDecodeError:  # then it says something else
        return False


def _replace(path: Path, text: str) -> None:
    """Write a file beside, and let it take the place of the old one at once."""
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with beside.open("x", encoding="utf-8", newline="") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        shutil.copymode(path, beside)
        beside.replace(path)
    finally:
        with suppress(FileNotFoundError):  # it has taken the place
            beside.unlink()
