"""The agent of the battery."""

from collections.abc import Mapping
from typing import Any, ClassVar

from agents.components.component import ElementAgent, known
from bus import keys
from bus.messages import BatteryState


class BatteryAgent(ElementAgent):
    """How full the battery is."""

    source = keys.BATTERY
    results: ClassVar[Mapping[str, str]] = {
        "voltage": "V",
        "fraction": "0 to 1 of a full charge, null where the robot does not say",
        "charging": "true while it is being charged",
    }

    def result(self, message: BatteryState) -> dict[str, Any]:
        """Voltage and charge."""
        return {
            "voltage": known(message.voltage, 2),
            "fraction": known(message.percentage),
            "charging": message.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_CHARGING,
        }
