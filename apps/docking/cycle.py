"""What a robot does to reach its dock, be charged and leave it: readings in, orders out. No bus, no clock."""

from dataclasses import dataclass
from enum import StrEnum
from math import atan2, inf, sqrt

import numpy as np

from agents.components.pose_control import PoseControlLimits, PoseGoal
from apps.docking.settings import DockingSettings
from apps.docking.station import Floats, find_dock, to_frame
from geometry import Pose2D, Twist2D, wrap_angle

STILL = Twist2D()
RELEASE = 1.5  # s of driving back for which a contact may still be that which the robot leaves
APART = 2.0  # s between two contacts of one obstacle; a stalled robot tries again now and then
STUCK = 4.0  # s of contact after which a robot that drives to the dock does not get there


class DockingState(StrEnum):
    """What the robot does."""

    GO = "drives to the dock"
    LOOK = "looks for the station"
    APPROACH = "drives onto the dock"
    CHARGE = "lowers its contacts"
    BACK = "drives back for another attempt"
    LEAVE = "leaves the dock"
    CHARGED = "is charged"
    LEFT = "has left the dock"
    GIVEN_UP = "has given up"


_ENDS = (DockingState.CHARGED, DockingState.LEFT, DockingState.GIVEN_UP)


@dataclass(frozen=True, slots=True)
class DockingOrders:
    """What to do now.

    twist: None while the motors are to be left alone, since lowered contacts have them off.
    contacts: True to lower the charging contacts, False to raise them, None to leave them. reason: of the state, in
    words. changed: state or reason are new.
    """

    state: DockingState
    twist: Twist2D | None
    contacts: bool | None
    reason: str
    changed: bool


@dataclass(frozen=True, slots=True)
class DockingHull:
    """The outline of the robot, m: from the axle to its front, and its width."""

    front: float
    width: float


