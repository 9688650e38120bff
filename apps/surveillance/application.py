"""The application: it starts the patrol manager, prints what happens, and writes the report at the end."""

import base64
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import configs
from agents import RobotError, Team, request
from agents.platform import AgentName
from apps.formation.shared_poses import read_starts
from apps.surveillance.patrol_manager import NAME, PatrolManager
from apps.surveillance.record import NightRecord
from apps.surveillance.report import write_report
from apps.surveillance.settings import SurveillanceSettings
from geometry import MapError, Point
from maps.building_map import BuildingMap
from maps.map_files import read_building_map

SERVICES = ("surveillance",)  # for the directory, when it runs as an agent
_PERIOD = 1.0  # s between two looks at the status
_ATTENTION = 5.0  # s without such a look, after which nobody patrols: the program hangs or is suspended
_REPORT_PERIOD = 60.0  # s between two lines of progress
_GATHERING = 15.0  # s for a first robot to begin, before it is said why none does

_running: list[NightRecord] = []


def main(
    team: Team,
    map: str = "",  # noqa: A002  # the word of the command line
    rooms: str | list[str] | dict[str, Any] = "",
    robots: str | list[str] = "",
    starts: str | dict[str, Any] = "",
    settings: str = "",
    minutes: float = 0.0,
    report: str = "patrol-report",
) -> None:
    """Patrol until stopped.

    Args:
        team: The robots on the bus.
        map: A map file of the building, on this machine; its goals are the rooms.
        rooms: Names of goals, separated by commas; `{"Lab": [2.5, 6.1]}` for places in the map, m; or `world:NAME` for
            the places of an emulated world. All goals of the map if empty.
        robots: Their names, separated by commas; all robots that are localized if empty.
        starts: Where the robots stand, for those that are not localized yet: a team file with places in the frame of
            the map, or `{"happy": [x, y, heading]}` in m, m and degrees.
        settings: A file with changes of `settings.toml`.
        minutes: How long; until stopped if 0.
        report: Folder for the report at the end; none if empty.
    Raises:
        RobotError: An argument is not valid, or the manager cannot be started.
    """
    try:
        tuned = SurveillanceSettings.load(settings)
    except configs.ConfigError as err:
        raise RobotError(str(err)) from err
    if not minutes >= 0.0:
        raise RobotError(f"minutes must be 0 or more, not {minutes!r}")
    plan = _map(map)
    places = _rooms(rooms, plan, tuned)
    names = robots if isinstance(robots, list) else [name.strip() for name in robots.split(",")]
    names = [str(name) for name in names if name]
    properties = {
        "settings": tuned.to_table(),
        "rooms": {room: list(place) for room, place in places.items()},
        "robots": names,
        "starts": _starts(team, starts, names, map),
        "map": str(Path(map).resolve()) if map else "",
        "attention": _ATTENTION,
    }
    record = NightRecord()
    _running[:] = [record]
    manager = PatrolManager(AgentName(NAME, team.platform), properties)
    try:
        with team.host(manager):
            _watch(team, str(manager.name), record, 60.0 * minutes)
    finally:
        _finish(record, report, plan)


@request("status")
def status() -> dict[str, Any]:
    """Return robots, rooms with their neglect, and alarms, as the patrol manager publishes them."""
    if not _running or not _running[0].status:
        raise RobotError("the patrol has not begun yet; ask again in a moment")
    return dict(_running[0].status)


@request("report")
def write_now(folder: str = "patrol-report") -> dict[str, Any]:
    """Write the report so far into a folder on the machine of the application, and return the name of its page."""
    if not _running or not _running[0].times:
        raise RobotError("the patrol has not begun yet; ask again in a moment")
    try:
        return {"report": str(write_report(Path(folder), _running[0]))}
    except OSError as err:
        raise RobotError(f"the report cannot be written to {folder}: {err.strerror}") from err


