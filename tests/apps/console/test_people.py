"""People of an emulated world on the map."""

import asyncio
from typing import Any

import pytest

from apps.console.emulator import EmulatorRefused
from apps.console.people import PeopleWatch, places_of

ANNA = {"x": 1.0, "y": 2.0, "heading": 0.5, "walks": True}


class Emulator:
    """An emulator that answers what it is given; None: it does not answer."""

    def __init__(self, people: Any) -> None:
        self.people, self.asked = people, 0

    async def ask(self, do: str) -> dict[str, Any]:
        self.asked += 1
        if self.people is None:
            raise EmulatorRefused("gone")
        return {"ok": True, "people": self.people}


def looked(emulator: Emulator, *times: float) -> list[list[float]]:
    """Where people are after looks at some times, s."""

    async def act() -> list[list[float]]:
        watch = PeopleWatch(emulator)  # type: ignore[arg-type]  # a stand-in with what is called
        for at in times:
            await watch.look(at)
        return watch.places

    return asyncio.run(act())


def test_people_are_looked_at_each_time_and_a_world_without_them_seldom() -> None:
    full, empty, silent = Emulator({"anna": ANNA}), Emulator({}), Emulator(None)
    assert looked(full, 0.0, 0.5, 1.0) == [[1.0, 2.0, 0.5]]
    assert looked(empty, 0.0, 0.5, 1.0, 11.0) == looked(silent, 0.0, 0.5) == []
    assert (full.asked, empty.asked, silent.asked) == (3, 2, 1)


@pytest.mark.parametrize("told", [None, 3, [ANNA], {"anna": 1}, {"anna": {"x": "far"}}, {"anna": {**ANNA, "y": None}}])
def test_what_is_malformed_is_left_out(told: Any) -> None:
    assert places_of(told) == []