class DockingCycle:
    """Decides what one robot does, step by step. Times are s on any steady clock; poses are in odom.

    dock: pose of the robot on its dock, corrected with each sighting of the station.
    """

    def __init__(
        self,
        settings: DockingSettings,
        dock: Pose2D,
        hull: DockingHull,
        *,
        needs_station: bool = True,
        leaves: bool = False,
    ) -> None:
        """Begin.

        Args:
            settings: Of the application.
            dock: Where the dock is expected.
            hull: Of the robot.
            needs_station: The station has to be seen; else the pose of the dock counts as it is.
            leaves: The robot stands on the dock and is to leave it.
        """
        self.dock = dock
        self.state = DockingState.LEAVE if leaves else DockingState.GO
        self.reason = "it was asked to" if leaves else "it was sent there"
        self._settings, self._hull, self._needs_station = settings, hull, needs_station
        self._sightings = 0
        self._attempts = 0
        self._since = -inf  # when the state began
        self._clear_at = -inf  # when the way was free last
        self._scan: Floats | None = None
        self._scan_at = -inf
        self._was_there = False
        self._told: tuple[DockingState, str] | None = None
        self._contacts: bool | None = False if leaves else None  # an order that is due
        self._left_from: Pose2D | None = None
        self._touches_since = self._touched_at = -inf

    @property
    def has_ended(self) -> bool:
        """Whether nothing is left to do."""
        return self.state in _ENDS

    def take_scan(self, stamp: float, points: Floats, pose: Pose2D) -> None:
        """Take a scan.

        Args:
            stamp: When it was made; one that is not newer than the last is ignored.
            points: Echoes in the robot's frame, m, shape (n, 2), in the order of the beams.
            pose: Of the robot at that time.
        """
        if stamp <= self._scan_at:
            return
        self._scan_at = stamp
        away = to_frame(points, Pose2D().relative_to(pose))  # in odom
        self._scan = away
        if self.state not in (DockingState.LOOK, DockingState.APPROACH) or not self._needs_station:
            return
        seen = find_dock(away, self.dock, self._settings.station)
        if seen is not None:
            self._sightings += 1
            share = max(self._settings.station.share, 1.0 / self._sightings)
            turned = wrap_angle(seen.heading - self.dock.heading)
            self.dock = Pose2D(
                self.dock.x + share * (seen.x - self.dock.x),
                self.dock.y + share * (seen.y - self.dock.y),
                wrap_angle(self.dock.heading + share * turned),
            )

    def step(self, now: float, pose: Pose2D, *, charging: bool, contact: bool = False) -> DockingOrders:
        """Decide.

        Args:
            now: s, on the clock of the stamps.
            pose: Of the robot.
            charging: The battery is charged.
            contact: A bumper is pressed or a wheel stalls.
        """
        if self._since == -inf:
            self._since = self._clear_at = now
        twist = self._decide(now, pose, charging, contact)
        changed = (self.state, self.reason) != self._told
        self._told = self.state, self.reason
        contacts, self._contacts = self._contacts, None
        is_docked = self.state in (DockingState.CHARGE, DockingState.CHARGED)
        return DockingOrders(self.state, None if is_docked else twist, contacts, self.reason, changed)

    def _decide(self, now: float, pose: Pose2D, charging: bool, contact: bool) -> Twist2D:
        drives_on = self.state in (DockingState.GO, DockingState.LOOK, DockingState.APPROACH)
        if charging and (drives_on or self.state is DockingState.CHARGE):
            return self._become(DockingState.CHARGED, "the battery is charged", now)
        if self._is_lost_by(contact, now):
            return self._lose("the robot has touched something", now)
        match self.state:
            case DockingState.GO:
                return self._go(now, pose)
            case DockingState.LOOK:
                return self._look(now, pose)
            case DockingState.APPROACH:
                return self._approach(now, pose)
            case DockingState.CHARGE if now - self._since > self._settings.charge.wait_s:
                return self._lose("the contacts have found no power", now)
            case DockingState.BACK | DockingState.LEAVE:
                return self._back(now, pose, contact)
        return STILL

    def _is_lost_by(self, contact: bool, now: float) -> bool:
        """Return whether a contact ends the attempt: at once on the way onto the dock, before if it lasts."""
        if not contact:
            return False
        if now - self._touched_at > APART:
            self._touches_since = now
        self._touched_at = now
        lasts = now - max(self._touches_since, self._since) > STUCK
        return self.state is DockingState.APPROACH or (lasts and self.state is DockingState.GO)

    def _become(self, state: DockingState, reason: str, now: float) -> Twist2D:
        self.state, self.reason, self._since, self._clear_at = state, reason, now, now
        self._was_there = False
        if state is DockingState.LOOK:
            self._sightings = 0
        return STILL

    def _lose(self, reason: str, now: float) -> Twist2D:
        """End an attempt."""
        self._attempts += 1
        self._contacts = False
        return self._become(DockingState.BACK, reason, now)

    @property
    def _start(self) -> Pose2D:
        """Where the straight approach begins."""
        return self.dock.compose(Pose2D(-self._settings.approach.away_m, 0.0, 0.0))

    def _go(self, now: float, pose: Pose2D) -> Twist2D:
        approach = self._settings.approach
        limits = PoseControlLimits(approach.speed_m_s, approach.turn_rad_s)
        start = self._start
        velocity, self._was_there = limits.towards(PoseGoal(start.x, start.y, start.heading), pose, self._was_there)
        if velocity.is_done:
            return self._become(DockingState.LOOK, "it stands before the dock", now)
        twist = Twist2D(velocity.linear, velocity.angular)
        return self._if_clear(now, pose, twist)

    def _look(self, now: float, pose: Pose2D) -> Twist2D:
        settings = self._settings
        if self._needs_station and self._sightings < settings.station.sightings:
            if now - self._since > settings.approach.look_s:
                return self._lose("no station is seen where the dock should be", now)
            return STILL
        along, across = self._start.locate(pose.x, pose.y)
        turned = wrap_angle(pose.heading - self.dock.heading)
        off = max(abs(along), abs(across)) > settings.approach.off_m or abs(turned) > settings.approach.turned_rad
        if off:
            return self._become(DockingState.GO, "the station is seen elsewhere", now)
        return self._become(DockingState.APPROACH, "it stands straight before the station", now)

    def _approach(self, now: float, pose: Pose2D) -> Twist2D:
        approach, dock = self._settings.approach, self._settings.dock
        along, across = self.dock.locate(pose.x, pose.y)
        turned = wrap_angle(pose.heading - self.dock.heading)
        if -along <= dock.along_m:
            if abs(across) > dock.across_m or abs(turned) > dock.turned_rad:
                return self._lose(f"it stands {abs(across):.2f} m beside the dock, {abs(turned):.2f} rad turned", now)
            self._contacts = True
            return self._become(DockingState.CHARGE, "it stands on the dock", now)
        steer = approach.gain * wrap_angle(atan2(-across, approach.ahead_m) - turned)
        speed = min(approach.straight_m_s, max(approach.creep_m_s, sqrt(2.0 * approach.braking_m_s2 * -along)))
        return self._if_clear(now, pose, Twist2D(speed, max(-approach.turn_rad_s, min(approach.turn_rad_s, steer))))

    def _back(self, now: float, pose: Pose2D, contact: bool) -> Twist2D:
        charge = self._settings.charge
        if self._left_from is None:
            self._left_from = pose
        gone = -self._left_from.locate(pose.x, pose.y)[0]
        is_leaving = self.state is DockingState.LEAVE
        way = charge.leave_m if is_leaving else max(0.0, self._settings.approach.away_m + self._along(self._left_from))
        is_behind = contact and (is_leaving or now - self._since > RELEASE)
        if gone < way and not is_behind:
            return Twist2D(-charge.back_m_s, 0.0)
        self._left_from = None
        if is_leaving:
            reason = "something is behind the robot" if is_behind else "it stands before the dock"
            return self._become(DockingState.GIVEN_UP if is_behind else DockingState.LEFT, reason, now)
        if self._attempts >= self._settings.attempts:
            return self._become(DockingState.GIVEN_UP, f"{self._attempts} attempts have failed; {self.reason}", now)
        return self._become(DockingState.GO, f"attempt {self._attempts + 1}: {self.reason}", now)

    def _along(self, pose: Pose2D) -> float:
        """How far a pose is ahead of the dock, along its axis, m; negative before it is reached."""
        return self.dock.locate(pose.x, pose.y)[0]

    def _if_clear(self, now: float, pose: Pose2D, twist: Twist2D) -> Twist2D:
        """Return a velocity, or none while something is in the way or no scan tells that nothing is."""
        settings = self._settings
        if self._scan is not None and now - self._scan_at > settings.silent_s:
            self.reason = "the laser is silent"
        elif twist.linear > 0.0 and self._is_barred(pose):
            self.reason = "something is in the way"
        else:
            if self.reason in ("the laser is silent", "something is in the way"):
                self.reason = "the way is free again"
            self._clear_at = now
            return twist
        if now - self._clear_at > settings.clear.wait_s:
            return self._become(DockingState.GIVEN_UP, self.reason, now)
        return STILL

    def _is_barred(self, pose: Pose2D) -> bool:
        """Tell whether an echo that is none of the station is close before the hull."""
        if self._scan is None:
            return False
        clear, station = self._settings.clear, self._settings.station
        local = to_frame(self._scan, pose)
        ahead = (local[:, 0] > 0.0) & (local[:, 0] < self._hull.front + clear.ahead_m)
        beside = np.abs(local[:, 1]) < self._hull.width / 2 + clear.beside_m
        of_dock = to_frame(self._scan, self.dock)
        across = station.width_m / 2 + clear.station_m
        is_station = (of_dock[:, 0] > station.ahead_m - clear.station_m) & (np.abs(of_dock[:, 1]) < across)
        # What lies behind the face of the station is not on the way onto the dock.
        is_beyond = of_dock[:, 0] > station.ahead_m + clear.station_m
        if self.state is DockingState.APPROACH:
            is_station |= is_beyond
        return bool(np.any(ahead & beside & ~is_station))
