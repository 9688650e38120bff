"""Wandering by optical flow in lockstep: robot, driver, camera and bus in one process in virtual time."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from acromovi.lockstep import Lockstep
from agents.components.vision.flow_inputs import CameraMotion, FlowOptions, HeadingHistory
from agents.components.vision.flow_tools import FlowTools
from apps.optical_flow.columns import FlowColumns
from apps.optical_flow.settings import FlowSettings
from apps.optical_flow.sight import FlowReadings
from apps.optical_flow.wanderer import Wanderer, WanderOrders
from bus import Sample, keys
from bus.bus import Closeable
from bus.messages import NS_PER_S, CompressedImage, decode, heading, stamp_ns, twist
from geometry import Pose2D, Twist2D
from p2os_emu.world import WorldSpec
from p2os_emu.world.free_space import FreeSpace
from vision.image import Pixels, VisionError

ROBOT, MODEL, CAMERA = "bart", "p3dx-sh", "camera:160x120@10"
CONNECTING = 2.0  # s
VIEW = math.radians(60.0)  # of the emulated camera
RADIUS = 0.25  # m of the hull, by the robot's model
CELL = 0.1  # m of the floor that is counted


class FlowCourse(Closeable):
    """A robot that wanders in a world. The same arguments and calls give the same drive.

    spoil: changes an image before it is used; None for one that does not come.
    cycles: processor time in s of each cycle: image decoded, flow, time to contact, and decision.
    """

    def __init__(
        self,
        world: WorldSpec,
        settings: FlowSettings,
        *,
        seed: int = 0,
        perfect: bool = False,
        has_vectors: bool = False,
    ) -> None:
        """Place the robot at the first start of the world.

        Args:
            world: Where.
            settings: Of the application.
            seed: Of every error.
            perfect: No errors of odometry.
            has_vectors: Whether `vectors` has the flow, for films.
        """
        self.world = world
        self.settings = settings
        self.wanderer = Wanderer(settings)
        self.cycles: list[float] = []
        self.told: list[str] = []
        self.path: list[Pose2D] = []  # true
        self.orders: WanderOrders | None = None
        self.columns: FlowColumns | None = None
        self.image: Pixels | None = None
        self.vectors: Sequence[Sequence[float]] = ()
        self.spoil: Callable[[CompressedImage], CompressedImage | None] = lambda message: message
        self._options = FlowOptions(vectors=has_vectors, ahead=settings.robot.camera_m)
        self.lockstep = Lockstep(world, {ROBOT: MODEL}, fits={ROBOT: CAMERA}, seed=seed, perfect=perfect)
        self._bus = self.lockstep.bus()
        self._tools = FlowTools(has_noise=False)
        self._headings = HeadingHistory()
        self._odometry: tuple[float, Pose2D, Twist2D] | None = None
        self._fresh: FlowColumns | None = None
        self._trouble, self._touches, self._spent = "", False, 0.0
        self._is_rear: bool | None = None
        self._bus.subscribe(keys.ODOM.key(ROBOT), self._take_odometry)
        self._bus.subscribe(keys.BUMPERS.key(ROBOT), self._take_bumpers)
        self.lockstep.run(CONNECTING)
        self._bus.subscribe(keys.CAMERA.key(ROBOT), self._take_image)

    @property
    def time(self) -> float:
        """Virtual time, s."""
        return self.lockstep.time

    def run(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / self.settings.period_s)):
            self.step()

    def step(self) -> WanderOrders:
        """Let one period pass, and decide."""
        self.lockstep.run(self.settings.period_s)
        assert self._odometry is not None  # the robot is connected
        begin = time.process_time()
        columns, self._fresh = self._fresh, None
        orders = self.wanderer.step(
            FlowReadings(self.lockstep.time, *self._odometry, columns, self._trouble, self._touches, self._is_rear)
        )
        self.cycles.append(self._spent + time.process_time() - begin)
        self._spent, self._touches, self._is_rear = 0.0, False, None
        self._bus.put(keys.CMD_VEL.key(ROBOT), twist(orders.twist.linear, orders.twist.angular))
        if orders.changed:
            self.told.append(f"{self.lockstep.time:.1f} s: {orders.situation.value}: {orders.reason}")
        self.path.append(self.lockstep.truth(ROBOT))
        self.orders = orders
        return orders

    def touched(self) -> list[str]:
        """Return what the robot has touched, in words with times."""
        return [f"{each.what} at {each.time:.0f} s" for each in self.lockstep.world.touches(ROBOT).last]

    def close(self) -> None:
        """End the world and the bus."""
        self._bus.close()
        self.lockstep.close()

    def _take_odometry(self, sample: Sample) -> None:
        message = decode(sample.type_name, sample.payload)
        at, moving = message.pose.pose, message.twist.twist
        stamp, direction = stamp_ns(message.header) / NS_PER_S, heading(at.orientation)
        self._headings.add(stamp, direction, moving.angular.z, moving.linear.x)
        pose = Pose2D(at.position.x, at.position.y, direction)
        self._odometry = stamp, pose, Twist2D(moving.linear.x, moving.angular.z)

    def _take_bumpers(self, sample: Sample) -> None:
        flags = decode(sample.type_name, sample.payload)
        pressed = any(flags.front) or any(flags.rear)
        self._touches = self._touches or pressed or flags.stall_left or flags.stall_right
        if pressed:
            self._is_rear = not any(flags.front)

    def _take_image(self, sample: Sample) -> None:
        begin = time.process_time()
        message = self.spoil(decode(sample.type_name, sample.payload))
        if message is None:
            return
        stamp, before = stamp_ns(message.header) / NS_PER_S, self._tools.stamp
        turned = None if before is None else self._headings.turned(before, stamp)
        try:
            image = self._tools.decoded(message)
            motion = CameraMotion(turned, speed=self._headings.speed, turn=self._headings.rate)
            result = self._tools.result(image, stamp, motion, {"field_of_view": VIEW}, self._options)
            result["stamp"] = stamp
            self._trouble = result["trouble"] or ""
            self.vectors = result.get("vectors", ())
            self.image = image.pixels
        except VisionError as err:
            result, self._trouble = {}, str(err)
        found = FlowColumns.of(result)
        if found is not None:
            self._fresh = self.columns = found
        self._spent += time.process_time() - begin


@dataclass(slots=True)
class FloorCover:
    """How much of the floor, on which the robot's middle can be, its hull has been over."""

    world: WorldSpec
    places: np.ndarray = field(init=False)
    is_free: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        xs = [x for wall in self.world.walls for x, _ in wall.footprint]
        ys = [y for wall in self.world.walls for _, y in wall.footprint]
        across, up = np.arange(min(xs), max(xs), CELL), np.arange(min(ys), max(ys), CELL)
        self.places = np.stack(np.meshgrid(across, up), axis=2).reshape(-1, 2)
        self.is_free = FreeSpace(self.world, RADIUS).are_free(self.places)
        low, high = np.array([min(xs), min(ys)]) + 0.1, np.array([max(xs), max(ys)]) - 0.1
        self.is_free &= np.all((self.places > low) & (self.places < high), axis=1)

    def share(self, path: list[Pose2D]) -> float:
        """Return the share that a path has visited."""
        visited = np.zeros(len(self.places), np.bool_)
        for pose in path[::3]:
            visited |= (self.places[:, 0] - pose.x) ** 2 + (self.places[:, 1] - pose.y) ** 2 < RADIUS**2
        return float((visited & self.is_free).sum() / self.is_free.sum())
