"""One follower on a team: its readings, its cycle, and the commands to it."""

import base64
import math
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from agents import Robot, RobotError, Team
from apps.background import BackgroundRequests
from apps.echoes import echo_points
from apps.remote_vision.aiming import view_of
from apps.robot_following.cycle import FollowingCycle
from apps.robot_following.follower import FollowerState, FollowingStep
from apps.robot_following.settings import FollowingSettings, RoomSettings
from geometry import Point, Pose2D, Twist2D
from vision.colours import ColourTable
from vision.image import VisionError

ANSWER_TIME = 1.0  # s for a reading or a command; the others do not wait for it
SLOW = 0.1  # s between two readings of what changes slowly
RANGES_FOR = 1.0  # s for which the echoes of range sensors hold; without newer ones the follower stands


@dataclass(frozen=True, slots=True)
class _Reading:
    """What is asked of an element again and again, s from one time to the next, and what takes the answer."""

    element: str
    request: str
    take: Callable[[Any], None]
    period: float


class FollowingRobot:
    """Reads one follower, steps its cycle, and drives it.

    Times are of this machine's steady clock; the cycle has those of the stamps, which the gateway makes.

    trouble: which of its readings is missing, in words, so that it stands; empty otherwise. refusal: why it is not
    allowed to drive. pose: in odom, None without readings. twist: m/s and rad/s. echoes: of its sonar by the number of
    the disc: its x, y and heading in base_link, and the range, m and rad. gap: m to the leader, None without one.
    """

    def __init__(
        self,
        robot: Robot,
        requests: BackgroundRequests,
        settings: FollowingSettings,
        colours: ColourTable | None = None,
        rangers: Sequence[str] = ("laser", "sonar"),
    ) -> None:
        """Prepare a robot that is there.

        Args:
            robot: The follower.
            requests: In which its requests are made.
            settings: Of the application.
            colours: Of the target; None for those that are shipped.
            rangers: Elements of which the first that it has tells obstacles.
        Raises:
            RobotError: It has no base or camera, or the camera's field of view is not known.
        """
        self.robot, self.trouble = robot, "no reading has come"
        self._requests, self._settings = requests, settings
        robot.element("base")
        self._has_head = robot.has("ptz")
        reach, lens = _pan_reach(robot) if self._has_head else 0.0, _lens(robot, settings)
        self.cycle = FollowingCycle(settings, lens, reach, colours)
        self._ranger = next((each for each in rangers if robot.has(each)), "")
        self._kinds = {
            element: _Reading(element, request, take, period)
            for element, request, take, period in (
                ("base", "read", self._take_base, 0.0),
                ("camera", "picture", self._take_picture, 0.0),
                ("ptz", "read", self._take_head, SLOW),
                ("laser", "read", self._take_laser, SLOW),
                ("sonar", "read", self._take_sonar, SLOW),
            )
            if element in ("base", "camera", self._ranger) or (element == "ptz" and self._has_head)
        }
        self._discs = robot.sonar.discs if self._ranger == "sonar" else {}
        place = robot.element("laser").properties.get("geometry", {}) if self._ranger == "laser" else {}
        self._mount = Pose2D(place.get("x", 0.0), place.get("y", 0.0), place.get("heading", 0.0))
        self._due: dict[str, float] = {}
        self._ranges: list[Point] = []
        self._ranges_at = self._base_at = -math.inf
        self._ranges_stamp = math.nan
        self._stamp = math.nan  # of the newest reading of the base, on the gateway's clock
        self.camera_trouble = self.refusal = ""
        self.pose: Pose2D | None = None
        self.twist = Twist2D()
        self.echoes: dict[int, tuple[float, float, float, float]] = {}
        self.gap: float | None = None

    @property
    def name(self) -> str:
        """Of the robot."""
        return self.robot.name

    def begin(self) -> "list[Future[Any]]":
        """Ask for everything that is due; returns the requests."""
        now, begun = time.monotonic(), []
        for kind, each in self._kinds.items():
            if now >= self._due.get(kind, 0.0):
                self._due[kind] = now + each.period
                begun.append(self._requests.begin((self.name, kind), self._ask, each))
        return begun

    @property
    def does(self) -> str:
        """What it does and why, in words."""
        if self.refusal:
            return f"stands: {self.refusal}"
        if self.trouble:
            return f"stands: {self.trouble}"
        return self.cycle.follower.state.value

    @property
    def sees(self) -> str:
        """What the camera saw last, or why there is no picture, in words."""
        return self.camera_trouble or self.cycle.words

    @property
    def has_given_up(self) -> bool:
        """Whether it has looked for the leader in vain for too long."""
        return self.cycle.follower.state is FollowerState.GIVEN_UP

    def step(self) -> FollowingStep | None:
        """Take what has been answered, and drive; returns what it does, None without readings."""
        step = self.look()
        self.drive(step.twist if step is not None and not self.trouble else Twist2D())
        return step

    def look(self, gaze: float | None = None) -> FollowingStep | None:
        """Take what has been answered, and turn the head, but do not drive; returns what `step` would do.

        Args:
            gaze: Bearing to look at, rad; None for where it sees or seeks the leader.
        """
        for kind in self._kinds:
            self._take(kind)
        at = time.monotonic()
        silence = at - self._base_at
        now = self._stamp + silence
        self.trouble = ""
        if silence > self._settings.silent:
            self.trouble = "the base is silent"
        elif self._ranger and at - self._ranges_at > RANGES_FOR:
            self.trouble = f"the {self._ranger} is silent"
        step = self.cycle.step(now, self._ranges) if silence <= self._settings.silent else None
        self.pose = self.cycle.pose(now) if step is not None else None
        self.gap = step.gap if step is not None else None
        pan = self.cycle.head_command(now, gaze) if step is not None else None
        if pan is not None:
            self._requests.take((self.name, "look"))
            self._requests.begin((self.name, "look"), self._look, pan)
        return step

    def drive(self, twist: Twist2D) -> str:
        """Drive, unless the command before has not been answered; returns why it is refused, in words, or nothing."""
        before = self._requests.take((self.name, "drive"))
        if before is not None:
            error = before.exception()
            self.refusal = str(error) if isinstance(error, RobotError) else ""
        self._requests.begin((self.name, "drive"), self.robot.base.drive, twist.linear, twist.angular)
        return self.refusal

    def _take(self, kind: str) -> None:
        """Take a reading that has been answered."""
        request = self._requests.take((self.name, kind))
        if request is None:
            return
        error = request.exception()
        if kind == "camera":
            self.camera_trouble = str(error) if error is not None else ""
        if error is None:
            self._kinds[kind].take(request.result())
        elif not isinstance(error, RobotError):
            raise error

    def _take_base(self, told: Any) -> None:
        if told["stamp"] != self._stamp:  # the same reading again is no sign of life
            self._stamp, self._base_at = float(told["stamp"]), time.monotonic()
            pose = Pose2D(float(told["x"]), float(told["y"]), float(told["heading"]))
            moving = self.twist = Twist2D(float(told["linear"] or 0.0), float(told["angular"] or 0.0))
            self.cycle.take_odometry(self._stamp, pose, moving)

    def _take_head(self, told: Any) -> None:
        if told["pan"] is not None:
            tilt = float(told["tilt"] or 0.0)
            self.cycle.take_head(float(told["stamp"]), float(told["pan"]), tilt, bool(told["moving"]))

    def _take_picture(self, told: Any) -> None:
        self.cycle.take_picture(float(told["stamp"]), base64.b64decode(told["data"]))

    def _take_laser(self, told: Any) -> None:
        first, increment = float(told["angle_min"]), float(told["angle_increment"])
        ranges = [math.inf if each is None else each for each in told["ranges"]]
        self._ranges = laser_points(ranges, first, increment, self._mount, self._settings.room)
        self._take_stamp(told)

    def _take_sonar(self, told: Any) -> None:
        self.echoes = self._heard(told["ranges"])
        self._ranges = sonar_points(list(self.echoes.values()), self._settings.room)
        self._take_stamp(told)

    def _take_stamp(self, told: Any) -> None:
        if told["stamp"] != self._ranges_stamp:
            self._ranges_stamp, self._ranges_at = told["stamp"], time.monotonic()

    def _heard(self, ranges: Mapping[int, float | None]) -> dict[int, tuple[float, float, float, float]]:
        return {
            number: (self._discs[number].x, self._discs[number].y, self._discs[number].heading, float(distance))
            for number, distance in ranges.items()
            if distance is not None and number in self._discs
        }

    def _ask(self, reading: "_Reading") -> Any:
        return self.robot.element(reading.element).ask(reading.request, within=ANSWER_TIME)

    def _look(self, pan: float) -> None:
        self.robot.ptz.ask("look", within=ANSWER_TIME, pan=pan, wait=False)


