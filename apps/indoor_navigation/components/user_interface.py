"""The component for people: it takes missions and reports their state; no mission is lost when planning restarts."""

import asyncio
from collections import Counter, deque
from collections.abc import AsyncIterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from math import isfinite
from typing import Any

from agents.platform import AgentName, agree, request, subscription
from apps.indoor_navigation.algorithms.planning.frames import MAP, ODOM
from apps.indoor_navigation.component import Component, Role, is_told
from apps.indoor_navigation.data import LEAST_TOLERANCE, GoalPoint, LogMessage
from bus import BusUnavailable, Refused

ENDED = ("done", "failed", "cancelled", "replaced")
SIGHT_TIMEOUT, SIGHT_PERIOD = 0.8, 0.1  # s for path planning to see something when it was asleep, and between queries
MAP_TIMEOUT = 4.0  # s for the localization to find a goal of the map
MESSAGE_TIMEOUT = 2.0  # s after the end of a mission for the last messages about it


@dataclass(frozen=True, slots=True)
class _InterfaceParameters:
    """look: s between two queries for the state of the mission. log: number of messages that are kept."""

    look: float
    log: int


class UserInterface(Component):
    """Answers requests of people's programs: `go`, `wait`, `state`, `picture`, `cancel`, `messages`.

    Subscription: `log`.
    """

    role = Role.DELIBERATIVE
    services = ("missions",)
    tells = (GoalPoint,)
    parameters_type = _InterfaceParameters

    async def setup(self) -> None:
        """Begin without a mission."""
        self._log: deque[tuple[int, LogMessage]] = deque(maxlen=self.parameters.log)
        self._logged = 0
        self._heard: Counter[str] = Counter()  # messages of path planning, by mission
        self._is_news = asyncio.Condition()
        self._goal: GoalPoint | None = None
        self._missions = 0
        self._ended: dict[str, dict[str, Any]] = {}
        self._is_planner_missed = False
        self._other: str | None = None  # mission that path planning named at the last look, if not the one sent to it
        self.every(self.parameters.look, self._look)

    @request("go", agrees_itself=True)
    async def go(
        self,
        x: Any = None,
        y: Any = None,
        heading: Any = None,
        tolerance: float = 0.25,
        place: str = "",
        frame: str = "odom",
    ) -> dict[str, Any]:
        """Send the robot to a place, and return the name of the mission; it replaces the one before.

        x, y: m. heading: at the end, rad; None for any. tolerance: m, at least 0.1. place: name of a goal of the map,
        instead of x and y. frame: of x, y and heading, `odom` or `map`. Places of the map need a robot that is
        localized, and are refused in walls and forbidden areas.
        """
        wanted = {"x": x, "y": y, "heading": heading, "tolerance": tolerance}
        if place:
            wanted = {"heading": heading, "tolerance": tolerance}
            if x is not None or y is not None:
                raise Refused("give a place, or x and y, not both")
        for name, value in wanted.items():
            is_number = isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
            if not is_number and not (name == "heading" and value is None):
                raise Refused(f"{name} must be a number, not {value!r}")
        if tolerance < LEAST_TOLERANCE:
            raise Refused(f"tolerance must be at least {LEAST_TOLERANCE:g} m, not {tolerance:g}")
        if frame not in (ODOM, MAP):
            raise Refused(f"frame must be {ODOM!r} or {MAP!r}, not {frame!r}")
        if place or frame == MAP:
            x, y, heading = await self._on_map(place, x, y, heading)
            frame = MAP
        agree()
        if self._goal is not None:
            self._end(self._goal.mission, "replaced", "another mission was begun")
        self._missions += 1
        self._goal = GoalPoint(f"m{int(self.home.wall_time())}-{self._missions}", x, y, heading, tolerance, frame)
        self._other = None
        self.work()
        self.tell(self._goal)
        return {"mission": self._goal.mission}

    async def _on_map(self, place: str, x: Any, y: Any, heading: Any) -> tuple[float, float, float | None]:
        """Return x, y and heading of a goal in map.

        Raises:
            Refused: The robot is not localized, or it cannot be there.
        """
        given = {"place": place, "x": x, "y": y, "heading": heading}
        asked = {name: value for name, value in given.items() if value not in (None, "")}
        outcome = await self.request(AgentName("localization", self.robot), "goal", reply_within=MAP_TIMEOUT, **asked)
        if not outcome.is_done:
            raise Refused(f"the localization gives no goal: {outcome.why}")
        (goal_x, goal_y, goal_heading), is_turned = outcome.result["map"], outcome.result["heading"] is not None
        return goal_x, goal_y, goal_heading if is_turned else None

    @request("cancel")
    async def cancel(self) -> dict[str, Any]:
        """Cancel the active mission, whoever began it; the robot stops."""
        mission = self._goal.mission if self._goal is not None else ""
        self.tell(GoalPoint(mission, None, None))
        if self._goal is not None:
            self._end(mission, "cancelled", "cancelled")
        return {"mission": mission}

    @request("state")
    async def state_of_mission(self) -> dict[str, Any]:
        """Return the mission: mission, state, why, since (s ago), goal, sub_target, travelled (m), pose."""
        return await self._asked("state")

    @request("picture")
    async def picture(self) -> dict[str, Any]:
        """Return the data of a picture of the mission."""
        return await self._asked("picture")

    @request("wait", agrees_itself=True)
    async def wait_for_end(self, mission: str) -> dict[str, Any]:
        """Wait until a mission has ended, and return its state: done, failed, cancelled or replaced.

        `logged` is the stamp of the last message about it, or None. A program that prints the log can end after that
        message.
        """
        if mission not in self._ended and (self._goal is None or self._goal.mission != mission):
            return await self._wait_for_others(mission)
        agree()
        while mission not in self._ended:
            await asyncio.sleep(self.parameters.look)
        ended = self._ended[mission]
        await self._hear_rest(mission, ended.get("messages", 0))
        return {**ended, "logged": self._last_stamp(mission)}

    @request("messages")
    async def messages(self) -> list[dict[str, Any]]:
        """Return the stored messages, oldest first."""
        return [asdict(message) for _, message in self._log]

    @subscription("log")
    async def log(self) -> AsyncIterator[dict[str, Any]]:
        """Yield the stored messages, and then new ones."""
        told = 0
        while True:
            for number, message in list(self._log):
                if number > told:
                    told = number
                    yield asdict(message)
            async with self._is_news:
                if self._logged == told:
                    await self._is_news.wait()

    @is_told(LogMessage)
    async def keep(self, message: LogMessage) -> None:
        """Store a message of a component."""
        self._heard[message.mission] += 1
        await self._note(message)

    async def _look(self) -> None:
        """Query the state of the mission; send the goal again if path planning was restarted and does not know it.

        Path planning has another mission if it names that at two queries in a row: at the first one the goal may still
        be on its way.
        """
        if self._goal is None:
            return
        self.work()
        goal = self._goal
        try:
            told = await self.ask("state")
        except BusUnavailable:
            raise
        except (TimeoutError, Refused) as err:
            if not self._is_planner_missed:
                self._is_planner_missed = True
                await self._say(
                    "warning", f"path planning does not answer: {err}; the mission continues when it answers again"
                )
            return
        self._is_planner_missed = False
        if self._goal is not goal:
            return
        mission = told.get("mission", "")
        before, self._other = self._other, mission if mission != goal.mission else None
        if self._other is None:
            if told.get("state") in ENDED:
                self._goal, self._ended[goal.mission] = None, told
        elif before != self._other:
            return
        elif mission in ("", *self._ended):
            await self._say("warning", "path planning was restarted; the mission is sent again")
            self.tell(goal)
        else:
            self._end(goal.mission, "replaced", f"replaced by {mission} of another client")

    async def _asked(self, what: str) -> dict[str, Any]:
        """Query path planning; where it was asleep, again until it has seen where the robot is now."""
        deadline = asyncio.get_running_loop().time() + SIGHT_TIMEOUT
        try:
            while not (told := await self.ask(what)).pop("is_current", True):
                if asyncio.get_running_loop().time() > deadline:
                    break
                await asyncio.sleep(SIGHT_PERIOD)
            return told
        except TimeoutError as err:
            raise Refused(f"path planning of {self.robot} does not answer; check whether it runs") from err

    async def _wait_for_others(self, mission: str) -> dict[str, Any]:
        """Wait for a mission that began before this component started."""
        told = await self._asked("state")
        if told.get("mission") != mission:
            raise Refused(f"there is no mission {mission!r}; the last one is {told.get('mission')!r}")
        agree()
        while told.get("mission") == mission and told.get("state") not in ENDED:
            await asyncio.sleep(self.parameters.look)
            told = await self._asked("state")
        return told if told.get("mission") == mission else {"mission": mission, "state": "replaced", "why": ""}

    async def _hear_rest(self, mission: str, messages: int) -> None:
        """Wait for the messages about a mission that have not arrived yet."""
        with suppress(TimeoutError):  # a message was lost; the end of the mission is returned anyway
            async with asyncio.timeout(MESSAGE_TIMEOUT), self._is_news:
                await self._is_news.wait_for(lambda: self._heard[mission] >= messages)

    def _last_stamp(self, mission: str) -> float | None:
        return next((message.stamp for _, message in reversed(self._log) if message.mission == mission), None)

    def _end(self, mission: str, state: str, why: str) -> None:
        self._ended[mission] = {"mission": mission, "state": state, "why": why}
        self._goal = None

    async def _say(self, level: str, what: str) -> None:
        mission = self._goal.mission if self._goal is not None else ""
        await self._note(LogMessage(self.home.wall_time(), self.name.local, mission, level, what))

    async def _note(self, message: LogMessage) -> None:
        async with self._is_news:
            self._logged += 1
            self._log.append((self._logged, message))
            self._is_news.notify_all()
