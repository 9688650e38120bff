"""Checks a team without starting it: what would keep its processes from starting, and what is not there yet."""

import os
from collections import defaultdict
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, field
from math import radians
from pathlib import Path
from typing import Any

import configs
from acromovi.team.identities import folder_of_keys
from acromovi.team.plan import TeamPlan
from bus.errors import BusError
from bus.secure import Profile
from configs import ConfigError
from configs.extras import missing, needs
from configs.team_file import TeamRobot
from gateway.local_ports import holders
from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.fit import Fit, FitError, read_fit
from p2os_emu.links.memory import MemoryLink
from p2os_emu.links.profile import LinkProfile


@dataclass(slots=True)
class TeamFindings:
    """What a check has found.

    robots: a line for each robot. problems: what keeps the team, or a robot, from starting. notes: what is not there
    yet, and would be waited for.
    """

    robots: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """Return it as one JSON object."""
        return {"ok": not self.problems, "problems": self.problems, "notes": self.notes}


def check_team(name: str, only: tuple[str, ...], bus: str, *, console: bool = False) -> TeamFindings:
    """Check a team's file, and what it needs of this machine.

    Args:
        name: One of `configs/teams`, or a file.
        only: The robots that are wanted; none means all.
        bus: The bus profile.
        console: Whether the web console is wanted as well.
    """
    found = TeamFindings()
    try:
        team = TeamPlan.load(name, only)
    except (ConfigError, BusError) as err:
        found.problems.append(str(err))
        return found
    if console and missing("console"):
        found.problems.append(needs("acromovi up --console", "console"))
    found.problems += [*_extras(team), *_links(team), *_emulated(team), *_shared_ports(team), *_bus(team, bus)]
    for robot in team.robots:
        _check_robot(robot, found)
    return found


def _extras(team: TeamPlan) -> Iterator[str]:
    if team.emulated and missing("emu"):
        yield needs("a team with emulated robots", "emu")
    has_camera = any(robot.camera or any(part.startswith("camera") for part in robot.fit) for robot in team.robots)
    if has_camera and missing("vision"):
        yield needs("a robot with a camera", "vision")


def _links(team: TeamPlan) -> Iterator[str]:
    for link in dict.fromkeys([team.file.link, *(robot.link for robot in team.robots if robot.link is not None)]):
        try:
            configs.load(LinkProfile, "links", link)
        except ConfigError as err:
            yield f"{team.source}: {err}"


def _emulated(team: TeamPlan) -> Iterator[str]:
    """Yield what keeps emulated robots from their world. They are put into one that runs nowhere and has no ports."""
    if not team.emulated or missing("emu"):
        return
    from p2os_emu.emulator import Emulator
    from p2os_emu.team import check_name
    from p2os_emu.world import World, WorldError, load_world

    try:
        world = World(load_world(team.file.world))
    except WorldError as err:
        yield f"{team.source}: {err}"
        return
    with closing(world):
        emulator = Emulator(world, LinkProfile("ideal"))
        for robot in team.emulated:
            try:
                model, fit = _fitted(robot)
            except (ConfigError, FitError):
                continue  # `_check_robot` reports it
            pose = None if robot.at_m is None else Pose2D(*robot.at_m, radians(robot.heading_deg))
            cables = {part: MemoryLink() for part in fit.cables}
            try:
                check_name(robot.name)
                emulator.add(robot.name, model, MemoryLink(), pose=pose, fit=fit, cables=cables)
            except ValueError as err:
                yield f"{team.source}: {err}"


def _shared_ports(team: TeamPlan) -> Iterator[str]:
    """Yield what two parts are plugged into."""
    users: dict[str, list[str]] = defaultdict(list)
    for robot in team.robots:
        if not robot.is_emulated:
            for part, place in _places(robot):
                users[place].append(f"{robot.name}{part and f' ({part})'}")
    for place, whose in users.items():
        if len(whose) > 1:
            yield f"{team.source}: {' and '.join(whose)} are on one port, {place}; correct one of them"


def _bus(team: TeamPlan, profile: str) -> Iterator[str]:
    try:
        Profile.find(profile)
        folder_of_keys(profile, team.name, [robot.name for robot in team.robots])
    except (ConfigError, BusError) as err:
        yield str(err)


def _places(robot: TeamRobot) -> list[tuple[str, str]]:
    """Return the ports of a real robot, each with the part that is on it."""
    parts = (("", robot.port), ("laser", robot.laser), ("arm", robot.arm), ("camera", robot.camera))
    return [(part, place) for part, place in parts if place]


def _check_robot(robot: TeamRobot, found: TeamFindings) -> None:
    try:
        _fitted(robot)
    except (ConfigError, FitError) as err:
        found.problems.append(f"{robot.name}: {err}")
    if not robot.is_emulated:
        for part, place in _places(robot):
            _check_port(f"{robot.name}{part and f': its {part}'}", place, found)
    where = "emulated" if robot.is_emulated else f"on {robot.port}"
    fit = f", with {', '.join(robot.fit)}" if robot.fit else ""
    settings = ", own gateway settings" if robot.gateway is not None else ""
    found.robots.append(f"{robot.name}: {robot.model} {where}{fit}{settings}")


def _fitted(robot: TeamRobot) -> tuple[RobotModel, Fit]:
    return read_fit(robot.fit, configs.load(RobotModel, "robots", robot.model))


def _check_port(whose: str, place: str, found: TeamFindings) -> None:
    if "://" in place:
        return  # reaching for it would open a connection, and a bridge has only one
    path = Path(place)
    if not path.exists():
        found.notes.append(f"{whose}: there is no port {place} now; it would be waited for")
    elif not os.access(path, os.R_OK | os.W_OK):
        found.problems.append(f"{whose}: this user may not open {place}; see acromovi doctor {place}")
    elif users := holders(place):
        found.problems.append(f"{whose}: {place} is in use by {' and '.join(map(str, users))}; end it first")
