"""What the suite itself knows of a few robots, so that it need not ask the code it judges.

Factors, limits and sonar numbers: ARIA's parameter files params/<subtype>.p (AriaCoda), as every old client uses them.
Firmware families: the Pioneer 2, Pioneer 3/2 H8, Pioneer 3 and AmigoBot operations manuals.
"""

from dataclasses import dataclass

ANGLE = 360 / 4096  # degrees per count, all models
SHORT_SIP, ARCOS_SIP = 0, 7  # bytes after the digital outputs


@dataclass(frozen=True, slots=True)
class Model:
    """One subtype.

    sip_tail: bytes after the digital outputs in its standard SIP.
    distance: mm per position count (DistConvFactor).
    speed: mm/s per wheel speed count (VelConvFactor).
    echo: mm per sonar count (RangeConvFactor).
    track: mm between the wheels as the kinematics see it (2 / DiffConvFactor).
    discs: sonar numbers with a disc behind them.
    firmware: the family the manuals name.
    """

    subtype: str
    firmware: str
    distance: float
    speed: float
    echo: float
    track: float
    discs: frozenset[int]

    @property
    def sip_tail(self) -> int:
        """Bytes after the digital outputs in the standard SIP."""
        return ARCOS_SIP if self.firmware == "ARCOS" else SHORT_SIP

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
RING_32 = frozenset(range(32))
POWERBOT_28 = RING_32 - {7, 15, 23, 31}  # empty slots at the robot's centre

MODELS = {
    model.subtype: model
    for model in (
        Model("p2dx", "P2OS", 0.84, 1.0, 0.268, 2 / 0.0056, RING_16),
        Model("p3dx", "AROS", 0.485, 1.0, 1.0, 2 / 0.0056, RING_16),
        Model("p3at", "AROS", 0.465, 1.0, 1.0, 2 / 0.0034, RING_16),
        Model("powerbot", "AROS", 0.5813, 1.0, 1.0, 2 / 0.00373, POWERBOT_28),
        Model("amigo", "AmigOS", 0.5083, 0.6154, 1.0, 2 / 0.011, RING_8),
        Model("p3dx-sh", "ARCOS", 1.0, 1.0, 1.0, 2 / 0.0056, RING_16),
        Model("p3at-sh", "ARCOS", 1.0, 1.0, 1.0, 2 / 0.0034, RING_16),
        Model("peoplebot-sh", "ARCOS", 1.0, 1.0, 1.0, 2 / 0.006, RING_32),
        Model("patrolbot-sh", "ARCOS", 1.0, 1.0, 1.0, 2 / 0.0056, RING_16),
        Model("powerbot-sh", "ARCOS", 1.0, 1.0, 1.0, 2 / 0.00373, POWERBOT_28),
    )
}
