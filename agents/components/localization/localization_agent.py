"""The agent of localization: where the robot is on a map, from odometry and laser or sonar.

It subscribes to nothing, computes nothing and loads no map until it is started. A thread of its own does the work.
"""

import asyncio
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from math import isfinite
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from agents.components.component import ElementAgent, failure
from agents.platform import AgentName, request
from agents.platform.schedule import Running
from bus import Publisher, Refused, Sample, Subscription, keys
from bus.messages import NS_PER_S
from geometry import Pose2D

if TYPE_CHECKING:  # these load numpy and maps
    from agents.components.localization.localization_tools import LocalizationTools
    from maps.localization.localizer import LocalizationEstimate

PERIOD = 0.1
"""Seconds between two uses of what has come."""
MAP_PERIOD = 5.0
"""Seconds between two publications of the map, while a program subscribes to it."""
_MOST_MESSAGES = 400  # that wait for the thread: four seconds of everything
_STOPPED = "stopped"
T = TypeVar("T")


class LocalizationAgent(ElementAgent):
    """`localization@happy`: pose in the frame `map`; also on `<robot>/pose`, `<robot>/tf` and `<robot>/map`."""

    services = ("localization",)
    results: ClassVar[Mapping[str, str]] = {
        "state": "stopped, searching, checking, localized or wrong map; the pose is to be believed if localized",
        "pose": "x, y, heading in map, m and rad; null without a guess",
        "deviations": "standard deviations of x, y and heading, m and rad",
        "score": "share of the latest readings that the map explains, 0 to 1",
        "particles": "how many there are",
        "odom_in_map": "x, y, heading of the frame odom in map, m and rad; null without a guess",
        "odometry": "systematic errors: true m per m (distance), rad per rad (turn), rad per m to the left (drift)",
        "silence": "s since the latest range reading",
        "map": "file of the map",
        "started": "ms since 1970 when this localization was started",
        "reason": "why the pose is not to be believed; null if it is",
    }

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._worker: ThreadPoolExecutor | None = None
        self._tools: LocalizationTools | None = None
        self._started = 0
        self._ticking: list[Running] = []
        self._hearing: list[Subscription] = []
        self._publishing: list[Publisher] = []
        # Not decoded yet; the bus's thread appends.
        self._samples: deque[Sample] = deque(maxlen=_MOST_MESSAGES)

    @classmethod
    def properties_of(cls, robot: Mapping[str, Any], element: Mapping[str, Any]) -> dict[str, Any]:
        """Return the places of the sensors; they are those of the robot, whichever element this agent is beside."""
        rows = [row for row in robot["elements"] if isinstance(row, dict)]
        laser = next((row.get("geometry") or {} for row in rows if row.get("name") == "laser"), None)
        has_sonar = any(row.get("name") == "sonar" for row in rows)
        discs = robot["geometry"]["sonar"] if has_sonar else []
        return {"laser": laser, "discs": discs, "robot_model": robot.get("model")}

    def describe(self) -> dict[str, Any]:
        """Return its description; it is not the agent of an element."""
        described = super().describe()
        return {**described, "services": [each for each in described["services"] if each != "component"]}

    async def take_down(self) -> None:
        """Stop."""
        self._end()

    @request("start", agrees_itself=True)
    async def start(self, map: str, pose: Any = "home", settings: str = "") -> dict[str, Any]:  # noqa: A002  # the word of the request
        """Localize the robot on a map; a localization that is under way is replaced.

        map: file .map or .yaml, on the machine of this agent. pose: `home` (RobotHome of the map), `unknown`, or a list
        of x, y (m) and heading (rad). settings: file with changes of the settings.
        """
        start = _start_of(pose)
        self._end()
        self._worker = worker = ThreadPoolExecutor(1, thread_name_prefix=str(self.name))
        try:
            tools, grid = await self._in_thread(lambda: self._loaded(map, start, settings))
        except Refused as err:
            if worker is self._worker:
                self._end()
            raise failure(err.why) from err
        if worker is not self._worker:
            raise failure(f"{self.name} was stopped or started again while it read {map}")
        self._tools = tools
        self._started = round(self.home.wall_time() * 1e3)
        self._begin(grid)
        return {"state": str(self._state()), "map": map}

    @request("stop")
    async def stop(self) -> dict[str, Any]:
        """End the localization."""
        self._end()
        return {"state": _STOPPED}

    @request("state")
    async def state_of_localization(self) -> dict[str, Any]:
        """The latest result; its state is `stopped` where no localization is under way."""
        if self._tools is None:
            return {"state": _STOPPED, "pose": None, "reason": "no localization was started"}
        if self._latest is None:
            return {"state": "searching", "pose": None, "reason": "no odometry has come yet"}
        silence = asyncio.get_running_loop().time() - self._heard_at
        late = {"reason": f"no odometry has come for {silence:.0f} s"} if silence > self.fresh else {}
        return {**self._latest, **late}

    @request("set_pose")
    async def set_pose(self, x: float, y: float, heading: float = 0.0) -> dict[str, Any]:
        """Begin again at a pose in the map, m and rad."""
        pose = Pose2D(x, y, heading)
        await self._with_tools(lambda tools: tools.set_pose(pose))
        return {"pose": [x, y, heading]}

    @request("goal")
    async def goal(self, place: str = "", x: Any = None, y: Any = None, heading: Any = None) -> dict[str, Any]:
        """Convert a goal to odom: x, y and heading (null for any).

        place: name of a goal of the map; or x, y (m) and heading (rad) in the map.
        Refused where the robot is not localized, there is no such goal, or it is in a wall or a forbidden area.
        """
        for called, value in {"x": x, "y": y, "heading": heading}.items():
            if value is not None and not _is_number(value):
                raise Refused(f"{called} must be a number, not {value!r}")
        return dict(await self._with_tools(lambda tools: tools.goal(place, x, y, heading)))

    @request("goals")
    async def goals(self) -> list[dict[str, Any]]:
        """The goals of the map: name, kind, and pose as x, y, heading."""
        found = await self._with_tools(lambda tools: tools.map.goals)
        return [
            {"name": each.name, "kind": each.kind, "pose": [each.pose.x, each.pose.y, each.pose.heading]}
            for each in found
        ]

    @request("floor")
    async def floor(self) -> dict[str, Any]:
        """The map for planning: a grid in the frame `map` with free, occupied, unknown and forbidden cells."""
        return dict(await self._with_tools(lambda tools: tools.floor()))

    def _state(self) -> str:
        return "searching" if self._latest is None else str(self._latest["state"])

    def _loaded(self, file: str, start: str | list[float], settings: str) -> "tuple[LocalizationTools, Any]":
        """Read the map; in the thread."""
        from agents.components.localization.localization_tools import LocalizationTools, SensorPlaces

        places = SensorPlaces.of(self.properties)
        if places.laser is None and not places.discs:
            raise Refused(f"{self.robot} has neither laser nor sonar; a localization needs one of them")
        tools = LocalizationTools(self.robot, file, start, places, settings)
        return tools, tools.map_message(round(self.home.wall_time() * NS_PER_S))

    def _begin(self, grid: Any) -> None:
        """Subscribe to odometry and ranges, and begin to publish."""
        pose, transform, map_ = (
            self.bus.publisher(topic.key(self.robot), topic.type_name) for topic in (keys.POSE, keys.TF, keys.MAP)
        )
        self._publishing = [pose, transform, map_]
        self._samples.clear()
        self._hearing = [
            self.bus.subscribe(topic.key(self.robot), self._samples.append, urgent=True)
            for topic in (keys.ODOM, keys.SCAN, keys.SONAR)
        ]

        async def show_map() -> None:
            if map_.has_listeners:
                map_.put(grid)

        self._ticking = [self.every(PERIOD, self._advance), self.every(MAP_PERIOD, show_map)]

    def _end(self) -> None:
        while self._ticking:
            self._ticking.pop().stop()
        for each in (*self._hearing, *self._publishing):
            each.close()
        self._hearing, self._publishing = [], []
        if self._tools is not None and self.is_heard:
            self.publish(
                {"state": _STOPPED, "pose": None, "odom_in_map": None, "reason": "the localization was stopped"}
            )
        if self._worker is not None:
            # What waits is short, and runs: a cancelled future would end the request that awaits it without a reply.
            self._worker.shutdown(wait=False)
        self._worker = self._tools = self._latest = None
        self._has_heard.clear()

    async def _advance(self) -> None:
        """Use what has come, and publish what is known."""
        tools, samples = self._tools, list(self._samples)
        if tools is None or not samples:
            return
        self._samples.clear()
        estimate, result = await self._in_thread(lambda: _advanced(tools, samples))
        if tools is not self._tools:
            return  # it was stopped meanwhile
        result = {**result, "started": self._started}
        before = None if self._latest is None else self._latest["state"]
        self.renew(result)
        if before != result["state"] and result["reason"] is not None and before is not None:
            self.home.report(self.name, f"{result['state']}: {result['reason']}", None)
        if result["state"] == "localized":
            pose, transform, _ = self._publishing
            if pose.has_listeners:
                pose.put(tools.pose_message(estimate))
            transform.put(tools.transform(estimate))

    async def _with_tools(self, job: "Callable[[LocalizationTools], T]") -> T:
        tools = self._tools
        if tools is None:
            raise Refused(f'no localization of {self.robot} is under way; start one with "start", map=FILE')
        return await self._in_thread(lambda: job(tools))

    async def _in_thread(self, job: Callable[[], T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._worker, job)


def _advanced(tools: "LocalizationTools", samples: list[Sample]) -> "tuple[LocalizationEstimate, dict[str, Any]]":
    estimate = tools.take(samples)
    return estimate, tools.result(estimate)


def _start_of(pose: Any) -> str | list[float]:
    """Check where a localization is to begin.

    Raises:
        Refused: It is neither `home` nor `unknown` nor a pose.
    """
    if pose in ("home", "unknown"):
        return str(pose)
    if isinstance(pose, list) and len(pose) == 3 and all(map(_is_number, pose)):
        return [float(value) for value in pose]
    raise Refused(f'pose must be "home", "unknown" or a list of x, y (m) and heading (rad), not {str(pose)[:60]!r}')


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
