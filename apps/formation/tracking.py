"""The virtual point of a follower, and the twist that takes a robot with two driven wheels to it."""

import math
from dataclasses import dataclass

from apps.formation.path import LeaderPath
from apps.formation.settings import Tracking
from geometry import Point, Pose2D, Twist2D, wrap_angle

SLOW = 0.02  # m/s; a slower point has no direction of its own
NEAR = 0.4  # m from the point in which a robot backs up instead of turning round
ALIGNED = math.pi / 3  # rad to the heading of a moving point in which it does


@dataclass(frozen=True, slots=True)
class VirtualPoint:
    """Where a follower should be: pose, m and rad, and velocity of the point, m/s and rad/s, along its heading."""

    pose: Pose2D
    twist: Twist2D


def path_point(path: LeaderPath, leader: Twist2D, offset: Point, later: float = 0.0) -> VirtualPoint:
    """Return a point that follows the leader's path.

    Args:
        path: Of the leader.
        leader: Its velocity.
        offset: m in front of and to the left of the leader; what is behind it is measured along the path.
        later: s after the last pose for which the point is predicted.
    """
    ahead, left = offset
    ahead += leader.linear * later
    base = path.at(-ahead)
    bend = path.curvature(-ahead)
    speed = leader.linear * (1.0 - bend * left)
    return VirtualPoint(
        Pose2D(*base.transform(0.0, left), base.heading), Twist2D(speed, leader.linear * bend if ahead <= 0.0 else 0.0)
    )


def frame_point(pose: Pose2D, leader: Twist2D, offset: Point) -> VirtualPoint:
    """Return a point that is fixed in the leader's frame; its heading is the direction in which it moves."""
    ahead, left = offset
    along, across = leader.linear - leader.angular * left, leader.angular * ahead
    speed = math.hypot(along, across)
    direction = math.atan2(across, along) if speed > SLOW else 0.0
    if abs(direction) > math.pi / 2 and leader.linear < 0.0:
        direction, speed = wrap_angle(direction + math.pi), -speed
    return VirtualPoint(
        Pose2D(*pose.transform(ahead, left), wrap_angle(pose.heading + direction)), Twist2D(speed, leader.angular)
    )


def twist_towards(point: VirtualPoint, robot: Pose2D, tuning: Tracking) -> Twist2D:
    """Return the velocity that takes a robot to its point and keeps it there.

    The velocity of the point is fed forward; its distance is fed back. The sum is a direction on the floor and a speed;
    since the robot drives only along its heading, it turns to that direction and drives the part along its heading. A
    point a little behind it is reached backwards.

    Args:
        point: Where it should be, in the frame of `robot`.
        robot: Its pose.
        tuning: Gains and limits.
    Source: feed-forward and feedback of a point as in Samson and Ait-Abderrahim, Feedback control of a nonholonomic
        wheeled cart in Cartesian space, 1991; the limits are our own.
    """
    dx, dy = point.pose.x - robot.x, point.pose.y - robot.y
    distance = math.hypot(dx, dy)
    moves = abs(point.twist.linear) > SLOW
    if not moves and distance <= tuning.at_point_m:
        return Twist2D()
    closing = min(tuning.gain * distance, tuning.speed_m_s) / distance if distance else 0.0
    vx = point.twist.linear * math.cos(point.pose.heading) + closing * dx
    vy = point.twist.linear * math.sin(point.pose.heading) + closing * dy
    speed = math.hypot(vx, vy)
    if moves and speed < SLOW:  # a robot that is ahead of its point waits, with the heading of the point
        off = wrap_angle(point.pose.heading - robot.heading)
        return Twist2D(0.0, _limited(tuning.turn_gain * off, tuning.turn_rad_s))
    off = wrap_angle(math.atan2(vy, vx) - robot.heading)
    is_aligned = not moves or abs(wrap_angle(point.pose.heading - robot.heading)) < ALIGNED
    if abs(off) > math.pi / 2 and distance < NEAR and is_aligned:
        off, speed = wrap_angle(off + math.pi), -speed
    along = speed * math.cos(off) if abs(off) < math.pi / 2 else 0.0
    turning = point.twist.angular if moves else 0.0
    return Twist2D(_limited(along, tuning.speed_m_s), _limited(turning + tuning.turn_gain * off, tuning.turn_rad_s))


def _limited(value: float, most: float) -> float:
    return max(-most, min(most, value))
