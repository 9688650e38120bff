"""The record of one drive to fetch an object, and its summary."""

import math
from dataclasses import dataclass, field
from itertools import pairwise

from apps.fetch.states import FetchState
from geometry import Point, Pose2D


@dataclass(slots=True)
class FetchRecord:
    """What happened, one entry for each decision.

    times: s. poses: m, m, rad in odom. states: what it did. told: sentences with their times. gripped_at: where it
    gripped the object, m in odom; None if it did not.
    """

    robot: str
    colour: str
    place: Point
    times: list[float] = field(default_factory=list)
    poses: list[Pose2D] = field(default_factory=list)
    states: list[FetchState] = field(default_factory=list)
    told: list[str] = field(default_factory=list)
    gripped_at: Point | None = None

    def add(self, time: float, pose: Pose2D, state: FetchState) -> None:
        """Add an entry."""
        self.times.append(time)
        self.poses.append(pose)
        self.states.append(state)

    @property
    def way(self) -> float:
        """Length of the path, m."""
        return sum(math.dist((a.x, a.y), (b.x, b.y)) for a, b in pairwise(self.poses))

    def summary(self) -> list[str]:
        """Return what there is to say at the end."""
        looking = (FetchState.SEARCH, FetchState.WANDER)
        share = sum(state in looking for state in self.states) / max(1, len(self.states))
        grip = "gripped nothing"
        if self.gripped_at is not None:
            grip = f"gripped the {self.colour} object at ({self.gripped_at[0]:.2f}, {self.gripped_at[1]:.2f})"
        return [
            f"{self.robot}: {self.way:.1f} m driven, {100 * share:.0f} % of the time looking for the object; {grip}",
        ]
