"""A lead-acid battery that drains with time and motor load, and fills from a charger."""

from random import Random

from p2os.sip import ChargeState

LOWERING = 5.0
"""s from CHARGE to contact."""
PATIENCE = 10.0
"""s that lowered contacts wait for power."""


class ChargerContacts:
    """The automatic charger: contacts that the robot lowers onto its dock (CHARGE), and the docking station (DOCK).

    Source: fact sheet section 4. Assumed: lowering takes five seconds and has the motors off; contacts that find no
    power within ten seconds more are raised again; ENABLE raises them as well.

    lowered: they are down, or on their way. docking: argument of DOCK: 0 off, 1 signals, 2 and stop when power comes.
    power_good: the charger gives power, as the SIP shows.
    """

    __slots__ = ("_down_for", "docking", "lowered", "power_good")

    def __init__(self) -> None:
        self.docking = 0
        self.power_good = False
        self.lowered = False
        self._down_for = 0.0

    def deploy(self) -> None:
        """CHARGE 1."""
        if not self.lowered:
            self.lowered = True
            self._down_for = 0.0

    def release(self) -> None:
        """CHARGE 0, and whatever drives the robot away."""
        self.lowered = False
        self._down_for = 0.0

    def advance(self, dt: float, plugged: bool, docked: bool) -> bool:
        """Let time pass.

        Args:
            dt: s.
            plugged: A person has plugged a charger in.
            docked: The robot stands at a dock.
        Returns:
            Whether power has just come.
        """
        had_power = self.power_good
        if self.lowered:
            self._down_for += dt
        touches = docked and self.lowered and self._down_for >= LOWERING
        if self.lowered and not touches and self._down_for >= LOWERING + PATIENCE:
            self.release()
        self.power_good = plugged or touches
        return self.power_good and not had_power


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
