"""Readings of one robot for the wanderer: odometry, bumpers, and the stream of the flow agent."""

import math
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Any

from agents import Robot, RobotError
from agents.client.readings import OtherReading
from apps.film import Pixels
from apps.optical_flow.columns import FlowColumns
from apps.optical_flow.film import FlowView
from apps.optical_flow.sight import FlowReadings
from geometry import Pose2D, Twist2D

ANSWER_TIME = 1.0  # s for a reading
_ASIDE = 0.05  # rad by which the camera head may look to a side
_ZOOM = 1.1  # up to which bearings and flow are as at the widest zoom
_KEPT = 10  # results of the flow agent, among which that of a picture is found
_APART = 0.05  # s between the stamps of a picture and a result that are of the same exposure, at most


@dataclass(slots=True)
class _Asked:
    """A reading that is asked for again and again, one request at a time."""

    ask: Callable[[], Any]
    future: "Future[Any] | None" = None
    error: str = ""


class FlowFeed:
    """Asks for readings in threads, so that no answer that is late holds up the next decision.

    Each call begins at most one request of a kind, and nothing begins one by itself: when the program hangs, its calls
    end, it counts as unattended, and the robot stops.
    """

    def __init__(self, robot: Robot) -> None:
        """Begin.

        Args:
            robot: With base, camera and flow.
        Raises:
            RobotError: It lacks one.
        """
        self._robot = robot
        self._flow = robot.element("flow")
        self._results: Iterator[Any] | None = None
        self._pool = ThreadPoolExecutor(5, "optical-flow")
        self._asked = {"flow": _Asked(self._next_result), "base": _Asked(self._odometry)}
        if robot.has("bumpers"):
            self._asked["bumpers"] = _Asked(self._bumpers)
        if robot.has("ptz"):
            self._asked["ptz"] = _Asked(self._head)
        self._picture = _Asked(self._stamped_pixels)
        self._viewed = math.nan  # stamp of the latest picture that was returned
        self._recent: deque[tuple[FlowColumns, Any]] = deque(maxlen=_KEPT)  # results with their vectors
        self._base: dict[str, Any] | None = None
        self._stamp = math.nan  # of the latest odometry
        self._heard = -math.inf  # s, when it was new
        self._is_stalled = False
        self._trouble = ""  # of the latest result of the flow agent
        self._aside = ""  # why the images do not show what is ahead

    def read(self, now: float, patience: float) -> FlowReadings | None:
        """Return what is known; None before the first odometry.

        Args:
            now: s on a steady clock.
            patience: s to wait for answers.
        """
        wait([self._begin(each) for each in self._asked.values()], patience)
        new = {name: value for name, each in self._asked.items() if (value := _answer(each)) is not None}
        if (base := new.get("base")) is not None:
            if base["stamp"] != self._stamp:
                self._heard = now
            self._base, self._stamp = base, float(base["stamp"])
        if self._base is None:
            return None
        columns = None
        if (result := new.get("flow")) is not None:
            self._trouble, columns = str(result.get("trouble") or ""), FlowColumns.of(result)
            if columns is not None:
                self._recent.append((columns, result.get("vectors") or ()))
        if (head := new.get("ptz")) is not None:
            self._aside = head_trouble(head)
        trouble = self._asked["flow"].error or self._trouble or self._aside
        if "ptz" in self._asked:
            trouble = trouble or self._asked["ptz"].error
        if now - self._heard > ANSWER_TIME:
            trouble = f"no odometry for {now - self._heard:.1f} s"
        pose = Pose2D(float(self._base["x"]), float(self._base["y"]), float(self._base["heading"]))
        twist = Twist2D(float(self._base["linear"]), float(self._base["angular"]))
        bumpers = new.get("bumpers") or {}
        touches, self._is_stalled = bool(bumpers.get("pressed")) or self._is_stalled, False
        return FlowReadings(now, self._stamp, pose, twist, columns, trouble, touches, rear_only(bumpers))

    def has_stalled(self) -> None:
        """Take a refusal to drive on against something for a contact."""
        self._is_stalled = True

    def view(self, words: str) -> FlowView | None:
        """Return a new picture with its flow where one has come since an earlier call; else None, and ask for one.

        Args:
            words: Situation and reason.
        """
        taken: tuple[float, Pixels] | None = _answer(self._picture)
        if taken is None:
            self._begin(self._picture)
        if taken is None or not self._recent or taken[0] == self._viewed:
            return None
        stamp, image = taken
        self._viewed = stamp
        columns, vectors = min(self._recent, key=lambda each: abs(each[0].stamp - stamp))
        return FlowView(stamp, image, columns, vectors, words) if abs(columns.stamp - stamp) < _APART else None

    def close(self) -> None:
        """Begin no more requests."""
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _begin(self, asked: _Asked) -> "Future[Any]":
        if asked.future is None:
            asked.future = self._pool.submit(asked.ask)
        return asked.future

    def _next_result(self) -> dict[str, Any]:
        """Return the next result of the flow agent's stream; after an error, the next call begins a new one."""
        if self._results is None:
            self._results = self._flow.watch(within=ANSWER_TIME)
        try:
            reading = next(self._results)
        except BaseException:
            self._results = None
            raise
        assert isinstance(reading, OtherReading)  # the flow agent's has no class of its own
        return reading.result

    def _odometry(self) -> dict[str, Any]:
        return dict(self._robot.base.ask("read", within=ANSWER_TIME))

    def _stamped_pixels(self) -> tuple[float, Pixels]:
        picture = self._robot.camera.picture()
        return picture.stamp, picture.pixels()

    def _head(self) -> dict[str, Any]:
        return dict(self._robot.ptz.ask("read", within=ANSWER_TIME))

    def _bumpers(self) -> dict[str, Any]:
        return dict(self._robot.bumpers.ask("read", within=ANSWER_TIME))


def head_trouble(head: Mapping[str, Any]) -> str:
    """Return why images do not show what is ahead, by a reading of the camera head; empty if they do."""
    if head["moving"]:
        return "the camera head moves"
    pan, zoom = float(head["pan"]), float(head["zoom"])
    if abs(pan) > _ASIDE:
        side = "left" if pan > 0.0 else "right"
        return f"the camera head looks {math.degrees(abs(pan)):.0f} degrees to the {side}; it must look ahead"
    return f"the camera head zooms {zoom:.1f} times; it must not" if zoom > _ZOOM else ""


def rear_only(bumpers: Mapping[str, Any]) -> bool | None:
    """Return whether segments are pressed at the rear only; None where none is, as when only wheels stall."""
    front, rear = (any(bumpers.get(name, ())) for name in ("front", "rear"))
    return not front if front or rear else None


def _answer(asked: _Asked) -> Any:
    """Return an answer that has come; None where there is none, or an error instead."""
    future = asked.future
    if future is None or not future.done():
        return None
    asked.future, asked.error = None, ""
    error = future.exception()
    if isinstance(error, RobotError):
        asked.error = str(error)
        return None
    return future.result()
