"""Tables as data: four legs and a top, as boxes at their true heights."""

import math
from dataclasses import dataclass

from geometry import Pose2D
from p2os_emu.world.colours import check_colour
from p2os_emu.world.spec import Block

TOP_THICKNESS = 0.03
"""m, of the top of every table; it belongs to the table's height."""


@dataclass(frozen=True, slots=True)
class TableEntry:
    """A table, chair or stool: centre, size (length, width) of its top, height, edge of its square legs, heading."""

    at_m: tuple[float, float]
    size_m: tuple[float, float]
    height_m: float = 0.74
    leg_m: float = 0.05
    name: str = "table"
    heading_deg: float = 0.0
    colour: str = "wood"

    def blocks(self) -> tuple[Block, ...]:
        """The legs, which stand at the corners of the top, and then the top.

        Raises:
            ValueError: A size makes no sense.
        """
        check_colour(self.colour)
        length, width = self.size_m
        if not self.height_m > TOP_THICKNESS:
            raise ValueError(f"height_m must be above {TOP_THICKNESS} m, the thickness of the top, not {self.height_m}")
        if not 0.0 < self.leg_m <= min(length, width) / 2:
            raise ValueError("leg_m must be above 0 m, and at most half of the shorter side of size_m")
        pose = Pose2D(*self.at_m, math.radians(self.heading_deg))
        under = self.height_m - TOP_THICKNESS
        x, y = (length - self.leg_m) / 2, (width - self.leg_m) / 2
        legs = (pose.transform(along, across) for along, across in ((-x, -y), (x, -y), (x, y), (-x, y)))
        name, colour = self.name, self.colour
        top = Block(pose.x, pose.y, pose.heading, length, width, TOP_THICKNESS, name, colour=colour, bottom=under)
        return (
            *(Block(*leg, pose.heading, self.leg_m, self.leg_m, under, name, colour=colour) for leg in legs),
            top,
        )
