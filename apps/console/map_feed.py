"""Updates of the map to browsers over websockets.

The browser requests each update after it has drawn the one before. What changes always, poses and ranges, is encoded
once for all browsers; what changes seldom is sent to a browser when it has changed since its last update.
"""

import asyncio
import time
import zlib
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from starlette.websockets import WebSocket, WebSocketDisconnect

from agents.platform import Agent, Directory
from apps.console.emulator import EmulatorControl
from apps.console.floor import FloorPlan
from apps.console.health import standing
from apps.console.locating import BUILT, LOCALIZATION, LocatingWatch, named_goals
from apps.console.map_layers import (
    SeenCells,
    SonarPicture,
    disc_count,
    laser_mount,
    mission_layout,
    ranges_mm,
    robot_layout,
    robot_record,
)
from apps.console.overlays import OverlayWatch
from apps.console.patrol import PatrolWatch
from apps.console.people import PeopleWatch
from apps.console.placing import FramePlaces
from apps.console.robots import RobotWatch, WatchedRobot
from apps.console.settings import MapSettings
from apps.web.viewer import framed
from bus import Sample, keys
from bus.aio import hand_over
from bus.messages import NS_PER_S, heading, stamp_ns
from geometry import Pose2D

_SLOW = 0.5  # s between two looks at what changes seldom
_LOOK = 0.008  # s between two looks for new readings while a browser waits for them
_NAVIGATION = "user_interface"
_MOST_GRID = 4_000_000  # cells of a grid that is sent
_GRID_OLD = 15.0  # s after which a grid makes way for that of another robot


@dataclass(slots=True)
class _Sent:
    """What a browser has: the version of each part and of the paths, and the number of cells of each robot."""

    versions: dict[str, int] = field(default_factory=dict)
    cells: dict[str, int] = field(default_factory=dict)
    trails: int = -1
    number: int = 0


