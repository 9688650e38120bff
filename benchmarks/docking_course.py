"""Docking in lockstep: robot, driver, laser and bus in one process; and rooms with a dock, made by a seed."""

import math
from math import radians
from random import Random

import numpy as np

from acromovi.lockstep import Lockstep
from apps.docking.cycle import DockingCycle, DockingHull, DockingOrders
from apps.docking.settings import DockingSettings
from apps.echoes import echo_points
from bus import Sample, keys
from bus.bus import Closeable
from bus.messages import NS_PER_S, BatteryState, decode, heading, stamp_ns, twist
from configs.loader import build
from geometry import Pose2D
from p2os_emu.world import WorldSpec
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.world_file import WorldFile

ROBOT = "max"
MODELS = ("powerbot", "peoplebot-sh", "patrolbot-sh")  # those with an automatic charger
CONNECTING = 3.0  # s
ROOM = 7.0, 6.0  # m
PIECES = 3, 6  # of furniture
TURNING, BESIDE = 0.7, 0.1  # m that are free round the axle on the way to the dock, and round the hull from there on
WRONG, TURNED = 0.15, 0.08  # m along and across, rad, by which the expected pose of the dock may be wrong


def docking_room(seed: int) -> WorldSpec:
    """Return a room with a dock at one of its walls, furniture beside the way to it, and where the robot begins."""
    rng = Random(f"{seed} docking room")
    length, depth = ROOM
    at_wall = rng.choice(
        ((0.75, None, 180.0), (length - 0.75, None, 0.0), (None, 0.75, -90.0), (None, depth - 0.75, 90.0))
    )
    x = at_wall[0] if at_wall[0] is not None else rng.uniform(1.5, length - 1.5)
    y = at_wall[1] if at_wall[1] is not None else rng.uniform(1.5, depth - 1.5)
    dock = Pose2D(x, y, radians(at_wall[2]))
    corners = ((0.0, 0.0), (length, 0.0), (length, depth), (0.0, depth))
    walls = [
        {"name": "wall", "from_m": list(begin), "to_m": list(end)}
        for begin, end in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    while True:
        start = Pose2D(rng.uniform(0.8, length - 0.8), rng.uniform(0.8, depth - 0.8), rng.uniform(-math.pi, math.pi))
        table = {
            "walls": walls,
            "furniture": [_piece(rng, number) for number in range(rng.randint(*PIECES))],
            "docks": [{"at_m": [x, y], "heading_deg": at_wall[2]}],
            "starts": [{"at_m": [start.x, start.y], "heading_deg": math.degrees(start.heading)}],
        }
        spec = build(WorldFile, table, "benchmark").to_spec(f"docking room {seed}", "benchmark")
        if _is_free(spec, dock, start):
            return spec


def _is_free(spec: WorldSpec, dock: Pose2D, start: Pose2D) -> bool:
    """Whether a robot gets straight from its start to the place before the dock, and from there to the station."""
    before = dock.transform(-1.0, 0.0)
    ways = [
        (start.x + share * (before[0] - start.x), start.y + share * (before[1] - start.y))
        for share in np.linspace(0, 1, 9)
    ]
    hull = [dock.transform(along, across) for along in np.arange(-1.0, 0.4, 0.1) for across in (-0.35, 0.0, 0.35)]
    return bool(FreeSpace(spec, TURNING).are_free(np.array(ways)).all()) and bool(
        FreeSpace(spec, BESIDE).are_free(np.array(hull)).all()
    )


def _piece(rng: Random, number: int) -> dict[str, object]:
    return {
        "name": f"piece {number}",
        "at_m": [rng.uniform(0.3, ROOM[0] - 0.3), rng.uniform(0.3, ROOM[1] - 0.3)],
        "size_m": [rng.uniform(0.3, 1.2), rng.uniform(0.3, 0.7), rng.uniform(0.5, 1.5)],
        "heading_deg": rng.uniform(-180.0, 180.0),
    }


class DockingCourse(Closeable):
    """A robot that drives to its dock in a world. The same arguments and calls give the same drive.

    told: changes with times and reasons. path: true poses, one for each step. dock: its true pose.
    """

    def __init__(self, world: WorldSpec, settings: DockingSettings, *, model: str = "powerbot", seed: int = 0) -> None:
        """Place the robot at the first start of the world; the pose of the dock that it is given is a little wrong."""
        self.settings = settings
        self.told: list[str] = []
        self.path: list[Pose2D] = []
        self.orders: DockingOrders | None = None
        self.lockstep = Lockstep(world, {ROBOT: model}, fits={ROBOT: "laser"}, seed=seed)
        self._bus = self.lockstep.bus()
        self.lockstep.run(CONNECTING)
        described = self._bus.query(keys.DESCRIPTION.key(ROBOT))[0].value
        size = described["geometry"]
        laser = next(each for each in described["elements"] if each["name"] == "laser")["geometry"]
        self._mount = Pose2D(laser["x"], laser["y"], laser["heading"])
        self.hull = DockingHull(size["length_front"], size["width"])
        self.start = self.lockstep.truth(ROBOT)
        (place,) = world.docks
        self.dock = place.pose
        rng = Random(f"{seed} wrong dock")
        off = Pose2D(rng.uniform(-WRONG, WRONG), rng.uniform(-WRONG, WRONG), rng.uniform(-TURNED, TURNED))
        self.cycle = DockingCycle(settings, self.dock.compose(off).relative_to(self.start), self.hull)
        self._pose: Pose2D | None = None
        self._charging = self._contact = False
        for topic, take in (
            (keys.ODOM, self._take_odometry),
            (keys.SCAN, self._take_scan),
            (keys.BATTERY, self._take_battery),
            (keys.BUMPERS, self._take_bumpers),
        ):
            self._bus.subscribe(topic.key(ROBOT), take)

    def leave(self) -> None:
        """Leave the dock from now on."""
        assert self._pose is not None  # it is on the dock
        self.cycle = DockingCycle(self.settings, self.cycle.dock, self.hull, leaves=True)

    def run(self, seconds: float) -> bool:
        """Let time pass until the docking has ended; returns whether it has."""
        for _ in range(round(seconds / self.settings.period_s)):
            self.lockstep.run(self.settings.period_s)
            self.path.append(self.lockstep.truth(ROBOT))
            if self._pose is None:
                continue
            orders = self.cycle.step(self.lockstep.time, self._pose, charging=self._charging, contact=self._contact)
            self._contact = False
            self.orders = orders
            if orders.changed:
                self.told.append(f"{self.lockstep.time:.1f} s: {orders.state}: {orders.reason}")
            if orders.contacts is not None:
                self._bus.query(keys.CHARGE.key(ROBOT), {"on": orders.contacts})
                if not orders.contacts:
                    self._bus.query(keys.ENABLE.key(ROBOT), {"on": True})
            if orders.twist is not None:
                self._bus.put(keys.CMD_VEL.key(ROBOT), twist(orders.twist.linear, orders.twist.angular))
            if self.cycle.has_ended:
                return True
        return False

    @property
    def is_charged(self) -> bool:
        """Whether the battery tells that it is charged."""
        return self._charging

    def touched(self) -> list[str]:
        """Return what the robot has touched, in words with times."""
        return [f"{each.what} at {each.time:.0f} s" for each in self.lockstep.world.touches(ROBOT).last]

    def close(self) -> None:
        """End the world and the bus."""
        self._bus.close()
        self.lockstep.close()

    def _take_odometry(self, sample: Sample) -> None:
        at = decode(sample.type_name, sample.payload).pose.pose
        self._pose = Pose2D(at.position.x, at.position.y, heading(at.orientation))

    def _take_scan(self, sample: Sample) -> None:
        if self._pose is not None:
            scan = decode(sample.type_name, sample.payload)
            ranges = np.asarray(scan.ranges, np.float64)
            points = echo_points(ranges, scan.angle_min, scan.angle_increment, self._mount)
            self.cycle.take_scan(stamp_ns(scan.header) / NS_PER_S, points, self._pose)

    def _take_battery(self, sample: Sample) -> None:
        status = decode(sample.type_name, sample.payload).power_supply_status
        self._charging = status in (BatteryState.POWER_SUPPLY_STATUS_CHARGING, BatteryState.POWER_SUPPLY_STATUS_FULL)

    def _take_bumpers(self, sample: Sample) -> None:
        flags = decode(sample.type_name, sample.payload)
        self._contact |= bool(any(flags.front) or any(flags.rear) or flags.stall_left or flags.stall_right)
