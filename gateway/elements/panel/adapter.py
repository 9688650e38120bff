"""What the robot obeys without an answer, on the bus: charging contacts, display, servo pulses, power outputs."""

from typing import Any

from bus import keys
from gateway.commands import NOTHING, Arguments, CommandRow
from gateway.driver import Driver
from gateway.elements.adapter import BusAdapter
from gateway.elements.panel.element import ChargerElement, Display, PowerOutputs, Servos


def _charge(driver: Driver, arguments: Arguments, now: float) -> None:
    charger = driver.element(ChargerElement, now)
    driver.check_free()
    charger.deploy(arguments["on"])


def _write(driver: Driver, arguments: Arguments, now: float) -> None:
    driver.element(Display, now).write(arguments["text"])


def _servo(driver: Driver, arguments: Arguments, now: float) -> None:
    servos = driver.element(Servos, now)
    if arguments["pulse"]:
        driver.check_free()
    servos.move(arguments["port"], arguments["pulse"])


def _power(driver: Driver, arguments: Arguments, now: float) -> dict[str, Any]:
    outputs = driver.element(PowerOutputs, now)
    outputs.switch(arguments["output"], arguments["on"])
    return {"outputs": list(outputs.outputs)}


class ChargerAdapter(BusAdapter):
    """`command/charge`."""

    name = "charger"
    commands = (CommandRow(keys.CHARGE, {"on": bool}, _charge, name),)

    def is_present(self, driver: Driver) -> bool:
        """The robot says that it has charging contacts."""
        return driver.has(ChargerElement)

    def describe(self, driver: Driver) -> dict[str, str]:
        """Which."""
        return {"kind": driver.lookup(ChargerElement).kind}


class DisplayAdapter(BusAdapter):
    """`command/lcd`."""

    name = "lcd"
    commands = (CommandRow(keys.LCD, {"text": str}, _write, NOTHING),)

    def is_present(self, driver: Driver) -> bool:
        """The settings say that there is one."""
        return driver.has(Display)


class ServosAdapter(BusAdapter):
    """`command/servo`."""

    name = "servos"
    commands = (CommandRow(keys.SERVO, {"port": int, "pulse": float}, _servo, name),)

    def is_present(self, driver: Driver) -> bool:
        """The board has the ports."""
        return driver.has(Servos)


class PowerAdapter(BusAdapter):
    """`command/power`."""

    name = "power"
    commands = (CommandRow(keys.POWER, {"output": str, "on": bool}, _power, NOTHING),)

    def is_present(self, driver: Driver) -> bool:
        """Model or CONFIGpac say what can be switched."""
        return driver.has(PowerOutputs)

    def describe(self, driver: Driver) -> dict[str, list[str]]:
        """What can be switched."""
        return {"outputs": list(driver.lookup(PowerOutputs).outputs)}
