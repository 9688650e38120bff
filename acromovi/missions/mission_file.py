"""Missions in a file of one's own: one JSON object for each line, with a robot, a floor, a start and a goal."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import configs
from acromovi.missions.task import Task, clearance
from configs import ConfigError
from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.fit import FitError, read_fit
from p2os_emu.world import WorldError, WorldSpec, load_world
from p2os_emu.world.shortest_path import shortest_path

PASSING = 0.05  # m beside the robot on the shortest way, where there is as much


@dataclass(frozen=True, slots=True)
class _Entry:
    """One line, key by key. start: m, m, rad. goal: m. perfect: without errors of odometry and sensors."""

    world: str
    robot: str
    start: tuple[float, float, float]
    goal: tuple[float, float]
    fit: tuple[str, ...] = ()
    seed: int = 0
    perfect: bool = False


@dataclass(frozen=True, slots=True)
class FileMission:
    """A line of such a file. world: path or name of the world, found from where the file is."""

    file: Path
    line: int
    entry: _Entry
    world: str

    @property
    def robot(self) -> str:
        """The model."""
        return self.entry.robot

    @property
    def command(self) -> str:
        """What to type to play it again."""
        return f"acromovi missions --file {self.file} --line {self.line}"

    @property
    def name(self) -> str:
        """For lists."""
        return f"line {self.line}: {self.entry.robot} in {self.entry.world}"

    def task(self) -> Task:
        """Find the shortest way.

        Raises:
            WorldError, ConfigError, FitError: There is no such world, robot or accessory.
        """
        entry = self.entry
        world, model = _world(self.world), configs.load(RobotModel, "robots", entry.robot)
        read_fit(entry.fit, model)
        start, half_width = entry.start[:2], model.width / 2
        room = clearance(world, start, entry.goal, half_width)
        way = shortest_path(world, start, entry.goal, half_width + min(PASSING, room)) if room is not None else None
        world, fit = replace(world, starts=(Pose2D(*entry.start),)), ",".join(entry.fit)
        return Task(world, entry.robot, fit, entry.goal, way, entry.seed, entry.perfect, room)


def read_missions(path: Path) -> list[FileMission]:
    """Read a file, and check everything that can be known before the missions are played.

    Raises:
        ConfigError: The file cannot be read, a line is not a mission, or names a world, a robot or an accessory that
            does not exist; says which line.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as err:
        raise ConfigError(f"{path} cannot be read: {err}; give a file with one JSON object for each mission") from err
    missions = [_mission(path, number, text) for number, text in enumerate(lines, 1) if text.strip()]
    if not missions:
        raise ConfigError(f"{path} has no missions; write one JSON object for each line")
    return missions


def _mission(path: Path, number: int, text: str) -> FileMission:
    where = f"{path}, line {number}"
    try:
        table: Any = json.loads(text)
    except ValueError as err:
        raise ConfigError(f"{where}: not JSON ({err}); write one object for each line") from err
    if not isinstance(table, Mapping):
        raise ConfigError(f'{where}: write an object, as in {{"world": "office", ...}}, not {text.strip()[:40]}')
    entry = configs.build(_Entry, table, where)
    beside = path.parent / entry.world
    world = str(beside) if beside.is_file() else entry.world
    try:
        _world(world)
        read_fit(entry.fit, configs.load(RobotModel, "robots", entry.robot))
    except (WorldError, FitError, ConfigError) as err:
        raise ConfigError(f"{where}: {err}") from err
    return FileMission(path, number, entry, world)


@lru_cache(maxsize=8)  # the missions of one floor come one after the other
def _world(name: str) -> WorldSpec:
    return load_world(name)
