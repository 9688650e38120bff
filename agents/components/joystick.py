"""The agent of the joystick on the robot."""

from collections.abc import Mapping
from typing import Any, ClassVar

from agents.components.component import ElementAgent, every_known
from agents.platform import request
from bus import keys
from bus.messages import Joy


class JoystickAgent(ElementAgent):
    """How it is held."""

    source = keys.JOYSTICK
    results: ClassVar[Mapping[str, str]] = {
        "axes": "to the left, forward, throttle; -1 to 1",
        "buttons": "1 while pressed",
    }

    @request("drive", agrees_itself=True)
    async def drive(self, on: bool, token: str = "") -> dict[str, Any]:
        """Let the joystick drive the robot, or no longer."""
        return await self.command(keys.JOYDRIVE, on=on, token=token)

    def result(self, message: Joy) -> dict[str, Any]:
        """Axes and buttons."""
        return {
            "axes": every_known([float(axis) for axis in message.axes]),
            "buttons": [int(button) for button in message.buttons],
        }
