"""Readiness of a robot: its gateway is connected, its container exists, with an agent for each element."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import inf

from acromovi.team.plan import SERVICES
from configs.team_file import TeamRobot

PATIENCE = 15.0
"""Seconds after it was connected in which a part must have shown itself; a camera head may be deaf, a laser broken."""
QUIET_TIME = 0.7
"""Seconds without another agent after which a robot has shown all that it has."""
SHOWN = ("gripper", "laser", "ptz", "arm", "camera", "gyro", "compass")
"""Parts that `fit` names and that become elements of the same name, once the robot has shown them."""


@dataclass(slots=True)
class RobotReadiness:
    """Progress of one robot; times in s of one steady clock.

    parts: that it must show. agents: those there are, by their local names. connected_at: the latest time.
    """

    parts: frozenset[str]
    connected_at: float = inf
    is_lost: bool = False
    container_serves: bool = False
    agents: set[str] = field(default_factory=set)
    changed_at: float = -inf

    @property
    def is_connected(self) -> bool:
        """Whether its gateway has ever talked to it."""
        return self.connected_at < inf

    @property
    def is_in_touch(self) -> bool:
        """Whether its gateway talks to it now."""
        return self.is_connected and not self.is_lost

    def missing(self) -> list[str]:
        """What has not shown itself, for people."""
        if not self.is_in_touch:
            return ["the robot"]
        if not self.container_serves:
            return ["its container"]
        return sorted(self.parts - self.agents) or ([] if self.agents else ["agents"])

    @property
    def awaited(self) -> str:
        """Which of its parts it waits for that does not serve; empty when it is as good as ready."""
        if not self.is_in_touch:
            return "gateway"
        return " and ".join(self.missing()) if self.container_serves else "container"

    def serves(self, now: float) -> bool:
        """Whether it has all required parts, or has had enough time to show them."""
        if not (self.is_in_touch and self.container_serves and self.agents):
            return False
        if now - self.changed_at < QUIET_TIME:
            return False
        return not self.missing() or now - self.connected_at >= PATIENCE


class Readiness:
    """Progress of a team's robots during the start."""

    def __init__(self, robots: Iterable[TeamRobot]) -> None:
        self._progress = {robot.name: RobotReadiness(_fitted(robot)) for robot in robots}
        self._services_serve = False

    def __getitem__(self, robot: str) -> RobotReadiness:
        """One robot's progress."""
        return self._progress[robot]

    @property
    def services_serve(self) -> bool:
        """Whether the container of the team's own agents serves."""
        return self._services_serve

    def connected(self, robot: str, now: float) -> None:
        """Its gateway talks to it."""
        progress = self._progress[robot]
        progress.connected_at, progress.is_lost = now, False

    def lost(self, robot: str) -> None:
        """Its gateway looks for it again; once that has found it, its parts are asked for anew."""
        self._progress[robot].is_lost = True

    def container(self, name: str, serves: bool) -> None:
        """A container serves, or has ended."""
        if name in self._progress:
            self._progress[name].container_serves = serves
        elif name == SERVICES:
            self._services_serve = serves

    def agent(self, robot: str, local: str, is_there: bool, now: float) -> None:
        """Note that an agent appeared or vanished; agents of other platforms are ignored."""
        progress = self._progress.get(robot)
        if progress is not None:
            (progress.agents.add if is_there else progress.agents.discard)(local)
            progress.changed_at = now

    def serving(self, now: float) -> list[str]:
        """The robots that serve, in the order of the team's file."""
        return [name for name, progress in self._progress.items() if progress.serves(now)]


def _fitted(robot: TeamRobot) -> frozenset[str]:
    """The parts that a robot must show, by the team's file."""
    parts = {part.partition(":")[0] for part in robot.fit}
    own = {"laser": robot.laser, "arm": robot.arm, "camera": robot.camera}
    return frozenset((parts & set(SHOWN)) | {part for part, place in own.items() if place})
