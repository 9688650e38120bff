"""A robot with its gateway in one process under a virtual clock, something that goes wrong, and who watches the bus."""

from collections.abc import Callable, Iterator
from math import hypot
from pathlib import Path
from typing import Any

import pytest

from acromovi.lockstep import Lockstep
from bus import Refused, Sample, keys, messages
from geometry import Pose2D
from p2os_emu.world import load_world

ROBOT = "happy"
BEAT = 0.1  # s between two Twists
START = 2.0  # s in which the robot is found and set up
ROOM = """
walls = [
    { from_m = [-3.0, -3.0], to_m = [3.0, -3.0] },
    { from_m = [3.0, -3.0], to_m = [3.0, 3.0] },
    { from_m = [3.0, 3.0], to_m = [-3.0, 3.0] },
    { from_m = [-3.0, 3.0], to_m = [-3.0, -3.0] },
]
starts = [{ at_m = [-1.5, 0.0] }]
"""


def distance(a: Pose2D, b: Pose2D) -> float:
    return hypot(b.x - a.x, b.y - a.y)


class Mission:
    """One robot in a room, its driver on the bus, and everything that was published."""

    def __init__(self, world: Path, fit: str) -> None:
        self.lockstep = Lockstep(load_world(str(world)), {ROBOT: "powerbot-sh"}, fits={ROBOT: fit}, seed=1)
        self.bus = self.lockstep.bus()
        self.heard: dict[str, list[Sample]] = {}
        self.bus.subscribe(f"{ROBOT}/**", lambda sample: self.heard.setdefault(sample.key, []).append(sample))
        self.lockstep.run(START)

    def fault(self, spec: str) -> Callable[[], None]:
        """Let something go wrong; returns what ends it."""
        number = self.lockstep.fault(spec)
        return lambda: self.lockstep.clear(number)

    def run(self, seconds: float) -> float:
        """Let time pass; returns how far the robot was from where it began, m."""
        start = self.truth
        self.lockstep.run(seconds)
        return distance(start, self.truth)

    def drive(self, seconds: float, linear: float = 0.2) -> float:
        """Send Twists for so long; returns how far the robot was from where it began, m."""
        start = self.truth
        for _ in range(round(seconds / BEAT)):
            self.bus.put(keys.CMD_VEL.key(ROBOT), messages.twist(linear, 0.0))
            self.lockstep.run(BEAT)
        return distance(start, self.truth)

    def turn(self, seconds: float, angular: float = 0.5) -> None:
        """Send Twists that turn the robot for so long."""
        for _ in range(round(seconds / BEAT)):
            self.bus.put(keys.CMD_VEL.key(ROBOT), messages.twist(0.0, angular))
            self.lockstep.run(BEAT)

    def move(self) -> str | None:
        """Ask for a long motion and take it back; returns why it was refused, None if it was not."""
        try:
            self.bus.query(keys.MOVE.key(ROBOT), {"distance": 0.01})
        except Refused as refused:
            return refused.why
        self.bus.query(keys.STOP.key(ROBOT), {})
        self.lockstep.run(1.0)
        return None

    def enable(self) -> None:
        self.bus.query(keys.ENABLE.key(ROBOT), {"on": True})
        self.lockstep.run(0.5)

    def forget(self) -> None:
        """Hear only what comes from now on."""
        self.heard.clear()

    def count(self, topic: keys.Topic) -> int:
        return len(self.heard.get(topic.key(ROBOT), []))

    def all(self, topic: keys.Topic) -> list[Any]:
        return [messages.decode(each.type_name, each.payload) for each in self.heard.get(topic.key(ROBOT), [])]

    def last(self, topic: keys.Topic) -> Any:
        return self.all(topic)[-1]

    def counters(self) -> dict[str, int]:
        """What the gateway's diagnostics count about the robot's cable."""
        (cable,) = (each for each in self.last(keys.DIAGNOSTICS).status if each.name == f"{ROBOT}: cable")
        return {pair.key: int(pair.value) for pair in cable.values if ":" in pair.key}

    def ranges(self) -> list[tuple[int, float]]:
        """Every sonar reading published: disc and range, m."""
        return [
            (int(each.header.frame_id.rpartition("_")[2]), each.range)
            for array in self.all(keys.SONAR)
            for each in array.ranges
        ]

    @property
    def truth(self) -> Pose2D:
        return self.lockstep.truth(ROBOT)

    @property
    def pose(self) -> Pose2D:
        """What odometry believes, as published last."""
        pose = self.last(keys.ODOM).pose.pose
        return Pose2D(pose.position.x, pose.position.y, messages.heading(pose.orientation))


@pytest.fixture
def make_mission(tmp_path: Path) -> Iterator[Callable[[str], Mission]]:
    """Factory of missions, by what is fitted to their robot."""
    world = tmp_path / "room.toml"
    world.write_text(ROOM)
    begun: list[Mission] = []

    def make(fit: str) -> Mission:
        begun.append(Mission(world, fit))
        return begun[-1]

    yield make
    for mission in begun:
        mission.lockstep.close()


@pytest.fixture
def mission(make_mission: Callable[[str], Mission]) -> Mission:
    return make_mission("")
