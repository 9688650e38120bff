"""The record of a drive by optical flow, and its summary."""

import math
from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise

from apps.optical_flow.situation import FlowSituation
from geometry import Pose2D


@dataclass(slots=True)
class FlowRecord:
    """What happened, one entry for each decision.

    times: s. poses: m, m, rad. contacts: least time to contact in the columns, s; NaN where none is known.
    situations: as judged. told: sentences with their times. touches: how often something touched the robot.
    """

    robot: str
    times: list[float] = field(default_factory=list)
    poses: list[Pose2D] = field(default_factory=list)
    contacts: list[float] = field(default_factory=list)
    situations: list[FlowSituation] = field(default_factory=list)
    told: list[str] = field(default_factory=list)
    touches: int = 0

    def add(self, time: float, pose: Pose2D, contact: float, situation: FlowSituation) -> None:
        """Add an entry."""
        self.times.append(time)
        self.poses.append(pose)
        self.contacts.append(contact)
        self.situations.append(situation)

    @property
    def way(self) -> float:
        """Length of the path, m."""
        return sum(math.dist((a.x, a.y), (b.x, b.y)) for a, b in pairwise(self.poses))

    def visited(self, width: float, cell: float = 0.1) -> float:
        """Return the floor that a robot of a width, m, has been over, m^2."""
        reach = int(width / 2.0 / cell)
        offsets = [
            (x, y)
            for x in range(-reach, reach + 1)
            for y in range(-reach, reach + 1)
            if math.hypot(x, y) * cell <= width / 2.0
        ]
        places = {(math.floor(pose.x / cell), math.floor(pose.y / cell)) for pose in self.poses}
        return len({(x + dx, y + dy) for x, y in places for dx, dy in offsets}) * cell**2

    def summary(self, width: float) -> list[str]:
        """Return what there is to say at the end, for a robot of a width, m."""
        count = len(self.times)
        shares = ", ".join(
            f"{each.value} {100 * n / count:.0f} %" for each, n in Counter(self.situations).most_common()
        )
        touched = f"touched something {self.touches} times" if self.touches else "touched nothing"
        return [
            f"{self.robot}: {self.way:.1f} m, {self.visited(width):.1f} m^2 of floor visited, {touched}",
            f"situations: {shares}",
        ]