def _watch(team: Team, manager: str, record: NightRecord, lasts: float) -> None:
    """Print what happens until the program is to end."""
    told, next_report, has_begun = 0, _REPORT_PERIOD, False
    for now in team.every(_PERIOD):
        record.add(now, team.ask(manager, "status"))
        for event in team.ask(manager, "events", number=told):
            told = event["number"] + 1
            picture = event.get("picture")
            if picture:
                record.pictures.setdefault(int(event["alarm"]), []).append(base64.b64decode(picture["data"]))
            ago = max(0.0, time.time() - float(event["time"]))
            record.told.append(f"{max(0.0, now - ago):.0f} s: {event['text']}")
            print(record.told[-1], flush=True)
        serving = [robot for robot, each in record.status["robots"].items() if each["serves"]]
        if not has_begun and not serving and now >= _GATHERING:
            has_begun = True
            print("no robot patrols:", *_troubles(record.status), sep="\n  ", flush=True)
        has_begun = has_begun or bool(serving)
        if now >= next_report:
            next_report = now + _REPORT_PERIOD
            print(f"{now:.0f} s: {_progress(record)}", flush=True)
        if lasts and now >= lasts:
            return


def _troubles(told: Mapping[str, Any]) -> list[str]:
    return [f"{robot}: {each['does']}" for robot, each in told["robots"].items()] or ["there is no robot on the bus"]


def _progress(record: NightRecord) -> str:
    told = record.status
    robots = [f"{robot} {each['does']}" for robot, each in told["robots"].items()]
    return "; ".join([f"longest neglect {told['longest']:.0f} s, {len(record.alarms)} alarms", *robots])


def _finish(record: NightRecord, report: str, plan: BuildingMap | None) -> None:
    """Print the summary, and write the report."""
    if not record.times:
        return
    print(f"after {record.times[-1]:.0f} s:", *record.summary(), sep="\n  ", flush=True)
    if report:
        try:
            print(f"see {write_report(Path(report), record, plan)}", flush=True)
        except OSError as err:
            print(f"no report: {err}", flush=True)


def _map(file: str) -> BuildingMap | None:
    """Return the map of a file; None without one.

    Raises:
        RobotError: It cannot be read.
    """
    if not file:
        return None
    try:
        return read_building_map(file)
    except (MapError, ValueError) as err:
        raise RobotError(str(err)) from err


def _rooms(given: object, plan: BuildingMap | None, settings: SurveillanceSettings) -> dict[str, Point]:
    """Return rooms with their places; none where those of the robots' map are meant.

    Raises:
        RobotError: There is no such room.
    """
    if isinstance(given, dict):
        return {str(name): _place(str(name), row) for name, row in given.items()}
    if isinstance(given, str) and given.startswith("world:"):
        return _places_of_world(given.removeprefix("world:"))
    names = given if isinstance(given, list) else [name.strip() for name in str(given).split(",")]
    names = [str(name) for name in names if name] or list(settings.rooms)
    if plan is None:
        if names:
            raise RobotError("rooms by name need map=FILE, whose goals they are; or give places, as rooms={...}")
        return {}
    try:
        goals = [plan.goal(name) for name in names] or [each for each in plan.goals if each.kind.startswith("Goal")]
    except KeyError as err:
        raise RobotError(str(err.args[0])) from err
    if not goals:
        raise RobotError('the map has no goals, so there is nothing to patrol; give rooms={"Lab": [2.5, 6.1]}')
    return {each.name: (each.pose.x, each.pose.y) for each in goals}


def _places_of_world(name: str) -> dict[str, Point]:
    """Return the named places of an emulated world, in its frame.

    Raises:
        RobotError: There is no such world, or it has no places.
    """
    try:
        table = configs.read(configs.find("worlds", name))
    except configs.ConfigError as err:
        raise RobotError(str(err)) from err
    rooms = {str(room): _place(str(room), row) for room, row in table.get("places_m", {}).items()}
    if not rooms:
        raise RobotError(f"the world {name} has no places; give rooms by their places")
    return rooms


def _place(name: str, row: object) -> Point:
    match row:
        case [int() | float() as x, int() | float() as y]:
            return float(x), float(y)
    raise RobotError(f"the place of {name} is {str(row)[:40]}; expected [x, y] in m")


def _starts(team: Team, given: str | dict[str, Any], names: list[str], file: str) -> dict[str, list[float]]:
    """Return where robots stand in the map.

    Raises:
        RobotError: It is not valid, or there is no map for it.
    """
    if not given:
        return {}
    if not file:
        raise RobotError("starts= needs map=FILE, on which the robots begin their localization")
    poses = read_starts(given, names or [each.name for each in team.robots(having="base")])
    return {robot: [pose.x, pose.y, pose.heading] for robot, pose in poses.items()}
