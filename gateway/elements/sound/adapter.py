"""Buzzer and sounds on the bus."""

from typing import Any, Never

from bus import keys
from gateway.commands import NOTHING, Arguments, CommandRow
from gateway.elements.adapter import BusAdapter
from gateway.elements.sound.element import SoundElement
from gateway.errors import CommandRefused


class _SoundAdapter(BusAdapter[Never]):
    """`command/sound`."""

    name = "sound"
    element = SoundElement

    def describe(self) -> dict[str, Any]:
        """Return the sounds that an AmigoBot has reported."""
        sounds = self._driver.lookup(SoundElement).sounds
        return {"sounds": [{"number": number, "name": name} for number, name in sorted(sounds.items())]}

    def _sound(self, arguments: Arguments, now: float) -> None:
        sound = self._driver.element(SoundElement, now)
        match {key: value for key, value in arguments.items() if key in ("notes", "number", "on")}:
            case {"notes": notes, **rest} if not rest:
                sound.play(notes)
            case {"number": number, **rest} if not rest:
                sound.play_number(number)
            case {"on": on, **rest} if not rest:
                sound.switch(on)
            case _:
                raise CommandRefused("send one of notes, number and on")

    commands = (CommandRow(keys.SOUND, {}, _sound, NOTHING, may_take={"notes": list, "number": int, "on": bool}),)


ADAPTERS = (_SoundAdapter,)
