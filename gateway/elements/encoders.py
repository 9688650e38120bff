"""The encoders of the driven wheels, where the settings want them on the bus."""

from gateway.elements.polled import PolledElement
from gateway.events import EncodersReceived
from p2os import Command, Encoders, RobotModel


class WheelEncoders(PolledElement):
    """is_present: the settings want them."""

    takes = (Encoders,)
    command = Command.ENCODER

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask, if they are wanted."""
        self._model = model
        self.is_present = self._settings.encoders
        if self.is_present:
            self.begin(now)

    def take(self, packet: object, now: float) -> None:
        """Pass them on."""
        super().take(packet, now)
        assert isinstance(packet, Encoders)
        self._announce(EncodersReceived(packet, self._model))
