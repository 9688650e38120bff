"""What fetches an object: a gripper with paddles, or an arm. One interface for both; no bus, no clock.

The fetcher orders by words: `deploy` opens the fingers and brings them to where they grip, `close`, `up`, `down`, and
`open`, which also frees the way back. A hand makes motions of its robot's agents of them, one after the other.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from apps.fetch.settings import FetchSettings
from apps.fetch.states import HandMotion, HandState

_OPEN = 0.004  # m that open fingers of an arm may lack
_CLOSED = 0.004  # m that closed fingers of an arm may lack
_STOPPED = 0.003  # m from where they were sent, from which on fingers count as stopped by an object
_HOLDS = 0.0015  # m from there, down to which they count as stopped by it still


class Hand(Protocol):
    """Grips an object in front of the robot.

    element: of the robot. fingers: what they are called. hides: when it is down, it hides parts of objects from the
    camera. trouble: why its last motion was not made, in words; empty if it was.
    """

    element: str
    fingers: str
    hides: bool
    trouble: str

    @property
    def state(self) -> HandState | None:
        """The hand by its last reading; None before that."""

    def take(self, reading: Mapping[str, Any]) -> None:
        """Take a result of the element's agent."""

    def order(self, word: str, height: float) -> None:
        """Begin what a word says, in place of what was ordered before.

        Args:
            word: `deploy`, `close`, `up`, `down` or `open`.
            height: Of the object, m.
        """

    def motion(self) -> HandMotion | None:
        """Return the motion to be made now; the next one comes when `ended` has been called."""

    def ended(self, motion: HandMotion, error: str = "") -> None:
        """Take that a motion has ended; error: why it was not made or has not arrived."""

    def is_between(self, state: HandState, left: float) -> bool:
        """Return whether the object is between the fingers, to which the robot has so many m left by its odometry."""

    def misses(self, left: float, aside: float, width: float) -> bool:
        """Return whether a finger would meet the object instead of passing beside it.

        Args:
            left: m until it is between the fingers.
            aside: m from the middle between the fingers to that of the object.
            width: Of the object, m.
        """

    @property
    def covers(self) -> bool:
        """Whether it may hide parts of objects from the camera now."""

    def is_clear(self, state: HandState) -> bool:
        """Return whether the robot may back off without taking along what is between the fingers."""


class PaddleHand:
    """A gripper with paddles on a lift: its agent knows the words, and a light beam tells what is between them."""

    element, fingers, hides = "gripper", "paddles", False

    def __init__(self) -> None:
        self.trouble = ""
        self._state: HandState | None = None
        self._motion: HandMotion | None = None

    @property
    def state(self) -> HandState | None:
        """As `Hand.state`."""
        return self._state

    def take(self, reading: Mapping[str, Any]) -> None:
        """As `Hand.take`."""
        self._state = HandState(
            str(reading["paddles"]), str(reading["lift"]), bool(reading["inner_beam"]), bool(reading["holds"])
        )

    def order(self, word: str, height: float) -> None:
        """As `Hand.order`."""
        self._motion = HandMotion(self.element, word)

    def motion(self) -> HandMotion | None:
        """As `Hand.motion`; a new order does not wait for the one before."""
        motion, self._motion = self._motion, None
        return motion

    def ended(self, motion: HandMotion, error: str = "") -> None:
        """As `Hand.ended`; the readings show what it has done."""
        self.trouble = error

    def is_between(self, state: HandState, left: float) -> bool:
        """As `Hand.is_between`, by the beam."""
        return state.has_beam_broken

    def misses(self, left: float, aside: float, width: float) -> bool:
        """As `Hand.misses`; paddles are wide apart, and push aside what they meet."""
        return False

    @property
    def covers(self) -> bool:
        """As `Hand.covers`; paddles are below the image."""
        return False

    def is_clear(self, state: HandState) -> bool:
        """As `Hand.is_clear`; paddles open while the robot begins to move."""
        return True


@dataclass(slots=True)
class _Step:
    """One motion, and what it makes of the hand: `up`, `down`, or the opening to which fingers close, m."""

    motion: HandMotion
    height: str = ""
    closes_to: float | None = None


