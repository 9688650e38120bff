"""The application: one robot fetches an object, and answers requests."""

import math
from concurrent.futures import wait
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import configs
from agents import NotThere, Robot, RobotError, Stopped, Team, request
from apps.background import BackgroundRequests, stop_first
from apps.fetch.hands import ArmHand, Hand, PaddleHand
from apps.fetch.plots import draw_fetching
from apps.fetch.record import FetchRecord
from apps.fetch.settings import FetchSettings
from apps.fetch.states import FetchState
from apps.hull import check_hull
from apps.pictures import check_picture
from configs.extras import ExtraMissing, require
from geometry import Point

if TYPE_CHECKING:
    from apps.fetch.robot import FetchRobot
    from vision.colours import ColourTable

SERVICES = ("fetching",)  # for the directory, when it runs as an agent
HAVING = ("base", "camera", "sonar")  # besides a gripper or an arm
_SAME_HULL = 0.03  # m by which the hull may end elsewhere than in the settings
_MOST_REQUESTS = 10  # at the same time

_running: "list[FetchRobot]" = []


def main(
    team: Team,
    robot: str = "",
    colour: str = "red",
    place: str | list[float] = "",
    settings: str = "",
    colours: str = "",
    picture: str = "fetch.svg",
) -> None:
    """Fetch one object.

    Args:
        team: The robots on the bus.
        robot: Its name; any robot with camera, sonar, and gripper or arm if empty.
        colour: Of the object: a name in the settings, or of a trained channel.
        place: Where it is to stand, m and m in the robot's frame `odom`, as `[1,0.5]`; where the robot is if empty.
        settings: A file with changes of `settings.toml`, and for a robot with an arm of `arm.toml`.
        colours: A file of the agent `colours`, or `trained` for what that of the robot has been trained to. Without it,
            the colours of the settings.
        picture: File for the plot at the end; none if empty.
    Raises:
        RobotError: An argument is not valid, the robot or an element is missing, or the object could not be fetched.
    """
    check_picture(picture)
    goal = _place(place)
    me = _robot(team, robot)
    try:
        tuned = FetchSettings.load(settings) if me.has("gripper") else FetchSettings.load_for_arm(settings)
        require("fetching", "vision")
    except configs.ConfigError as err:
        raise RobotError(str(err)) from err
    table = _table(team, me, tuned, colour, colours)
    hand = _hand(me, tuned)
    from apps.fetch.robot import FetchRobot  # it loads OpenCV, which may be missing

    requests = BackgroundRequests(_MOST_REQUESTS, "fetch")
    start = me.base.pose()
    record = FetchRecord(me.name, colour, goal or (start.x, start.y))
    try:
        _running[:] = [FetchRobot(me, requests, tuned, colour, record.place, hand, table)]
        _fetch(team, _running[0], record, tuned)
        me.base.stop()
    finally:
        stop_first([me])
        with suppress(RobotError, Stopped):  # it stands or holds what it has, and the program is ending
            (me.gripper if hand.element == "gripper" else me.arm).stop()
        requests.close()
        _finish(record, picture)
    fetcher = _running[0].cycle.fetcher
    if fetcher.state is FetchState.GIVEN_UP:
        raise RobotError(fetcher.reason)


@request("status")
def status() -> dict[str, Any]:
    """Return what the robot does and why, what its camera sees, and the attempts to grip so far."""
    if not _running:
        raise RobotError("fetching has not begun yet; ask again in a moment")
    fetcher = _running[0].cycle.fetcher
    return {
        "robot": _running[0].robot.name,
        "does": fetcher.state.value,
        "reason": _running[0].trouble or fetcher.reason,
        "colour": fetcher.colour,
        "place": list(fetcher.place),
        "sees": _running[0].cycle.seen,
        "attempts": fetcher.attempts,
    }


def _fetch(team: Team, robot: "FetchRobot", record: FetchRecord, settings: FetchSettings) -> None:
    """Step the robot until it has ended or the program is to end."""
    fetcher = robot.cycle.fetcher
    next_report, trouble = settings.report_s, ""
    place = f"({record.place[0]:.2f}, {record.place[1]:.2f})"
    _tell(record, 0.0, f"{record.robot} fetches a {record.colour} object to {place}")
    for now in team.every(settings.period_s):
        wait(robot.begin(), settings.period_s / 2.0)
        orders = robot.step()
        if robot.trouble != trouble:
            trouble = robot.trouble
            _tell(record, now, f"stands: {trouble}" if trouble else "goes on")
        if orders is None or robot.pose is None:
            continue
        record.add(now, robot.pose, orders.state)
        if orders.state is FetchState.LIFT and record.gripped_at is None:
            record.gripped_at = robot.pose.transform(settings.robot.grip_m, 0.0)
        if orders.changed:
            _tell(record, now, f"{orders.state.value}: {orders.reason}")
            next_report = now + settings.report_s
        elif now >= next_report:
            _tell(record, now, f"{orders.state.value}; {record.way:.1f} m driven; camera: {robot.cycle.seen}")
            next_report = now + settings.report_s
        if fetcher.has_ended:
            return


