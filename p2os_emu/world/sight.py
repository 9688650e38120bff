"""Visible changes of a world, in pieces small enough to be sent often."""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from p2os_emu.world.collision import HULL
from p2os_emu.world.engine import PhysicsClient
from p2os_emu.world.light import LightState
from p2os_emu.world.look import Look, Quaternion, Triple

MOST_NEW = 100
"""Things described in one piece of news."""


class Placed(NamedTuple):
    """Where a thing is in the world: of its centre of mass, m, and how it is turned."""

    place: Triple
    turn: Quaternion


class _SeenBody(NamedTuple):
    """Something to be drawn. is_fixed: it never moves."""

    body: int
    link: int
    look: Look
    is_fixed: bool


@dataclass(slots=True)
class SceneChanges:
    """Changes since the last message, by the number of the object. light: now; None if it never changes."""

    new: dict[int, tuple[Look, Placed]] = field(default_factory=dict)
    gone: set[int] = field(default_factory=set)
    moved: dict[int, Placed] = field(default_factory=dict)
    light: LightState | None = None

    def add(self, later: "SceneChanges") -> None:
        """Take in what has changed since."""
        for number in later.gone:
            self.moved.pop(number, None)
            if self.new.pop(number, None) is None:
                self.gone.add(number)
        self.new |= later.new
        self.moved |= later.moved
        self.light = later.light


class Sight:
    """Everything that can be seen in one world."""

    def __init__(
        self,
        client: PhysicsClient,
        light: Callable[[], LightState | None] = lambda: None,
        put_robots: Callable[[], None] = lambda: None,
    ) -> None:
        """Know of nothing yet.

        Args:
            client: Of the physics engine.
            light: Returns the light now; None where it never changes.
            put_robots: Puts robots where they are in the engine too.
        """
        self._put_robots = put_robots
        self._client = client
        self._light = light
        self._numbers = itertools.count()
        self._things: dict[int, _SeenBody] = {}

    def add(self, body: int, looks: Mapping[int, Look], *, is_fixed: bool = False) -> None:
        """A body has come, with the looks of its links."""
        for link, look in looks.items():
            self._things[next(self._numbers)] = _SeenBody(body, link, look, is_fixed)

    def remove(self, body: int) -> None:
        """Remove a body."""
        self._things = {number: thing for number, thing in self._things.items() if thing.body != body}

    def news(self, known: set[int]) -> SceneChanges:
        """What somebody has to hear who knows some things already, and where all that can move are now."""
        self._put_robots()
        unknown = [number for number in self._things if number not in known][:MOST_NEW]
        return SceneChanges(
            {number: (self._things[number].look, self._placed(self._things[number])) for number in unknown},
            known - self._things.keys(),
            {n: self._placed(thing) for n, thing in self._things.items() if n in known and not thing.is_fixed},
            self._light(),
        )

    def _placed(self, thing: _SeenBody) -> Placed:
        if thing.link == HULL:
            return Placed(*self._client.getBasePositionAndOrientation(thing.body))
        return Placed(*self._client.getLinkState(thing.body, thing.link)[:2])