@dataclass(slots=True)
class ArmHand:
    """An arm whose hand points down, with fingers that part sideways.

    Nothing tells what is between the fingers: it is decided by sight and odometry. Fingers close by small steps, so
    that they press with a bounded lag, and hold what stops them.

    opening: of the fingers, m. finger_joint: number of the joint that opens them.
    """

    settings: FetchSettings
    opening: float
    finger_joint: int
    trouble: str = ""
    element: str = "arm"
    fingers: str = "fingers"
    hides: bool = True
    _reading: float | None = None  # m between the fingers
    _steps: deque[_Step] = field(default_factory=deque)
    _under_way: _Step | None = None
    _height: str = "between"
    _tip: float = 0.0  # m above the floor, where it grips
    _gripped: float | None = None  # m to which fingers were sent that something has stopped

    @classmethod
    def of(cls, settings: FetchSettings, properties: Mapping[str, Any]) -> "ArmHand | None":
        """Return the hand by the description of an arm; None where its last joint opens no fingers."""
        last = (properties.get("joints") or [{}])[-1]
        if last.get("unit") != "m":
            return None
        return cls(settings, float(last["upper"]), int(str(last["name"]).rpartition("_")[2]))

    @property
    def state(self) -> HandState | None:
        """As `Hand.state`."""
        opening = self._reading
        if opening is None:
            return None
        holds = self._gripped is not None and opening > self._gripped + _HOLDS
        if self._steps or self._under_way:
            return HandState("moving", "moving", has_beam_broken=False, holds=holds)
        fingers = "open" if opening > self.opening - _OPEN else "closed" if opening < _CLOSED else "between"
        return HandState(fingers, self._height, has_beam_broken=False, holds=holds)

    def take(self, reading: Mapping[str, Any]) -> None:
        """As `Hand.take`; joints by their numbers."""
        opening = reading["joints"].get(self.finger_joint)
        self._reading = None if opening is None else float(opening)

    def order(self, word: str, height: float) -> None:
        """As `Hand.order`."""
        arm = self.settings.arm
        if word == "deploy" or not self._tip:
            self._tip = max(height - arm.overlap_m, arm.lowest_m)
        if word in ("deploy", "open"):
            self._gripped = None
        steps = {
            "deploy": (self._fingers(self.opening), self._hand(0.0, "down")),
            "open": (self._fingers(self.opening), *self._raising()),
            "close": (self._closing(),),
            "up": self._raising(),
            "down": self._lowering(),
        }
        self._steps, self._under_way = deque(steps[word]), None

    def motion(self) -> HandMotion | None:
        """As `Hand.motion`."""
        if self._under_way is not None or not self._steps:
            return None
        self._under_way = self._steps.popleft()
        if self._under_way.height:
            self._height = "between"
        return self._under_way.motion

    def ended(self, motion: HandMotion, error: str = "") -> None:
        """As `Hand.ended`; that of an order which another one has replaced is ignored."""
        step = self._under_way
        if step is None or step.motion != motion:
            return
        self._under_way = None
        if step.closes_to is not None:
            self._end_closing(step.closes_to)
            return
        self.trouble = error
        if error:
            self._steps.clear()
        elif step.height:
            self._height = step.height

    def is_between(self, state: HandState, left: float) -> bool:
        """As `Hand.is_between`, by where the object was seen."""
        return left <= self.settings.arm.stop_m

    def misses(self, left: float, aside: float, width: float) -> bool:
        """As `Hand.misses`."""
        return left < self.settings.arm.check_m and abs(aside) > (self.opening - width) / 2.0

    @property
    def covers(self) -> bool:
        """As `Hand.covers`: it does until it is raised."""
        return bool(self._tip) and self._height != "up"

    def is_clear(self, state: HandState) -> bool:
        """As `Hand.is_clear`: fingers are open, and the hand is above the object, or it does not get there."""
        return state.height != "moving"

    def _end_closing(self, target: float) -> None:
        if self._reading is not None and self._reading > target + _STOPPED:
            self._gripped = target
        elif target > 0.0:
            self._steps.append(self._closing())

    def _closing(self) -> _Step:
        target = max(0.0, (self._reading or 0.0) - self.settings.arm.step_m)
        return _Step(self._fingers(target).motion, closes_to=target)

    def _fingers(self, opening: float) -> _Step:
        return _Step(HandMotion(self.element, "move", {"joints": {str(self.finger_joint): opening}}))

    def _raising(self) -> list[_Step]:
        """Return the way up; a hand that is up already stays there."""
        *ways, lift = self._ways()
        return [*(self._hand(way, "between") for way in ways if self._height != "up"), self._hand(lift, "up")]

    def _lowering(self) -> list[_Step]:
        *ways, _ = self._ways()
        return [*(self._hand(way, "between") for way in reversed(ways)), self._hand(0.0, "down")]

    def _ways(self) -> list[float]:
        """Return heights above where it grips, m, up to the last one.

        They are small steps: joints take different times, and between steps the hand points down.
        """
        lift = self.settings.robot.lift_m
        count = max(1, round(lift / self.settings.arm.raise_m))
        return [lift * part / count for part in range(1, count + 1)]

    def _hand(self, way: float, height: str) -> _Step:
        """Return the motion of the hand to so many m above where it grips."""
        arm = self.settings.arm
        place = {"x": self.settings.robot.grip_m, "y": 0.0, "z": self._tip + way}
        angles = {"pitch": arm.pitch_rad, "yaw": 0.0, "speed": arm.speed_rad_s}
        return _Step(HandMotion(self.element, "reach", {**place, **angles}), height=height)
