"""The application: reads the team, steps the controller, drives the followers, and answers requests."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import configs
from agents import Robot, RobotError, Team, request
from apps.background import stop_first
from apps.film import check_film
from apps.formation.controller import Formation, FormationOrders
from apps.formation.members import MemberState, PoseSource
from apps.formation.plots import draw_formation, write_film
from apps.formation.pose_filter import PoseFilter
from apps.formation.record import FormationRecord
from apps.formation.settings import FormationSettings
from apps.formation.shapes import ShapeError
from apps.formation.shared_poses import SharedPoses, read_starts
from apps.pictures import check_picture
from apps.waypoints import Follower
from configs.extras import ExtraMissing, require
from geometry import Point, Pose2D, Twist2D

SERVICES = ("formation",)  # for the directory, when it runs as an agent
SLOW_FROM, STAND_FROM = 0.3, 1.2  # m that a follower is off, from which a leader of `drive=` drives slower, and stands
SETTLE = 3.0  # s after the last waypoint, in which the followers take their places


class _Robots(PoseSource, Protocol):
    """Where poses come from, and who drives."""

    def drive(self, name: str, twist: Twist2D) -> str:
        """Drive a robot; returns why it cannot be driven, in words, or nothing."""
        ...

    def has_leapt(self, name: str) -> bool:
        """Return whether the odometry of a robot has jumped, so that nobody knows any more where it is."""
        ...

    def close(self) -> None:
        """Begin no more requests."""
        ...


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
    poses: str = "odometry",
    colours: str = "",
    film: str = "",
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
        poses: `odometry`: that of all robots, from their starts; `sight`: the followers' cameras see the target on the
            leader, which need not be on the bus.
        colours: Of the target: a file of the agent `colours`, or `trained` for what that of each follower has been
            trained to. Without it, those of the targets that emulated robots carry.
        film: File for a film of the drive from above, .gif or .mp4; none if empty.
    Raises:
        RobotError: An argument is not valid, or a robot is missing.
    """
    by_sight = _is_by_sight(poses, drive)
    tuned = _settings(settings)
    tuned = tuned.by_sight if by_sight else tuned
    robots = _robots(team, leader, followers, by_sight)
    names = [leader, *(each.name for each in robots if each.name != leader)]
    waypoints = _waypoints(drive)
    check_picture(picture)
    check_film(film)
    try:
        formation = Formation(names[0], names[1:], shape, tuned, by_sight=by_sight)
    except ShapeError as err:
        raise RobotError(str(err)) from err
    _running.formation = formation
    record = FormationRecord(names[0])
    if by_sight:
        from apps.formation.sighted_robots import SightedRobots  # it loads OpenCV
        from apps.robot_following.robot import target_colours

        eyes = [(each, target_colours(team, each, colours)) for each in robots]
        source: _Robots = SightedRobots(leader, eyes, tuned)
    else:
        source = SharedPoses(robots, read_starts(starts, names), tuned.period_s)
    try:
        _keep(team, robots, formation, source, record, Follower(waypoints) if waypoints else None)
        for each in robots:
            if waypoints or each.name != leader:
                each.base.stop()
    finally:
        source.close()
        stop_first(each for each in robots if waypoints or each.name != leader)
        _finish(record, picture, "sight" if by_sight else "odometry", film)


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
    team: Team,
    robots: Sequence[Robot],
    formation: Formation,
    poses: _Robots,
    record: FormationRecord,
    course: Follower | None,
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
        for robot in robots:
            _show(robot, formation, orders, places.get(robot.name))
        if now >= next_report:
            next_report += settings.report_s
            _tell(record, now, _progress(formation, orders))
        if course is not None and (pose := places[formation.leader]):
            arrived = min(arrived, now) if course.is_done else math.inf
            poses.drive(formation.leader, _led(course, pose, formation, orders))
            if now - arrived > SETTLE:
                return


def _show(robot: Robot, formation: Formation, orders: FormationOrders, pose: Pose2D | None) -> None:
    """Show on maps where a follower has its point, and how far that is."""
    at = orders.points.get(robot.name)
    if robot.name == formation.leader:
        robot.show("formation", f"leads a {formation.shape}")
    elif at is not None and pose is not None:
        point = at.relative_to(pose)
        words = f"{formation.shape}: {orders.errors.get(robot.name, 0.0):.2f} m off"
        robot.show("formation", words, points=[(point.x, point.y)], lines=[((0.0, 0.0), (point.x, point.y))])


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


def _finish(record: FormationRecord, picture: str, measured: str, film: str) -> None:
    """Print the summary, and write picture and film."""
    if not record.times:
        return
    print(f"after {record.times[-1]:.0f} s:", *record.summary(), sep="\n  ", flush=True)
    if picture:
        try:
            draw_formation(Path(picture), record, f"formation led by {record.leader}, poses by {measured}")
            print(f"see {picture}", flush=True)
        except (OSError, ExtraMissing) as err:
            print(f"no picture: {err}", flush=True)
    if film:
        try:
            print(f"see {film}, {write_film(Path(film), record)} frames", flush=True)
        except OSError as err:
            print(f"no film: {err}", flush=True)


def _formation() -> Formation:
    if _running.formation is None:
        raise RobotError("the formation has not begun yet; ask again in a moment")
    return _running.formation


def _settings(file: str) -> FormationSettings:
    try:
        return FormationSettings.load(file)
    except configs.ConfigError as err:
        raise RobotError(str(err)) from err


def _is_by_sight(poses: str, drive: object) -> bool:
    if poses not in ("odometry", "sight"):
        raise RobotError(f"poses must be odometry or sight, not {poses!r}")
    if poses == "odometry":
        return False
    if drive:
        raise RobotError("by sight, nobody knows where the waypoints of drive= are; drive the leader by other means")
    try:
        require("a formation by sight", "vision")
    except ExtraMissing as err:
        raise RobotError(str(err)) from err
    return True


def _robots(team: Team, leader: str, followers: str | list[str], by_sight: bool) -> list[Robot]:
    """Return leader and followers; by sight the followers only.

    Raises:
        RobotError: A robot is missing or named twice, or there is no follower.
    """
    if not leader:
        raise RobotError("no leader is given; name one, as leader=happy")
    having = ("base", "camera") if by_sight else ("base",)
    names = followers if isinstance(followers, list) else [name.strip() for name in followers.split(",")]
    names = [str(name) for name in names if name] or [
        each.name for each in team.robots(having=having) if each.name != leader
    ]
    if leader in names:
        raise RobotError(f"{leader} leads and cannot follow itself; leave it out of followers")
    if twice := [name for name in names if names.count(name) > 1]:
        raise RobotError(f"{twice[0]} is named twice in followers; name each robot once")
    if not names:
        raise RobotError(f"there is no robot to follow {leader}; a formation needs at least two robots")
    return [team.robot(name, having=having) for name in (names if by_sight else (leader, *names))]


def _waypoints(drive: Sequence[object] | None) -> list[Point]:
    found = []
    for row in drive or ():
        match row:
            case [int() | float() as x, int() | float() as y] if math.isfinite(x) and math.isfinite(y):
                found.append((float(x), float(y)))
            case _:
                raise RobotError(f"drive is a list of waypoints [x, y] in m, and {row!r} is none")
    return found