class MapFeed:
    """The map of the team, for all browsers.

    places: of the robots' frames. missions: what is drawn of navigations, by robot. locating: of their localizations.
    patrol: of the surveillance.
    """

    def __init__(
        self,
        agent: Agent,
        robots: RobotWatch,
        directory: Directory,
        floor: FloorPlan,
        places: FramePlaces,
        emulator: EmulatorControl | None,
        settings: MapSettings,
        may_ask: bool,
        recorded_missions: Callable[[], Mapping[str, dict[str, Any]]] | None = None,
    ) -> None:
        """Begin; little is done until a browser looks.

        Args:
            agent: Asks the navigations.
            robots: The robots.
            directory: Of the agents.
            floor: What is known of it.
            places: Of the robots' frames.
            emulator: The emulator, which knows where its robots are; None without one.
            settings: Settings.
            may_ask: Whether agents can be asked: not in a recording, nor with a role that permits looking only.
            recorded_missions: Returns the missions at the position of a recording; None for a live team.
        """
        self.missions: dict[str, dict[str, Any]] = {}
        self.places = places
        self._agent, self._robots, self._directory, self._floor = agent, robots, directory, floor
        self._emulator, self._settings, self._may_ask = emulator, settings, may_ask
        self._recorded_missions = recorded_missions
        self._watching = self._waiting = 0  # browsers, and those of them that wait for what is new
        self._encoded_at = 0.0  # s of the monotonic clock
        self._number = 0  # of updates
        self._live = b""
        self._seen: tuple[int, ...] = ()
        self._trails_begun = 0  # of the paths that fit the poses in `_live`
        self._moved = asyncio.Event()
        self._parts: dict[str, tuple[int, Any]] = {}  # version and content of what changes seldom
        self._sonar: dict[str, tuple[int, SonarPicture]] = {}
        self._cells: dict[str, SeenCells] = {}
        self._cells_of: dict[str, int] = {}  # number of the scan that was last added
        self._grid_of, self._grid_at = "", 0.0  # robot whose grid is shown, and when the newest one came
        self._goals: dict[str, tuple[str, Any]] = {}  # by robot: its map, and the goals of that
        self.locating = LocatingWatch(agent.bus, robots, places)
        self._overlays = OverlayWatch(agent.bus, robots.clock)
        self.patrol = PatrolWatch(agent.bus, robots.clock)
        self._people = PeopleWatch(emulator) if emulator is not None else None
        self._grid_body = b""
        self._parts["floor"] = 1, {**floor.to_json(), "cell": settings.cell_m}
        loop = asyncio.get_running_loop()
        self._subscription = agent.bus.subscribe("*/map", partial(hand_over, loop, self._hear_grid))

    async def run(self) -> None:
        """Keep the map up to date until this is cancelled."""
        settings = self._settings
        looking: asyncio.Future[Any] | None = None
        slow_at = look_at = 0.0
        try:
            while True:
                await asyncio.sleep(_LOOK if self._waiting else settings.soonest_s if self._watching else _SLOW)
                now = time.monotonic()
                if now - slow_at >= _SLOW:
                    slow_at = now
                    await self._step(self._look_slowly)
                if not self._watching:
                    continue
                if self._waiting:
                    await self._renew()
                if self._may_ask and now - look_at >= settings.look_s and (looking is None or looking.done()):
                    look_at = now
                    looking = asyncio.ensure_future(self._step(self._ask_navigations))
        finally:
            self._subscription.close()
            self.locating.close()
            self._overlays.close()
            self.patrol.close()

    async def serve(self, browser: WebSocket, is_open: Callable[[], bool]) -> None:
        """Answer the requests of one browser until it ends.

        Args:
            browser: The websocket.
            is_open: Whether its page is.
        """
        await browser.accept()
        sent = _Sent()
        self._watching += 1
        try:
            while is_open():
                await browser.receive_text()
                begun = time.monotonic()
                await self._renew()
                if self._number <= sent.number:
                    self._waiting += 1
                    try:
                        with suppress(TimeoutError):  # the reply tells that nothing has moved
                            async with asyncio.timeout(self._settings.wait_s):
                                await self._moved.wait()
                    finally:
                        self._waiting -= 1
                await browser.send_bytes(self._reply(sent, time.monotonic() - begun))
            await browser.close(4001, "this page is not known; load it again")
        except (WebSocketDisconnect, RuntimeError):  # RuntimeError: it was closed while a reply was awaited
            return
        finally:
            self._watching -= 1

    async def _renew(self) -> None:
        """Encode what is new, unless that was done a moment ago: browsers get what is new when they ask."""
        now = time.monotonic()
        if now - self._encoded_at >= self._settings.soonest_s:
            await self._step(self._encode)

    async def _step(self, action: Callable[[], Awaitable[None]]) -> None:
        """Do one step; an error in it is reported, and the map goes on."""
        try:
            await action()
        except Exception as err:  # a message of a foreign program may hold anything
            self._agent.home.report(self._agent.name, "the map", err)

    def _reply(self, sent: _Sent, waited: float) -> bytes:
        head: dict[str, Any] = {"waited": round(waited, 4), "names": self._names}
        for name, (version, content) in self._parts.items():
            if sent.versions.get(name) != version:
                sent.versions[name] = version
                head[name] = content
        if sent.trails != self._trails_begun:
            sent.trails = self._trails_begun
            trails = {robot.name: list(robot.trail) for robot in self._robots.robots.values()}
            head["trails"] = {
                name: [round(value * 1000.0) for point in trail for value in point] for name, trail in trails.items()
            }
        body, bodies = self._live, [self._live]
        cells = self._new_cells(sent)
        head["cells"] = {name: len(new) for name, new in cells.items()}
        bodies += [np.ascontiguousarray(new, "<i2").tobytes() for new in cells.values()]
        if "grid" in head:
            bodies.append(self._grid_body)
        head["live"] = len(body)
        sent.number = max(self._number, 1)
        return framed(head, b"".join(bodies))

    def _new_cells(self, sent: _Sent) -> dict[str, Any]:
        new = {}
        for name, seen in self._cells.items():
            have = sent.cells.get(name, 0)
            if have < len(seen.cells):
                new[name] = seen.cells[have:]
                sent.cells[name] = len(seen.cells)
        return new

    @property
    def _names(self) -> list[str]:
        return self._robots.names

    async def _encode(self) -> None:
        """Encode poses and ranges, if there are new ones."""
        now = self._robots.clock()
        topics = (keys.ODOM, keys.SONAR, keys.SCAN)
        robots = [(number, self._robots.robots[name]) for number, name in enumerate(self._names)]
        present = [(number, robot) for number, robot in robots if robot.is_there]
        for _, robot in present:
            for topic in topics:
                if topic is keys.ODOM or (topic.suffix in ("sonar", "scan") and _has(robot, topic.suffix)):
                    self._robots.reading(robot.name, topic)
        seen = (
            self._robots.trails_begun,
            *(
                robot.readings[topic.suffix].number if topic.suffix in robot.readings else -1
                for _, robot in present
                for topic in topics
            ),
        )
        if seen == self._seen:
            return
        self._seen, self._trails_begun = seen, seen[0]
        self._encoded_at = time.monotonic()
        self._live = b"".join(self._record(number, robot, now) for number, robot in present)
        self._tell()

    def _record(self, number: int, robot: WatchedRobot, now: float) -> bytes:
        odom = robot.newest(keys.ODOM)
        if odom is None:
            return b""
        discs = disc_count(robot)
        version, picture = self._sonar.get(robot.name) or (-1, SonarPicture(discs))
        if len(picture.ranges(now)) != discs:
            version, picture = -1, SonarPicture(discs)
        sonar = robot.readings.get(keys.SONAR.suffix)
        if sonar is not None and sonar.number != version and (message := sonar.message) is not None:
            version = sonar.number
            picture.hear(message, now)
        self._sonar[robot.name] = version, picture
        scan = robot.readings.get(keys.SCAN.suffix)
        beams = np.zeros(0, np.uint16)
        if scan is not None and scan.age(now) < 1.0 and (message := scan.message) is not None:
            beams = ranges_mm(message.ranges)
        return robot_record(number, odom, stamp_ns(odom.header) / NS_PER_S, picture.ranges(now), beams)

    def _tell(self) -> None:
        self._number += 1
        self._moved.set()
        self._moved = asyncio.Event()

    async def _look_slowly(self) -> None:
        """Look at layout, frames and what lasers have seen."""
        robots = self._robots.robots
        if self._emulator is not None:
            await self.places.ask(self._emulator, robots, time.monotonic(), is_watched=bool(self._watching))
        if self._people is not None and self._watching:
            await self._people.look(time.monotonic())
        self.locating.look()
        layout = [
            robot_layout(robots[name], self.places.of(name), standing(robots[name])) for name in self._robots.names
        ]
        is_new = self._note("robots", layout)
        is_new |= self._note("frames", self.places.words(robots))
        is_new |= self._note("located", self.locating.located)
        is_new |= self._note("goals", self.goals)
        is_new |= self._note("overlays", self._overlays.overlays)
        is_new |= self._note("people", self._people.places if self._people is not None else [])
        patrol = self.patrol.patrol
        is_new |= self._note("patrol", patrol.layout(self.places) if patrol is not None else {})
        if self._recorded_missions is not None:
            found = self._recorded_missions()
            self.missions = {robot: {**told, "goal": self._goal_in_odom(robot, told)} for robot, told in found.items()}
            is_new |= self._note("missions", self.missions)
        if not self._floor.is_known:
            for robot in robots.values():
                self._add_cells(robot)
        if is_new:
            self._tell()

    def _goal_in_odom(self, robot: str, mission: Mapping[str, Any]) -> list[float | None] | None:
        """Return the goal of a recorded mission, x, y and heading or None; None if its place is not known."""
        goal: list[Any] | None = mission["goal"]  # of JSON
        odom = self.places.of(robot)
        if goal is None or mission["frame"] == "odom":
            return goal
        if odom is None:
            return None
        x, y, heading = goal
        there = self.places.map_of(robot).compose(Pose2D(x, y, heading or 0.0)).relative_to(odom)
        return [there.x, there.y, None if heading is None else there.heading]

    def _note(self, name: str, content: Any) -> bool:
        """Note what changes seldom; return whether it has changed."""
        version, before = self._parts.get(name, (0, None))
        if before == content:
            return False
        self._parts[name] = version + 1, content
        return True

    def _add_cells(self, robot: WatchedRobot) -> None:
        mount, pose = laser_mount(robot), robot.pose
        if mount is None or pose is None or not robot.is_there:
            return
        reading = self._robots.reading(robot.name, keys.SCAN)
        if reading.number == self._cells_of.get(robot.name) or (scan := reading.message) is None:
            return
        self._cells_of[robot.name] = reading.number
        settings = self._settings
        seen = self._cells.setdefault(robot.name, SeenCells(settings.cell_m, settings.most_cells))
        seen.add(scan, Pose2D(*pose), mount)

    async def _ask_navigations(self) -> None:
        """Ask the navigations of robots what they do."""
        known = {name.platform for name in self._directory.names if name.local == _NAVIGATION}
        answers = await asyncio.gather(
            *(self._agent.request(f"{_NAVIGATION}@{robot}", "picture", reply_within=1.5) for robot in sorted(known))
        )
        await self._ask_goals()
        missions = {
            robot: mission_layout(answer.result)
            for robot, answer in zip(sorted(known), answers, strict=True)
            if answer.is_done and isinstance(answer.result, Mapping)
        }
        self.missions = missions
        if self._note("missions", missions):
            self._tell()

    async def _ask_goals(self) -> None:
        """Ask for the goals of maps on which robots are localized, once for each map."""
        for robot in self.locating.located:
            file = self.locating.map_name(robot)
            if self._goals.get(robot, ("",))[0] != file and file != BUILT:
                answer = await self._agent.request(f"{LOCALIZATION}@{robot}", "goals", reply_within=1.5)
                if answer.is_done:
                    self._goals[robot] = file, answer.result

    @property
    def goals(self) -> dict[str, list[dict[str, Any]]]:
        """The named goals of the maps on which robots are localized, by robot."""
        return {
            robot: named_goals(told, self.places.map_of(robot))
            for robot, (file, told) in self._goals.items()
            if file == self.locating.map_name(robot)
        }

    def _hear_grid(self, sample: Sample) -> None:
        """Take an OccupancyGrid; the newest one is shown."""
        try:
            grid = sample.decoded()
            info, data = grid.info, np.asarray(grid.data, np.int8)
            origin = info.origin
            shape: dict[str, Any] = {
                "robot": keys.split(sample.key)[0],
                "width": int(info.width),
                "height": int(info.height),
                "resolution": float(info.resolution),
                "origin": [float(origin.position.x), float(origin.position.y), float(heading(origin.orientation))],
                "in_odom": str(grid.header.frame_id).endswith("/odom"),
            }
        except Exception as err:  # not a grid, or one that is damaged
            self._agent.home.report(self._agent.name, f"what comes on {sample.key}", err)
            return
        if shape["width"] * shape["height"] != data.size or data.size > _MOST_GRID or not shape["resolution"] > 0.0:
            return
        robot, now = shape["robot"], time.monotonic()
        if robot != self._grid_of and now - self._grid_at < _GRID_OLD and not self.locating.is_building(robot):
            return  # two maps in turns would flicker; one that is being built is shown in any case
        self._grid_of, self._grid_at = robot, now
        self._grid_body = zlib.compress(data.tobytes(), 3)
        version, _ = self._parts.get("grid", (0, None))
        self._parts["grid"] = version + 1, {**shape, "bytes": len(self._grid_body)}
        self._tell()


def _has(robot: WatchedRobot, suffix: str) -> bool:
    return ("laser" if suffix == keys.SCAN.suffix else "sonar") in robot.elements


def encoded_goal(place: Pose2D | None, x: float, y: float, heading: float | None) -> dict[str, float]:
    """Return a goal on the map as the navigation takes it, in odom.

    Args:
        place: Of the robot's frame odom on the map; None for the same frame.
        x: m.
        y: m.
        heading: rad; None for any.
    """
    frame = place or Pose2D()
    there = Pose2D(x, y, heading or 0.0).relative_to(frame)
    goal = {"x": round(there.x, 3), "y": round(there.y, 3)}
    return goal if heading is None else {**goal, "heading": round(there.heading, 4)}
