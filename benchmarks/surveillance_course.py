"""A team on patrol in virtual time: the agents of the application, and robots that are played.

The manager and the agents `patrol@ROBOT` are those that run on a team, on a bus in one process. The robots are played:
each drives along the shortest way of the plan's free floor at a constant speed, and turns on the spot at corners; that
is a kinematic model, without the indoor navigation, people in the way or contacts. Localization is the true pose with
an error of the size that the localization has. Laser scans are those of the emulator's planar sensors, with noise.
"""

import asyncio
from collections.abc import Callable, Mapping, Sequence
from math import cos, dist, nan, pi, sin
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from agents.platform import Agent, AgentName, Container
from agents.platform.virtual_time import VirtualTimeLoop
from apps.surveillance.algorithms.floor import PatrolFloor
from apps.surveillance.patrol_manager import NAME, PatrolManager
from apps.surveillance.settings import SurveillanceSettings
from benchmarks.surveillance_robots import (
    LASER,
    ORIGIN,
    STEP,
    PlayedBase,
    PlayedCamera,
    PlayedIntruder,
    PlayedLocalization,
    PlayedMotion,
    PlayedNavigation,
    PlayedRobot,
)
from bus import MemoryBus, MemoryNetwork, Publisher, Sample, keys
from bus.messages import NS_PER_S, BatteryState, LaserScan, decode_json, header, quaternion
from bus.messages import Point as PointMessage
from bus.messages import Pose as PoseMessage
from bus.ros_msgs import PoseWithCovariance, PoseWithCovarianceStamped
from geometry import Point, Pose2D, wrap_angle
from p2os_emu.body import ScanBeams
from p2os_emu.world import WorldSpec
from p2os_emu.world.objects import MovingObject
from p2os_emu.world.people import BODY_RADIUS, LEG_RADIUS
from p2os_emu.world.planar import PlanarScene

MANAGER = f"{NAME}@team"
SHARED = 0.2  # s between two poses
BEAMS, REACH, NOISE = 181, 10.0, 0.01  # of the laser: count, m, m
WIDTH, FRONT, RADIUS = 0.4, 0.25, 0.22  # m of a played robot
SIGHT, IN_A_ROW = 8.0, 5  # m and scans in a row in which an intruder is visible, if at least three beams end at it
_LEG_EDGE = 0.02  # m from a leg, within which a beam ends at it
_KEPT_AWAY = 2.5  # m from any robot, at which an intruder appears
OFF, TURNED = 0.015, 0.004  # m and rad: standard deviation of the error of the localization
_MEMORY = 0.9  # of that error, from one pose to the next
_START = 1_700_000_000.0  # s since 1970


class CourseLoop(VirtualTimeLoop):
    """Virtual time in which work for threads is done at once."""

    def run_in_executor(self, executor: Any, func: Any, *args: Any) -> Any:  # type: ignore[override]  # it is generic there
        """Do it now; the future is done."""
        future = self.create_future()
        future.set_result(func(*args))
        return future


