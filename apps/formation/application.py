"""The application: reads the team, steps the controller, drives the followers, and answers requests."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import configs
from agents import Robot, RobotError, Team, request
from apps.formation.controller import Formation, FormationOrders
from apps.formation.members import MemberState
from apps.formation.plots import draw_formation
from apps.formation.pose_filter import PoseFilter
from apps.formation.record import FormationRecord
from apps.formation.settings import FormationSettings
from apps.formation.shapes import ShapeError
from apps.formation.shared_poses import SharedPoses, read_starts
from apps.pictures import check_picture
from apps.waypoints import Follower
from configs.extras import ExtraMissing
from geometry import Point, Pose2D, Twist2D

SERVICES = ("formation",)  # for the directory, when it runs as an agent
SLOW_FROM, STAND_FROM = 0.3, 1.2  # m that a follower is off, from which a leader of `drive=` drives slower, and stands
SETTLE = 3.0  # s after the last waypoint, in which the followers take their places


@dataclass(slots=True)
class _Running:
    """What the requests are about."""

    formation: Formation | None = None
    orders: FormationOrders | None = None


_running = _Running()


def main(
    team: Team,
    leader: str = "",
    followers: str | list[str] = "",
    shape: str = "triangle",
    starts: str | dict[str, Any] = "acromovi",
    settings: str = "",
    drive: list[list[float]] | None = None,
    picture: str = "formation.svg",
) -> None:
    """Keep a formation until stopped.

    Args:
        team: The robots on the bus.
        leader: Its name.
        followers: Their names, separated by commas; all other robots if empty.
        shape: column, line, wedge, triangle, diamond, or a TOML file with offsets.
        starts: Where the robots stood when their gateways first connected: a team file, or poses by name, m and deg.
        settings: A file with changes of `settings.toml`.
        drive: Waypoints in m to which the application drives the leader; without, it never does.
        picture: File for the plots at the end; none if empty.
    Raises:
        RobotError: An argument is not valid, or a robot is missing.
    """
    tuned = _settings(settings)
    robots = _robots(team, leader, followers)
    names = [each.name for each in robots]
    waypoints = _waypoints(drive)
    check_picture(picture)
    try:
        formation = Formation(names[0], names[1:], shape, tuned)
    except ShapeError as err:
        raise RobotError(str(err)) from err
    _running.formation = formation
    record = FormationRecord(names[0])
    poses = SharedPoses(robots, read_starts(starts, names), tuned.period_s)
    try:
        _keep(team, formation, poses, record, Follower(waypoints) if waypoints else None)
        for each in robots[0 if waypoints else 1 :]:
            each.base.stop()
    finally:
        poses.close()
        _finish(record, picture)


@request("shape")
def change_shape(shape: str) -> dict[str, Any]:
    """Change the shape while driving; returns the status."""
    formation = _formation()
    try:
        formation.set_shape(shape)
    except ShapeError as err:
        raise RobotError(str(err)) from err
    return status()


@request("status")
def status() -> dict[str, Any]:
    """Return the shape, the followers' distances from their points in m, and who is lost and why."""
    formation, orders = _formation(), _running.orders
    return {**formation.status, "errors": {} if orders is None else dict(orders.errors)}


def _keep(
    team: Team, formation: Formation, poses: SharedPoses, record: FormationRecord, course: Follower | None
) -> None:
    """Drive the followers until the program is to end, or the leader's last waypoint has been passed."""
    settings = formation.settings
    corrected = PoseFilter(settings.poses)
    next_report, arrived = settings.report_s, math.inf
    _tell(record, 0.0, f"{formation.leader} leads {', '.join(formation.members.followers)}: {formation.shape}")
    for now in team.every(settings.period_s):
        states: Mapping[str, MemberState] = poses.read(now)
        if settings.poses.correct:
            states = corrected.update(states)
        orders = _running.orders = formation.step(now, states)
        if poses.has_leapt(formation.leader):
            raise RobotError(
                f"the odometry of {formation.leader} has jumped, as when its gateway starts again; give new starts"
            )
        for name, twist in orders.twists.items():
            formation.refused(name, poses.drive(name, twist))
        for told in orders.told:
            _tell(record, now, told)
        places = {
            name: states[name].pose if name in states else None
            for name in (formation.leader, *formation.members.followers)
        }
        points = {
            name: (at.x, at.y) if (at := orders.points.get(name)) else None for name in formation.members.followers
        }
        record.add(now, places, points)
        if now >= next_report:
            next_report += settings.report_s
            _tell(record, now, _progress(formation, orders))
        if course is not None and (pose := places[formation.leader]):
            arrived = min(arrived, now) if course.is_done else math.inf
            poses.drive(formation.leader, _led(course, pose, formation, orders))
            if now - arrived > SETTLE:
                return


