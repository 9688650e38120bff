"""Elements without feedback on the bus: charging contacts, display, servo pulses, power outputs."""

from typing import Any, Never

from bus import keys
from gateway.commands import NOTHING, Arguments, CommandRow
from gateway.elements.adapter import BusAdapter
from gateway.elements.panel.element import ChargerElement, Display, PowerOutputs, Servos


class _ChargerAdapter(BusAdapter[Never]):
    """`command/charge`."""

    name = "charger"
    element = ChargerElement

    def describe(self) -> dict[str, str]:
        """Return the kind of the contacts."""
        return {"kind": self._driver.lookup(ChargerElement).kind}

    def _charge(self, arguments: Arguments, now: float) -> None:
        charger = self._driver.element(ChargerElement, now)
        self._driver.check_free()
        charger.deploy(arguments["on"])

    commands = (CommandRow(keys.CHARGE, {"on": bool}, _charge, name),)


class _DisplayAdapter(BusAdapter[Never]):
    """`command/lcd`."""

    name = "lcd"
    element = Display

    def _write(self, arguments: Arguments, now: float) -> None:
        self._driver.element(Display, now).write(arguments["text"])

    commands = (CommandRow(keys.LCD, {"text": str}, _write, NOTHING),)


class _ServosAdapter(BusAdapter[Never]):
    """`command/servo`."""

    name = "servos"
    element = Servos

    def _servo(self, arguments: Arguments, now: float) -> None:
        servos = self._driver.element(Servos, now)
        if arguments["pulse"]:
            self._driver.check_free()
        servos.move(arguments["port"], arguments["pulse"])

    commands = (CommandRow(keys.SERVO, {"port": int, "pulse": float}, _servo, name),)


class _PowerAdapter(BusAdapter[Never]):
    """`command/power`."""

    name = "power"
    element = PowerOutputs

    def describe(self) -> dict[str, list[str]]:
        """Return the names of the outputs."""
        return {"outputs": list(self._driver.lookup(PowerOutputs).outputs)}

    def _power(self, arguments: Arguments, now: float) -> dict[str, Any]:
        outputs = self._driver.element(PowerOutputs, now)
        outputs.switch(arguments["output"], arguments["on"])
        return {"outputs": list(outputs.outputs)}

    commands = (CommandRow(keys.POWER, {"output": str, "on": bool}, _power, NOTHING),)


ADAPTERS = (_DisplayAdapter, _ServosAdapter, _PowerAdapter, _ChargerAdapter)
