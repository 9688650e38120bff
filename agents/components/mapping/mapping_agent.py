"""The agent that builds a map of the building while its robot is driven, by whomever.

It subscribes to odometry and sensors only between `start` and `stop`. The work is done in a thread of its own, in
batches; readings that the thread cannot keep up with are left out, odometry is not.
"""

import asyncio
import base64
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from agents.components.component import ElementAgent, failure
from agents.platform import AgentName, request
from bus import Publisher, Refused, Sample, Subscription, keys
from bus.aio import query
from bus.messages import NS_PER_S
from geometry import MapError, Pose2D

if TYPE_CHECKING:  # it loads the algorithms
    from agents.components.mapping.mapping_tools import MapWork
    from maps.building_map import BuildingMap

T = TypeVar("T")

PERIOD = 0.25
"""Seconds between two batches."""
MOST_ODOMETRY, MOST_READINGS = 3000, 100
"""Messages kept between two batches; of more readings the oldest are left out, which odometry bridges."""
DESCRIPTION_TIME = 2.0  # s for the gateway to describe the robot
LOCALIZATION_TIME = 2.0  # s for the localization to tell its state
MOST_CONTENT = 6_000_000
"""Bytes of a map's files that are sent in one reply."""


class MappingAgent(ElementAgent):
    """`mapping@happy`: builds a map from the robot's laser, or sonar if it has none. The map has the frame `map`.

    Its origin is where the robot stood at the start, unless a map is extended.
    """

    services = ("mapping",)
    results: ClassVar[Mapping[str, str]] = {
        "building": "whether a map is being built",
        "scans": "scans used so far",
        "key_scans": "scans that make up the map",
        "loops": "loops closed",
        "driven": "m driven meanwhile",
        "pose": "m, m, rad: the robot in map",
        "odom": "m, m, rad: the frame odom in map",
        "trouble": "why nothing is added; null if nothing is wrong",
    }

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._worker = ThreadPoolExecutor(1, thread_name_prefix=str(self.name))
        self._work: MapWork | None = None  # used by the thread alone
        # The bus's thread appends.
        self._odometry: deque[Sample] = deque(maxlen=MOST_ODOMETRY)
        self._readings: deque[Sample] = deque(maxlen=MOST_READINGS)
        self._hearing: list[Subscription] = []
        self._starting: object | None = None  # the start that is under way
        self._published: Publisher | None = None
        self._published_at = 0.0
        self._trouble: str | None = None
        self._has_changed = False
        self._heard_at = 0.0
        self._figures: dict[str, Any] = {}

    @classmethod
    def properties_of(cls, robot: Mapping[str, Any], element: Mapping[str, Any]) -> dict[str, Any]:
        """Return the robot's kind; where its sensors are is queried when a map is begun."""
        return {
            "robot_model": robot.get("model"),
            "robot_class": robot.get("class"),
            "emulated": robot.get("emulated"),
        }

    def describe(self) -> dict[str, Any]:
        """Return its description; it is not the agent of an element."""
        described = super().describe()
        return {**described, "services": [each for each in described["services"] if each != "component"]}

    async def setup(self) -> None:
        """Prepare, without the sensors."""
        await super().setup()
        self.every(PERIOD, self._work_off)

    async def take_down(self) -> None:
        """Give up the sensors and the work."""
        self._give_up()
        self._worker.shutdown(wait=False, cancel_futures=True)
        if self._published is not None:
            self._published.close()

    @request("start")
    async def start(
        self, extend: str = "", x: float | None = None, y: float | None = None, heading: float | None = None
    ) -> dict[str, Any]:
        """Begin a map; one that was built before is forgotten.

        extend: file of a map that is extended, .map or .yaml, on the machine of this agent. x, y, heading: where the
        robot is in that map, about; by default its RobotHome, or its origin.
        """
        if self._hearing or self._starting is not None:
            raise Refused(f"{self.name} is building a map; ask it to stop first")
        given = (x, y, heading)
        if any(each is not None for each in given) and (x is None or y is None):
            raise Refused("a start needs x and y, m; heading, rad, is 0 where it is not given")
        start = None if x is None or y is None else Pose2D(x, y, heading or 0.0)
        self._starting = starting = object()
        try:
            await self._check_localization()
            description = await self._description()
            work = await self._in_thread(lambda: _begun(description, extend, start))
            if starting is not self._starting:
                raise failure(f"{self.name} was stopped while it began the map")
        finally:
            if starting is self._starting:
                self._starting = None
        self._work = work
        self._trouble, self._figures, self._has_changed = None, {}, False
        self._heard_at = asyncio.get_running_loop().time()
        self._odometry.clear()
        self._readings.clear()
        source = keys.SCAN if self._work.has_laser else keys.SONAR
        self._hearing = [
            self.bus.subscribe(keys.ODOM.key(self.robot), self._odometry.append, urgent=True),
            self.bus.subscribe(source.key(self.robot), self._readings.append, urgent=True),
        ]
        return self._state()

    @request("state")
    async def tell_state(self) -> dict[str, Any]:
        """Whether a map is being built, and how far it is."""
        return self._state()

    @request("stop")
    async def end(self, refine: bool = True) -> dict[str, Any]:
        """Stop listening, and improve the map by all that was seen; it is kept until the next start.

        A start that is under way fails, and the map before it is kept.
        """
        if self._starting is not None:
            self._give_up()
            return self._state()
        work = self._existing()
        await self._work_off()
        self._give_up()
        if refine:
            await self._in_thread(work.refine)
            self._figures = await self._in_thread(work.progress)
        await self._publish_map(work)
        return self._state()

    @request("save")
    async def save(self, path: str, formats: list[str] | None = None) -> dict[str, Any]:
        """Write the map so far on the machine of this agent, and return the files.

        path: ends in .map (ARIA) or .yaml (ROS), or has no ending with formats. formats: such as ["map", "yaml"].
        """
        work = self._existing()
        file = Path(path).expanduser()
        if not file.is_absolute():
            raise Refused(f"{path} is not an absolute path; this agent may run in any folder")
        files = [file.with_name(f"{file.name}.{each}") for each in formats] if formats else [file]
        return {"files": [str(each) for each in await self._in_thread(lambda: _written(work.map(), files))]}

    @request("content")
    async def content(self, kind: str = "map") -> dict[str, Any]:
        """Return the files of the map so far: name to content in base64; for programs on other machines.

        kind: map (ARIA) or yaml (ROS, with its picture).
        """
        work = self._existing()
        files = await self._in_thread(lambda: _contents(work.map(), kind))
        if sum(map(len, files.values())) > MOST_CONTENT:
            raise failure(f"the map has more than {MOST_CONTENT} bytes; save it on the machine of {self.name} instead")
        return {"files": files}

    def _existing(self) -> "MapWork":
        """Return what has been built.

        Raises:
            Refused: There is nothing yet.
        """
        if self._work is None:
            raise Refused(f"{self.name} has no map; ask it to start")
        return self._work

    def _state(self) -> dict[str, Any]:
        return {"building": bool(self._hearing), **self._figures, "trouble": self._trouble}

    async def _check_localization(self) -> None:
        """Refuse to begin while the robot is localized: both would publish their grids on `<robot>/map`.

        Raises:
            Refused: Its localization is under way.
        """
        localization = AgentName("localization", self.robot)
        outcome = await self.request(localization, "state", reply_within=LOCALIZATION_TIME)
        # A robot without the agent, or whose agent does not reply, publishes no grid of another map.
        if outcome.is_done and outcome.value()["state"] != "stopped":
            raise Refused(
                f"{self.robot} is localized on another map, and both maps would be on {keys.MAP.key(self.robot)};"
                f" stop it with: acromovi localize {self.robot} --stop"
            )

    async def _description(self) -> Mapping[str, Any]:
        try:
            (answer, *_) = await query(self.bus, keys.DESCRIPTION.key(self.robot), None, DESCRIPTION_TIME)
        except TimeoutError:
            raise Refused(f"{self.robot} has not described its sensors; see whether its p2os-gateway runs") from None
        return dict(answer.value)

    async def _work_off(self) -> None:
        """Give the thread what has come, and publish how far the map is."""
        if self._work is None or not self._hearing:
            return
        work, loop = self._work, asyncio.get_running_loop()
        # Readings first: the odometry after them may have come meanwhile, but not the other way round.
        readings = [self._readings.popleft() for _ in range(len(self._readings))]
        samples = [self._odometry.popleft() for _ in range(len(self._odometry))] + readings
        if samples:
            try:
                changed, self._figures = await self._in_thread(lambda: (work.take(samples), work.progress()))
            except Refused as err:
                self._trouble = err.why
                self._give_up()
                self.home.report(self.name, err.why, None)
                self._show()
                return
            if changed:
                self._has_changed, self._heard_at = True, loop.time()
        silence = loop.time() - self._heard_at
        is_silent = not samples and silence > self.fresh
        self._trouble = f"nothing has come from {self.robot} for {silence:.0f} s" if is_silent else None
        if samples:
            self._heard_at = loop.time()
            self._show()
        if self._has_changed:
            await self._publish_map(work, sparing=True)

    def _show(self) -> None:
        self.renew({"stamp": self.home.wall_time(), **self._state()})

    async def _publish_map(self, work: "MapWork", *, sparing: bool = False) -> None:
        """Publish the grid; sparing: only for those who subscribe, and not too often."""
        from agents.components.mapping.mapping_tools import grid_message

        if self._published is None:
            self._published = self.bus.publisher(keys.MAP.key(self.robot), keys.MAP.type_name)
        now = asyncio.get_running_loop().time()
        if sparing and not (self._published.has_listeners and now - self._published_at >= work.publish_period):
            return
        if work.is_empty:
            return
        self._published_at, self._has_changed = now, False
        grid = await self._in_thread(work.grid)
        self._published.put(grid_message(grid, round(self.home.wall_time() * NS_PER_S)))

    def _give_up(self) -> None:
        """End the subscriptions, and a start that is under way."""
        self._starting = None
        while self._hearing:
            self._hearing.pop().close()

    async def _in_thread(self, job: Callable[[], T]) -> T:
        """Do something in the agent's thread.

        Raises:
            Refused: It cannot be done; the message says why.
        """

        def done() -> T:
            try:
                return job()
            except (MapError, ValueError) as err:
                raise Refused(str(err)) from err

        return await asyncio.get_running_loop().run_in_executor(self._worker, done)


def _begun(description: Mapping[str, Any], extend: str, start: Pose2D | None) -> "MapWork":
    """Begin the work, in the thread: the algorithms are loaded here.

    Raises:
        ValueError: The robot has neither laser nor sonar, or the map cannot be read.
    """
    from agents.components.mapping.mapping_tools import MapWork, sensors_of
    from agents.components.mapping.settings import MappingAgentSettings
    from maps.map_files import read_building_map

    base = read_building_map(extend) if extend else None
    return MapWork(sensors_of(description), MappingAgentSettings.load(), base, start)


def _written(made: "BuildingMap", files: list[Path]) -> list[Path]:
    from maps.map_files import write_building_map

    return [written for file in files for written in write_building_map(made, file)]


def _contents(made: "BuildingMap", kind: str) -> dict[str, str]:
    """Return the files of a map."""
    import tempfile

    if kind not in ("map", "yaml"):
        raise ValueError(f"the kind is map or yaml, not {kind[:40]!r}")
    with tempfile.TemporaryDirectory() as folder:
        files = _written(made, [Path(folder) / f"map.{kind}"])
        return {file.name: base64.b64encode(file.read_bytes()).decode() for file in files}
