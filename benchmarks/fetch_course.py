"""Fetching in lockstep: robot, driver, camera and bus in one process; and rooms with objects, made by a seed."""

import math
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from random import Random

from acromovi.lockstep import Lockstep
from agents.components.gripper import GripperAgent
from apps.fetch.cycle import FetchCycle
from apps.fetch.settings import FetchSettings
from apps.fetch.states import FetchOrders, GripperState
from bus import Refused, Sample, keys
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
LENGTHS, DEPTHS = (5.0, 7.0), (4.5, 6.0)  # m of rooms
PIECES, OTHERS = (2, 4), (1, 3)  # of furniture, and objects of other colours
COLOURS = ("wood", "brown", "cream", "dark grey", "white")
FETCHED, HEIGHTS = (0.08, 0.13), (0.1, 0.26)  # m of the object, which when lifted stays below the sonar, and of others
ROOM = 0.75  # m about the object, and about the place, that is free
APART = 1.0  # m from the object to the place and to the robot, and between objects
_PASSAGE = 0.6  # m, radius of a disc that gets everywhere


def fetch_room(seed: int) -> tuple[WorldSpec, Point]:
    """Return a room with furniture, a red object and objects of other colours, and the place for the red one."""
    rng = Random(f"{seed} fetch room")
    length, depth = rng.uniform(*LENGTHS), rng.uniform(*DEPTHS)
    corners = ((0.0, 0.0), (length, 0.0), (length, depth), (0.0, depth))
    walls = tuple(
        block
        for begin, end in zip(corners, corners[1:] + corners[:1], strict=True)
        for block in WallEntry(begin, end, "wall").blocks()
    )
    while True:
        pieces = tuple(_piece(rng, length, depth, number) for number in range(rng.randint(*PIECES)))
        spec = WorldSpec(f"fetch room {seed}", walls=walls, furniture=pieces)
        space = FreeSpace(spec, ROOM)
        places: list[Point] = []
        for _ in range(400):
            place = rng.uniform(0.7, length - 0.7), rng.uniform(0.7, depth - 0.7)
            if space.is_free(place) and all(math.dist(place, other) > APART for other in places):
                places.append(place)
            if len(places) == 3 + OTHERS[1]:
                break
        if len(places) == 3 + OTHERS[1] and are_connected(FreeSpace(spec, _PASSAGE), places):
            break
    start, place, thing, *others = places
    objects = [_thing(rng, "object", "red", thing, FETCHED)]
    for number, other in enumerate(others[: rng.randint(*OTHERS)]):
        objects.append(_thing(rng, f"other {number}", rng.choice(("green", "blue", "yellow")), other, HEIGHTS))
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


def _thing(rng: Random, name: str, colour: str, place: Point, heights: tuple[float, float]) -> Movable:
    shape = rng.choice(tuple(Shape))
    long = rng.uniform(0.05, 0.09)
    wide = long if shape is Shape.CYLINDER else rng.uniform(0.05, 0.09)
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
            fit: Accessories.
        """
        self.world, self.settings = world, settings
        self.told: list[str] = []
        self.path: list[Pose2D] = []
        self.costs: list[float] = []
        self.has_camera = True
        self.orders: FetchOrders | None = None
        self.lockstep = Lockstep(world, {ROBOT: MODEL}, fits={ROBOT: fit}, seed=seed, perfect=perfect)
        self._bus = self.lockstep.bus()
        self._gripper = GripperAgent(f"gripper@{ROBOT}")
        self.lockstep.run(CONNECTING)
        start = self.lockstep.truth(ROBOT)
        described = self._bus.query(keys.DESCRIPTION.key(ROBOT))[0].value
        self._discs = {
            disc["frame"]: Pose2D(disc["x"], disc["y"], disc["heading"]) for disc in described["geometry"]["sonar"]
        }
        view = {"field_of_view": self.lockstep.view(ROBOT).field_of_view}
        self.cycle = FetchCycle(settings, colour, start.locate(*place), view)
        self.start = start
        for topic, take in (
            (keys.ODOM, self._take_odometry),
            (keys.SONAR, self._take_sonar),
            (keys.GRIPPER, self._take_gripper),
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
        begin = time.process_time()
        orders = self.cycle.step(self.time)
        self.costs.append(time.process_time() - begin)
        self.path.append(self.lockstep.truth(ROBOT))
        if orders is None:
            return
        self.orders = orders
        if orders.changed:
            self.told.append(f"{self.time:.1f} s: {orders.state.value}: {orders.reason}")
        if orders.gripper:
            with suppress(Refused):  # it is reported by the gripper, that it does not move
                self._bus.query(keys.GRIP.key(ROBOT), {"do": orders.gripper, "detach": True})
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

    def _take_gripper(self, sample: Sample) -> None:
        told = self._gripper.result(decode(sample.type_name, sample.payload))
        self.cycle.take_gripper(GripperState.of(told))

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
