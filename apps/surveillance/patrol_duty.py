"""What a robot does while it serves: it visits its rooms, watches, and follows intruders, as long as it is able."""

import asyncio
from collections.abc import Callable, Coroutine, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import dist, isfinite
from typing import Any

from agents.components.localization.localization_tools import SensorPlaces
from agents.platform import Agent, AgentName
from agents.platform.directory import Directory
from apps.surveillance.algorithms.changes import MapComparison, NearRobot, SeenFloor
from apps.surveillance.algorithms.floor import PatrolFloor
from apps.surveillance.algorithms.intruders import WatchedThing
from apps.surveillance.algorithms.room_plan import RoomPlan
from apps.surveillance.patrol_driver import PatrolDriver, PlaceNotReached, RobotLost, RobotNotAble
from apps.surveillance.patrol_senses import LOCALIZATION, MOTION, PatrolSenses
from apps.surveillance.settings import SurveillanceSettings
from bus import Refused
from bus.overlay import overlay
from geometry import Point, Pose2D
from maps.building_map import BuildingMap
from maps.map_files import read_building_map

_DESCRIPTION_TIME = 3.0  # s
_FIRST_POSE = 3.0  # s for the first result of the localization, and of the battery
_CHECK = 0.1  # s between two looks whether the robot is able to go on
_YIELDS = 1  # times that a robot makes way for one room; then the room counts as not reached
_PASSING = 8.0  # s for which a robot that has made way waits for the other
_BACK = 0.5  # m from where the robot came from, at which it has made way
_BESIDE = 0.05  # m that ways keep beside the hull


@dataclass(frozen=True, slots=True)
class PatrollingRobot:
    """A robot and the map on which it is localized.

    file: of the map. started: of the localization on it, ms since 1970. geometry: of its base. view: of its camera,
    rad, 0 without one. seen: the floor as it has seen it.
    """

    file: str
    started: Any
    map: BuildingMap
    floor: PatrolFloor
    geometry: Mapping[str, Any]
    sensors: SensorPlaces
    view: float
    seen: SeenFloor


async def prepared(agent: Agent, before: PatrollingRobot | None) -> PatrollingRobot:
    """Read the map on which a robot is localized, and what its agents describe.

    Args:
        agent: Of the patrol.
        before: What was prepared before; on the same map the robot remembers what it has seen.
    Raises:
        Refused: It is not localized, or has neither laser nor sonar.
        MapError, ValueError: The map cannot be used.
        NoAnswer, TimeoutError: An agent of the robot is missing.
    """
    robot = agent.name.platform
    localization = AgentName(LOCALIZATION, robot)
    described = await agent.query(localization.description_key, timeout=_DESCRIPTION_TIME)
    base = await agent.query(AgentName("base", robot).description_key, timeout=_DESCRIPTION_TIME)
    told = await agent.request(localization, "state", reply_within=_DESCRIPTION_TIME)
    file = told.result.get("map") if told.is_done else None
    if not file:
        raise Refused(f"{robot} is not localized: {told.result['reason'] if told.is_done else told.why}")
    sensors = SensorPlaces.of(described["properties"])
    if sensors.laser is None and not sensors.discs:
        raise Refused(f"{robot} has neither laser nor sonar, so it would see no intruder")
    geometry = dict(base["properties"]["geometry"])
    made = await asyncio.to_thread(_made, str(file), told.result.get("started"), geometry, sensors, await _view(agent))
    if before is not None and before.file == made.file and before.seen.fits(made.floor):
        return replace(made, seen=before.seen)
    return made


def _made(file: str, started: Any, geometry: Mapping[str, Any], sensors: SensorPlaces, view: float) -> PatrollingRobot:
    map_ = read_building_map(file)
    floor = PatrolFloor(map_, 0.5 * float(geometry["width"]) + _BESIDE)
    return PatrollingRobot(file, started, map_, floor, geometry, sensors, view, SeenFloor(floor))


