"""What the suite itself knows of a few robots, so that it need not ask the code it judges.

Factors, limits and sonar numbers: ARIA's parameter files params/<subtype>.p (AriaCoda), as every old client uses them.
Firmware families: the Pioneer 2, Pioneer 3/2 H8, Pioneer 3 and AmigoBot operations manuals.
"""

from dataclasses import dataclass

ANGLE = 360 / 4096  # degrees per count, all models


@dataclass(frozen=True, slots=True)
class Model:
    """One subtype.

    distance: mm per position count (DistConvFactor).
    speed: mm/s per wheel speed count (VelConvFactor).
    echo: mm per sonar count (RangeConvFactor).
    track: mm between the wheels as the kinematics see it (2 / DiffConvFactor).
    discs: sonar numbers with a disc behind them.
    firmware: the family that the manuals name, or that follows from the subtype; a CONFIGpac may tell more.
    """

    subtype: str
    firmware: str
    distance: float
    speed: float
    echo: float
    track: float
    discs: frozenset[int]

    @property
    def arrays(self) -> dict[int, list[int]]:
        """Disc numbers per sonar array, arrays counted from 1."""
        return {
            array: members
            for array in range(1, 5)
            if (members := sorted(disc for disc in self.discs if disc // 8 == array - 1))
        }


RING_8 = frozenset(range(8))
RING_16 = frozenset(range(16))
RING_24 = frozenset(range(24))
RING_32 = frozenset(range(32))
POWERBOT_14 = RING_16 - {7, 15}
POWERBOT_28 = RING_32 - {7, 15, 23, 31}  # empty slots at the robot's centre

MODELS = {
    model.subtype: model
    for model in (
        Model("p2dx", "P2OS", 0.84, 1.0, 0.268, 2 / 0.0056, RING_16),
        Model("p2de", "P2OS", 0.969, 1.0, 0.268, 2 / 0.0056, RING_16),
        Model("p2ce", "P2OS", 0.826, 1.0, 0.268, 2 / 0.0057, RING_16),
        Model("p2df", "P2OS", 0.485, 1.0, 0.268, 2 / 0.006, RING_16),
        Model("p2at", "P2OS", 1.32, 1.0, 0.268, 2 / 0.0034, RING_16),
        Model("p2it", "P2OS", 1.136, 1.0, 0.268, 2 / 0.0032, RING_16),
        Model("p2pb", "P2OS", 0.424, 1.0, 0.268, 2 / 0.0056, RING_24),
        Model("p2pp", "P2OS", 0.485, 1.0, 0.268, 2 / 0.006, RING_24),
        Model("p2d8", "AROS", 0.485, 1.0, 1.0, 2 / 0.0056, RING_16),
        Model("p2d8+", "AROS", 0.485, 1.0, 1.0, 2 / 0.0056, RING_16),
        Model("p2at8", "AROS", 1.32, 1.0, 1.0, 2 / 0.0034, RING_16),
        Model("p2at8+", "AROS", 0.465, 1.0, 1.0, 2 / 0.0034, RING_16),
        Model("perfpb", "AROS", 0.485, 1.0, 1.0, 2 / 0.006, RING_32),
        Model("perfpb+", "AROS", 0.485, 1.0, 1.0, 2 / 0.006, RING_32),
        Model("p3dx", "AROS", 0.485, 1.0, 1.0, 2 / 0.0056, RING_16),
        Model("p3at", "AROS", 0.465, 1.0, 1.0, 2 / 0.0034, RING_16),
        Model("powerbot", "AROS", 0.5813, 1.0, 1.0, 2 / 0.00373, POWERBOT_28),
        Model("amigo", "AmigOS", 0.5083, 0.6154, 1.0, 2 / 0.011, RING_8),
        Model("p3dx-sh", "ARCOS", 1.0, 1.0, 1.0, 2 / 0.0056, RING_16),
        Model("p3at-sh", "ARCOS", 1.0, 1.0, 1.0, 2 / 0.0034, RING_16),
        Model("p3atiw-sh", "ARCOS", 1.0, 1.0, 1.0, 2 / 0.0034, RING_16),
        Model("peoplebot-sh", "ARCOS", 1.0, 1.0, 1.0, 2 / 0.006, RING_32),
        Model("patrolbot-sh", "ARCOS", 1.0, 1.0, 1.0, 2 / 0.0056, RING_16),
        Model("powerbot-sh", "ARCOS", 1.0, 1.0, 1.0, 2 / 0.00373, POWERBOT_28),
        Model("powerbot-sh-uarcs", "ARCOS", 1.0, 1.0, 1.0, 2 / 0.00373, POWERBOT_14),
        Model("amigo-sh", "ARCOS", 1.0, 1.0, 1.0, 2 / 0.011, RING_8),
    )
}
