"""The component that carries out missions: it sends pieces of plans to goto and orienting, and messages to people."""

import asyncio
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from agents.platform import AgentName, Cyclic, RequestNotDone, Restart
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.doors_map import thinned
from apps.indoor_navigation.algorithms.planning.floor import FloorMap
from apps.indoor_navigation.algorithms.planning.mission import MapFix, Navigator
from apps.indoor_navigation.algorithms.planning.orders import REST, MissionParameters, Order
from apps.indoor_navigation.component import Component, Role, answers_query, hears, is_told
from apps.indoor_navigation.components.embodied import QUERY_PERIOD
from apps.indoor_navigation.components.passage_leases import PassageLeases
from apps.indoor_navigation.data import (
    DIGITS,
    DLEData,
    GoalPoint,
    LogMessage,
    ObstRead,
    PlannedWay,
    WayRequest,
    WorldCoord,
)
from bus import BusUnavailable, Refused
from geometry import Pose2D

SAME_PLACE, SAME_HEADING = 0.02, 0.02  # m and rad within which an order is not sent again
MILLISECONDS = 1e3
MAP_TIMEOUT, MAP_RETRY = 10.0, 2.0  # s for the map to come, and between two requests for it
SHOWN_PERIOD, SHOWN_SPACING = 0.5, 0.15  # s between two plans for people, and m between two of their places
SILENT = 3.0  # s without a result of the localization after which it counts as ended


@dataclass(frozen=True, slots=True)
class _PlanningParameters:
    """Timing of the component, and the parameters of missions.

    period: s between two steps. repeat: s after which an order is sent again, for components that did not receive it.
    busy: load of the fuser above which the robot drives at half speed. half_width: of the robot, m, until the base has
    described it. doors_file: file for doors and ways, read at the next start; empty for none. Such a file is useful
    where the robot's odometry begins at the same place each time.
    """

    period: float
    repeat: float
    busy: float
    half_width: float
    doors_file: str
    mission: MissionParameters


