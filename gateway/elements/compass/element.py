"""A TCM2 compass module, behind the microcontroller. Source: compass manual, Pioneer 3 operations manual (TCM2)."""

from collections.abc import Sequence

from gateway.elements.asked import AskedElement
from gateway.events import CompassSeen
from geometry import wrap_angle
from p2os import Command, CompassReport, RobotModel
from p2os.arguments import CompassMode


class CompassElement(AskedElement[CompassReport]):
    """Asks for one packet, and if it arrives, for all of them."""

    takes = (CompassReport,)
    question = Command.TCM2, CompassMode.ONE_PACKET
    stream = Command.TCM2, CompassMode.CONTINUOUS
    _errors = 0

    @property
    def faults(self) -> Sequence[str]:
        """The errors that the module reports."""
        return (f"the compass reports errors ({self._errors:#06x})",) if self._errors else ()

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask, unless the settings know that there is none."""
        self._errors = 0
        if self._settings.fitted.compass:
            super().begin_link(model, now)

    def take(self, packet: CompassReport, now: float) -> None:
        """Turn the heading the way REP 103 counts it."""
        super().take(packet, now)
        self.is_present = True
        self._errors = packet.error_bits
        self._announce(CompassSeen(packet, wrap_angle(-packet.heading)))