class SurveillanceCourse:
    """A team on patrol. The same arguments and calls give the same night.

    robots: by name. visible: for each intruder, s from which on a robot has it in view. reported: likewise, s of the
    first alarm on the bus near it. false_sightings: alarms that are near no intruder.
    """

    def __init__(
        self,
        world: WorldSpec,
        file: Path,
        floor: PatrolFloor,
        rooms: Mapping[str, Point],
        starts: Mapping[str, Pose2D],
        settings: SurveillanceSettings,
        *,
        seed: int = 0,
        intruders: Sequence[PlayedIntruder] = (),
        scan_s: float = SHARED,
        pose_s: float = SHARED,
        view: float = 0.0,
        navigates: bool = True,
    ) -> None:
        """Start all agents.

        Args:
            world: What the lasers see.
            file: Of the map on which the robots are localized.
            floor: Of the same map.
            rooms: To patrol, m.
            starts: Of the robots.
            settings: Of the application.
            seed: Of all errors.
            intruders: Who comes.
            scan_s: s between two scans; a whole number of steps.
            pose_s: s between two poses, likewise; no more than between two scans.
            view: Field of view of cameras, rad; 0 for no cameras.
            navigates: The robots have an indoor navigation.
        """
        self.loop = CourseLoop()
        self.floor = floor
        self.robots = {name: PlayedRobot(name, pose) for name, pose in starts.items()}
        self.intruders = list(intruders)
        self.visible: dict[int, float] = {}
        self._sights: dict[tuple[int, str], tuple[float, int]] = {}  # of an intruder by a robot: since when, and scans
        self.reported: dict[int, float] = {}
        self.false_sightings = 0
        self._standers: list[str] = []
        self._scene = PlanarScene([*world.walls, *world.furniture], self._moving)
        self._rng, self._scan_steps = np.random.default_rng(seed), round(scan_s / STEP)
        self._pose_steps, self._view = round(pose_s / STEP), view
        self._navigates = navigates
        self._random = Random(seed)
        self._network = MemoryNetwork()
        self._bus = MemoryBus(self._network)
        self._file = file
        self._containers: dict[str, Container] = {}
        self._streams: dict[str, dict[str, Publisher]] = {}
        properties = {
            "settings": settings.to_table(),
            "rooms": {name: list(place) for name, place in rooms.items()},
            "robots": [],
            "starts": {},
            "map": "",
            "attention": 0.0,
        }
        self.manager = PatrolManager(MANAGER, properties)
        self._shown: tuple[MovingObject, ...] = ()
        self.errors: list[str] = []
        self._run(self._join("team", self.manager))
        for name in starts:
            self.bring_up(name)
        self._bus.subscribe("*/agents/patrol/results", self._take_report)
        self._playing = self.loop.create_task(self._play())

    def listen(self, key: str, hear: Callable[[Any], None]) -> None:
        """Call a function with each JSON payload that is published on a key."""
        self._bus.subscribe(key, lambda sample: hear(decode_json(sample.payload)))

    @property
    def time(self) -> float:
        """Virtual time, s."""
        return self.loop.time()

    def bring_up(self, name: str) -> None:
        """Start the agents of a robot."""
        robot = self.robots[name]
        geometry = {"length_front": FRONT, "length_rear": FRONT, "width": WIDTH}
        played: list[Agent] = [
            PlayedBase(robot, geometry),
            PlayedLocalization(robot, self._file),
        ]
        if self._view:
            played.append(PlayedMotion(AgentName("motion", name), {"field_of_view": self._view}))
            played.append(PlayedCamera(AgentName("camera", name)))
        bus = MemoryBus(self._network)
        self._streams[name] = {
            "scan": bus.publisher(keys.SCAN.key(name), keys.SCAN.type_name),
            "pose": bus.publisher(keys.POSE.key(name), keys.POSE.type_name),
        }
        self._run(self._join(name, *played))
        if self._navigates:
            self._run(self._join(f"{name}-navigation", PlayedNavigation(robot, self.floor)))

    def add(self, name: str, pose: Pose2D) -> None:
        """Have another robot join."""
        self.robots[name] = PlayedRobot(name, pose)
        self.bring_up(name)

    def add_stander(self, name: str, pose: Pose2D) -> None:
        """Have a robot stand somewhere that is localized and takes no part in the patrol."""
        self.robots[name] = PlayedRobot(name, pose, is_dead=True)
        self._standers.append(name)

    def kill(self, name: str) -> None:
        """End the agents of a robot as when it is switched off; it stands from now on."""
        self.robots[name].is_dead = True
        self.robots[name].way = []
        for container in {name, f"{name}-navigation"} & self._containers.keys():
            self._run(self._containers.pop(container).close())

    def freeze(self, name: str) -> None:
        """Have nothing come from the robot's agents any more, as when its container is frozen."""
        patrol = self._containers[name].agent(AgentName("patrol", name))
        patrol.publish = lambda result: None  # type: ignore[method-assign]  # a frozen one tells nothing

    def kill_manager(self) -> None:
        """End the manager as when its program is killed."""
        self._run(self._containers.pop("team").close())

    def freeze_manager(self) -> None:
        """Have the manager do nothing any more, as when its program is frozen: no heartbeat comes from it."""
        self._containers["team"]._heartbeats.close()

    def share_pose(self, name: str, pose: Pose2D) -> None:
        """Publish the pose of a robot that is localized and takes no part in the patrol."""
        self._bus.put(keys.POSE.key(name), _pose_message(pose, _START + self.time))

    def share_battery(self, name: str, fraction: float, *, charging: bool) -> None:
        """Publish how full the battery of a robot is, 0 to 1."""
        status = BatteryState.POWER_SUPPLY_STATUS_CHARGING if charging else BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
        message = BatteryState(
            header=header(round((_START + self.time) * NS_PER_S), f"{name}/base_link"),
            voltage=25.0,
            temperature=nan,
            current=nan,
            charge=nan,
            capacity=nan,
            design_capacity=nan,
            percentage=fraction,
            power_supply_status=status,
            power_supply_health=BatteryState.POWER_SUPPLY_HEALTH_UNKNOWN,
            power_supply_technology=0,
            present=True,
            cell_voltage=np.empty(0, np.float32),
            cell_temperature=np.empty(0, np.float32),
            location="",
            serial_number="",
        )
        self._bus.put(keys.BATTERY.key(name), message)

    def show_motion(self, name: str, blobs: Sequence[Mapping[str, float]]) -> None:
        """Publish what moves in an image of 100 x 100 px of a robot: blobs with `area` and `x`."""
        told = {"stamp": _START + self.time, "width": 100, "height": 100, "settled": True, "blobs": list(blobs)}
        self._containers[name].agent(AgentName("motion", name)).publish(told)

    def block(self, name: str, place: Point) -> None:
        """Have the navigation of a robot find no way to a place, m."""
        self.robots[name].barred.append(place)

    def run(self, seconds: float) -> None:
        """Let time pass."""
        self.loop.run_for(seconds)

    def run_until(self, is_so: Callable[[], bool], within: float) -> bool:
        """Let time pass until something is so; returns whether it is in time."""
        until = self.time + within
        while not is_so() and self.time < until:
            self.run(STEP)
        return is_so()

    def close(self) -> None:
        """End everything."""
        self._playing.cancel()
        self.loop.run_for(STEP)
        for container in reversed(self._containers.values()):
            self._run(container.close())
        self._run(self.loop.shutdown_asyncgens())
        self.loop.close()

    def _run(self, work: Any) -> Any:
        return self.loop.run_until_complete(work)

    async def _join(self, name: str, *agents: Agent) -> None:
        def report(report: Any) -> None:
            if report.error is not None:
                self.errors.append(f"{report.agent}: {report.what}: {report.error!r}")

        container = Container(MemoryBus(self._network), name, report, lambda: _START + self.loop.time())
        self._containers[name] = container
        container.show()
        for agent in agents:
            await container.start(agent)

    async def _play(self) -> None:
        """Let the robots drive, and publish poses and scans."""
        step = 0
        while True:
            await asyncio.sleep(STEP)
            step += 1
            for robot in self.robots.values():
                robot.step(STEP)
                if step % round(1.0 / STEP) == 0:
                    robot.path.append(robot.pose)
            self._keep_away()
            alive = [each for each in self.robots.values() if not each.is_dead]
            if step % self._pose_steps == 0:
                for robot in alive:
                    self._share(robot)
                for name in self._standers:
                    self.share_pose(name, self.robots[name].pose)
            if step % self._scan_steps == 0:
                self._shown = tuple(self._objects())
                for robot in alive:
                    self._streams[robot.name]["scan"].put(self._scan(robot))

    def _share(self, robot: PlayedRobot) -> None:
        stamp = _START + self.time
        for number, size in enumerate((OFF, OFF, TURNED)):
            noise = self._random.gauss(0.0, size)
            robot.error[number] = _MEMORY * robot.error[number] + (1.0 - _MEMORY**2) ** 0.5 * noise
        x, y, turned = robot.error
        at = Pose2D(robot.pose.x + x, robot.pose.y + y, wrap_angle(robot.pose.heading + turned))
        told = {
            "stamp": stamp,
            "state": "searching" if robot.is_lost else "localized",
            "pose": [at.x, at.y, at.heading],
            "deviations": [OFF, OFF, TURNED],
            "odom_in_map": [ORIGIN.x, ORIGIN.y, ORIGIN.heading],
            "started": robot.started,
            "reason": "the readings fit no place" if robot.is_lost else None,
        }
        self._containers[robot.name].agent(AgentName("localization", robot.name)).publish(told)
        if not robot.is_lost:
            self._streams[robot.name]["pose"].put(_pose_message(at, stamp))

    def _scan(self, robot: PlayedRobot) -> LaserScan:
        about = header(round((_START + self.time) * NS_PER_S), f"{robot.name}/laser")
        step = pi / (BEAMS - 1)
        beams = ScanBeams(LASER.x, LASER.y, 0.3, -pi / 2, step, BEAMS, REACH)
        echoes = self._scene.cast(beams, robot.pose, robot.name)
        self._note_visible(robot, echoes.ranges)
        ranges = echoes.ranges + self._rng.normal(0.0, NOISE, BEAMS)
        return LaserScan(
            header=about,
            angle_min=-pi / 2,
            angle_max=pi / 2,
            angle_increment=step,
            time_increment=0.0,
            scan_time=self._scan_steps * STEP,
            range_min=0.0,
            range_max=32.0,
            ranges=ranges.astype(np.float32),
            intensities=np.empty(0, np.float32),
        )

    def _note_visible(self, robot: PlayedRobot, ranges: Any) -> None:
        """Note since when a robot has an intruder in view: three beams end at it within 8 m, in five scans in a row.

        Beams that end at a wall beside it are no view of it, nor is one from where the robot would stand in it.
        """
        seen = np.where(np.isfinite(ranges), ranges, REACH)
        bearings = np.linspace(-pi / 2, pi / 2, BEAMS)
        laser = robot.pose.compose(LASER)
        for number, intruder in enumerate(self.intruders):
            place = intruder.place(self.time)
            if place is None or number in self.visible:
                continue
            away = dist((robot.pose.x, robot.pose.y), place)
            ends = np.zeros(BEAMS, np.bool_)
            for x, y in (laser.locate(*leg) for leg in intruder.legs(self.time)):
                ends |= np.hypot(seen * np.cos(bearings) - x, seen * np.sin(bearings) - y) < LEG_RADIUS + _LEG_EDGE
            if not RADIUS + BODY_RADIUS < away < SIGHT or np.count_nonzero(ends) < 3:
                self._sights.pop((number, robot.name), None)
                continue
            since, scans = self._sights.get((number, robot.name), (self.time, 0))
            self._sights[number, robot.name] = since, scans + 1
            if scans + 1 == IN_A_ROW:
                self.visible[number] = since

    def _take_report(self, sample: Sample) -> None:
        """Note which intruders an alarm reports."""
        told = sample.decoded()
        if told.get("event") != "alarm":
            return
        here = float(told["x"]), float(told["y"])
        # A person walks on before the alarm comes, so where the person was lately counts as well.
        moments = [self.time - 0.2 * number for number in range(8)]
        near = [
            number
            for number, intruder in enumerate(self.intruders)
            if any(place is not None and dist(place, here) < 1.0 for place in map(intruder.place, moments))
        ]
        self.false_sightings += not near
        for number in near:
            self.reported.setdefault(number, self.time)

    def _keep_away(self) -> None:
        """Have intruders who would appear beside a robot come later."""
        for intruder in self.intruders:
            if self.time - STEP < intruder.begins <= self.time and self._is_near_robot(intruder.way[0]):
                intruder.begins += 1.0

    def _is_near_robot(self, place: Point) -> bool:
        return any(dist((each.pose.x, each.pose.y), place) < _KEPT_AWAY for each in self.robots.values())

    def _moving(self) -> Sequence[MovingObject]:
        return self._shown

    def _objects(self) -> list[MovingObject]:
        found = [_disc(each.name, (each.pose.x, each.pose.y), RADIUS) for each in self.robots.values()]
        for number, intruder in enumerate(self.intruders):
            found += [_disc(f"intruder {number}", leg, LEG_RADIUS) for leg in intruder.legs(self.time)]
        return found


def _pose_message(pose: Pose2D, stamp: float) -> PoseWithCovarianceStamped:
    at = PoseMessage(position=PointMessage(x=pose.x, y=pose.y, z=0.0), orientation=quaternion(pose.heading))
    return PoseWithCovarianceStamped(header(round(stamp * NS_PER_S), "map"), PoseWithCovariance(at, np.zeros(36)))


def _disc(name: str, place: Point, radius: float) -> MovingObject:
    corners = tuple(
        (place[0] + radius * cos(turn), place[1] + radius * sin(turn))
        for turn in np.linspace(0.0, 2.0 * pi, 12, endpoint=False).tolist()
    )
    return MovingObject(name, corners, 0.0, 1.7)
