"""One robot on a team: its readings, its cycle, and the commands to it."""

import base64
import math
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any

from agents import Failed, Robot, RobotError
from apps.background import BackgroundRequests
from apps.fetch.cycle import FetchCycle
from apps.fetch.hands import Hand
from apps.fetch.settings import FetchSettings
from apps.fetch.states import FetchOrders, HandMotion
from geometry import Point, Pose2D, Twist2D
from vision.colours import ColourTable

_ANSWER_TIME = 1.0  # s for a reading or a command; the others do not wait for it
_SILENT = 1.0  # s without odometry or sonar, after which the robot stands
_SLOW = 0.2  # s between two readings of the head


@dataclass(frozen=True, slots=True)
class _AskedReading:
    """What is asked of an element again and again, s from one time to the next, and what takes the answer."""

    request: str
    take: Callable[[Any], None]
    period: float = 0.0


class FetchRobot:
    """Reads one robot, steps its cycle, and drives it.

    Times are of this machine's steady clock; the cycle has those of the stamps, which the gateway makes.

    trouble: why it stands, in words; empty if it does what its cycle wants. pose: in odom, None without readings.
    """

    def __init__(
        self,
        robot: Robot,
        requests: BackgroundRequests,
        settings: FetchSettings,
        colour: str,
        place: Point,
        hand: Hand,
        table: ColourTable | None = None,
    ) -> None:
        """Prepare a robot: turn the head of its camera to the floor, and find the zeros of its arm.

        Args:
            robot: With base, camera, sonar, and gripper or arm.
            requests: In which its requests are made.
            settings: Of the application.
            colour: Of the object.
            place: For the object, m in odom.
            hand: Its gripper or arm.
            table: Trained channels; None for the colours of the settings.
        Raises:
            RobotError: It lacks an element, the field of view of its camera is not known, or head or arm do not
                move.
        """
        self.robot, self.trouble = robot, "no reading has come"
        self.pose: Pose2D | None = None
        self._requests = requests
        self.cycle = FetchCycle(settings, colour, place, _camera(robot), hand, table)
        self._kinds = {
            "base": _AskedReading("read", self._take_base),
            "camera": _AskedReading("picture", self._take_picture),
            hand.element: _AskedReading("read", self.cycle.take_hand),
            "sonar": _AskedReading("read", self._take_sonar),
        }
        if robot.has("bumpers"):
            self._kinds["bumpers"] = _AskedReading("read", self._take_bumpers)
        if robot.has("ptz"):
            lowest = (robot.ptz.properties.get("limits") or {}).get("tilt", (-math.inf,))[0]
            robot.ptz.look(pan=0.0, tilt=max(-settings.camera.down_rad, lowest), zoom=1.0)  # as its model is
            self._kinds["ptz"] = _AskedReading("read", self._take_head, _SLOW)
        if hand.element == "arm":
            robot.arm.power()
            robot.arm.home()
        self._hand = hand
        self._motions: dict[str, HandMotion] = {}  # under way, by how their requests are called
        self._discs = {number: Pose2D(each.x, each.y, each.heading) for number, each in robot.sonar.discs.items()}
        self._ranges: dict[int, float] = {}
        self._due: dict[str, float] = {}
        self._stamp = math.nan  # of the newest reading of the base, on the gateway's clock
        self._sonar_stamp = math.nan
        self._base_at = self._sonar_at = -math.inf
        self._refusals: dict[str, str] = {}

    def begin(self) -> "list[Future[Any]]":
        """Ask for everything that is due; returns the requests."""
        now, begun = time.monotonic(), []
        for element, each in self._kinds.items():
            if now >= self._due.get(element, 0.0):
                self._due[element] = now + each.period
                begun.append(self._requests.begin(element, self._ask, element, each.request))
        return begun

    def step(self) -> FetchOrders | None:
        """Take what has been answered, and do what is to be done; returns it, None without readings."""
        for element in self._kinds:
            self._take(element)
        for kind, motion in list(self._motions.items()):
            ended = self._requests.take(kind)
            if ended is not None:
                del self._motions[kind]
                self._hand.ended(motion, ended.result())
                self._refusals["hand"] = self._hand.trouble
        at = time.monotonic()
        orders = None
        if at - self._base_at <= _SILENT:
            now = self._stamp + at - self._base_at
            self.pose = self.cycle.pose(now)
            if at - self._sonar_at <= _SILENT:
                orders = self.cycle.step(now)
        self._drive(orders.twist if orders is not None else Twist2D())
        if orders is not None and orders.motion is not None:
            kind = str(orders.motion)
            self._requests.take(kind)
            self._motions[kind] = orders.motion
            self._requests.begin(kind, self._move_hand, orders.motion)
        silent = next((name for name, heard in self._heard if at - heard > _SILENT), "")
        self.trouble = f"the {silent} is silent" if silent else next(filter(None, self._refusals.values()), "")
        return orders

    @property
    def _heard(self) -> tuple[tuple[str, float], ...]:
        return ("base", self._base_at), ("sonar", self._sonar_at)

    def _drive(self, twist: Twist2D) -> None:
        """Drive, unless the command before has not been answered."""
        before = self._requests.take("drive")
        if before is not None:
            error = before.exception()
            self._refusals["base"] = str(error) if isinstance(error, RobotError) else ""
            if isinstance(error, Failed):  # it is stalled: something blocks it
                self.cycle.take_contact()
        self._requests.begin("drive", self.robot.base.drive, twist.linear, twist.angular)

    def _move_hand(self, motion: HandMotion) -> str:
        """Make a motion, and wait for its end; so it stops when this program dies or freezes.

        Returns:
            Why it was not made, or has not arrived; empty if it has.
        """
        mover = self.robot.gripper if motion.element == "gripper" else self.robot.arm
        try:
            getattr(mover, motion.request)(**motion.arguments)
        except RobotError as err:  # the readings show what it has done
            return str(err)
        return ""

    def _take(self, element: str) -> None:
        """Take a reading that has been answered."""
        request = self._requests.take(element)
        if request is None:
            return
        error = request.exception()
        if error is None:
            self._kinds[element].take(request.result())
        elif not isinstance(error, RobotError):
            raise error

    def _take_base(self, told: Any) -> None:
        if told["stamp"] != self._stamp:  # the same reading again is no sign of life
            self._stamp, self._base_at = float(told["stamp"]), time.monotonic()
            pose = Pose2D(float(told["x"]), float(told["y"]), float(told["heading"]))
            moving = Twist2D(float(told["linear"] or 0.0), float(told["angular"] or 0.0))
            self.cycle.take_odometry(self._stamp, pose, moving)

    def _take_picture(self, told: Any) -> None:
        self.cycle.take_image(float(told["stamp"]), base64.b64decode(told["data"]))

    def _take_sonar(self, told: Any) -> None:
        if told["stamp"] == self._sonar_stamp:
            return
        self._sonar_stamp, self._sonar_at = told["stamp"], time.monotonic()
        ranges = {int(number): math.inf if each is None else float(each) for number, each in told["ranges"].items()}
        # A reading has the ranges of the last second. Those that differ from the last reading were measured since.
        fresh = [
            number for number, each in ranges.items() if each != self._ranges.get(number) and number in self._discs
        ]
        self._ranges = ranges
        discs = [self._discs[number] for number in fresh]
        self.cycle.take_sonar(float(told["stamp"]), discs, [ranges[number] for number in fresh])

    def _take_bumpers(self, told: Any) -> None:
        if told["pressed"] or told["stall_left"] or told["stall_right"]:
            self.cycle.take_contact()

    def _take_head(self, told: Any) -> None:
        if told["pan"] is not None and told["tilt"] is not None:
            self.cycle.take_head(float(told["pan"]), float(told["tilt"]), bool(told["moving"]))

    def _ask(self, element: str, request: str) -> Any:
        return self.robot.element(element).ask(request, within=_ANSWER_TIME)


def _camera(robot: Robot) -> Mapping[str, Any]:
    """Return the properties of the camera, with its model or field of view.

    Raises:
        RobotError: Neither is known.
    """
    known = dict(robot.camera.properties)
    if not known.get("field_of_view") and robot.has("ptz"):
        known["field_of_view"] = robot.ptz.properties.get("field_of_view")
    if known.get("model") is None and not known.get("field_of_view"):
        raise RobotError(
            f"the field of view of the camera of {robot.name} is not known; calibrate it by acromovi camera calibrate"
        )
    return known
