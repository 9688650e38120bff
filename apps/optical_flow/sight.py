"""What images say at once: what they add to the memory, contact ahead, and whether they are frozen."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from apps.optical_flow.columns import FlowColumns
from apps.optical_flow.memory import FloorMemory
from apps.optical_flow.settings import FlowSettings
from geometry import Pose2D, Twist2D

_POSES = 40  # odometry readings that are kept
_MOVES = 0.5  # px/s of flow from which on a column moves
_MOVING = 0.2  # share of the columns that moves, from which on images are not frozen
_FORWARD, _TURNING = 0.04, 0.1  # m/s and rad/s from which on a robot moves


@dataclass(frozen=True, slots=True)
class FlowReadings:
    """What is known at one time.

    time: s on a steady clock. stamp: of the odometry, s on the clock of the images. pose, twist: by odometry.
    columns: of the newest image; None if no new one has come. trouble: why the newest image cannot be used; empty if
    nothing is wrong. touches: whether bumpers or stalled wheels show a contact.
    is_rear: whether only bumpers at the rear do; None where no bumper says where.
    """

    time: float
    stamp: float
    pose: Pose2D
    twist: Twist2D
    columns: FlowColumns | None = None
    trouble: str = ""
    touches: bool = False
    is_rear: bool | None = None


class FlowSight:
    """Takes readings as they come, and puts what images show into a memory.

    image_at: s, when the last usable image came. unmoved: s for which columns have not moved although the robot does.
    moves: whether those of the newest image do. has_seen: whether images have shown what is ahead since the robot last
    turned on the spot. contact: s at full speed until contact in the lane, by the newest image alone.
    """

    def __init__(self, settings: FlowSettings, memory: FloorMemory) -> None:
        self.image_at = -math.inf
        self.unmoved = 0.0
        self.moves = False
        self.has_seen = False
        self.contact = math.inf
        self._settings = settings
        self._memory = memory
        self._poses: deque[tuple[float, Pose2D, Twist2D]] = deque(maxlen=_POSES)
        self._moving_since = math.inf  # stamp
        self._way = 0.0  # m since it turned on the spot

    def take(self, readings: FlowReadings, dt: float) -> float:
        """Take readings, dt s after those before; returns by how much the robot has moved, m."""
        step = 0.0
        if not self._poses or readings.stamp > self._poses[-1][0]:
            if self._poses:
                last = self._poses[-1][1]
                step = math.dist((last.x, last.y), (readings.pose.x, readings.pose.y))
            self._poses.append((readings.stamp, readings.pose, readings.twist))
        self._way += step
        is_steady = readings.twist.linear >= self._settings.memory.least_m_s
        self._moving_since = min(self._moving_since, readings.stamp) if is_steady else math.inf
        if readings.columns is not None and not readings.trouble:
            self.image_at = readings.time
            self.moves = bool((np.nan_to_num(readings.columns.motion) > _MOVES).mean() > _MOVING)
            if self.moves:
                self.unmoved = 0.0
            elif abs(readings.twist.linear) > _FORWARD or abs(readings.twist.angular) > _TURNING:
                self.unmoved += dt
            self.contact = self._contact_in_lane(readings.columns, readings.twist)
            self._remember(readings.columns)
        return step

    def begin_anew(self) -> None:
        """Note that the robot has turned on the spot, so that nothing is known of what is ahead."""
        self._way, self.has_seen, self.contact = 0.0, False, math.inf

    def _remember(self, columns: FlowColumns) -> None:
        memory, robot = self._settings.memory, self._settings.robot
        if columns.stamp - self._moving_since < memory.settle_s or self._turns_fast(columns):
            return
        speed = self._speed(columns.stamp - columns.interval, columns.stamp)
        if speed < memory.least_m_s:
            return
        with np.errstate(invalid="ignore", divide="ignore"):  # NaN and zero rates, which `where` leaves out
            depths = np.where(columns.rates > 1e-3, speed / columns.rates, np.inf)
            doubtful = columns.deviations > memory.doubt * columns.rates + 0.03
        depths = np.where(np.isnan(columns.rates) | doubtful, np.nan, depths)
        at = min(self._poses, key=lambda each: abs(each[0] - columns.stamp))
        self.has_seen = True
        half = float(np.abs(np.diff(columns.bearings)).mean()) / 2.0
        self._memory.see(at[1].compose(Pose2D(robot.camera_m)), columns.bearings, depths, half)

    def _contact_in_lane(self, columns: FlowColumns, twist: Twist2D) -> float:
        """Return the time to contact at full speed that enough columns in the lane are below, s; infinite for none."""
        memory, robot = self._settings.memory, self._settings.robot
        if self._way < memory.reflex_m or twist.linear < memory.least_m_s or self._turns_fast(columns):
            return math.inf
        with np.errstate(invalid="ignore", divide="ignore"):  # likewise
            depths = np.where(columns.rates > 1e-3, twist.linear / columns.rates, np.inf)
            is_ahead = depths * np.abs(np.tan(columns.bearings)) < robot.width_m / 2.0
        gaps = np.sort(depths[is_ahead]) - (robot.front_m - robot.camera_m)
        number = int(memory.reflex_columns)
        return float(gaps[number - 1]) / self._settings.drive.speed_m_s if len(gaps) >= number else math.inf

    def _turns_fast(self, columns: FlowColumns) -> bool:
        """Return whether the robot turned so fast, between the images that were compared, that it hides the flow."""
        begin, most = columns.stamp - columns.interval - self._settings.period_s, self._settings.memory.most_rad_s
        return any(abs(twist.angular) > most for stamp, _, twist in self._poses if stamp >= begin)

    def _speed(self, begin: float, end: float) -> float:
        """Return the mean speed forward between two stamps, m/s."""
        kept = [twist.linear for stamp, _, twist in self._poses if begin <= stamp <= end]
        return sum(kept) / len(kept) if kept else self._poses[-1][2].linear