class PathPlanning(Component):
    """Carries out one mission after the other, in steps at a fixed rate."""

    role = Role.DELIBERATIVE
    gives = (PlannedWay,)
    tells = (WorldCoord, LogMessage)
    may_tell = (WayRequest,)  # not in wiring files for older versions, nor for a robot that has no sound
    parameters_type = _PlanningParameters
    is_pulled = False  # whoever watches its plans wakes nobody

    async def setup(self) -> None:
        """Read the doors, and wait for a mission."""
        self._navigator = Navigator(self.parameters.mission, self.parameters.half_width)
        self._number = round(self.home.wall_time() * MILLISECONDS)  # higher than before a restart, without a file
        self._order, self._told_at = REST, float("-inf")
        self._mission = self._navigator.status()
        self._is_under_way = False
        self._shown_at = float("-inf")
        self._sees = False  # whether a reading has been received since this component woke up
        self._complained: set[str] = set()
        self._file = Path(self.parameters.doors_file) if self.parameters.doors_file else None
        if self._file is not None:
            try:
                self._navigator.memory.doors.read(self._file)
            except ValueError as err:
                self.home.report(self.name, str(err), None)
                self._file = None  # the file is not overwritten
        self._localization = AgentName("localization", self.robot)
        self._floor: FloorMap | None = None
        self._map_number: Any = None  # of the localization whose map that is
        self._map_at = self._fix_at = float("-inf")
        self.listen_awake(self._localization.results_key, self._hear_localization)
        self._passages = PassageLeases(self)
        self.every(self.parameters.period, self._step)
        self.add(Cyclic(self._know_robot), Restart())

    def woken(self, slept: float) -> None:
        """Wait for a reading: the robot may have been pushed."""
        self._sees, self._fix_at = False, self._now

    async def take_down(self) -> None:
        """Stop the robot."""
        if self._order.aim != "rest":
            self._tell_order(REST)

    @is_told(GoalPoint)
    async def take_up(self, goal: GoalPoint) -> None:
        """Begin or cancel a mission."""
        self.work()
        if not self._sees:
            self._tell_order(self._order)  # wakes goto and orienting while the first reading is on its way
        self._navigator.begin(goal, self._now)
        self._is_under_way |= self._navigator.is_active
        self._mission = self._navigator.status()
        await self._step()

    @hears(ObstRead)
    async def see(self, reading: ObstRead) -> None:
        """Take a reading of obstacles; after a sleep, begin to drive at once."""
        is_first, self._sees = not self._sees, True
        self._navigator.see(reading, self._now)
        self._mission = self._navigator.status()
        if is_first and self._navigator.is_active:
            await self._step()

    @hears(DLEData)
    async def see_doors(self, data: DLEData) -> None:
        """Take the doors of a scan."""
        self._navigator.see_doors(data)

    @answers_query("state")
    def tell_state(self) -> dict[str, Any]:
        """Return the state of the mission. since: s ago. messages: number of LogMessages that were sent about it.
        is_current: whether the pose is that of a reading since this component woke up.

        This runs on the thread of the bus, so it returns what the event loop stored after it had sent these messages.
        """
        told = self._mission
        return {**told, "since": self._now - told["since"], "is_current": self._is_current}

    @answers_query("picture")
    def draw(self) -> dict[str, Any]:
        """Return the data of a picture; `area.undrawn` unpacks the grid."""
        picture = self._navigator.picture()
        return {**picture, "since": self._now - picture["since"], "is_current": self._is_current}

    async def _hear_localization(self, told: dict[str, Any]) -> None:
        """Take what the localization knows; get its map first."""
        self._fix_at = self._now
        try:
            place, number = told["odom_in_map"], told.get("started")
            is_known = told["state"] == "localized" and place is not None
            odom = Pose2D(*map(float, place)) if is_known else None
        except (LookupError, TypeError, ValueError) as err:
            self._complain("localization", f"the localization sent an invalid result: {err!r}")
            return
        if odom is not None and number != self._map_number:
            if self._now - self._map_at < MAP_RETRY:
                return
            self._map_at = self._now
            await self._get_map(number)
        floor = self._floor if number == self._map_number else None
        self._localize(MapFix(odom, floor, str(told.get("reason") or "its map has not come yet")))

    async def _get_map(self, number: Any) -> None:
        """Request the map of the localization."""
        try:
            told = (await self.request(self._localization, "floor", reply_within=MAP_TIMEOUT)).value()
            floor = FloorMap.of_json(told)
        except BusUnavailable:  # the container ends this component, and tells why
            raise
        except (RequestNotDone, ValueError) as err:
            self._complain("map", f"the map does not come: {err}; continues by the sensors alone")
            return
        self._complained.discard("map")
        self._floor, self._map_number = floor, number

    def _localize(self, fix: MapFix | None) -> None:
        self._navigator.localize(fix, self._now)
        self._mission = self._navigator.status()

    def _mind_silence(self) -> None:
        """Continue by odometry on a mission on the map when the localization is silent; otherwise without the map."""
        if self._now - self._fix_at <= SILENT:
            self._complained.discard("silence")
        elif self._navigator.is_active and self._navigator.status()["on_map"] is not None:
            self._complain("silence", "the localization is silent; the robot continues by its odometry")
        else:
            self._localize(None)

    async def _step(self) -> None:
        """Decide on the order of this step, and send it."""
        self._mind_silence()
        if self._navigator.is_active:
            self.work()
            if not self._sees and self._now - self.woke_at < self.parameters.mission.silence:
                return  # it has just woken up
            is_slow = await self._is_fuser_busy()
            rights = self._navigator.rights
            rights.grant(self._passages.granted, self._passages.holders)
            order = self._navigator.step(self._now)
            self._passages.need(rights.needed, self._now)
            self._give(replace(order, speed=order.speed / 2.0) if is_slow else order)
            if self._navigator.take_way_request():
                self.tell(WayRequest(self.home.wall_time(), self._navigator.status()["mission"]))
        if not self._navigator.is_active:
            self._give(REST)
            self._passages.need((), self._now)
            if self._is_under_way:
                self._keep_doors()
        self._show(has_ended=self._is_under_way and not self._navigator.is_active)
        self._is_under_way = self._navigator.is_active
        self._tell_notes()
        self._mission = self._navigator.status()

    def _show(self, *, has_ended: bool) -> None:
        """Push the plan for people, such as a recorder: now and then during a mission, and once after it."""
        is_due = self._navigator.is_active and self._now - self._shown_at >= SHOWN_PERIOD
        if not (is_due or has_ended) or not self.is_watched(PlannedWay):
            return
        self._shown_at = self._now
        way = thinned(self._navigator.route(), SHOWN_SPACING)
        route = tuple(round(value, DIGITS) for place in way for value in place)
        mission = self._navigator.status()["mission"]
        self.push(PlannedWay(self.home.wall_time(), mission, route, tuple(self._navigator.doors())))

    def _give(self, order: Order) -> None:
        """Send a new order, and repeat it while a mission is active."""
        is_new = not _is_same(order, self._order)
        is_due = self._navigator.is_active and self._now - self._told_at >= self.parameters.repeat
        if is_new or is_due:
            self._tell_order(order if is_new else self._order)

    def _tell_order(self, order: Order) -> None:
        if order is not self._order:
            self._number += 1
        self._order, self._told_at = order, self._now
        stamp = self.home.wall_time()
        self.tell(WorldCoord(stamp, self._number, **asdict(order)))

    def _tell_notes(self) -> None:
        notes = self._navigator.notes
        while notes:
            note = notes.popleft()
            self.tell(LogMessage(self.home.wall_time(), self.name.local, note.mission, note.level, note.what))

    async def _is_fuser_busy(self) -> bool:
        """Return whether the fuser's load is high; its silence is reported once, and does not stop the mission."""
        try:
            load = await self.ask("load")
            is_busy = bool(load["busy"] > self.parameters.busy)
        except BusUnavailable:
            raise
        except (TimeoutError, Refused, LookupError, TypeError, ValueError) as err:
            self._complain("fuser", f"the fuser does not say how it is: {err}; the robot stands if it is not there")
            return False
        self._complained.discard("fuser")
        if is_busy:
            self._complain("busy", f"the fuser is busy {load['busy']:.0%} of its time; the robot drives at half speed")
        else:
            self._complained.discard("busy")
        return is_busy

    def _complain(self, what: str, why: str) -> None:
        """Add a warning once, until its reason is gone."""
        if what not in self._complained:
            self._complained.add(what)
            self._navigator.note("warning", why)

    def _keep_doors(self) -> None:
        """Write the doors to the file, unless odom was set anew since the file was read."""
        if self._file is None or self._navigator.memory.has_jumped:
            return
        try:
            self._navigator.memory.doors.write(self._file)
        except OSError as err:
            self._complain("file", f"the doors cannot be saved: {err}; check whether {self._file} is writable")

    async def _know_robot(self) -> None:
        """Query the outline of the robot periodically, because the robot may be replaced."""
        await self.awake()
        try:
            self._navigator.memory.outline = Outline.of(await self.ask("robot"))
        except BusUnavailable:
            raise
        except (TimeoutError, Refused, LookupError, TypeError, ValueError):
            pass  # until the base answers, the robot has the half width of the parameters
        await asyncio.sleep(QUERY_PERIOD)

    @property
    def _is_current(self) -> bool:
        return self.is_awake and self._sees

    @property
    def _now(self) -> float:
        assert self._loop is not None  # it is asked on the bus's thread too
        return self._loop.time()


def _is_same(one: Order, other: Order) -> bool:
    """Return whether two orders lead to the same motion."""
    if (one.aim, one.is_last, one.speed, one.path) != (other.aim, other.is_last, other.speed, other.path):
        return False
    if one.aim == "turn":
        return abs(one.heading - other.heading) < SAME_HEADING
    return abs(one.x - other.x) < SAME_PLACE and abs(one.y - other.y) < SAME_PLACE
