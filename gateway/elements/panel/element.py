"""Elements without feedback: charging contacts, display, servo pulses, power outputs.

Source: H8-series and Pioneer 3 operations manuals (CHARGE, LCDWRITE), Pioneer 2 manual (PTUPOS), client libraries (the
power commands; SETPBIOPORT as output number and state, output 11 the laser).
"""

from collections.abc import Mapping
from typing import Never

from gateway.elements.element import Element
from gateway.errors import CommandRefused
from p2os import Command, Configuration, Family, RobotModel
from p2os.arguments import (
    DISPLAY_SIZE,
    LASER_POWER_PORT,
    LONGEST_PULSE,
    POWER_PORTS,
    PULSE_UNIT,
    SERVO_PORTS,
    display_data,
)
from p2os.configuration import ChargerKind

_CHARGERS: Mapping[int, str] = {ChargerKind.PIONEER: "Pioneer 3", ChargerKind.POWERBOT: "PowerBot"}
_IO_PORTS: Mapping[str, int] = {"laser": LASER_POWER_PORT, **{str(port): port for port in POWER_PORTS}}
"""Outputs that SETPBIOPORT switches: output to number. Which output feeds what else is not documented."""
_POWER_COMMANDS: Mapping[str, Command] = {
    "pc": Command.POWER_PC,
    "laser": Command.POWER_LRF,
    "5v": Command.POWER_5V,
    "12v": Command.POWER_12V,
}
"""Where a CONFIGpac has power bits, each output has its own command."""


class ChargerElement(Element[Never]):
    """kind: of the charging contacts."""

    kind = ""

    def configure(self, configuration: Configuration, now: float) -> None:
        """Take the kind of charging contacts."""
        self.is_present = configuration.charger != ChargerKind.NONE
        self.kind = _CHARGERS.get(configuration.charger, f"number {configuration.charger}")

    def deploy(self, on: bool) -> None:
        """Lower or raise the contacts."""
        self._ask(Command.CHARGE, int(on))


class Display(Element[Never]):
    """A display; only the settings tell whether there is one."""

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Take from the settings whether there is one."""
        self.is_present = self._settings.fitted.lcd

    def write(self, text: str) -> None:
        """Write on it.

        Raises:
            CommandRefused: The text does not fit.
        """
        if len(text) > DISPLAY_SIZE or not text.isascii() or not text.isprintable():
            raise CommandRefused(f"the display shows up to {DISPLAY_SIZE} printable ASCII characters, not {text!r}")
        self._ask(Command.LCDWRITE, display_data(text))


class Servos(Element[Never]):
    """Four ports for the pulses of RC servos."""

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Note that every board but the AmigoBot's has them."""
        self.is_present = model.firmware is not Family.AMIGOS

    def move(self, port: int, pulse: float) -> None:
        """Set the pulse of a port, s; 0 ends it.

        Raises:
            CommandRefused: There is no such port, or no such pulse.
        """
        if port not in SERVO_PORTS:
            raise CommandRefused(f"port {port} is not within {SERVO_PORTS[0]} to {SERVO_PORTS[-1]}")
        if not 0.0 <= pulse <= LONGEST_PULSE:
            raise CommandRefused(f"pulse {pulse} s is not within 0 to {LONGEST_PULSE:g} s")
        self._ask(Command.PTUPOS, (port, round(pulse / PULSE_UNIT)), kind=(Command.PTUPOS, port))


class PowerOutputs(Element[Never]):
    """outputs: names of those that can be switched."""

    outputs: tuple[str, ...] = ()
    _ports: Mapping[str, int] = {}

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Take the sensors or outputs of the model."""
        self._ports = _IO_PORTS if model.power_ports else {}
        self._offer(self._ports)

    def configure(self, configuration: Configuration, now: float) -> None:
        """Offer the outputs of later firmware, which has a command for each."""
        if configuration.power_bits:
            self._offer(_POWER_COMMANDS)

    def switch(self, output: str, on: bool) -> None:
        """Switch one.

        Raises:
            CommandRefused: There is no such output.
        """
        if output not in self.outputs:
            raise CommandRefused(f"there is no output {output!r}; there are {', '.join(self.outputs)}")
        if self.outputs == tuple(_POWER_COMMANDS):
            self._ask(_POWER_COMMANDS[output], int(on))
        else:
            port = self._ports[output]
            self._ask(Command.SETPBIOPORT, (port, int(on)), kind=(Command.SETPBIOPORT, port))

    def _offer(self, outputs: Mapping[str, object]) -> None:
        self.outputs = tuple(outputs)
        self.is_present = bool(outputs)
