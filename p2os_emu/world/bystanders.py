"""Moving objects of a world beside robots: people and the leaves of doors."""

from collections.abc import Callable, Iterable, Iterator, Mapping

from p2os_emu.world.engine import PhysicsClient
from p2os_emu.world.leaves import DoorState, Leaves
from p2os_emu.world.look import Look, leaf_look, person_look
from p2os_emu.world.moving_doors import MovingDoor
from p2os_emu.world.objects import MovingObject
from p2os_emu.world.people import Person
from p2os_emu.world.presence import Footprint
from p2os_emu.world.spec import WorldSpec
from p2os_emu.world.stepping_aside import Asker
from p2os_emu.world.walkers import PersonPlace, Walkers


class Bystanders:
    """People and doors of one world. Each waits for the other, and both for robots; things only keep doors open."""

    def __init__(self, client: PhysicsClient, spec: WorldSpec, seed: int) -> None:
        self._people = Walkers(client, spec, seed)
        self._leaves = Leaves(client, spec.moving_doors, seed)
        self._there_are_any = bool(spec.people or spec.moving_doors)

    def __bool__(self) -> bool:
        return self._there_are_any

    @property
    def bodies(self) -> dict[int, Person | MovingDoor]:
        """Body ids of the engine, and who or what they are."""
        return {**self._people.bodies, **self._leaves.bodies}

    @property
    def looks(self) -> dict[int, Look]:
        """What each looks like, by body id."""
        people = {body: person_look(person) for body, person in self._people.bodies.items()}
        return people | {body: leaf_look(door) for body, door in self._leaves.bodies.items()}

    @property
    def names(self) -> dict[int, str]:
        """What each is called, by body id."""
        return {body: each.name for body, each in self.bodies.items()}

    def step(self, robots: Callable[[], Iterable[Footprint]], things: Callable[[], Iterable[Footprint]]) -> None:
        """Move them all; the engine sees it in its next step. Who is in the way is only asked where it matters."""
        self._leaves.step(lambda: (*robots(), *self._people.presences().values(), *things()))
        if self._people:
            self._people.step(lambda: (*robots(), *self._leaves.in_gaps().values()))

    def hear(self, asker: Callable[[], Asker | None]) -> None:
        """Let people hear the sound of a robot; asker: where it is, None when it has gone."""
        self._people.hear(asker)

    def stop_people(self, on: bool) -> None:
        """Stop the people, or let them walk again."""
        self._people.stand_still = on

    def moving(self) -> Iterator[MovingObject]:
        """Each at its present place."""
        yield from self._leaves.moving()
        yield from self._people.moving()

    def presences(self) -> dict[str, Footprint]:
        """Where no robot can be put: people, and doors that are not wide open."""
        return self._people.presences() | self._leaves.in_gaps()

    def people(self) -> Mapping[str, PersonPlace]:
        """Where everybody is."""
        return self._people.places()

    def doors(self) -> Mapping[str, DoorState]:
        """How far each door is open."""
        return self._leaves.states()

    def set_door(self, name: str, is_open: bool) -> None:
        """Open or shut a door for good.

        Raises:
            WorldError: There is no such door.
        """
        self._leaves.set(name, is_open)
