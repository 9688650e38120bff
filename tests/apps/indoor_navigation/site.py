"""Components of the navigation in virtual time, each in a process of its own, and a robot that a test speaks for."""

from collections.abc import Awaitable, Mapping
from typing import Any, TypeVar

import numpy as np

from agents.platform import Agent, Container, Report
from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.component import push_key, query_key
from apps.indoor_navigation.data import Data
from bus import Bus, MemoryBus, MemoryNetwork, Sample, keys
from bus.messages import (
    LaserScan,
    Odometry,
    Point,
    Pose,
    PoseWithCovariance,
    Range,
    RangeArray,
    TwistWithCovariance,
    decode,
    decode_json,
    header,
    quaternion,
    twist,
)

T = TypeVar("T")
D = TypeVar("D", bound=Data)

ROBOT = "happy"
EPOCH = 1.8e9  # s since 1970 when a loop's time is zero
DESCRIPTION = {
    "name": ROBOT,
    "model": "p2dx",
    "geometry": {
        "radius": 0.25,
        "width": 0.425,
        "length_front": 0.21,
        "length_rear": 0.301,
        "sonar": [
            {"number": 0, "x": 0.07, "y": 0.14, "heading": 1.5708},
            {"number": 3, "x": 0.17, "y": 0.03, "heading": 0.0},
        ],
    },
    "limits": {"linear": 2.2, "angular": 8.7, "deceleration": 0.6},
    "elements": [
        {"name": "base"},
        {"name": "laser", "geometry": {"x": 0.02, "y": 0.01, "z": 0.2, "heading": 0.1, "flipped": False}},
    ],
}


class Site:
    """A bus, and whoever is on it.

    reports: what went wrong anywhere, in words.
    """

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self.loop = loop
        self.network = MemoryNetwork()
        self.reports: list[str] = []
        self.bus = MemoryBus(self.network)
        self._containers: dict[str, tuple[Container, Bus]] = {}

    @property
    def time(self) -> float:
        """s since 1970."""
        return EPOCH + self.loop.time()

    def do(self, work: Awaitable[T]) -> T:
        """Let time pass until this is done."""

        async def done() -> T:
            return await work

        return self.loop.run_until_complete(done())

    def run(self, seconds: float) -> None:
        """Let time pass."""
        self.loop.run_for(seconds)

    def start(self, component: Agent) -> None:
        """Let a component live."""
        bus = MemoryBus(self.network)
        container = Container(bus, f"of-{component.name.local}", self._note, lambda: self.time)
        self._containers[component.name.local] = container, bus
        assert self.do(container.start(component))

    def kill(self, local: str) -> None:
        """Its process dies: nothing of it is heard any more, and it hears nothing."""
        container, bus = self._containers.pop(local)
        bus.close()
        self.do(container.close())

    def pushed(self, source: str, kind: type[D]) -> list[D]:
        """What a component pushes from now on, in a list that grows."""
        heard: list[D] = []

        def hear(sample: Sample) -> None:
            heard.append(kind.from_json(decode_json(sample.payload)))

        self.bus.subscribe(push_key(ROBOT, source, kind), hear)
        return heard

    def push(self, source: str, data: Data) -> None:
        """Speak for a component."""
        self.bus.put(push_key(ROBOT, source, type(data)), data.to_json())

    def ask(self, answerer: str, what: str) -> dict[str, Any]:
        """Ask a component."""
        (answer,) = self.bus.query(query_key(ROBOT, answerer, what))
        return answer.value

    def close(self) -> None:
        """End everything."""
        for container, _ in self._containers.values():
            self.do(container.close())

    def _note(self, report: Report) -> None:
        self.reports.append(f"{report.agent}: {report.what}: {report.error}")


class Robot:
    """What a gateway is to the components: streams, a description, and wheels that obey.

    told: each velocity that came, with its time, s of the loop, and its token.
    """

    def __init__(self, site: Site, description: Mapping[str, Any] = DESCRIPTION) -> None:
        self._site = site
        self._description = description
        self._bus = MemoryBus(site.network)
        self.told: list[tuple[float, float, float, str]] = []
        self.come()

    def come(self) -> None:
        """Its gateway is there."""
        self._bus = MemoryBus(self._site.network)
        self._bus.serve(keys.DESCRIPTION.key(ROBOT), lambda arguments: dict(self._description))
        self._bus.subscribe(keys.CMD_VEL.key(ROBOT), self._obey)

    def go(self) -> None:
        """Its gateway is gone."""
        self._bus.close()

    def odometry(
        self, x: float = 0.0, y: float = 0.0, heading: float = 0.0, linear: float = 0.0, angular: float = 0.0
    ) -> None:
        """It is there now, and that fast."""
        nothing = np.zeros(36)
        pose = Pose(position=Point(x=x, y=y, z=0.0), orientation=quaternion(heading))
        message = Odometry(
            header=self._header("odom"),
            child_frame_id=f"{ROBOT}/base_link",
            pose=PoseWithCovariance(pose=pose, covariance=nothing),
            twist=TwistWithCovariance(twist=twist(linear, angular), covariance=nothing),
        )
        self._bus.put(keys.ODOM.key(ROBOT), message)

    def sonar(self, ranges: Mapping[int, float]) -> None:
        """These discs have measured."""
        array = [
            Range(
                header=self._header(f"sonar_{number}"),
                radiation_type=Range.ULTRASOUND,
                field_of_view=0.4,
                min_range=0.1,
                max_range=5.0,
                range=distance,
                variance=0.0,
            )
            for number, distance in ranges.items()
        ]
        self._bus.put(keys.SONAR.key(ROBOT), RangeArray(self._header("base_link"), array))

    def scan(self, ranges: list[float], age: float = 0.0) -> None:
        """The laser has measured, so many s ago."""
        message = LaserScan(
            header=self._header("laser", age),
            angle_min=-0.5,
            angle_max=0.5,
            angle_increment=1.0 / (len(ranges) - 1),
            time_increment=0.0,
            scan_time=0.2,
            range_min=0.01,
            range_max=8.0,
            ranges=np.array(ranges, np.float32),
            intensities=np.zeros(len(ranges), np.float32),
        )
        self._bus.put(keys.SCAN.key(ROBOT), message)

    def _header(self, frame: str, age: float = 0.0) -> Any:
        return header(round((self._site.time - age) * 1e9), f"{ROBOT}/{frame}")

    def _obey(self, sample: Sample) -> None:
        told = decode(sample.type_name, sample.payload)
        self.told.append((self._site.loop.time(), told.linear.x, told.angular.z, sample.attachment.decode()))
