"""One component on a bench: what its gateway would say and answer is up to the test."""

from collections.abc import Awaitable, Mapping
from typing import Any, TypeVar

import numpy as np

from agents.components.all_components import component_for
from agents.platform import Agent, AgentName, Container, Outcome, Report
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, Refused, Subscription, keys
from bus.keys import Kind, Topic
from bus.messages import (
    Odometry,
    Point,
    Pose,
    PoseWithCovariance,
    TwistWithCovariance,
    header,
    quaternion,
    twist,
)

T = TypeVar("T")
ROBOT = "happy"


class Bench:
    """The agent of one element, and `app@lab`, which asks it.

    component: the agent. obeyed: commands that were given, with their arguments. reports: what went wrong, in words.
    """

    def __init__(self, loop: VirtualTimeLoop, element: str, properties: Mapping[str, Any] | None = None) -> None:
        self.loop = loop
        self.element = element
        self.robot = MemoryBus()
        self.reports: list[str] = []
        self.obeyed: list[tuple[str, dict[str, Any]]] = []
        self.component = component_for(element)(AgentName(element, ROBOT), properties)
        self.app = Agent(AgentName("app", "lab"))
        self._homes = [
            Container(MemoryBus(self.robot.network), ROBOT, self._note),
            Container(MemoryBus(self.robot.network), "lab", self._note),
        ]
        for home, agent in zip(self._homes, (self.component, self.app), strict=True):
            assert self.do(home.start(agent))

    def _note(self, report: Report) -> None:
        self.reports.append(f"{report.agent}: {report.what}: {report.error}")

    def do(self, work: Awaitable[T]) -> T:
        """Let time pass until this is done."""

        async def done() -> T:
            return await work

        return self.loop.run_until_complete(done())

    def run(self, seconds: float = 0.01) -> None:
        """Let time pass."""
        self.loop.run_for(seconds)

    def say(self, topic: Topic, message: object) -> None:
        """Put something where the robot's messages belong, and let it be heard."""
        self.robot.put(topic.key(ROBOT), message)
        self.run()

    def obey(self, topic: Topic, refusal: str = "") -> Subscription:
        """Take a command from now on, or refuse it with a sentence."""

        def answer(given: dict[str, Any]) -> dict[str, Any]:
            heartbeat = given.pop("heartbeat", None)
            assert heartbeat in (None, self.component.name.heartbeat_key)
            if refusal:
                raise Refused(refusal)
            self.obeyed.append((topic.suffix, given))
            return {"ok": True}

        return self.robot.serve(topic.key(ROBOT), answer)

    def obey_all(self) -> None:
        """Take every command."""
        for topic in keys.TOPICS:
            if topic.suffix.startswith("command/") and topic.kind is Kind.QUERY:
                self.obey(topic)

    def ask(self, name: str = "read", **arguments: Any) -> Outcome:
        """Ask the component for something, and wait for the end."""
        return self.do(self.app.request(self.component.name, name, reply_within=20.0, **arguments))

    def value(self, name: str = "read", **arguments: Any) -> Any:
        """The same; it must be done."""
        return self.ask(name, **arguments).value()

    def results(self) -> list[Mapping[str, Any]]:
        """What the component sends from now on, in a list that grows."""
        heard: list[Mapping[str, Any]] = []

        async def hear(result: Mapping[str, Any]) -> None:
            heard.append(result)

        async def listen() -> None:
            self.app.listen(self.component.name.results_key, hear, keep=100)

        self.do(listen())
        return heard

    def close(self) -> None:
        """End everything."""
        for home in reversed(self._homes):
            self.do(home.close())


def odometry(x: float = 0.0, y: float = 0.0, heading: float = 0.0) -> Odometry:
    """A pose in odom, m and rad, on the way at 0.25 m/s and -0.5 rad/s."""
    nothing = np.zeros(36)
    pose = Pose(position=Point(x=x, y=y, z=0.0), orientation=quaternion(heading))
    return Odometry(
        header=header(0, f"{ROBOT}/odom"),
        child_frame_id=f"{ROBOT}/base_link",
        pose=PoseWithCovariance(pose=pose, covariance=nothing),
        twist=TwistWithCovariance(twist=twist(0.25, -0.5), covariance=nothing),
    )
