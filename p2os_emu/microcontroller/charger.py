"""The automatic charger: contacts that the robot lowers onto its dock (CHARGE), and the older docking station (DOCK).

Source: fact sheet section 4. Assumed, for no source tells: lowering takes five seconds and has the motors off; contacts
that find no power within ten seconds more are raised again; ENABLE raises them as well.
"""

LOWERING = 5.0
"""s from CHARGE to contact."""
PATIENCE = 10.0
"""s that lowered contacts wait for power."""


class ChargerContacts:
    """The contacts.

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
