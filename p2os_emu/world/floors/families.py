"""Floors made up by a seed, in families of different topology: `hall:7` is the floor of the family `hall` by seed 7."""

import re
from collections.abc import Callable, Mapping
from random import Random
from typing import NamedTuple

from p2os_emu.hints import nearest
from p2os_emu.world.errors import WorldError
from p2os_emu.world.floors import clutter, corridors, culs, desks, flat, glass, hall, plan, skew, store
from p2os_emu.world.floors.building import PASSING
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.shortest_path import are_connected
from p2os_emu.world.spec import WorldSpec

_TRIES = 20
_NAME = re.compile(r"(\w+):(?!.*\.(?:toml|map)$)(.*)", re.DOTALL)


class FloorFamily(NamedTuple):
    """Floors of one kind. about: a few words. make: makes the one of a seed."""

    about: str
    make: Callable[[int], WorldSpec]


def _family(name: str, about: str, make: Callable[[str, Random], WorldSpec]) -> FloorFamily:
    """A family whose floors are checked: one with a place that robots cannot reach is made anew."""

    def make_passable(seed: int) -> WorldSpec:
        tries = (make(f"{name}:{seed}", Random(f"{name} {seed} {number}")) for number in range(_TRIES))
        for spec in tries:
            if are_connected(FreeSpace(spec, PASSING), list(spec.places.values())):
                return spec
        raise WorldError(f"no floor {name}:{seed} was found that a robot can pass; choose another seed")

    return FloorFamily(about, make_passable)


FAMILIES: Mapping[str, FloorFamily] = {
    "plan": FloorFamily(plan.ABOUT, plan.floor_plan),
    **{
        name: _family(name, module.ABOUT, module.make)
        for name, module in (
            ("hall", hall),
            ("corridors", corridors),
            ("desks", desks),
            ("culs", culs),
            ("skew", skew),
            ("store", store),
            ("flat", flat),
            ("glass", glass),
            ("clutter", clutter),
        )
    },
}
"""All families by name."""


def floor(name: str) -> WorldSpec | None:
    """Make the floor of a name, as "hall:7"; None for a name that is none of a floor.

    Raises:
        WorldError: There is no such family, or the seed is no whole number.
    """
    match = _NAME.fullmatch(name)
    if match is None:
        return None
    family, seed = match.groups()
    if family not in FAMILIES:
        raise WorldError(f"there is no family of floors {family!r}; {nearest(family, FAMILIES)}")
    try:
        number = int(seed)
    except ValueError:
        raise WorldError(f"{name} is no floor: write a whole number, as in {family}:7") from None
    return FAMILIES[family].make(number)
