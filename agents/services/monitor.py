"""The monitor of a team: presence, streams and failures, and the restarts after failures.

It publishes each event at once on its results, `{"time", "what", "about", "level"}`, and once a second the states of
all on `<team>/diagnostics`. Tokens and reports are events of the bus; only the rates are checked periodically, twice a
second.
"""

import asyncio
import threading
from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from typing import Any, ClassVar

from agents.platform import Agent, AgentName, AgentState, NameNotValid, OneShot, every, request
from agents.platform.container.context import AgentEnd
from agents.platform.names import ContainerName
from agents.services.events import SEVERITY, History, Level, Standing
from agents.services.restarts import Restarts
from agents.services.supervision import Supervision
from agents.services.watching import ElementName, RobotName, Watching
from bus import BusError, Refused, Sample, Subscription, keys
from bus.aio import hand_over
from bus.bus import Publisher
from bus.keys import DESCRIPTION, DIAGNOSTICS, STATE, split
from bus.messages import NS_PER_S, DiagnosticArray, DiagnosticStatus, KeyValue, RobotState, header

TOKENS = ("*/alive", "*/agents/*/alive", "*/containers/*/alive", "*/elements/*/alive")
GATHER = 0.01  # s in which tokens that come or go are taken together; a process that dies takes all of its own with it
BEGINNING = 0.5  # s in which it learns the present agents
LOOK = 0.5  # s between two checks of the rates
SETTLE = 0.3  # s after the last change of a robot's elements until its description is read
DESCRIPTION_TIME = 2.0  # s
ATTEMPTS = 5  # to read a description
STEADY = frozenset({keys.ODOM, keys.SONAR, keys.SCAN, keys.BUMPERS, keys.BATTERY, keys.STATE})
"""Streams that flow by themselves as long as their element works. These are watched, and the results of their agents.
Not watched are streams that rest when nothing happens (ptz, arm, gripper, ...) and pictures: whoever listens to a
camera makes it draw and send."""
MANY = 64  # reports or states that wait while one is processed


