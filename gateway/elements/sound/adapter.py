"""Buzzer and sounds on the bus."""

from typing import Any

from bus import keys
from gateway.commands import NOTHING, Arguments, CommandRow
from gateway.driver import Driver
from gateway.elements.adapter import BusAdapter
from gateway.elements.sound.element import SoundElement
from gateway.errors import CommandRefused


def _sound(driver: Driver, arguments: Arguments, now: float) -> None:
    sound = driver.element(SoundElement, now)
    match {key: value for key, value in arguments.items() if key in ("notes", "number", "on")}:
        case {"notes": notes, **rest} if not rest:
            sound.play(notes)
        case {"number": number, **rest} if not rest:
            sound.play_number(number)
        case {"on": on, **rest} if not rest:
            sound.switch(on)
        case _:
            raise CommandRefused("say one of notes, number and on")


class SoundAdapter(BusAdapter):
    """`command/sound`."""

    name = "sound"
    commands = (CommandRow(keys.SOUND, {}, _sound, NOTHING, may_take={"notes": list, "number": int, "on": bool}),)

    def is_present(self, driver: Driver) -> bool:
        """Every robot has a buzzer."""
        return driver.has(SoundElement)

    def describe(self, driver: Driver) -> dict[str, Any]:
        """The sounds that an AmigoBot has answered."""
        sounds = driver.lookup(SoundElement).sounds
        return {"sounds": [{"number": number, "name": name} for number, name in sorted(sounds.items())]}