def _robot(team: Team, name: str) -> Robot:
    """Return a robot with a gripper, or else with an arm.

    Raises:
        NotThere: It is not present, or has neither.
    """
    try:
        return team.robot(name, having=(*HAVING, "gripper"))
    except NotThere:
        if not any("arm" in each.elements for each in team.robots() if name in ("", each.name)):
            raise
    return team.robot(name, having=(*HAVING, "arm"))


def _hand(robot: Robot, settings: FetchSettings) -> Hand:
    """Return the hand of a robot.

    Raises:
        RobotError: It holds something, its arm has no fingers, or the settings are those of another robot.
    """
    if robot.has("gripper"):
        hull = settings.robot
        check_hull(robot, length_front=hull.front_m, width=2.0 * hull.half_width_m)
        if robot.gripper.read().holds:
            raise RobotError(f"the gripper of {robot.name} holds something already; open it first")
        return PaddleHand()
    properties = robot.arm.properties
    front, own = settings.robot.front_m, float((properties.get("hull") or {}).get("length_front", math.nan))
    if not abs(front - own) <= _SAME_HULL:
        raise RobotError(
            f"the settings for an arm are of a hull that ends {front:.2f} m before the axle, and that of {robot.name} "
            f"ends {own:.2f} m before it; give settings of its own"
        )
    hand = ArmHand.of(settings, properties)
    if hand is None:
        raise RobotError(f"the arm of {robot.name} has no fingers that it knows of; use a robot with a gripper")
    reading = robot.arm.read()
    hand.take({"joints": reading.joints})
    if reading.homed and hand.state is not None and hand.state.fingers == "between":
        raise RobotError(
            f"the fingers of {robot.name} may hold something; open them first, by acromovi ask arm@{robot.name} move "
            f"'joints={{\"{hand.finger_joint}\": {hand.opening:.2g}}}'"
        )
    return hand


def _tell(record: FetchRecord, now: float, told: str) -> None:
    record.told.append(f"{now:.1f} s: {told}")
    print(record.told[-1], flush=True)


def _finish(record: FetchRecord, picture: str) -> None:
    """Print the summary, and draw the picture."""
    if not record.times:
        return
    print(f"after {record.times[-1]:.0f} s:", *record.summary(), sep="\n  ", flush=True)
    if picture:
        try:
            draw_fetching(Path(picture), record, f"{record.robot} fetches a {record.colour} object, by its odometry")
            print(f"see {picture}", flush=True)
        except (OSError, ExtraMissing) as err:
            print(f"no picture: {err}", flush=True)


def _place(given: str | list[float]) -> Point | None:
    """Return a place, None for none.

    Raises:
        RobotError: It is not made of two numbers.
    """
    if given in ("", []):
        return None
    parts = given.strip("[] ").split(",") if isinstance(given, str) else given
    try:
        x, y = map(float, parts)
    except (TypeError, ValueError):
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise RobotError(f"a place is x and y in m, such as place=[1,0.5], not {str(given)[:40]!r}")
    return x, y


def _table(team: Team, robot: Robot, settings: FetchSettings, colour: str, given: str) -> "ColourTable | None":
    """Return trained channels; None for the colours of the settings.

    Raises:
        RobotError: The file cannot be read, or the colour is none of those.
    """
    table, names = None, sorted(settings.shades)
    if given:
        from vision.colours import ColourTable  # it loads OpenCV
        from vision.image import VisionError

        try:
            if given == "trained":
                data = str(team.ask(f"colours@{robot.name}", "save")["colours"]).encode()
            else:
                data = Path(given).read_bytes()
            table = ColourTable.load(data)
        except OSError as err:
            raise RobotError(f"the colours cannot be read from {given}: {err.strerror}") from err
        except VisionError as err:
            raise RobotError(f"the colours of {given}: {err}") from err
        names = [channel.name for _, channel in sorted(table.channels.items()) if channel.name]
    if colour not in names:
        known = ", ".join(names) or "none; train a channel and give it a name"
        raise RobotError(f"there is no colour {str(colour)[:40]!r}; known colours: {known}")
    return table
