"""Commands the mission: one sub-target after the other to those who move the robot, and what is worth it to people."""

import asyncio
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from agents.platform import Cyclic, Restart
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.mission import Navigator
from apps.indoor_navigation.algorithms.planning.orders import REST, MissionParameters, Order
from apps.indoor_navigation.component import Component, Role, answers_query, hears, is_told
from apps.indoor_navigation.data import DLEData, GoalPoint, LogMessage, ObstRead, WorldCoord
from bus import BusUnavailable, Refused

ASK_AGAIN = 1.0  # s between two tries to learn how wide the robot is
SAME_PLACE, SAME_HEADING = 0.02, 0.02  # m and rad within which an order is the same
MILLISECONDS = 1e3


@dataclass(frozen=True, slots=True)
class _PlanningParameters:
    """How missions are commanded.

    period: s between two steps. repeat: s after which an order is told again, for who was not there or not yet. busy:
    part of its time that the fuser works, above which the robot goes at half speed. half_width: of the robot, m, until
    it has said what it is. doors_file: where doors and ways are kept from one start of this program to the next;
    nothing is kept if it is empty. Such a file is of use where the robot's odometry begins at the same place each time.
    """

    period: float
    repeat: float
    busy: float
    half_width: float
    doors_file: str
    mission: MissionParameters


class PathPlanning(Component):
    """Steps at a fixed rate while a mission is under way."""

    role = Role.DELIBERATIVE
    tells = (WorldCoord, LogMessage)
    parameters_type = _PlanningParameters

    async def setup(self) -> None:
        """Remember the doors, and be ready for a mission."""
        self._navigator = Navigator(self.parameters.mission, self.parameters.half_width)
        self._number = round(self.home.wall_time() * MILLISECONDS)  # higher than any before, though nothing is kept
        self._order, self._told_at = REST, float("-inf")
        self._mission = self._navigator.told()
        self._is_under_way = False
        self._complained: set[str] = set()
        self._file = Path(self.parameters.doors_file) if self.parameters.doors_file else None
        if self._file is not None:
            try:
                self._navigator.memory.doors.read(self._file)
            except ValueError as err:
                self.home.report(self.name, str(err), None)
                self._file = None  # what is there may be dear to somebody
        self.every(self.parameters.period, self._step)
        self.add(Cyclic(self._know_robot), Restart())

    async def take_down(self) -> None:
        """Leave nobody on the way."""
        if self._order.aim != "rest":
            self._tell_order(REST)

    @is_told(GoalPoint)
    async def take_up(self, goal: GoalPoint) -> None:
        """A person wants something."""
        self._navigator.begin(goal, self._now)
        self._is_under_way |= self._navigator.is_active
        self._mission = self._navigator.told()
        await self._step()

    @hears(ObstRead)
    async def see(self, reading: ObstRead) -> None:
        """Something is seen."""
        self._navigator.see(reading, self._now)
        self._mission = self._navigator.told()

    @hears(DLEData)
    async def see_doors(self, data: DLEData) -> None:
        """Doors are seen."""
        self._navigator.see_doors(data)

    @answers_query("state")
    def tell_state(self) -> dict[str, Any]:
        """Where the mission stands. since: s ago. messages: how many LogMessages were sent about it until then.

        It is read on the bus's thread, so it is what the loop noted when it had sent all messages up to this state.
        """
        told = self._mission
        return {**told, "since": self._now - told["since"]}

    @answers_query("picture")
    def draw(self) -> dict[str, Any]:
        """All that there is to draw; `area.undrawn` unpacks the grid."""
        picture = self._navigator.picture()
        return {**picture, "since": self._now - picture["since"]}

    async def _step(self) -> None:
        """Decide what is to be done now, and tell it."""
        if self._navigator.is_active:
            is_slow = await self._is_fuser_busy()
            order = self._navigator.step(self._now)
            self._give(replace(order, speed=order.speed / 2.0) if is_slow else order)
        if not self._navigator.is_active:
            self._give(REST)
            if self._is_under_way:
                self._keep_doors()
        self._is_under_way = self._navigator.is_active
        self._tell_notes()
        self._mission = self._navigator.told()

    def _give(self, order: Order) -> None:
        """Tell an order when it is new, and again while a mission is under way."""
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
        """Ask the fuser how it is before each step; its silence is said once, and stops nobody."""
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
            self._complain("busy", f"the fuser works {load['busy']:.0%} of its time; the robot goes at half speed")
        else:
            self._complained.discard("busy")
        return is_busy

    def _complain(self, what: str, why: str) -> None:
        """Say it once, until it is over."""
        if what not in self._complained:
            self._complained.add(what)
            self._navigator.note("warning", why)

    def _keep_doors(self) -> None:
        """Write down the doors, unless they are of another odometry than those in the file."""
        if self._file is None or self._navigator.memory.has_jumped:
            return
        try:
            self._navigator.memory.doors.write(self._file)
        except OSError as err:
            self._complain("file", f"the doors cannot be kept: {err}; see whether {self._file} may be written")

    async def _know_robot(self) -> None:
        """Learn how wide the robot is, and again now and then, since it may be another one."""
        try:
            self._navigator.memory.outline = Outline.of(await self.ask("robot"))
        except BusUnavailable:
            raise
        except (TimeoutError, Refused, LookupError, TypeError, ValueError):
            pass  # until it has said so, it is taken to be as wide as the numbers say
        await asyncio.sleep(ASK_AGAIN)

    @property
    def _now(self) -> float:
        assert self._loop is not None  # it is asked on the bus's thread too
        return self._loop.time()


def _is_same(one: Order, other: Order) -> bool:
    """Whether nobody would do anything else."""
    if (one.aim, one.is_last, one.speed, one.then) != (other.aim, other.is_last, other.speed, other.then):
        return False
    if one.aim == "turn":
        return abs(one.heading - other.heading) < SAME_HEADING
    return abs(one.x - other.x) < SAME_PLACE and abs(one.y - other.y) < SAME_PLACE
