"""A robot on the bus whose words would do harm as HTML, with agents that note what they are told."""

import asyncio
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from agents.platform import Agent, AgentName, Container
from bus import ZenohBus, keys
from bus.acromovi_msgs import RobotState
from bus.messages import NS_PER_S, header, quaternion
from bus.ros_msgs import (
    Header,
    Odometry,
    Point,
    Pose,
    PoseWithCovariance,
    Twist,
    TwistWithCovariance,
    Vector3,
)

NAME = "<img-src=x-onerror=pwned()>"
WORDS = "<img src=x onerror='window.pwned=1'><script>window.pwned=1</script>"
MAP = 1.0, 0.5  # m; the frame odom in the frame map
X, HEADING = 2.0, 1.5708  # m and rad, in odom; y is 0


class NotingNavigation(Agent):
    """A navigation that notes its goals."""

    def __init__(self, robot: str) -> None:
        super().__init__(AgentName("user_interface", robot))
        self.goals: list[dict[str, object]] = []
        self.answer("go", self.go)
        self.answer("picture", self.picture)
        self.answer_queries("goal", self.goal)

    async def go(self, x: float, y: float, heading: float | None = None) -> dict[str, str]:
        """Note a goal in odom: m and rad."""
        self.goals.append({"x": x, "y": y, "heading": heading})
        return {"mission": "m1"}

    async def goal(self, number: int = -1) -> dict[str, object]:
        """Return one of the goals, the newest by default."""
        return self.goals[number]

    async def picture(self) -> dict[str, object]:
        """Return what is drawn of a mission."""
        return {"mission": WORDS, "state": "active", "why": WORDS, "doors": [WORDS]}


class NotingLocalization(Agent):
    """A localization that notes where it is told to begin again; its frame map is `MAP` in odom."""

    def __init__(self, robot: str) -> None:
        super().__init__(AgentName("localization", robot))
        self.poses: list[tuple[float, float, float]] = []
        self.answer("set_pose", self.set_pose)
        self.answer("goals", self.goals)
        self.answer("goal", self.goal)

    async def set_pose(self, x: float, y: float, heading: float = 0.0) -> None:
        """Note a pose in the map: m and rad."""
        self.poses.append((x, y, heading))

    async def goals(self) -> list[dict[str, object]]:
        """Return a goal of hostile words."""
        return [{"name": WORDS, "kind": "Goal", "pose": [5.0, 2.0, 0.0]}]

    async def goal(self, place: str) -> dict[str, object]:
        """Return the goal in odom."""
        return {"x": 5.0 - MAP[0], "y": 2.0 - MAP[1], "heading": None, "name": place}


@contextmanager
def odd_robot(profile: str) -> Iterator[tuple[NotingNavigation, NotingLocalization]]:
    """Have the robot on a bus during a block; gives its navigation and its localization."""
    agents, is_over = (NotingNavigation(NAME), NotingLocalization(NAME)), threading.Event()
    thread = threading.Thread(target=lambda: asyncio.run(_live(profile, agents, is_over)))
    thread.start()
    try:
        yield agents
    finally:
        is_over.set()
        thread.join()


async def _live(profile: str, agents: tuple[Agent, ...], is_over: threading.Event) -> None:
    with ZenohBus.open(profile) as bus:
        bus.serve(keys.DESCRIPTION.key(NAME), lambda arguments: {"model": WORDS, "elements": [{"name": WORDS}]})
        bus.serve(keys.LEASE_STATE.key(NAME), lambda arguments: {"holder": WORDS, "elements": {}})
        bus.declare_alive(keys.ALIVE.key(NAME))
        async with Container(bus, "odd") as container:
            for agent in agents:
                await container.start(agent)
            while not is_over.is_set():
                stamp = header(int(time.time() * NS_PER_S), "odom")
                bus.put(keys.STATE.key(NAME), RobotState(stamp, "connected", True, False, False, 0, [WORDS]))
                bus.put(keys.ODOM.key(NAME), _odometry(stamp))
                event = {"time": time.time(), "what": f"{WORDS} has failed", "about": f"{WORDS}@x", "level": "error"}
                bus.put("x/agents/monitor/results", event)
                located = {"state": "localized", "reason": WORDS, "map": WORDS, "odom_in_map": [*MAP, 0.0]}
                pose = {"pose": [MAP[0] + X, MAP[1], HEADING], "deviations": [0.1, 0.2, 0.05]}
                bus.put(f"{NAME}/agents/localization/results", {**located, **pose})
                await asyncio.sleep(0.1)


def _odometry(stamp: Header) -> Odometry:
    zero, covariance = Vector3(0.0, 0.0, 0.0), np.zeros(36)
    pose = PoseWithCovariance(Pose(Point(X, 0.0, 0.0), quaternion(HEADING)), covariance)
    return Odometry(stamp, "base_link", pose, TwistWithCovariance(Twist(zero, zero), covariance))