def _pan_reach(robot: Robot) -> float:
    """Return how far the head goes to both sides, rad."""
    limits = robot.ptz.properties.get("limits") or {}
    low, high = limits.get("pan") or (0.0, 0.0)
    return float(min(-low, high))


def _lens(robot: Robot, settings: FollowingSettings) -> dict[str, Any]:
    """Return the field of view of the camera, rad, by the settings, or what the robot's description has of its lens.

    Raises:
        RobotError: Neither has anything.
    """
    if settings.camera.field_of_view:
        return {"field_of_view": settings.camera.field_of_view}
    camera, head = (robot.element(each).properties if robot.has(each) else {} for each in ("camera", "ptz"))
    lens = view_of(camera, head)
    if not lens:
        raise RobotError(
            f"the field of view of the camera of {robot.name} is not known; give it in rad as camera.field_of_view in "
            f"the settings, or calibrate the camera"
        )
    return lens


def target_colours(team: Team, robot: Robot, given: str) -> ColourTable | None:
    """Return the colours of the target for a follower; None for those that are shipped.

    Args:
        team: The robots on the bus.
        robot: The follower.
        given: A file of the agent `colours`, `trained`, or nothing.
    Raises:
        RobotError: The file cannot be read, or not all three channels are trained.
    """
    if not given:
        return None
    try:
        if given == "trained":
            data = str(team.ask(f"colours@{robot.name}", "save")["colours"]).encode()
        else:
            data = Path(given).read_bytes()
        return ColourTable.load(data)
    except OSError as err:
        raise RobotError(f"the colours cannot be read from {given}: {err.strerror}") from err
    except VisionError as err:
        raise RobotError(f"the colours of {given}: {err}") from err


def laser_points(
    ranges: Sequence[float], first: float, increment: float, mount: Pose2D, room: RoomSettings
) -> list[Point]:
    """Return the echoes of a laser scan in the robot's frame, m; those farther than `room.range` are left out.

    Args:
        ranges: m; infinite or NaN without an echo.
        first: Angle of the first range in the laser's frame, rad.
        increment: rad from one range to the next.
        mount: Of the laser on the robot.
        room: Settings.
    """
    distances = np.asarray(ranges, np.float64)
    near = np.where(distances < room.range, distances, math.inf)
    return [(x, y) for x, y in echo_points(near, first, increment, mount).tolist()]


def sonar_points(ranges: Sequence[tuple[float, float, float, float]], room: RoomSettings) -> list[Point]:
    """Return the echoes of sonar discs in the robot's frame, m, as if they were on the axes of the discs.

    Args:
        ranges: x, y, m, and heading, rad, of each disc in the robot's frame, and its range, m.
        room: Settings.
    """
    return [
        (x + away * math.cos(way), y + away * math.sin(way)) for x, y, way, away in ranges if 0.0 < away < room.range
    ]
