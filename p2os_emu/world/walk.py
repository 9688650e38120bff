"""How one person has come along their route: the clockwork of a walk, without a body."""

from random import Random

from p2os_emu.world.people import STEP_LENGTH, Person, PersonRoute


class Walk:
    """One person under way.

    place: where they are, heading the way they walk. walked: all their steps together, m.
    """

    def __init__(self, person: Person, random: Random) -> None:
        self._person = person
        self._random = random
        self._route = PersonRoute(person.route, loops=person.loops)
        self._along = person.begin
        self._sense = 1
        self._rest = 0.0
        self._patience = random.uniform(*person.patience)
        self.walked = 0.0
        self.place = self._route.at(self._along)

    @property
    def is_resting(self) -> bool:
        """They stand because they like to."""
        return self._rest > 0.0

    def advance(self, dt: float, *, is_blocked: bool) -> None:
        """Let time pass; whoever is blocked waits, and in the end turns back."""
        if self._rest > 0.0:
            self._rest -= dt
        elif not is_blocked:
            self._walk(self._person.speed * dt)
        elif (patience := self._patience - dt) > 0.0:
            self._patience = patience
        else:
            self._turn_back()

    def _walk(self, way: float) -> None:
        mark = self._route.next_mark(self._along, self._sense)
        left = abs(mark - self._along)
        self.walked += min(left, way)
        if left > way:
            self._along += self._sense * way
        else:
            self._along = mark
            self._arrive()
        self.place = self._route.at(self._along, self._sense)

    def _arrive(self) -> None:
        """Go on at a waypoint; at an end of the route rest, and begin anew or go back."""
        end = self._route.length if self._sense > 0 else 0.0
        if self._along != end:
            return
        self._rest = self._random.uniform(*self._person.pause)
        self._patience = self._random.uniform(*self._person.patience)
        if self._route.loops:
            self._along = self._route.length - end
        else:
            self._sense = -self._sense

    def _turn_back(self) -> None:
        self._sense = -self._sense
        self._patience = self._random.uniform(*self._person.patience)
        self.place = self._route.at(self._along, self._sense)

    @property
    def stride(self) -> float:
        """How far the left foot is ahead of the middle, m; the right one is as far behind.

        The foot that bears stays where it stands while the body moves over it; then the other one bears.
        """
        steps = self.walked / STEP_LENGTH % 2
        return STEP_LENGTH * (0.5 - steps if steps < 1 else steps - 1.5)