def _led(course: Follower, pose: Pose2D, formation: Formation, orders: FormationOrders) -> Twist2D:
    """Return the twist of a leader that the application drives; it does not leave its followers behind."""
    if formation.waits_for:
        return Twist2D()
    worst = max((orders.errors[name] for name in formation.members.active if name in orders.errors), default=0.0)
    share = max(0.0, min(1.0, (STAND_FROM - worst) / (STAND_FROM - SLOW_FROM)))
    twist = course.steer(pose)
    cruise = formation.settings.tracking.speed_m_s / 2  # followers on the outer side of a curve drive faster
    return Twist2D(share * min(twist.linear, cruise), share * twist.angular)


def _progress(formation: Formation, orders: FormationOrders) -> str:
    offs = [f"{name} {100 * error:.0f} cm" for name, error in orders.errors.items() if name in formation.members.active]
    lost = [f"{name} {member.trouble}" for name, member in formation.members.followers.items() if member.trouble]
    return "; ".join([f"{formation.formed}: {', '.join(offs) or 'nobody'} from their points", *lost])


def _tell(record: FormationRecord, now: float, told: str) -> None:
    record.told.append(f"{now:.1f} s: {told}")
    print(record.told[-1], flush=True)


def _finish(record: FormationRecord, picture: str) -> None:
    """Print the summary, and draw the picture."""
    if not record.times:
        return
    print(f"after {record.times[-1]:.0f} s:", *record.summary(), sep="\n  ", flush=True)
    if picture:
        try:
            draw_formation(Path(picture), record, f"formation led by {record.leader}, poses by odometry")
            print(f"see {picture}", flush=True)
        except (OSError, ExtraMissing) as err:
            print(f"no picture: {err}", flush=True)


def _formation() -> Formation:
    if _running.formation is None:
        raise RobotError("the formation has not begun yet; ask again in a moment")
    return _running.formation


def _settings(file: str) -> FormationSettings:
    try:
        return FormationSettings.load(file)
    except configs.ConfigError as err:
        raise RobotError(str(err)) from err


def _robots(team: Team, leader: str, followers: str | list[str]) -> list[Robot]:
    """Return leader and followers.

    Raises:
        RobotError: A robot is missing or named twice, or there is no follower.
    """
    if not leader:
        raise RobotError("no leader is given; name one, as leader=happy")
    names = followers if isinstance(followers, list) else [name.strip() for name in followers.split(",")]
    names = [str(name) for name in names if name] or [
        each.name for each in team.robots(having="base") if each.name != leader
    ]
    if leader in names:
        raise RobotError(f"{leader} leads and cannot follow itself; leave it out of followers")
    if twice := [name for name in names if names.count(name) > 1]:
        raise RobotError(f"{twice[0]} is named twice in followers; name each robot once")
    if not names:
        raise RobotError(f"there is no robot to follow {leader}; a formation needs at least two robots")
    return [team.robot(name, having="base") for name in (leader, *names)]


def _waypoints(drive: Sequence[object] | None) -> list[Point]:
    found = []
    for row in drive or ():
        match row:
            case [int() | float() as x, int() | float() as y] if math.isfinite(x) and math.isfinite(y):
                found.append((float(x), float(y)))
            case _:
                raise RobotError(f"drive is a list of waypoints [x, y] in m, and {row!r} is none")
    return found
