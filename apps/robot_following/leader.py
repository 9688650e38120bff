"""The leader's motion from sightings of its target: an extended Kalman filter of a robot that drives ahead."""

from dataclasses import dataclass
from math import cos, sin

import numpy as np

from apps.robot_following.settings import LeaderSettings
from geometry import Pose2D, wrap_angle
from vision.image import Floats

_X, _Y, _HEADING, _SPEED, _TURN = range(5)


@dataclass(frozen=True, slots=True)
class Sighting:
    """A leader as it was seen.

    pose: of the leader, in odom. position_deviation, m: standard deviation of its place. heading_deviation, rad.
    """

    pose: Pose2D
    position_deviation: float
    heading_deviation: float


@dataclass(frozen=True, slots=True)
class LeaderState:
    """Where the leader is believed to be, in odom, and how it moves: speed in m/s, turn in rad/s."""

    pose: Pose2D
    speed: float
    turn: float


class LeaderTrack:
    """Estimates pose and velocity of the leader; between sightings it is expected to go on as before.

    The state is x, y, heading, speed, rate of turn; speed and rate change at random (constant velocity and turn rate
    model). Source: Y. Bar-Shalom et al., Estimation with Applications to Tracking and Navigation, 2001, section 11.7.
    """

    def __init__(self, settings: LeaderSettings) -> None:
        self._settings = settings
        self._state: Floats | None = None
        self._covariance: Floats = np.zeros((5, 5))
        self._at = 0.0
        self._refused = 0

    @property
    def is_known(self) -> bool:
        """Whether the leader was seen since the last `forget`."""
        return self._state is not None

    def forget(self) -> None:
        """Begin anew with the next sighting."""
        self._state = None

    def see(self, sighting: Sighting, at: float) -> bool:
        """Take a sighting.

        Args:
            sighting: Of the target.
            at: When the image was exposed, s; earlier than the one before is of no use.
        Returns:
            Whether it was taken: one that the leader cannot have reached is not, unless others agree with it.
        """
        pose = sighting.pose
        measured = np.array([pose.x, pose.y, pose.heading])
        noise = np.diag(np.square([sighting.position_deviation] * 2 + [sighting.heading_deviation]))
        if self._state is None:
            self._begin(measured, noise, at)
            return True
        if at <= self._at:
            return False
        state, covariance = self._predicted(at)
        off = measured - state[:3]
        off[_HEADING] = wrap_angle(float(off[_HEADING]))
        spread = covariance[:3, :3] + noise
        if float(off @ np.linalg.solve(spread, off)) > self._settings.gate:
            self._refused += 1
            if self._refused > self._settings.refusals:
                self._begin(measured, noise, at)
                return True
            return False
        gain = covariance[:, :3] @ np.linalg.inv(spread)
        self._state = state + gain @ off
        self._covariance = covariance - gain @ covariance[:3]
        self._at, self._refused = at, 0
        return True

    def at(self, time: float) -> LeaderState:
        """Return what is expected of the leader at a time, s, not before the last sighting."""
        assert self._state is not None, "the leader was never seen"
        x, y, heading, speed, turn = self._moved(self._state, max(0.0, time - self._at)).tolist()
        return LeaderState(Pose2D(x, y, wrap_angle(heading)), speed, turn)

    def _begin(self, measured: Floats, noise: Floats, at: float) -> None:
        self._state = np.array([*measured, 0.0, 0.0])
        self._covariance = np.zeros((5, 5))
        self._covariance[:3, :3] = noise
        self._covariance[_SPEED, _SPEED] = self._settings.first_speed_deviation**2
        self._covariance[_TURN, _TURN] = self._settings.first_turn_deviation**2
        self._at, self._refused = at, 0

    def _predicted(self, at: float) -> tuple[Floats, Floats]:
        """Return state and covariance at a time."""
        assert self._state is not None
        dt = at - self._at
        _, _, heading, speed, turn = self._state.tolist()
        ahead = heading + turn * dt / 2.0  # in the middle of the time
        change = np.eye(5)
        change[_X, _HEADING], change[_Y, _HEADING] = -speed * dt * sin(ahead), speed * dt * cos(ahead)
        change[_X, _SPEED], change[_Y, _SPEED] = dt * cos(ahead), dt * sin(ahead)
        change[_X, _TURN], change[_Y, _TURN] = change[_X, _HEADING] * dt / 2.0, change[_Y, _HEADING] * dt / 2.0
        change[_HEADING, _TURN] = dt
        pushed = np.array([dt / 2.0 * cos(ahead), dt / 2.0 * sin(ahead), 0.0, 1.0, 0.0])
        turned = np.array([0.0, 0.0, dt / 2.0, 0.0, 1.0])
        settings = self._settings
        noise = np.outer(pushed, pushed) * settings.acceleration_deviation**2 * dt
        noise += np.outer(turned, turned) * settings.turn_acceleration_deviation**2 * dt
        return self._moved(self._state, dt), change @ self._covariance @ change.T + noise

    def _moved(self, state: Floats, dt: float) -> Floats:
        x, y, heading, speed, turn = state.tolist()
        ahead = heading + turn * dt / 2.0
        return np.array([x + speed * dt * cos(ahead), y + speed * dt * sin(ahead), heading + turn * dt, speed, turn])


def leader_pose(robot: Pose2D, camera: Pose2D, target: tuple[float, float, float], carried: float) -> Pose2D:
    """Return the pose of the robot that carries a target.

    Args:
        robot: The follower, in odom, when the image was exposed.
        camera: On the follower, in its frame, with the pan as heading.
        target: x, y, m, and orientation, rad, in the levelled frame of the camera.
        carried: m from the middle of the leader back to the middle between the target's flanks.
    """
    seen = robot.compose(camera).compose(Pose2D(*target))
    return Pose2D(seen.x + carried * cos(seen.heading), seen.y + carried * sin(seen.heading), seen.heading)
