"""The agent of the microcontroller's user ports."""

from collections.abc import Mapping
from typing import Any, ClassVar

from agents.components.component import ElementAgent, every_known
from agents.platform import request
from bus import keys
from bus.messages import InputsOutputs


class InputOutput(ElementAgent):
    """Digital and analogue ports."""

    source = keys.IO
    results: ClassVar[Mapping[str, str]] = {
        "digital_in": "true or false of each pin, the lowest bit first",
        "digital_out": "likewise",
        "analog_in": "V of each",
    }

    @request("output", agrees_itself=True)
    async def output(self, mask: int, value: int) -> dict[str, Any]:
        """Set the digital outputs whose bits are in the mask, to the bits of the value."""
        return await self.command(keys.OUTPUT, mask=mask, value=value)

    def result(self, message: InputsOutputs) -> dict[str, Any]:
        """The state of all ports."""
        return {
            "digital_in": [bool(pin) for pin in message.digital_in],
            "digital_out": [bool(pin) for pin in message.digital_out],
            "analog_in": every_known([float(pin) for pin in message.analog_in], 3),
        }