class Monitor(Agent):
    """Watches robots, containers and agents on the bus, and restarts failed agents of its team.

    Its property `restart` has the rules (`restarts.Restarts`), its property `results` the elements whose agents'
    results are watched beside their robots' streams: by default the base alone, which is enough to see that a container
    has stopped working, since results without subscribers cost nothing.
    """

    services: ClassVar[tuple[str, ...]] = ("monitoring",)

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._lock = threading.Lock()
        self._tokens: list[tuple[str, bool]] = []
        self._watched: dict[str, Subscription] = {}
        self._reading: set[str] = set()  # robots whose descriptions will be read
        self._diagnostics: Publisher | None = None

    async def setup(self) -> None:
        """Start watching.

        Raises:
            ConfigError: The rules cannot be used.
        """
        self._clock = asyncio.get_running_loop().time
        self._history = History(self.publish, self.home.wall_time)
        self._watching = Watching(self._history.tell)
        restarts = Restarts(self.properties.get("restart"), f"the restart rules of {self.name}")
        self._supervision = Supervision(
            self.name.platform, restarts, self._watching.is_there, self.query, self._history.tell, self.add
        )
        self._diagnostics = self.bus.publisher(DIAGNOSTICS.key(self.name.platform), DIAGNOSTICS.type_name)
        self.listen("*/containers/*/reports", self._hear_report, keep=MANY, keyed=True)
        self.listen("*/" + STATE.suffix, self._hear_state, keep=MANY, keyed=True)
        self.listen("*/" + DIAGNOSTICS.suffix, self._hear_diagnostics, keep=MANY, keyed=True)
        loop = asyncio.get_running_loop()
        self._begins_until = self._clock() + BEGINNING
        for expression in TOKENS:
            self._watched[expression] = self.bus.watch_alive(expression, partial(self._take_token, loop))
        self.add(OneShot(self._tell_beginning, "tell who is there"))

    async def take_down(self) -> None:
        """Stop watching."""
        for watched in self._watched.values():
            watched.close()
        if self._diagnostics is not None:
            self._diagnostics.close()

    @request("status")
    async def status(self, robot: str = "") -> dict[str, Any]:
        """How all stand, or one robot with what belongs to it."""
        standings = self._standings(robot)
        return {
            "level": max((each.level for each in standings), key=SEVERITY.__getitem__, default=Level.OK),
            "standings": {standing.about: standing.to_dict() for standing in standings},
            "robots": sorted(self._watching.robots),
            "containers": [str(name) for name in self._watching.containers if robot in ("", name.platform)],
            "agents": [str(name) for name in self._watching.agents if robot in ("", name.platform)],
            "looks_after": self._supervision.under_way,
        }

    @request("events")
    async def events(self, last: int = 50) -> list[dict[str, Any]]:
        """So many of the newest events, oldest first."""
        return [event.to_dict() for event in self._history.last(last)]

    @request("policy")
    async def policy(self, agent: str = "") -> dict[str, Any]:
        """The rules by which agents that fail are started again, or the one for an agent and how often it was."""
        restarts = self._supervision.restarts
        if not agent:
            return {"rules": restarts.rules()}
        try:
            name = AgentName.parse(agent)
        except NameNotValid as err:
            raise Refused(str(err)) from err
        return {"agent": agent, **asdict(restarts.rule_of(name)), "attempted": restarts.attempts(name)}

    @every(LOOK)
    async def look(self) -> None:
        """Check the rates."""
        self._watching.judge(self._clock())

    @every(1.0)
    async def diagnose(self) -> None:
        """Publish the diagnostics."""
        if self._diagnostics is not None:
            status = [_status(self.name.platform, standing) for standing in self._standings("")]
            stamp = header(int(self.home.wall_time() * NS_PER_S), "")
            self._diagnostics.put(DiagnosticArray(header=stamp, status=status))

    def _standings(self, robot: str) -> list[Standing]:
        if robot and robot not in self._watching.robots:
            known = ", ".join(sorted(self._watching.robots)) or "none"
            raise Refused(f"there is no robot {robot!r} at this moment; there are: {known}")
        return self._watching.standings(self._clock(), robot or None)

    # Presence. Tokens come on the bus's thread, and are taken in the loop a moment later, all together.

    def _take_token(self, loop: asyncio.AbstractEventLoop, key: str, is_alive: bool) -> None:
        with self._lock:
            self._tokens.append((key, is_alive))
            is_first = len(self._tokens) == 1
        if is_first:
            hand_over(loop, loop.call_later, GATHER, self._follow_tokens)

    async def _tell_beginning(self) -> None:
        await asyncio.sleep(BEGINNING)
        self._history.tell(self.name, f"{self.name} watches {self._watching.population()}")

    def _follow_tokens(self) -> None:
        if self.state is AgentState.DELETED:
            return  # it has just been stopped
        with self._lock:
            tokens, self._tokens = self._tokens, []
        for name, is_alive in self._watching.changed(tokens, self._clock() < self._begins_until):
            match name:
                case ContainerName() if is_alive:
                    self._supervision.container_came(name)
                case ContainerName():
                    self._supervision.container_gone(name)
                case RobotName() | ElementName() if name.robot in self._watching.robots:
                    self._read_description_soon(name.robot)
                case RobotName():
                    self._watch_streams(name.robot, {})

    async def _hear_report(self, key: str, report: dict[str, Any]) -> None:
        container = ContainerName.of_key(key)
        match report:
            case {"agent": None, "ended": str(how)}:
                self._watching.ended(container, how)
            case {"agent": str(agent), "ended": AgentEnd.FAILED | AgentEnd.NOT_SET_UP}:
                self._supervision.agent_failed(AgentName.parse(agent), container, report)
            case {"agent": str(agent), "ended": str(how)}:
                self._watching.ended(AgentName.parse(agent), how)
            case {"agent": str(agent), "what": str(what), **rest}:
                self._watching.complained(agent, what, rest.get("error"))

    # Robots.

    async def _hear_state(self, key: str, state: Any) -> None:
        if isinstance(state, RobotState):
            self._watching.state(split(key)[0], state)

    async def _hear_diagnostics(self, key: str, array: Any) -> None:
        if isinstance(array, DiagnosticArray) and split(key)[0] != self.name.platform:
            self._watching.diagnosed(array)

    def _read_description_soon(self, robot: str) -> None:
        if robot not in self._reading:
            self._reading.add(robot)
            self.add(OneShot(partial(self._read_description, robot), f"read the description of {robot}"))

    async def _read_description(self, robot: str) -> None:
        """Read the robot's steady streams from its description; elements may still appear."""
        for attempt in range(ATTEMPTS):
            await asyncio.sleep(SETTLE * 2.0**attempt)
            self._reading.discard(robot)  # later changes are not in this answer
            try:
                description = await self.query(DESCRIPTION.key(robot), None, DESCRIPTION_TIME)
            except (BusError, TimeoutError):
                continue  # the query is repeated
            if robot in self._watching.robots:
                self._watch_streams(robot, self._steady(robot, description))
            return

    def _steady(self, robot: str, description: Mapping[str, Any]) -> dict[str, float | None]:
        """Return the streams to watch."""
        listed = self.properties.get("results", ["base"])
        results = {AgentName(element, robot).results_key for element in listed}
        steady = _steady_streams(robot, description)
        return {key: rate for key, rate in steady.items() if not split(key)[1].startswith("agents/") or key in results}

    def _watch_streams(self, robot: str, wanted: Mapping[str, float | None]) -> None:
        """Watch exactly these streams of a robot."""
        streams = self._watching.streams
        for key in [key for key in streams.keys if split(key)[0] == robot and key not in wanted]:
            self._watched.pop(key).close()
            streams.ignore(key)
        for key, declared in wanted.items():
            if key not in self._watched:
                streams.watch(key, self._clock(), declared)
                self._watched[key] = self.bus.subscribe(key, self._beat, urgent=True)

    def _beat(self, sample: Sample) -> None:
        """Count a sample, on the bus's thread."""
        self._watching.streams.beat(sample.key, self._clock())


def _steady_streams(robot: str, description: Mapping[str, Any]) -> dict[str, float | None]:
    """Return the keys of a robot's steady streams by its description, each with its rate in Hz if it is known."""
    found: dict[str, float | None] = {}
    elements = description.get("elements")
    for element in elements if isinstance(elements, list) else []:
        match element:
            case {"name": str(name), "streams": list(streams)}:
                steady = [key for key in streams if isinstance(key, str) and keys.topic_of(key) in STEADY]
            case _:
                continue  # not an element as gateways describe them
        rate = element.get("rate")
        declared = float(rate) if isinstance(rate, int | float) and rate > 0 else None
        if steady:
            found |= dict.fromkeys([*steady, AgentName(name, robot).results_key], declared)
    return found


def _status(team: str, standing: Standing) -> DiagnosticStatus:
    """Return the status of one subject as a message; its name is `<team>: <about>`."""
    return DiagnosticStatus(
        level=SEVERITY[standing.level],
        name=f"{team}: {standing.about}",
        message=standing.what,
        hardware_id="",
        values=[KeyValue(key=key, value=str(value)) for key, value in standing.values.items()],
    )
