"""A robot with a gripper or an arm among objects on an open floor, as the fetcher has it: no images, no physics."""

from dataclasses import dataclass, field
from math import hypot

from apps.fetch.fetcher import Fetcher
from apps.fetch.hands import ArmHand, PaddleHand
from apps.fetch.settings import FetchSettings
from apps.fetch.sight import CameraView, ObjectSighting
from apps.fetch.states import FetchOrders, FetchReadings, FetchState, HandMotion, HandState
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
        return cls(Fetcher(SETTINGS, colour, place, PaddleHand()), list(things))

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
        if orders.motion is not None:
            self._make(orders.motion)
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

    def _gripper(self) -> HandState:
        if self.time < self._until:
            return HandState("moving", "moving", has_beam_broken=False, holds=self.held is not None)
        is_there = self.held is not None or self._between() is not None
        return HandState(self._paddles, self._lift, is_there, self.held is not None)

    def _make(self, motion: HandMotion) -> None:
        self._move(motion.request)

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


ARM_SETTINGS = FetchSettings.load_for_arm()
_OPENING = 0.07  # m
_PADS = 0.01  # m to both sides along the robot, where the fingers grip


@dataclass
class ToyArmRobot(ToyRobot):
    """Likewise with an arm; orders has the requests. tip: of the hand above the floor, m."""

    tip: float = 0.8
    opening: float = 0.0
    _motion: HandMotion | None = None

    @classmethod
    def among(cls, *things: Thing, place: Point = (0.0, 1.0), colour: str = "red") -> "ToyArmRobot":
        rows = [{"name": "toy/arm_joint_1", "unit": "rad"}, {"name": "toy/arm_joint_2", "unit": "m", "upper": _OPENING}]
        hand = ArmHand.of(ARM_SETTINGS, {"joints": rows})
        assert hand is not None
        return cls(Fetcher(ARM_SETTINGS, colour, place, hand), list(things))

    def _gripper(self) -> HandState:
        if self._motion is not None and self.time >= self._until:
            motion, self._motion = self._motion, None
            self._arrive(motion)
            self.fetcher.hand.ended(motion)
        self.fetcher.hand.take({"joints": {1: 0.0, 2: self.opening}})
        state = self.fetcher.hand.state
        assert state is not None
        return state

    def _make(self, motion: HandMotion) -> None:
        self.orders.append(motion.request)
        self._motion, self._until = motion, self.time + _MOTION / 4.0

    def _arrive(self, motion: HandMotion) -> None:
        if motion.request == "reach":
            self.tip = motion.arguments["z"]
            return
        target = motion.arguments["joints"]["2"]
        if self.held is not None and target > self.held.width:
            self.held.x, self.held.y = self.pose.transform(ARM_SETTINGS.robot.grip_m, 0.0)
            self.things.append(self.held)
            self.held = None
        if self.held is None and target < self.opening and not self.slips:
            self.held = next((each for each in self.things if self._meets(each, target)), None)
            if self.held is not None:
                self.things.remove(self.held)
        self.opening = max(target, 0.0 if self.held is None else self.held.width)
        self.fetcher.hand.take({"joints": {1: 0.0, 2: self.opening}})

    def _meets(self, each: Thing, opening: float) -> bool:
        x, y = self.pose.locate(each.x, each.y)
        is_there = abs(x - ARM_SETTINGS.robot.grip_m) < _PADS + each.width / 2.0 and abs(y) < _OPENING / 2.0
        return is_there and each.width > opening and each.height > self.tip
