"""Drive a robot along a list of waypoints by its odometry."""

from apps.waypoints.follower import Follower

__all__ = ["Follower"]
