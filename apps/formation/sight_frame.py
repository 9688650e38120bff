"""Poses by sight: each follower sees the leader's target, and all are placed in one frame by that. No bus, no clock."""

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from apps.formation.members import MemberState, RangeEcho
from apps.formation.settings import SightSettings
from apps.robot_following.leader import LeaderState
from geometry import Pose2D, Twist2D, integrate


@dataclass(frozen=True, slots=True)
class FollowerView:
    """What a follower knows by itself.

    pose, twist: own, in the frame of its odometry, m, rad, m/s and rad/s. leader: as it sees it, in the same frame;
    None while it does not. echoes: of its range sensors.
    """

    pose: Pose2D
    twist: Twist2D
    leader: LeaderState | None
    echoes: tuple[RangeEcho, ...] = ()


class SightFrame:
    """One frame for all members, in which the leader drives as its followers see it drive.

    A follower has the place relative to the leader at which it sees itself, so that its distance from its virtual point
    depends on its own camera alone. The frame drifts with the leader, which matters to nobody. A follower that does not
    see the leader for some time is placed by its odometry, as long as others see the leader.
    """

    def __init__(self, leader: str, followers: Sequence[str], settings: SightSettings) -> None:
        """Begin with the leader in the origin.

        Args:
            leader: Its name.
            followers: Their names.
            settings: Times for which robots may be out of sight.
        """
        self._leader = leader
        self._unplaced = set(followers)
        self._settings = settings
        self._at = Pose2D()
        self._twist = Twist2D()
        self._begun: float | None = None
        self._time = self._led_at = 0.0  # s of the last update, and when somebody saw the leader
        self._origins: dict[str, Pose2D] = {}  # of each follower's odometry
        self._seen_at: dict[str, float] = {}
        self._states: dict[str, MemberState] = {}

    def update(self, now: float, views: Mapping[str, FollowerView]) -> dict[str, MemberState]:
        """Return the states of the leader and of the followers that have seen it.

        Who does not know any more where it is keeps its last state, and so falls silent. There are no states before
        all have seen the leader, or have looked for it long enough.

        Args:
            now: s.
            views: Of the followers that are heard of.
        """
        seen = {name: view.leader for name, view in views.items() if view.leader is not None}
        if self._begun is None:
            self._begun = self._time = now
        elapsed, self._time = now - self._time, now
        if seen:
            speeds, turns = [each.speed for each in seen.values()], [each.turn for each in seen.values()]
            self._twist = Twist2D(statistics.fmean(speeds), statistics.fmean(turns))
            self._led_at = now
        elif now - self._led_at > self._settings.unled_s:
            self._origins.clear()  # it goes on unseen, and nobody knows where it is
            self._twist = Twist2D()
        self._at = integrate(self._at, self._twist, elapsed)
        self._states.pop(self._leader, None)
        if seen:
            self._states[self._leader] = MemberState(self._at, self._twist, now)
        for name, view in views.items():
            if name in seen:
                self._origins[name] = self._at.compose(Pose2D().relative_to(seen[name].pose))
                self._seen_at[name] = now
                self._unplaced.discard(name)
            if name in self._origins and now - self._seen_at[name] <= self._settings.blind_s:
                self._states[name] = MemberState(self._origins[name].compose(view.pose), view.twist, now, view.echoes)
            elif name in self._states:  # its echoes are of unknown places
                self._states[name] = replace(self._states[name], twist=Twist2D(), echoes=())
        is_begun = not self._unplaced or now - self._begun > self._settings.gather_s
        return dict(self._states) if is_begun else {}

    def gaze(self, follower: str, view: FollowerView) -> float | None:
        """Return the bearing at which a follower will have the leader when its head has turned, rad.

        One that does not see the leader looks to where the others see it; None if nobody does.
        """
        if view.leader is not None:
            leader = view.leader.pose
        elif follower in self._origins:
            leader = self._at.relative_to(self._origins[follower])
        else:
            return None
        ahead = integrate(leader, self._twist, self._settings.gaze_s)
        return integrate(view.pose, view.twist, self._settings.gaze_s).bearing_to(ahead.x, ahead.y)

    def in_view(self, follower: str, twist: Twist2D) -> Twist2D:
        """Return the twist for a follower, or rest if it would turn away from a leader that is far aside already."""
        state, leader = self._states.get(follower), self._states.get(self._leader)
        if state is None or leader is None:
            return twist
        bearing = state.pose.bearing_to(leader.pose.x, leader.pose.y)
        turns_away = twist.angular * bearing < 0.0
        return Twist2D() if turns_away and abs(bearing) > self._settings.turned_rad else twist
