"""Batteries that know their own charge: some robots answer with a packet of their own. Source: client libraries."""

from gateway.elements.asked import AskedElement
from gateway.events import ChargeSeen
from p2os import BatteryReport, Command

PERIOD = 10.0
"""Seconds from one answer to the next question; a charge changes slowly."""
RELATIVE_CHARGE = 3
"""Byte of a battery that holds its charge in percent of what it can hold now."""


class Batteries(AskedElement):
    """is_present: the robot has answered."""

    takes = (BatteryReport,)
    question = Command.BATTERYINFO, 1

    def take(self, packet: object, now: float) -> None:
        """Report the mean charge of all batteries."""
        super().take(packet, now)
        assert isinstance(packet, BatteryReport)
        charges = [battery[RELATIVE_CHARGE] for battery in packet.batteries if len(battery) > RELATIVE_CHARGE]
        if charges:
            self.is_present = True
            self._announce(ChargeSeen(min(1.0, sum(charges) / len(charges) / 100.0)))
        self._asks_left = self.times
        self.deadline = now + PERIOD
