"""Robots without errors that do at once as they are told, for tests of the controller alone."""

import math
from itertools import combinations

from apps.formation.controller import Formation, FormationOrders
from apps.formation.members import MemberState, RangeEcho
from apps.formation.settings import FormationSettings
from geometry import Point, Pose2D, Twist2D, integrate

PERIOD = 0.1  # s
FORWARD = Twist2D(0.2, 0.0)
RANGE = 1.5  # m to which a toy robot sees


class Toy:
    """A leader and its followers on a plane.

    poses: where they are. silent: of whom nothing is heard. blind: whose sonar is silent. frozen: who stands. walls:
    points that range sensors see. orders: the last ones. told: all sentences. nearest, nearest_wall: how near two
    robots, and a robot and a wall point, have been, m.
    """

    def __init__(self, followers: int, shape: str, settings: FormationSettings | None = None) -> None:
        names = [f"robot-{number}" for number in range(1, followers + 1)]
        self.formation = Formation("leader", names, shape, settings or FormationSettings.load())
        self.poses = {"leader": Pose2D()} | {name: Pose2D(-1.0, 1.0 - 0.9 * n, 0.0) for n, name in enumerate(names)}
        self.twists = dict.fromkeys(self.poses, Twist2D())
        self.silent: set[str] = set()
        self.blind: set[str] = set()
        self.frozen: set[str] = set()
        self.walls: list[Point] = []
        self.orders = FormationOrders({})
        self.told: list[str] = []
        self.time = 0.0
        self.nearest = self.nearest_wall = math.inf
        self._heard: dict[str, MemberState] = {}

    def run(self, seconds: float, leader: Twist2D = FORWARD) -> None:
        """Let time pass while the leader drives."""
        for _ in range(round(seconds / PERIOD)):
            self._heard |= {name: self._state(name) for name in self.poses if name not in self.silent}
            self.orders = self.formation.step(self.time, self._heard)
            self.told += self.orders.told
            self.twists |= self.orders.twists
            self.twists["leader"] = leader
            self.twists |= dict.fromkeys(self.frozen, Twist2D())
            self.poses = {name: integrate(pose, self.twists[name], PERIOD) for name, pose in self.poses.items()}
            self.time += PERIOD
            places = [(pose.x, pose.y) for pose in self.poses.values()]
            self.nearest = min(self.nearest, *(math.dist(a, b) for a, b in combinations(places, 2)))
            apart = [math.dist(a, b) for a in places for b in self.walls]
            self.nearest_wall = min([self.nearest_wall, *apart])

    def off(self) -> float:
        """Return the largest distance of a member from its point, m."""
        return max(self.orders.errors[name] for name in self.formation.members.active)

    def _state(self, name: str) -> MemberState:
        pose = self.poses[name]
        seen = [(number, pose.locate(*wall)) for number, wall in enumerate(self.walls)]
        echoes = tuple(
            RangeEcho(number, Pose2D(x, y, 0.0), 1e-6 * self.time)  # never the same, as measured ones
            for number, (x, y) in seen
            if x * x + y * y < RANGE * RANGE
        )
        if name in self.blind:
            return MemberState(pose, self.twists[name], self.time, trouble="has a silent sonar")
        return MemberState(pose, self.twists[name], self.time, echoes)
