"""The controller of a formation: from the states of its members to a twist for each follower. No bus, no clock."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from apps.formation.avoidance import MovingDisc, admissible_twist
from apps.formation.members import REST, MemberState
from apps.formation.membership import Membership
from apps.formation.passages import EchoMemory
from apps.formation.path import LeaderPath
from apps.formation.settings import FormationSettings
from apps.formation.shapes import COLUMN, assign, check_behind, shape_offsets
from apps.formation.tracking import VirtualPoint, frame_point, path_point, twist_towards
from geometry import Point, Pose2D, Twist2D, integrate

PATH_LENGTH = 30.0  # m of the leader's path that is remembered
AHEAD = 0.6  # m along the leader's path of the point to which a follower drives that is far behind


@dataclass(frozen=True, slots=True)
class FormationOrders:
    """What to do now.

    twists: for each follower. points: the virtual point of each, in the common frame; for one that is lost, the point
    that it had as a member. offsets: that point in the leader's frame, m. errors: the distance from it, m. told: what
    has changed, in sentences.
    """

    twists: Mapping[str, Twist2D]
    points: Mapping[str, Pose2D] = field(default_factory=dict)
    offsets: Mapping[str, Point] = field(default_factory=dict)
    errors: Mapping[str, float] = field(default_factory=dict)
    told: tuple[str, ...] = ()


class Formation:
    """A leader and its followers.

    shape: the wanted one. is_narrow: whether a column is formed instead, because the place is narrow. waits_for: why
    all followers stand, in words; empty while they drive.
    """

    def __init__(
        self, leader: str, followers: Sequence[str], shape: str, settings: FormationSettings, *, by_sight: bool = False
    ) -> None:
        """Begin with a shape.

        Args:
            leader: Its name.
            followers: Their names.
            shape: As for `set_shape`.
            settings: Of the application.
            by_sight: The followers see the leader's target, so their points must be behind it.
        Raises:
            ShapeError: It cannot be formed.
        """
        self.leader = leader
        self.settings = settings
        self._by_sight = by_sight
        self._blur = settings.sight.blur_m if by_sight else 0.0  # by which its echo can be off its place
        self._unheard = "is not seen" if by_sight else "is silent"
        self.members = Membership(followers, settings, "does not see the leader" if by_sight else self._unheard)
        self.is_narrow = False
        self.waits_for = ""
        self.shape = shape
        self._path = LeaderPath(PATH_LENGTH)
        self._echoes = EchoMemory(settings.passages)
        self._places: dict[tuple[str, frozenset[str]], dict[str, int]] = {}
        self._heard: dict[tuple[str, int], float] = {}
        self._clear_since = math.inf
        self._offsets = {COLUMN: self._offsets_for(COLUMN), shape: self._offsets_for(shape)}

    @property
    def formed(self) -> str:
        """The shape that is formed now."""
        return COLUMN if self.is_narrow else self.shape

    def set_shape(self, shape: str) -> None:
        """Change the shape.

        Raises:
            ShapeError: It cannot be formed; the shape stays as it is.
        """
        self._offsets = {COLUMN: self._offsets_for(COLUMN), shape: self._offsets_for(shape)}
        self.shape = shape
        self._places.clear()

    def refused(self, robot: str, why: str) -> None:
        """Note why a follower does not let itself be driven; without a reason, that it obeys again."""
        self.members.followers[robot].refusal = why

    @property
    def status(self) -> dict[str, Any]:
        """The shape, and what is wrong with whom, for people and programs."""
        return {
            "leader": self.leader,
            "shape": self.shape,
            "formed": self.formed,
            "waits_for": self.waits_for,
            "lost": {member.name: member.trouble for member in self.members.lost},
        }

    def step(self, now: float, states: Mapping[str, MemberState]) -> FormationOrders:
        """Return what to do.

        Args:
            now: s on the clock of `MemberState.heard`.
            states: By name, the leader's included; those that have been heard of.
        """
        self.members.told.clear()
        leader = states.get(self.leader)
        if leader is None or self.members.is_silent(leader, now):
            self._wait(f"{self.leader}, the leader, {self._unheard}")
            return FormationOrders(
                self._commanded(dict.fromkeys(self.members.followers, REST)), told=tuple(self.members.told)
            )
        self._path.add(leader.pose)
        self._echoes.add(now, self._new_echoes(states), self._discs(states))
        self.members.judge_hearing(now, states)
        self._judge_width(now)
        points = self._points(leader, states, now)
        errors = {
            name: math.dist(_xy(_predicted(states[name], now, self._lag).pose), _xy(point.pose))
            for name, (point, _) in points.items()
        }
        if self.members.judge_motion(now, states, errors, all_wait=bool(self.waits_for)):
            self._forget_columns()
        lost = self.members.lost
        waits = self.settings.members.when_stopped == "wait" and lost
        self._wait(f"waiting for {lost[0].name}, which {lost[0].trouble}" if waits else "")
        drivers = [name for name in points if not waits or self.members.followers[name].trouble]
        drivers.sort(key=lambda name: (bool(self.members.followers[name].trouble), -points[name][1][0], name))
        twists: dict[str, Twist2D] = {}
        for name in drivers:  # who is in front goes first, and the others take account of that
            twists[name] = self._twist(name, points[name][0], states, twists, now)
        return FormationOrders(
            self._commanded({name: twists.get(name, REST) for name in self.members.followers}),
            {name: point.pose for name, (point, _) in points.items()},
            {name: offset for name, (_, offset) in points.items()},
            errors,
            tuple(self.members.told),
        )

    @property
    def _lag(self) -> float:
        return self.settings.tracking.lag_s

    def _offsets_for(self, shape: str) -> list[tuple[Point, ...]]:
        """Return the offsets of a shape for no follower, one, two and so on: it is formed with fewer robots, too.

        Raises:
            ShapeError: It cannot be formed.
        """
        settings = self.settings
        radii = sorted((settings.radius(name) for name in (self.leader, *self.members.followers)), reverse=True)
        nearest = sum(radii[:2]) + settings.safety.robot_gap_m
        spacing = settings.points.column_spacing_m if shape == COLUMN else settings.points.spacing_m
        found = [shape_offsets(shape, count, spacing, nearest) for count in range(len(self.members.followers) + 1)]
        if self._by_sight:
            check_behind(shape, found[-1], settings.sight.aside_rad)
        return found

    def _discs(self, states: Mapping[str, MemberState]) -> list[tuple[Pose2D, float]]:
        return [(state.pose, self.settings.radius(name) + self._blur) for name, state in states.items()]

    def _new_echoes(self, states: Mapping[str, MemberState]) -> list[Point]:
        """Return what members see for the first time, in the common frame."""
        found = []
        for name, state in states.items():
            for echo in state.echoes:
                is_new = self._heard.get((name, echo.number)) != echo.distance  # measured twice it would be another
                self._heard[name, echo.number] = echo.distance
                if is_new and echo.distance < self.settings.passages.range_m:
                    found.append(state.pose.transform(*echo.point))
        return found

    def _judge_width(self, now: float) -> None:
        """Form a column where the shape has no room, and the shape again after that."""
        active = self.members.active
        if self.shape == COLUMN or not active:
            self.is_narrow = False
            return
        radius = max(self.settings.radius(name) for name in active)
        is_blocked = self._echoes.blocks(self._path, self._offsets[self.shape][len(active)], radius)
        if is_blocked:
            self._clear_since = math.inf
            if not self.is_narrow:
                self.is_narrow = True
                self.members.told.append(f"too narrow for the {_named(self.shape)}: forming a column")
        elif self.is_narrow:
            self._clear_since = min(self._clear_since, now)
            if now - self._clear_since >= self.settings.passages.clear_s:
                self.is_narrow = False
                self.members.told.append(f"room again: forming the {_named(self.shape)}")

    def _forget_columns(self) -> None:
        """Let a column be assigned anew, since robots in it cannot overtake each other to regain their places."""
        self._places = {key: places for key, places in self._places.items() if key[0] != COLUMN}

    def _points(
        self, leader: MemberState, states: Mapping[str, MemberState], now: float
    ) -> dict[str, tuple[VirtualPoint, Point]]:
        """Return virtual point and offset of each follower that can be driven."""
        active = self.members.active
        found = self._assigned(leader, states, active, now)
        for name in (member.name for member in self.members.lost):
            if self.members.can_be_driven(name, states, now):
                found[name] = self._assigned(leader, states, [*active, name], now)[name]
        return found

    def _assigned(
        self, leader: MemberState, states: Mapping[str, MemberState], names: Sequence[str], now: float
    ) -> dict[str, tuple[VirtualPoint, Point]]:
        """Assign followers to the points of the present shape; the same followers have the same places again."""
        offsets = self._offsets[self.formed][len(names)]
        points = [self._point(leader, offset, now) for offset in offsets]
        key = self.formed, frozenset(names)
        is_would_be = any(self.members.followers[name].trouble for name in names)
        if key not in self._places or (is_would_be and self.formed == COLUMN):
            self._places[key] = assign(
                {name: _xy(states[name].pose) for name in names}, [_xy(point.pose) for point in points]
            )
        return {name: (points[place], offsets[place]) for name, place in self._places[key].items()}

    def _point(self, leader: MemberState, offset: Point, now: float) -> VirtualPoint:
        """Return a virtual point as it is when a command given now takes hold."""
        later = now - leader.heard + self._lag
        if self.settings.points.follow == "path" or self.formed == COLUMN:
            return path_point(self._path, leader.twist, offset, later)
        return frame_point(integrate(leader.pose, leader.twist, later), leader.twist, offset)

    def _twist(
        self,
        name: str,
        point: VirtualPoint,
        states: Mapping[str, MemberState],
        decided: Mapping[str, Twist2D],
        now: float,
    ) -> Twist2D:
        """Return the twist of a follower: towards its point, smooth, and without collision.

        Args:
            name: Of the follower.
            point: Where it should be.
            states: Of all robots.
            decided: Twists of those that go before this one.
            now: s.
        """
        tuning, safety = self.settings.tracking, self.settings.safety
        robot = _predicted(states[name], now, self._lag)
        goal = twist_towards(self._approach(point, robot.pose), robot.pose, tuning)
        wanted = Twist2D(self._reachable(name, goal.linear), goal.angular)
        others = []
        for other, state in states.items():
            if other != name:
                is_still = self.members.is_silent(state, now)
                seen = state if is_still else _predicted(state, now, self._lag)
                gives_way = other != self.leader and other not in decided and not is_still
                twist = REST if is_still else decided.get(other, seen.twist)
                radius = self.settings.radius(other)
                others.append(MovingDisc(seen.pose.relative_to(robot.pose), twist, radius, gives_way))
        echoes = [
            robot.pose.locate(x, y)
            for x, y in (states[name].pose.transform(*echo.point) for echo in states[name].echoes)
            if all(
                math.hypot(x - state.pose.x, y - state.pose.y) > self.settings.radius(other) + 0.2
                for other, state in states.items()
                if other != name
            )
        ]
        most = Twist2D(tuning.speed_m_s, tuning.turn_rad_s)
        chosen = admissible_twist(wanted, goal, echoes, others, self.settings.radius(name), safety, most)
        linear = self._reachable(name, chosen.linear)
        if chosen == wanted or linear == chosen.linear:
            return chosen
        return Twist2D(linear, chosen.angular * linear / chosen.linear)  # the same arc

    def _reachable(self, name: str, linear: float) -> float:
        """Return the speed nearest to one that the acceleration allows now, m/s; a robot brakes as fast as it can."""
        before = self.members.followers[name].command.linear
        change = self.settings.tracking.acceleration_m_s2 * self.settings.period_s
        if abs(linear) <= abs(before) and linear * before >= 0.0:
            return linear
        return max(before - change, min(before + change, linear))

    def _approach(self, point: VirtualPoint, robot: Pose2D) -> VirtualPoint:
        """Return where a follower drives to now: its point, or in a column a nearer point of the leader's path.

        A straight line to a distant point could lead through a wall; the leader's path does not.
        """
        if self.formed != COLUMN or math.dist(_xy(robot), _xy(point.pose)) < self.settings.tracking.join_m:
            return point
        backs, _ = self._path.locate(np.array([[robot.x, robot.y]]), 0.0, PATH_LENGTH)
        aim = float(backs[0]) - AHEAD
        goal, _ = self._path.locate(np.array([[point.pose.x, point.pose.y]]), 0.5, PATH_LENGTH)
        if aim <= float(goal[0]):
            return point
        pose = self._path.at(aim)
        return VirtualPoint(pose, Twist2D(point.twist.linear, 0.0))

    def _wait(self, why: str) -> None:
        if why != self.waits_for and (why or self.waits_for):
            self.members.told.append(f"{why}; the followers stand" if why else "the followers drive on")
        self.waits_for = why

    def _commanded(self, twists: Mapping[str, Twist2D]) -> Mapping[str, Twist2D]:
        for name, twist in twists.items():
            self.members.followers[name].command = twist
        return twists


def _predicted(state: MemberState, now: float, lag: float) -> MemberState:
    """Return a state as it is when a command given now takes hold."""
    seconds = max(0.0, now - state.heard) + lag
    return MemberState(integrate(state.pose, state.twist, seconds), state.twist, state.heard, state.echoes)


def _xy(pose: Pose2D) -> Point:
    return pose.x, pose.y


def _named(shape: str) -> str:
    return "formation" if shape.endswith(".toml") else shape
