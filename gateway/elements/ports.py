"""The microcontroller's user ports: digital inputs and outputs, analog inputs."""

from gateway.elements.polled import PolledElement
from gateway.errors import CommandRefused
from gateway.events import InputsOutputsReceived
from p2os import Command, IoReport, RobotModel


class UserPorts(PolledElement):
    """Asks for I/O packets where somebody needs them; remembers the outputs, to set a robot again that was reset."""

    takes = (IoReport,)
    command = Command.IOREQUEST
    _mask = _value = 0

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask, as the settings, or else the model, want it."""
        self.is_present = True
        wanted = self._settings.inputs_outputs
        if model.request_io_packets or model.irs if wanted is None else wanted:
            self.begin(now)
        if self._mask:
            self.set_outputs(self._mask, self._value)

    def take(self, packet: object, now: float) -> None:
        """Pass them on."""
        super().take(packet, now)
        assert isinstance(packet, IoReport)
        self._announce(InputsOutputsReceived(packet))

    def set_outputs(self, mask: int, value: int) -> None:
        """Set the digital outputs whose bits are set in `mask` to the bits of `value`.

        Raises:
            CommandRefused: These are no bytes.
        """
        if not (0 <= mask <= 255 and 0 <= value <= 255):
            raise CommandRefused(f"mask {mask} and value {value} must be 0 to 255")
        self._value = (self._value & ~mask) | (value & mask)
        self._mask |= mask
        # All outputs set so far go in one frame, since a frame that still waits is replaced.
        self._ask(Command.DIGOUT, (self._mask, self._value))
