"""A robot with a gripper among objects on a floor without walls, as the fetcher has it: no images, no physics."""

from dataclasses import dataclass, field
from math import hypot

from apps.fetch.fetcher import Fetcher
from apps.fetch.settings import FetchSettings
from apps.fetch.sight import CameraView, ObjectSighting
from apps.fetch.states import FetchOrders, FetchReadings, FetchState, GripperState
from geometry import Point, Pose2D, Twist2D, integrate

SETTINGS = FetchSettings.load()
VIEW = CameraView(0.44, 0.6)
PERIOD = 0.1  # s
_BEAM, _BEHIND = 0.3, 0.24  # m before the axle, where an object is between the paddles
_MOTION = 2.0  # s that a motion of the gripper takes


@dataclass
class Thing:
    """An object: where it is, m in odom, its colour, width and height, m."""

    x: float
    y: float
    colour: str = "red"
    width: float = 0.06
    height: float = 0.12


@dataclass
class ToyRobot:
    """Moves exactly as it is told, and sees and grips exactly.

    things: on the floor. held: in the gripper. orders: what the gripper was told. blind: why there are no images.
    slips: the gripper closes on nothing, although something is there. wound: the heading without wrapping, rad.
    narrow: a place near which it cannot drive forward while it carries something.
    """

    fetcher: Fetcher
    things: list[Thing]
    pose: Pose2D = field(default_factory=Pose2D)
    held: Thing | None = None
    orders: list[str] = field(default_factory=list)
    blind: str = ""
    slips: bool = False
    wound: float = 0.0
    narrow: Point | None = None
    time: float = 0.0
    told: list[str] = field(default_factory=list)
    last: FetchOrders | None = None
    _images: int = 0
    _paddles: str = "closed"
    _lift: str = "up"
    _until: float = 0.0

    @classmethod
    def among(cls, *things: Thing, place: Point = (0.0, 1.0), colour: str = "red") -> "ToyRobot":
        return cls(Fetcher(SETTINGS, colour, place), list(things))

    def run(self, seconds: float, state: FetchState | None = None) -> FetchState:
        """Let time pass, until a state is reached or it has ended."""
        for _ in range(round(seconds / PERIOD)):
            self.step()
            if self.fetcher.state is state or self.fetcher.has_ended:
                break
        return self.fetcher.state

    def step(self) -> Twist2D:
        self.time += PERIOD
        if not self.blind:
            self._images += 1
            self.fetcher.objects.take(self.time, self.pose, self._seen(), VIEW)
        orders = self.last = self.fetcher.step(
            FetchReadings(self.time, self.pose, self._gripper(), self._images, self.blind)
        )
        if orders.changed:
            self.told.append(f"{orders.state.value}: {orders.reason}")
        if orders.gripper:
            self._move(orders.gripper)
        twist = Twist2D(min(orders.twist.linear, 0.0), 0.0) if self._is_stuck() else orders.twist
        self.pose = integrate(self.pose, twist, PERIOD)
        self.wound += twist.angular * PERIOD
        return orders.twist

    def _is_stuck(self) -> bool:
        if self.narrow is None or self.held is None:
            return False
        x, y = self.pose.locate(*self.narrow)
        return x > 0.0 and hypot(x, y) < 0.4

    def _seen(self) -> list[ObjectSighting]:
        found = []
        for each in self.things:
            x, y = self.pose.locate(each.x, each.y)
            if 0.6 < x < 4.0 and abs(y) < 0.44 * (x - 0.1):
                found.append(ObjectSighting(each.colour, x, y, each.width, each.height))
        return found

    def _between(self) -> Thing | None:
        for each in self.things:
            x, y = self.pose.locate(each.x, each.y)
            if _BEHIND < x - each.width / 2.0 < _BEAM - 0.03 and abs(y) < 0.08:
                return each
        return None

    def _gripper(self) -> GripperState:
        if self.time < self._until:
            return GripperState("moving", "moving", outer_beam=False, inner_beam=False, holds=self.held is not None)
        is_there = self.held is not None or self._between() is not None
        return GripperState(self._paddles, self._lift, is_there, is_there, self.held is not None)

    def _move(self, order: str) -> None:
        self.orders.append(order)
        self._until = self.time + _MOTION
        if order in ("open", "deploy"):
            self._paddles = "open"
            if self.held is not None:
                self.held.x, self.held.y = self.pose.transform(SETTINGS.robot.grip_m, 0.0)
                self.things.append(self.held)
                self.held = None
        if order == "close":
            between = None if self.slips else self._between()
            self._paddles = "closed" if between is None else "between"
            if between is not None:
                self.things.remove(between)
                self.held = between
        self._lift = {"deploy": "down", "down": "down", "up": "up"}.get(order, self._lift)
