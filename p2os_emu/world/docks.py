"""Charging docks: places where a robot that lowers its charging contacts finds power."""

from dataclasses import dataclass
from math import radians

from geometry import Pose2D, wrap_angle

# How far a robot may stand from its place for its contacts to meet the plate of the dock; assumed.
ALONG = 0.05  # m
ACROSS = 0.04  # m
TURNED = radians(6.0)


@dataclass(frozen=True, slots=True)
class Dock:
    """A charging dock.

    pose: of a robot that is charged, in the world: the middle of its axle, facing the station.
    """

    name: str
    pose: Pose2D

    def reaches(self, pose: Pose2D) -> bool:
        """Return whether the contacts of a robot at a pose would meet the plate."""
        along, across = self.pose.locate(pose.x, pose.y)
        turned = wrap_angle(pose.heading - self.pose.heading)
        return abs(along) <= ALONG and abs(across) <= ACROSS and abs(turned) <= TURNED
