"""The robot's pose in `odom`: continuous over roll-overs and reconnects, calibrated, with its uncertainty.

The origin of `odom` is where the robot stood when its gateway first connected, and its x axis points to where the robot
faced then: the first pose is zero, whatever the robot's counters hold. A gateway that is restarted has a new origin.

After a reconnect the counters are believed if the robot can have driven there meanwhile: what it rolled unheard is then
in the pose. Otherwise, and when the counters are back at zero (a reset), the pose goes on from where it was.
"""

from math import cos, hypot, sin

from gateway.settings import Calibration, OdometryErrors
from geometry import Pose2D, wrap_angle
from p2os import OdometryUnwrapper, RobotModel, StandardSip


class OdometryTracker:
    """Dead reckoning from SIPs.

    pose: in `odom`. turned: rad since the start, not wrapped. linear, angular: velocity, m/s and rad/s.
    """

    def __init__(self, calibration: Calibration, errors: OdometryErrors) -> None:
        self._calibration = calibration
        self._errors = errors
        self._unwrapper: OdometryUnwrapper | None = None
        self._last: tuple[float, float, float] | None = None  # x, y, heading as the robot counts; m, m, rad
        self._variances = [0.0] * 9
        self.pose = Pose2D()
        self.turned = 0.0
        self.linear = 0.0
        self.angular = 0.0

    @property
    def covariance(self) -> tuple[float, ...]:
        """Of x, y and heading, row by row, 3 by 3; m², m·rad, rad²."""
        return tuple(self._variances)

    def forget_counters(self) -> None:
        """Note that the robot's counters begin again; the pose continues."""
        self._last = None
        if self._unwrapper is not None:
            self._unwrapper.rebase()

    def update(self, sip: StandardSip, model: RobotModel, turned: float | None = None) -> None:
        """Take the next SIP.

        Args:
            sip: As it came.
            model: Of the robot.
            turned: rad since the last SIP by a gyro, which is more accurate than the wheels; None to use the wheels.
        """
        if self._unwrapper is None:
            self._unwrapper = OdometryUnwrapper(model)
        x, y = self._unwrapper.update(sip.x, sip.y)
        last = self._last or (x, y, sip.heading)
        self._last = (x, y, sip.heading)
        self._advance(x - last[0], y - last[1], last[2], wrap_angle(sip.heading - last[2]), turned)
        self.linear = (sip.left_velocity + sip.right_velocity) / 2.0 * self._calibration.distance
        turning = sip.rotational_velocity
        if turning is None:
            turning = (sip.right_velocity - sip.left_velocity) / model.wheel_track
        self.angular = turning * self._calibration.heading

    def _advance(self, dx: float, dy: float, heading: float, turn: float, true_turn: float | None) -> None:
        """Append a step given in the frame of the robot's counters: seen from the robot, and calibrated."""
        middle = heading + turn / 2.0
        forward = (dx * cos(middle) + dy * sin(middle)) * self._calibration.distance
        aside = (dy * cos(middle) - dx * sin(middle)) * self._calibration.distance
        turn = turn * self._calibration.heading if true_turn is None else true_turn
        direction = self.pose.heading + turn / 2.0
        c, s = cos(direction), sin(direction)
        step_x, step_y = forward * c - aside * s, forward * s + aside * c
        self.pose = Pose2D(self.pose.x + step_x, self.pose.y + step_y, wrap_angle(self.pose.heading + turn))
        self.turned += turn
        if step_x or step_y or turn:
            self._spread(step_x, step_y, turn, c, s)

    def _spread(self, step_x: float, step_y: float, turn: float, c: float, s: float) -> None:
        """Propagate the covariance through one step: P = F P Fᵀ + Q, where F shears by the heading's error."""
        errors = self._errors
        rolled = hypot(step_x, step_y)
        along = errors.distance_per_m**2 * rolled
        twisting = errors.heading_rad_per_m**2 * rolled + errors.heading_rad_per_rad**2 * abs(turn)
        xx, xy, xh, _, yy, yh, _, _, hh = self._variances
        xx, xy, xh = (
            xx - 2.0 * step_y * xh + step_y**2 * hh,
            xy + step_x * xh - step_y * (yh + step_x * hh),
            xh - step_y * hh,
        )
        yy, yh = yy + 2.0 * step_x * yh + step_x**2 * hh, yh + step_x * hh
        xx, xy, yy, hh = xx + along * c * c, xy + along * c * s, yy + along * s * s, hh + twisting
        self._variances = [xx, xy, xh, xy, yy, yh, xh, yh, hh]
