"""Fetching in lockstep: robot, driver, camera and bus in one process; and rooms with objects, made by a seed."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from random import Random

from acromovi.lockstep import Lockstep
from apps.fetch.cycle import FetchCycle
from apps.fetch.settings import FetchSettings
from apps.fetch.states import FetchOrders
from benchmarks.fetch_hands import LockstepArm, LockstepGripper, LockstepHand
from bus import Sample, keys
from bus.bus import Closeable
from bus.messages import NS_PER_S, decode, heading, stamp_ns, twist
from geometry import Point, Pose2D, Twist2D
from p2os_emu.world import Block, WorldSpec
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.shortest_path import are_connected
from p2os_emu.world.spec import WallEntry

ROBOT, MODEL = "bart", "p3dx-sh"
FIT = "gripper,no-rear-sonar,ptz:vcc4,camera:160x120@10"  # as robots of the team acromovi
CONNECTING = 3.0  # s in which the driver connects, and the head is ready
ARMED, ARM_FIT = "powerbot-sh", "arm,ptz:vcc4,camera:320x240@5"
PIECES, OTHERS = (2, 4), (1, 3)  # of furniture, and objects of other colours
COLOURS = ("wood", "brown", "cream", "dark grey", "white")
HEIGHTS = (0.1, 0.26)  # m of other objects


@dataclass(frozen=True, slots=True)
class FetchRooms:
    """Rooms for one kind of robot; all in m, from and to.

    name: in the seed. length, depth: of the room. heights: of the object. boxes, tins: widths of objects by their
    shape. free: about object and place. apart: from the object to the place and to the robot, and between objects.
    passage: radius of a disc that gets everywhere. margin: of places from the walls.
    """

    name: str
    length: tuple[float, float]
    depth: tuple[float, float]
    heights: tuple[float, float]
    boxes: tuple[float, float]
    tins: tuple[float, float]
    free: float
    apart: float
    passage: float
    margin: float


GRIPPER_ROOMS = FetchRooms(
    "fetch room",
    (5.0, 7.0),
    (4.5, 6.0),
    (0.08, 0.13),  # so that when lifted it stays below the sonar
    (0.05, 0.09),
    (0.05, 0.09),
    0.75,
    1.0,
    0.6,
    0.7,
)
ARM_ROOMS = FetchRooms(
    "fetch room for an arm", (7.0, 9.0), (6.0, 8.0), (0.38, 0.43), (0.032, 0.042), (0.036, 0.05), 1.1, 1.5, 0.95, 1.1
)


def fetch_room(seed: int, rooms: FetchRooms = GRIPPER_ROOMS) -> tuple[WorldSpec, Point]:
    """Return a room with furniture, a red object and objects of other colours, and the place for the red one."""
    rng = Random(f"{seed} {rooms.name}")
    length, depth = rng.uniform(*rooms.length), rng.uniform(*rooms.depth)
    corners = ((0.0, 0.0), (length, 0.0), (length, depth), (0.0, depth))
    walls = tuple(
        block
        for begin, end in zip(corners, corners[1:] + corners[:1], strict=True)
        for block in WallEntry(begin, end, "wall").blocks()
    )
    while True:
        pieces = tuple(_piece(rng, length, depth, number) for number in range(rng.randint(*PIECES)))
        spec = WorldSpec(f"{rooms.name} {seed}", walls=walls, furniture=pieces)
        space = FreeSpace(spec, rooms.free)
        places: list[Point] = []
        for _ in range(400):
            place = rng.uniform(rooms.margin, length - rooms.margin), rng.uniform(rooms.margin, depth - rooms.margin)
            if space.is_free(place) and all(math.dist(place, other) > rooms.apart for other in places):
                places.append(place)
            if len(places) == 3 + OTHERS[1]:
                break
        if len(places) == 3 + OTHERS[1] and are_connected(FreeSpace(spec, rooms.passage), places):
            break
    start, place, thing, *others = places
    objects = [_thing(rng, "object", "red", thing, rooms, rooms.heights)]
    for number, other in enumerate(others[: rng.randint(*OTHERS)]):
        objects.append(_thing(rng, f"other {number}", rng.choice(("green", "blue", "yellow")), other, rooms, HEIGHTS))
    pose = Pose2D(*start, rng.uniform(-math.pi, math.pi))
    return replace(spec, objects=tuple(objects), starts=(pose,)), place


def _piece(rng: Random, length: float, depth: float, number: int) -> Block:
    long, wide = rng.uniform(0.4, 1.2), rng.uniform(0.35, 0.7)
    x, y = rng.uniform(0.8, length - 0.8), rng.uniform(0.8, depth - 0.8)
    return Block(
        x,
        y,
        rng.uniform(-math.pi, math.pi),
        long,
        wide,
        rng.uniform(0.5, 1.5),
        f"piece {number}",
        colour=rng.choice(COLOURS),
    )


def _thing(
    rng: Random, name: str, colour: str, place: Point, rooms: FetchRooms, heights: tuple[float, float]
) -> Movable:
    shape = rng.choice(tuple(Shape))
    widths = rooms.tins if shape is Shape.CYLINDER else rooms.boxes
    long = rng.uniform(*widths)
    wide = long if shape is Shape.CYLINDER else rng.uniform(*widths)
    pose = Pose2D(*place, rng.uniform(-math.pi, math.pi))
    return Movable(name, shape, pose, long, wide, rng.uniform(*heights), rng.uniform(0.2, 0.5), 0.5, colour)


class FetchCourse(Closeable):
    """A robot that fetches in a world. The same arguments and calls give the same drive.

    path: true poses, one for each step. told: changes with times and reasons. costs: s of processor time of each step.
    has_camera: whether images come to the application.
    """

    def __init__(
        self,
        world: WorldSpec,
        settings: FetchSettings,
        place: Point,
        *,
        colour: str = "red",
        seed: int = 0,
        perfect: bool = False,
        model: str = MODEL,
        fit: str = FIT,
    ) -> None:
        """Place the robot at the first start of the world.

        Args:
            world: Where.
            settings: Of the application.
            place: For the object, m in the world.
            colour: Of the object.
            seed: Of every error.
            perfect: No errors of odometry and sonar.
            model: Of the robot.
            fit: Accessories; an arm is used in place of a gripper.
        """
        self.world, self.settings = world, settings
        self.told: list[str] = []
        self.path: list[Pose2D] = []
        self.costs: list[float] = []
        self.has_camera = True
        self.orders: FetchOrders | None = None
        self.lockstep = Lockstep(world, {ROBOT: model}, fits={ROBOT: fit}, seed=seed, perfect=perfect)
        self._bus = self.lockstep.bus()
        self.lockstep.run(CONNECTING)
        start = self.lockstep.truth(ROBOT)
        described = self._bus.query(keys.DESCRIPTION.key(ROBOT))[0].value
        self._discs = {
            disc["frame"]: Pose2D(disc["x"], disc["y"], disc["heading"]) for disc in described["geometry"]["sonar"]
        }
        view = {"field_of_view": self.lockstep.view(ROBOT).field_of_view}
        has_arm = "arm" in fit.split(",")
        self.hand: LockstepHand = (
            LockstepArm(self._bus, ROBOT, described, settings) if has_arm else LockstepGripper(self._bus, ROBOT)
        )
        self.cycle = FetchCycle(settings, colour, start.locate(*place), view, self.hand.hand)
        self.start = start
        for topic, take in (
            (keys.ODOM, self._take_odometry),
            (keys.SONAR, self._take_sonar),
            (keys.BUMPERS, self._take_bumpers),
            (keys.PTZ, self._take_head),
            (keys.CAMERA, self._take_image),
        ):
            self._bus.subscribe(topic.key(ROBOT), take)
        if "ptz" in fit:
            self._bus.query(keys.LOOK.key(ROBOT), {"pan": 0.0, "tilt": -settings.camera.down_rad, "detach": True})

    @property
    def time(self) -> float:
        """Virtual time, s."""
        return self.lockstep.time

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> bool:
        """Let time pass, until the fetching has ended or a condition holds; returns whether one of them is so."""
        for _ in range(round(seconds / self.settings.period_s)):
            self.step()
            if self.cycle.fetcher.has_ended or until():
                return True
        return False

    def step(self) -> None:
        """Let one period pass, and decide."""
        self.lockstep.run(self.settings.period_s)
        self.hand.step(self.time)
        begin = time.process_time()
        orders = self.cycle.step(self.time)
        self.costs.append(time.process_time() - begin)
        self.path.append(self.lockstep.truth(ROBOT))
        if orders is None:
            return
        self.orders = orders
        if orders.changed:
            self.told.append(f"{self.time:.1f} s: {orders.state.value}: {orders.reason}")
        if orders.motion is not None:
            self.hand.begin(orders.motion, self.time)
        self._bus.put(keys.CMD_VEL.key(ROBOT), twist(orders.twist.linear, orders.twist.angular))

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
        pose = Pose2D(at.position.x, at.position.y, heading(at.orientation))
        self.cycle.take_odometry(stamp_ns(message.header) / NS_PER_S, pose, Twist2D(moving.linear.x, moving.angular.z))

    def _take_sonar(self, sample: Sample) -> None:
        message = decode(sample.type_name, sample.payload)
        discs = [self._discs[each.header.frame_id] for each in message.ranges]
        self.cycle.take_sonar(
            stamp_ns(message.header) / NS_PER_S, discs, [float(each.range) for each in message.ranges]
        )

    def _take_bumpers(self, sample: Sample) -> None:
        flags = decode(sample.type_name, sample.payload)
        if any(flags.front) or any(flags.rear) or flags.stall_left or flags.stall_right:
            self.cycle.take_contact()

    def _take_head(self, sample: Sample) -> None:
        message = decode(sample.type_name, sample.payload)
        self.cycle.take_head(message.pan, message.tilt, bool(message.moving))

    def _take_image(self, sample: Sample) -> None:
        if self.has_camera:
            message = decode(sample.type_name, sample.payload)
            self.cycle.take_image(stamp_ns(message.header) / NS_PER_S, message.data.tobytes())
