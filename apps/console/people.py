"""The people of an emulated world, for the map. Real robots report no people."""

from typing import Any

from apps.console.emulator import EmulatorControl, EmulatorRefused
from apps.console.map_layers import is_number

_AGAIN = 10.0  # s until a world without people is looked at again
_MOST = 100


class PeopleWatch:
    """Where people of the emulated world are. places: x, y and heading of each, m and rad in the frame of the world."""

    def __init__(self, emulator: EmulatorControl) -> None:
        """Know of nobody until `look`."""
        self.places: list[list[float]] = []
        self._emulator = emulator
        self._again_at = float("-inf")

    async def look(self, now: float) -> None:
        """Ask the emulator, if there may be people; now: s of a steady clock. Nobody is shown if it does not answer."""
        if now < self._again_at:
            return
        try:
            told = (await self._emulator.ask("truth")).get("people")
        except EmulatorRefused:  # it is being ended, or hangs; the page Faults says so
            told = None
        self.places = places_of(told)
        if not self.places:
            self._again_at = now + _AGAIN


def places_of(told: Any) -> list[list[float]]:
    """Return x, y and heading of each of the people in the truth of an emulator; what is malformed is left out."""
    rows = list(told.values())[:_MOST] if isinstance(told, dict) else []
    found: list[list[Any]] = [[row.get(key) for key in ("x", "y", "heading")] for row in rows if isinstance(row, dict)]
    return [[round(float(value), 3) for value in row] for row in found if all(map(is_number, row))]
