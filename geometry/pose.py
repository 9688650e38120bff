"""Poses, twists and angles in the plane: x forward, y left, headings counter-clockwise from +x in (-pi, pi]."""

from dataclasses import dataclass
from math import atan2, cos, isfinite, pi, sin, tau


def wrap_angle(angle: float) -> float:
    """Bring an angle into (-pi, pi], rad.

    Raises:
        ValueError: `angle` is not finite.
    """
    if not isfinite(angle):
        raise ValueError(f"angle {angle} rad is not finite")
    if -pi < angle <= pi:
        return angle
    wrapped = angle % tau
    return wrapped - tau if wrapped > pi else wrapped


@dataclass(frozen=True, slots=True)
class Pose2D:
    """Where something is and which way it looks: m, m, rad, in a frame that the context names."""

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0

    def transform(self, x: float, y: float) -> tuple[float, float]:
        """Take a point given in this pose's own frame to the frame the pose is given in; m."""
        c, s = cos(self.heading), sin(self.heading)
        return self.x + c * x - s * y, self.y + s * x + c * y

    def locate(self, x: float, y: float) -> tuple[float, float]:
        """Take a point from the frame the pose is given in to this pose's own frame; m. Undoes `transform`."""
        c, s = cos(self.heading), sin(self.heading)
        dx, dy = x - self.x, y - self.y
        return c * dx + s * dy, c * dy - s * dx

    def compose(self, other: "Pose2D") -> "Pose2D":
        """Take a pose given in this pose's own frame to the frame this pose is given in."""
        x, y = self.transform(other.x, other.y)
        return Pose2D(x, y, wrap_angle(self.heading + other.heading))

    def relative_to(self, origin: "Pose2D") -> "Pose2D":
        """Express this pose in the frame of `origin`; both are given in one frame. Undoes `origin.compose`."""
        return Pose2D(*origin.locate(self.x, self.y), wrap_angle(self.heading - origin.heading))

    def bearing_to(self, x: float, y: float) -> float:
        """Direction of a point as seen from this pose, rad in (-pi, pi]; 0 is straight ahead."""
        return wrap_angle(atan2(y - self.y, x - self.x) - self.heading)


@dataclass(frozen=True, slots=True)
class Twist2D:
    """A body's velocity: m/s forward, rad/s counter-clockwise."""

    linear: float = 0.0
    angular: float = 0.0


def integrate(pose: Pose2D, twist: Twist2D, dt: float) -> Pose2D:
    """Move a pose along a constant twist.

    Follows the circular arc exactly, so one step of 0.2 s equals two of 0.1 s.

    Args:
        pose: Start: m, m, rad.
        twist: Body velocity: m/s forward, rad/s counter-clockwise.
        dt: Elapsed time, s; zero returns an equal pose.
    Returns:
        End pose in the frame of the start; heading in (-pi, pi].
    Raises:
        ValueError: `dt` is negative or not finite.
    Source: Thrun, Burgard and Fox, Probabilistic Robotics, section 5.3.
    """
    if not (isfinite(dt) and dt >= 0.0):
        raise ValueError(f"dt {dt} s must be finite and not negative")
    half_turn = twist.angular * dt / 2.0
    # The chord of the arc leaves at half the turn; sin(a)/a stays exact where the textbook's v/w would divide by zero.
    chord = twist.linear * dt * (sin(half_turn) / half_turn if half_turn else 1.0)
    direction = pose.heading + half_turn
    return Pose2D(
        pose.x + chord * cos(direction), pose.y + chord * sin(direction), wrap_angle(pose.heading + 2.0 * half_turn)
    )
