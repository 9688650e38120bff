"""The follower: sightings of the leader, own poses and ranges in, a twist and the camera's direction out."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from math import copysign, hypot, inf, sqrt

from apps.robot_following.curve import BezierCurve
from apps.robot_following.gaze import pan_to, sweep, swing_time
from apps.robot_following.leader import LeaderState, LeaderTrack, Sighting
from apps.robot_following.room import RoomAhead
from apps.robot_following.settings import FollowingSettings
from geometry import Point, Pose2D, Twist2D, integrate, wrap_angle

STAND = Twist2D(0.0, 0.0)
_SEEN = 0.4  # s without a sighting for which the leader counts as seen
_TRAIL = 60  # poses of the leader


class FollowerState(Enum):
    """What the follower does, in the words that a person reads."""

    WAITING = "waits for a leader to come into view"
    FOLLOWING = "follows"
    STANDING = "stands behind the leader"
    HELD = "is held by an obstacle"
    COASTING = "goes on without seeing the leader"
    SEARCHING = "looks for the leader"
    GIVEN_UP = "has given up looking for the leader"


@dataclass(frozen=True, slots=True)
class FollowingStep:
    """What the follower is to do now.

    twist: of the base. pan: of the camera's head, rad. curve: that it drives, in odom, or None. leader: where it is
    believed to be. gap: m along the curve.
    """

    state: FollowerState
    twist: Twist2D
    pan: float
    curve: BezierCurve | None = None
    leader: LeaderState | None = None
    gap: float | None = None


class SightFollower:
    """Follows one leader.

    With every sighting a cubic Bézier curve leads from the own pose to the leader's, along both headings. The follower
    drives along it as fast as keeps the gap, so it cuts the corners that the leader drives, and its path is smoother.
    """

    def __init__(self, settings: FollowingSettings, pan_reach: float = 0.0) -> None:
        """Begin.

        Args:
            settings: Of the application.
            pan_reach: How far the camera's head goes to either side, rad; 0 without one.
        """
        self._settings = settings
        self._pan_reach = pan_reach
        self._track = LeaderTrack(settings.leader)
        self._trail: deque[Pose2D] = deque(maxlen=_TRAIL)
        self._seen_at = -inf
        self._began_at: float | None = None
        self._aim = self._side = 0.0  # rad; where the camera looks for the target, and to which side the leader turned
        self._twist = STAND
        self._speed = 0.0
        self._turning = 0.0  # to which side it turns about where the leader was last; 0 until it is there
        self._stepped_at: float | None = None
        self.state = FollowerState.WAITING

    def expected(self, at: float) -> Pose2D | None:
        """Return where the leader should be in odom at a time, s; None if it has not been seen for a while."""
        if not self._track.is_known or at - self._seen_at > self._settings.search.sweep_after:
            return None
        return self._track.at(at).pose

    def forget(self) -> None:
        """Forget the leader; it is waited for again."""
        self._track.forget()
        self._trail.clear()
        self._began_at, self._seen_at, self._speed = None, -inf, 0.0

    def see(self, sighting: Sighting, at: float) -> None:
        """Take a sighting; at: when the image was exposed, s."""
        if self._track.see(sighting, at):
            self._seen_at = at

    def step(self, now: float, pose: Pose2D, obstacles: Sequence[Point], *, is_blind: bool = False) -> FollowingStep:
        """Return what to do; `state` is that of the result afterwards.

        Args:
            now: s.
            pose: Own, in odom.
            obstacles: Where range sensors have an echo, in the robot's frame, m.
            is_blind: Whether the camera gives no pictures that can be used; it then does not drive in search of the
                leader.
        """
        step = self._step(now, pose, obstacles, is_blind)
        self.state, self._twist = step.state, step.twist
        return step

    def _step(self, now: float, pose: Pose2D, obstacles: Sequence[Point], is_blind: bool) -> FollowingStep:
        elapsed = 0.0 if self._stepped_at is None else now - self._stepped_at
        self._stepped_at = now
        if self._began_at is None:
            self._began_at = now
        unseen = now - max(self._seen_at, self._began_at)
        if not self._track.is_known:
            return self._look_about(unseen, FollowerState.WAITING)
        leader = self._track.at(now)
        if unseen > self._settings.search.coast:
            self._speed = 0.0
            if is_blind:
                return self._look_about(unseen, FollowerState.SEARCHING)
            last = self._track.at(self._seen_at + self._settings.search.coast).pose
            if unseen <= self._settings.search.sweep_after:  # it stops, so the lead was too much
                self._aim = self._aim_at(last, pose)
            return self._search(unseen, pose, last, obstacles)
        lead = self._settings.search.pan_lead
        self._aim = self._aim_at(self._track.at(now + lead).pose, integrate(pose, self._twist, lead))
        self._side = wrap_angle(leader.pose.heading - pose.heading)
        self._turning = 0.0
        self._keep_trail(pose, leader.pose)
        return self._follow(leader, pose, obstacles, elapsed, is_seen=unseen <= _SEEN)

    def _look_about(self, unseen: float, state: FollowerState) -> FollowingStep:
        """Stand and swing the camera."""
        search = self._settings.search
        if unseen > search.give_up:
            return FollowingStep(FollowerState.GIVEN_UP, STAND, 0.0)
        since = unseen - search.sweep_after
        pan = (
            sweep(since, self._aim, self._side, search, self._pan_reach)
            if since > 0.0
            else pan_to(self._aim, self._pan_reach)
        )
        return FollowingStep(state, STAND, pan)

    def _search(self, unseen: float, pose: Pose2D, last: Pose2D, obstacles: Sequence[Point]) -> FollowingStep:
        """Stand, then swing the camera to both sides, then drive to where the leader was last, and turn about there.

        It turns first to where the leader was headed, and then on, since it may have gone anywhere from there.
        """
        search, drive = self._settings.search, self._settings.drive
        step = self._look_about(unseen, FollowerState.SEARCHING)
        if step.state is FollowerState.GIVEN_UP:
            self._track.forget()
            return step
        if not self._turning and unseen < search.sweep_after + swing_time(search, self._pan_reach):
            return step
        away, bearing = hypot(last.x - pose.x, last.y - pose.y), pose.bearing_to(last.x, last.y)
        if away > drive.nearest and not self._turning:
            turn = max(-search.turn, min(search.turn, 2.0 * bearing))
            way = BezierCurve.between(pose, last, drive.reach)
            room = RoomAhead(self._settings.room, pose, last, obstacles).along(way, self._settings.room.margin)
            if room > 0.0:
                speed = min(search.speed, sqrt(2.0 * drive.braking * room))
                return FollowingStep(step.state, Twist2D(speed if abs(bearing) < drive.face else 0.0, turn), step.pan)
        if not self._turning:
            self._turning = copysign(1.0, wrap_angle(last.heading - pose.heading))
        return FollowingStep(step.state, Twist2D(0.0, self._turning * search.turn), step.pan)

    def _follow(
        self, leader: LeaderState, pose: Pose2D, obstacles: Sequence[Point], elapsed: float, is_seen: bool
    ) -> FollowingStep:
        drive = self._settings.drive
        curve, room, rest = self._best_curve(pose, leader.pose, obstacles)
        gap = curve.length + rest
        pan = pan_to(self._aim, self._pan_reach)
        bearing = pose.bearing_to(leader.pose.x, leader.pose.y)
        straight = hypot(leader.pose.x - pose.x, leader.pose.y - pose.y)
        wanted = self._wanted_speed(leader, gap, straight)
        free = sqrt(2.0 * drive.braking * room) if room > 0.0 else 0.0
        speed = min(wanted, free, self._speed + drive.acceleration * elapsed)
        self._speed = max(0.0, speed, self._speed - drive.braking * elapsed if free > 0.0 else 0.0)
        state = FollowerState.FOLLOWING if is_seen else FollowerState.COASTING
        if wanted > 0.0 and free < min(wanted, drive.resting):
            state = FollowerState.HELD
        if wanted <= 0.0 and self._speed == 0.0:
            turn = 0.0 if abs(bearing) < drive.face else max(-drive.turn, min(drive.turn, bearing))
            return FollowingStep(FollowerState.STANDING, Twist2D(0.0, turn), pan, curve, leader, gap)
        return FollowingStep(state, Twist2D(self._speed, self._turn(curve, pose)), pan, curve, leader, gap)

    def _aim_at(self, leader: Pose2D, pose: Pose2D) -> float:
        """Return the bearing of the leader's target from the camera of the robot at a pose, rad."""
        camera = pose.compose(Pose2D(self._settings.camera.forward))
        return camera.bearing_to(*leader.transform(-self._settings.leader.carried, 0.0))

    def _wanted_speed(self, leader: LeaderState, gap: float, straight: float) -> float:
        """Return the speed that keeps the gap, m/s; 0 where the leader stands near enough."""
        drive = self._settings.drive
        off = gap - drive.gap
        if straight < drive.nearest or (abs(leader.speed) < drive.resting and off < drive.resting):
            return 0.0
        if self._speed == 0.0 and off < drive.resting and leader.speed < drive.starting:
            return 0.0  # the estimated speed of a leader that stands is not exactly 0, and the follower would creep
        closing = copysign(sqrt(2.0 * drive.braking * abs(off)), off)  # what can be braked within the error
        wanted = max(0.0, leader.speed) + max(-abs(closing), min(abs(closing), drive.gap_gain * off))
        return max(0.0, min(drive.speed, wanted))

    def _turn(self, curve: BezierCurve, pose: Pose2D) -> float:
        """Return the rate of turn along the arc to a place ahead on the curve, rad/s (pure pursuit)."""
        drive = self._settings.drive
        ahead = curve.pose_after(max(drive.least_aim, self._speed * drive.aim))
        along, aside = ahead.relative_to(pose).x, ahead.relative_to(pose).y
        curvature = 2.0 * aside / max(along**2 + aside**2, 1e-6)
        return max(-drive.turn, min(drive.turn, self._speed * curvature))

    def _best_curve(self, pose: Pose2D, leader: Pose2D, obstacles: Sequence[Point]) -> tuple[BezierCurve, float, float]:
        """Return the curve to drive, the way free along it, and how far the leader is beyond its end, m.

        That is the curve to the leader, if there is room for it. If not, it ends earlier on the trail of the leader,
        which had room there: the nearer its end, the less it cuts the corners. Where no curve has the usual margin, as
        in doors, the tight one is enough.
        """
        ahead = RoomAhead(self._settings.room, pose, leader, obstacles)
        for margin in (self._settings.room.margin, self._settings.room.tight):
            best = None
            rest, after = 0.0, leader
            for goal in (leader, *reversed(self._trail)):
                rest, after = rest + hypot(after.x - goal.x, after.y - goal.y), goal
                if goal is not leader and goal.relative_to(pose).x < self._settings.drive.least_aim:
                    break
                curve = BezierCurve.between(pose, goal, self._settings.drive.reach)
                free = ahead.along(curve, margin)
                if free == inf:
                    return curve, free, rest
                if best is None or free > best[1]:
                    best = curve, free, rest
        assert best is not None  # the leader itself
        return best

    def _keep_trail(self, pose: Pose2D, leader: Pose2D) -> None:
        """Add the leader's pose to its trail, and forget what the follower has passed."""
        last = self._trail[-1] if self._trail else None
        if last is None or hypot(leader.x - last.x, leader.y - last.y) > self._settings.drive.trail:
            self._trail.append(leader)
        while len(self._trail) > 1 and self._trail[0].relative_to(pose).x < 0.0:
            self._trail.popleft()
