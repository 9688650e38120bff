"""A lead-acid battery that drains with time and motor load, and fills from a charger."""

from random import Random

from p2os.sip import ChargeState

# Assumed: a day's work on one charge, as the makers advertised; no discharge curve has been read.
IDLE_ENDURANCE = 8 * 3600.0
"""s from full to empty at rest."""
LOADED_ENDURANCE = 2 * 3600.0
"""s from full to empty that full load on both motors would take by itself."""
CHARGE_TIME = 6 * 3600.0
"""s from empty to full."""

# Fractions of the nominal voltage.
EMPTY = 0.88
FULL = 1.075
SAG = 0.03
"""Lost under full load of both motors."""
LIFT = 0.07
"""Gained while the charger drives current in."""
BULK_ENDS = 0.85
"""Charge at which bulk charging gives way to overcharge."""


class BatteryModel:
    """State of charge and terminal voltage.

    charge: 1 full, 0 empty. voltage: V at the terminals.
    """

    __slots__ = ("_nominal", "charge", "charging", "voltage")

    def __init__(self, nominal: float, seed: int) -> None:
        """Start near full, as after a night on the charger.

        Args:
            nominal: V.
            seed: Decides how near.
        """
        self._nominal = nominal
        self.charge = Random(seed).uniform(0.9, 1.0)
        self.charging = ChargeState.NOT_CHARGING
        self.voltage = 0.0
        self.advance(0.0, 0.0, False)

    def advance(self, dt: float, load: float, plugged: bool) -> None:
        """Let time pass.

        Args:
            dt: s.
            load: Mean effort of the motors, 0 to 1.
            plugged: The charger gives power, and carries the robot's own consumption.
        """
        rate = 1.0 / CHARGE_TIME if plugged else -1.0 / IDLE_ENDURANCE - load / LOADED_ENDURANCE
        self.charge = min(1.0, max(0.0, self.charge + rate * dt))
        self.charging = self._stage() if plugged else ChargeState.NOT_CHARGING
        rest = EMPTY + (FULL - EMPTY) * self.charge
        self.voltage = self._nominal * (rest + LIFT if plugged else rest - SAG * load)

    def _stage(self) -> ChargeState:
        if self.charge >= 1.0:
            return ChargeState.FLOAT
        return ChargeState.OVERCHARGE if self.charge >= BULK_ENDS else ChargeState.BULK
