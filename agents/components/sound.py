"""The agent of buzzer and loudspeaker."""

from typing import Any

from agents.components.component import ElementAgent
from agents.platform import request
from bus import Refused, keys


class SoundAgent(ElementAgent):
    """Plays; hears nothing."""

    @request("play", agrees_itself=True)
    async def play(self, notes: list[Any] | None = None, number: int | None = None) -> dict[str, Any]:
        """Play notes, each a MIDI number and s as in [[60, 0.2]]; or a sound that the robot has, by its number."""
        if (notes is None) == (number is None):
            raise Refused("say either notes or a number")
        return await self.command(keys.SOUND, notes=notes, number=number)

    @request("mute", agrees_itself=True)
    async def mute(self, on: bool = True) -> dict[str, Any]:
        """Be silent, or no longer so."""
        return await self.command(keys.SOUND, on=not on)
