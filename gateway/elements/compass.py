"""A TCM2 compass module, behind the microcontroller. Source: compass manual, Pioneer 3 operations manual (TCM2)."""

from gateway.elements.asked import AskedElement
from gateway.events import CompassSeen
from geometry import wrap_angle
from p2os import Command, CompassReport, RobotModel

ONE_PACKET, CONTINUOUS = 2, 3
"""Arguments of TCM2."""


class Compass(AskedElement):
    """Asks for one packet, and if it comes for all of them."""

    takes = (CompassReport,)
    question = Command.TCM2, ONE_PACKET
    stream = Command.TCM2, CONTINUOUS

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask, unless the settings know that there is none."""
        if self._settings.fitted.compass:
            super().begin_link(model, now)

    def take(self, packet: object, now: float) -> None:
        """Turn the heading the way REP 103 counts it."""
        super().take(packet, now)
        assert isinstance(packet, CompassReport)
        self.is_present = True
        self._announce(CompassSeen(packet, wrap_angle(-packet.heading)))
