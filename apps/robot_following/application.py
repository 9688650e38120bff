"""The application: each follower drives behind the target that it sees, and answers requests."""

from collections.abc import Sequence
from concurrent.futures import wait
from pathlib import Path
from typing import TYPE_CHECKING, Any

import configs
from agents import Robot, RobotError, Team, request
from apps.background import BackgroundRequests, stop_first
from apps.film import check_film
from apps.pictures import check_picture
from apps.robot_following.plots import draw_following
from apps.robot_following.record import FollowingRecord
from apps.robot_following.settings import FollowingSettings
from configs.extras import ExtraMissing, require
from geometry import Pose2D

if TYPE_CHECKING:
    from apps.robot_following.film import FollowingFilm
    from apps.robot_following.robot import FollowingRobot

SERVICES = ("following",)  # for the directory, when it runs as an agent
MOST_REQUESTS = 6  # of a robot at the same time
HAVING = ("base", "camera")

_running: "list[FollowingRobot]" = []


def main(
    team: Team,
    robot: str = "",
    robots: str | list[str] = "",
    settings: str = "",
    colours: str = "",
    picture: str = "following.svg",
    film: str = "",
) -> None:
    """Follow until stopped, or until every follower has looked for its leader in vain.

    Args:
        team: The robots on the bus.
        robot: The follower.
        robots: Several followers in place of `robot`, separated by commas; each follows the target that it sees.
        settings: A file with changes of `settings.toml`.
        colours: Of the target: a file of the agent `colours`, or `trained` for what that of each follower has been
            trained to. Without it, those of the targets that emulated robots carry.
        picture: File for the plots at the end; none if empty.
        film: File for a film of the first follower, .gif or .mp4: both robots from above, and what it sees.
    Raises:
        RobotError: An argument is not valid, or a robot is missing.
    """
    tuned = _settings(settings)
    check_picture(picture)
    check_film(film)
    found = _robots(team, robot, robots)
    try:
        require("robot following", "vision")
    except ExtraMissing as err:
        raise RobotError(str(err)) from err
    from apps.robot_following.robot import FollowingRobot, target_colours  # it loads OpenCV, which may be missing

    shots = _film(film)
    requests = BackgroundRequests(MOST_REQUESTS * len(found), "following")
    records = [FollowingRecord(each.name) for each in found]
    try:
        _running[:] = [FollowingRobot(each, requests, tuned, target_colours(team, each, colours)) for each in found]
        _follow(team, _running, records, tuned, shots)
        for each in found:
            each.base.stop()
    finally:
        requests.close()
        stop_first(found)
        _finish(records, tuned, picture, shots)


@request("status")
def status() -> dict[str, Any]:
    """Return for each follower what it does and why, what its camera sees, and the gap in m, None without a leader."""
    if not _running:
        raise RobotError("following has not begun yet; ask again in a moment")
    return {
        each.name: {
            "does": each.does,
            "sees": each.sees,
            "gap": None if each.gap is None else round(each.gap, 3),
        }
        for each in _running
    }


def _follow(
    team: Team,
    followers: "Sequence[FollowingRobot]",
    records: Sequence[FollowingRecord],
    settings: FollowingSettings,
    shots: "FollowingFilm | None",
) -> None:
    """Step all followers until the program is to end, or all of them have given up."""
    next_report = 0.0
    last = [""] * len(followers)
    for now in team.every(settings.period):
        wait([asked for each in followers for asked in each.begin()], settings.period / 2.0)
        for number, (each, record) in enumerate(zip(followers, records, strict=True)):
            step = each.step()
            leader = step.leader.pose if step is not None and step.leader is not None else None
            record.add(now, each.pose, leader, each.gap)
            _show(each, leader)
            if each.does != last[number]:
                _tell(record, now, each.does)
                last[number] = each.does
            elif now >= next_report:
                _tell(record, now, _progress(each))
        if shots is not None:
            shots.add(records[0], followers[0].cycle.shown)
        if now >= next_report:
            next_report = now + settings.report
        if all(each.has_given_up for each in followers):
            return


def _show(follower: "FollowingRobot", leader: Pose2D | None) -> None:
    """Show on maps where a follower sees its leader."""
    words = follower.does if follower.gap is None else f"{follower.does}, gap {follower.gap:.2f} m"
    if leader is None or follower.pose is None:
        follower.robot.show("following", words)
        return
    seen, own = (leader.x, leader.y), (follower.pose.x, follower.pose.y)
    follower.robot.show("following", words, points=[seen], lines=[(own, seen)], frame="odom")


def _progress(follower: "FollowingRobot") -> str:
    gap = "" if follower.gap is None else f"; gap {follower.gap:.2f} m"
    return f"{follower.does}{gap}; camera: {follower.sees}"


def _tell(record: FollowingRecord, now: float, told: str) -> None:
    record.told.append(f"{now:.1f} s: {record.follower} {told}")
    print(record.told[-1], flush=True)


def _finish(
    records: Sequence[FollowingRecord], settings: FollowingSettings, picture: str, shots: "FollowingFilm | None"
) -> None:
    """Print the summary, and write picture and film."""
    known = [record for record in records if record.times]
    if not known:
        return
    print(f"after {known[0].times[-1]:.0f} s:", *(record.summary() for record in known), sep="\n  ", flush=True)
    if picture:
        try:
            draw_following(Path(picture), known, "robot following, by the followers' odometry", settings.drive.gap)
            print(f"see {picture}", flush=True)
        except (OSError, ExtraMissing) as err:
            print(f"no picture: {err}", flush=True)
    if shots is not None:
        try:
            if count := shots.close(records[0]):
                print(f"see {shots.file}, {count} frames", flush=True)
        except OSError as err:
            print(f"no film: {err}", flush=True)


def _film(file: str) -> "FollowingFilm | None":
    if not file:
        return None
    from apps.robot_following.film import FollowingFilm  # it loads OpenCV

    return FollowingFilm(Path(file))


def _settings(file: str) -> FollowingSettings:
    try:
        return FollowingSettings.load(file or None)
    except configs.ConfigError as err:
        raise RobotError(str(err)) from err


def _robots(team: Team, robot: str, robots: str | list[str]) -> list[Robot]:
    """Return the followers.

    Raises:
        RobotError: One is missing or named twice, or it is not clear which is meant.
    """
    given = robots if isinstance(robots, list) else robots.split(",")
    names = [str(name).strip() for name in (robot, *given) if str(name).strip()]
    if twice := [name for name in names if names.count(name) > 1]:
        raise RobotError(f"{twice[0]} is named twice; name each follower once")
    if names:
        return [team.robot(name, having=HAVING) for name in names]
    found = team.robots(having=HAVING)
    if len(found) != 1:
        there = ", ".join(each.name for each in found) or "no robot"
        raise RobotError(f"{there} could follow; name the follower, as robot=happy")
    return found