async def _view(agent: Agent) -> float:
    """Return the field of view of the robot's camera, rad; 0 where it has none whose images are compared."""
    motion = AgentName(MOTION, agent.name.platform)
    with suppress(TimeoutError, Refused, KeyError, TypeError, ValueError):  # there is none, or it does not know
        described = await agent.query(motion.description_key, timeout=_DESCRIPTION_TIME / 3.0)
        return float(described["properties"]["field_of_view"])
    return 0.0


class PatrolDuty:
    """One stretch of patrol of one robot, in the event loop of its agent. plan: its rooms. senses: its readings."""

    def __init__(
        self,
        agent: Agent,
        directory: Directory,
        robot: PatrollingRobot,
        rooms: Mapping[str, Point],
        settings: SurveillanceSettings,
        on_alarm: Callable[[int, WatchedThing], None],
    ) -> None:
        """Subscribe to the readings; nothing moves yet.

        Args:
            agent: Of the patrol.
            directory: Which agents there are.
            robot: The robot, with its map.
            rooms: All rooms of the patrol, m in `map`.
            settings: Of the application.
            on_alarm: Called in the loop with a number and each new intruder.
        """
        self.plan = RoomPlan(rooms, robot.floor, settings.patrol)
        comparison = MapComparison(robot.map, robot.floor, settings.scan, settings.sonar, settings.member)
        self.senses = PatrolSenses(agent, robot.sensors, comparison, robot.seen, settings, self._alarmed, robot.started)
        self.senses.view = robot.view
        self._driver = PatrolDriver(agent, directory, self.senses, robot.floor, robot.geometry, settings)
        self._directory = directory
        self._robot_name, self._floor, self._settings = agent.name.platform, robot.floor, settings
        self._on_alarm = on_alarm
        self._does = "waits for rooms"
        self._yields = 0  # in a row, to other robots
        self._came_from: Point | None = None  # the room of the last visit, m, or where the patrol began
        self._visits: dict[str, float] = {}  # s of the loop's time, by room
        self._returned: dict[str, str] = {}  # rooms that it gave back, and why
        self._alarms: list[WatchedThing] = []
        self._errand: tuple[Point, asyncio.Future[dict[str, Any]]] | None = None
        self._loop = asyncio.get_running_loop()
        self._sighted: tuple[Point, float] | None = None  # by another robot, and when

    @property
    def is_on_errand(self) -> bool:
        """Whether it follows an intruder."""
        return self._errand is not None

    async def check(self) -> None:
        """Wait for the first pose and the state of the battery, and see whether the robot is able.

        Raises:
            Refused: It is not.
        """
        until = self._loop.time() + _FIRST_POSE
        has_battery = self._directory.knows(AgentName("battery", self._robot_name))
        while self._loop.time() < until:
            if self.senses.is_localized and (self.senses.charging is not None or not has_battery):
                break
            await asyncio.sleep(_CHECK)
        if not self.senses.is_localized:
            raise Refused(f"{self._robot_name}: {self.senses.trouble}")
        pose = self.senses.pose
        self._came_from = None if pose is None else (pose.x, pose.y)
        if why := self._spent(self._settings.trust.battery_again):
            raise Refused(f"{self._robot_name} {why}")

    async def run(self) -> str:
        """Patrol until the robot is not able any more; return why. A cancelled patrol stops the robot."""
        working = asyncio.ensure_future(self._work())
        try:
            while not working.done():
                await asyncio.wait([working], timeout=_CHECK)
                if self.senses.lost_for > self._settings.trust.lost_s:
                    return f"{self._robot_name} has stopped: {self.senses.trouble}"
                if why := self._spent(self._settings.trust.battery):
                    return f"{self._robot_name} {why}"
            return working.result()
        finally:
            await _ended(working)

    async def close(self) -> None:
        """Stop the robot, and subscribe to nothing any more."""
        self.senses.close()
        if self._errand is not None:
            _, future = self._errand
            self._errand = None
            if not future.done():
                future.set_exception(Refused(f"{self._robot_name} does not patrol any more"))
        await self._driver.stop()

    def take(self, room: str, place: Point, neglected: Any) -> None:
        """Take a room; neglected: s since its last visit, None where it was never visited."""
        is_seen = isinstance(neglected, int | float) and isfinite(neglected)
        now = self._loop.time()
        self.plan.take(room, place, now, float(neglected) if is_seen else 1e6, is_seen=is_seen)
        self._returned.pop(room, None)

    async def follow(self, place: Point) -> dict[str, Any]:
        """Follow an intruder that is at a place, m, and return for how long, and where it was seen last."""
        future: asyncio.Future[dict[str, Any]] = self._loop.create_future()
        errand = place, future
        self._errand = errand
        try:
            return await future
        finally:
            if self._errand is errand:
                self._errand = None

    def note_sighting(self, place: Point) -> None:
        """Note where another robot sees the intruder that this one follows, m."""
        self._sighted = place, self._loop.time()

    def state(self) -> dict[str, Any]:
        """Return what it does, for its results."""
        now, pose = self._loop.time(), self.senses.pose
        return {
            "does": self._does,
            "pose": None if pose is None else [round(pose.x, 3), round(pose.y, 3), round(pose.heading, 3)],
            "rooms": list(self.plan.order),
            "next": self.plan.next_room(),
            "period": round(self.plan.period, 1),
            "visits": {room: round(now - at, 2) for room, at in self._visits.items()},
            "returned": dict(self._returned),
            "follows": self.is_on_errand,
            "navigates": self._driver.navigates,
            "intruders": [
                {
                    "intruder": number,
                    "sensor": str(each.sensor),
                    "x": round(each.place[0], 2),
                    "y": round(each.place[1], 2),
                }
                for number, each in enumerate(self._alarms, 1)
                if each in self.senses.intruders
            ],
        }

    def overlay(self) -> dict[str, Any] | None:
        """Return what it does for maps: a line to the next room, points for intruders; None while the robot is lost."""
        origin, pose, room = self.senses.odom_in_map, self.senses.pose, self.plan.next_room()
        if origin is None or pose is None:
            return None
        here = origin.locate(pose.x, pose.y)
        lines = [(here, origin.locate(*self.plan.rooms[room]))] if room is not None and not self.is_on_errand else []
        points = [origin.locate(*each.place) for each in self.senses.intruders]
        return overlay(self._does, points=points, lines=lines, frame="odom")

    def _spent(self, least: float) -> str:
        """Return why the battery does not allow to patrol; empty if it does."""
        if self.senses.charging:
            return "is being charged"
        battery = self.senses.battery
        return "" if battery is None or battery >= least else f"has to be charged: its battery is at {battery:.0%}"

    def _alarmed(self, thing: WatchedThing) -> None:
        self._alarms.append(thing)
        self._on_alarm(len(self._alarms), thing)

    async def _work(self) -> str:
        """Do one thing after the other; return why the robot cannot go on."""
        while True:
            try:
                if self._errand is not None:
                    await self._pursue(*self._errand)
                elif (room := self.plan.next_room()) is not None:
                    await self._visit(room)
                else:
                    self._does = "waits for rooms"
                    await asyncio.sleep(_CHECK)
            except RobotNotAble as err:
                if self.senses.is_localized and not isinstance(err, RobotLost):
                    return f"{self._robot_name} has stopped: {err}"
                self._does = f"stands: {err}"
                await asyncio.sleep(_CHECK)  # `run` ends it, unless the localization comes back
            if self.plan.is_stuck:
                return f"{self._robot_name} is stuck: it has not reached its last rooms"

    async def _visit(self, room: str) -> None:
        self._does = f"drives to {room}"
        patrol = self._settings.patrol

        def is_over() -> bool:
            return self.is_on_errand or self.plan.next_room() != room

        try:
            await self._unless(is_over, self._driver.go(lambda: self.plan.rooms[room], patrol.reached_m))
        except PlaceNotReached as err:
            self._does = f"has not reached {room}: {err}"
            is_traffic = err.is_traffic or bool(self.senses.near_robot)
            self._yields = self._yields + 1 if is_traffic else 0
            if is_traffic and self._yields <= _YIELDS:
                await self._make_way()
            else:
                self._yields = 0
                if self.plan.missed(room, self._loop.time()):
                    self._returned[room] = str(err)
            return
        if is_over():
            return
        self._does = f"looks in {room}"
        self._yields, self._came_from = 0, self.plan.rooms[room]
        self._visits[room] = self._loop.time()
        self.plan.visited(room, self._loop.time())
        self.senses.look(True)
        try:
            await self._unless(lambda: self.is_on_errand, asyncio.sleep(patrol.dwell_s))
        finally:
            self.senses.look(False)

    async def _make_way(self) -> None:
        """Drive to where no other robot needs to pass, so that one gets through; stay where there is no such place."""
        self._does = "makes way for another robot"
        aside = await asyncio.to_thread(self._aside, self.senses.pose, self.senses.robots())
        if aside is not None:
            with suppress(PlaceNotReached):  # then the other one has to
                await self._unless(lambda: self.is_on_errand, self._driver.go(lambda: aside, _BACK))
                self.plan.has_moved()
        await self._unless(lambda: self.is_on_errand, asyncio.sleep(_PASSING))

    def _aside(self, pose: Pose2D | None, robots: Sequence[NearRobot]) -> Point | None:
        """Return where the robot came from, or the nearest room, to which it gets without passing another robot, m.

        A robot that stands where it came from cannot go back; it may stand just where the other one wants to go.
        """
        if pose is None or not robots:
            return self._came_from
        here = pose.x, pose.y
        other = min(((each.x, each.y) for each in robots), key=lambda place: dist(place, here))
        rooms = sorted(self.plan.rooms.values(), key=lambda room: self._floor.length(room, here))
        places = rooms if self._came_from is None else [self._came_from, *rooms]
        for place in places:
            if dist(place, here) > _BACK and self._floor.leads_away(here, place, other):
                return place
        return None

    async def _unless(self, is_over: Callable[[], bool], work: Coroutine[Any, Any, None]) -> None:
        """Do something until its end, or until there is something else to do."""
        working = asyncio.ensure_future(work)
        try:
            while not working.done() and not is_over():
                await asyncio.wait([working], timeout=_CHECK)
            if working.done():
                working.result()
        finally:
            await _ended(working)

    async def _pursue(self, place: Point, future: "asyncio.Future[dict[str, Any]]") -> None:
        """Drive to an intruder and stay near it, until it has not been seen for a while."""
        pursuit = self._settings.follow
        begun = self._loop.time()
        seen, seen_at = place, begun
        self._sighted = None
        self._does = "follows an intruder"

        goal_for, place_to_go = place, place
        is_new = True

        def goal() -> Point | None:
            nonlocal seen, seen_at, goal_for, place_to_go, is_new
            now, pose = self._loop.time(), self.senses.pose
            if self.senses.intruders:
                last = seen
                thing = min(self.senses.intruders, key=lambda each: dist(each.place, last))
                seen, seen_at = thing.place, now
            elif self._sighted is not None and self._sighted[1] > seen_at:
                seen, seen_at = self._sighted
            is_over = now - seen_at > pursuit.lost_s or now - begun > pursuit.longest_s
            if is_over or self._errand is None or pose is None:
                return None
            if is_new or dist(seen, goal_for) > pursuit.replan_m:
                goal_for, is_new = seen, False
                place_to_go = self._floor.place_beside(seen, (pose.x, pose.y), pursuit.distance_m)
            return place_to_go

        while goal() is not None:
            try:
                await self._driver.go(goal, 0.5)
            except PlaceNotReached as err:
                self._does = f"follows an intruder, and cannot get near: {err}"
            await asyncio.sleep(_CHECK)
        if not future.done():
            lasted = round(self._loop.time() - begun, 1)
            future.set_result({"seconds": lasted, "x": round(seen[0], 2), "y": round(seen[1], 2)})
        self._errand = None
        pose = self.senses.pose
        if pose is not None:
            self.plan.enter((pose.x, pose.y), self._loop.time())


async def _ended(work: "asyncio.Future[Any]") -> None:
    """Cancel what is not done, and wait for its end, with which it stops the robot."""
    work.cancel()
    await asyncio.wait([work])
    if not work.cancelled():
        work.exception()  # whoever needs it has taken the result; asyncio is not to complain besides
