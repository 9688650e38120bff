"""How one person has come along their route: the clockwork of a walk, without a body."""

from math import atan2, dist, pi
from random import Random

from geometry import Point, Pose2D, wrap_angle
from p2os_emu.world.people import STEP_LENGTH, Person, PersonRoute

LONGEST_ASIDE = 15.0
"""s that they stand aside at most."""


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
        self._aside: Point | None = None
        self._stays = 0.0  # s more beside the route
        self.walked = 0.0
        self.place = self._route.at(self._along)

    @property
    def is_resting(self) -> bool:
        """They stand because they like to."""
        return self._rest > 0.0 or (self._aside == (self.place.x, self.place.y) and self._stays > 0.0)

    @property
    def is_aside(self) -> bool:
        """They are beside their route, or on the way there or back."""
        return self._aside is not None

    @property
    def on_route(self) -> Point:
        """Where they are on the route, or have left it, m."""
        place = self._route.at(self._along)
        return place.x, place.y

    def step_aside(self, place: Point) -> None:
        """Leave the route for a place beside it, m, and stay there until `go_back` or for `LONGEST_ASIDE` s."""
        self._aside, self._stays, self._rest = place, LONGEST_ASIDE, 0.0

    def go_back(self) -> None:
        """Go back to the route, where it was left."""
        self._stays = 0.0

    def walk_away(self, from_place: Point) -> bool:
        """Go on along the route, or back, if that leads away from a place; return whether it does."""
        away = atan2(self.place.y - from_place[1], self.place.x - from_place[0])
        for sense in (self._sense, -self._sense):
            heading = self._route.at(self._along, sense).heading
            if self._route.leads_on(self._along, sense) and abs(wrap_angle(heading - away)) < pi / 2:
                if sense != self._sense:
                    self._turn_back()
                self._rest = 0.0
                return True
        return False

    def advance(self, dt: float, *, is_blocked: bool) -> None:
        """Let time pass; whoever is blocked waits, and in the end turns back."""
        if self._aside is not None:
            self._advance_aside(self._aside, dt, is_blocked=is_blocked)
        elif self._rest > 0.0:
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

    def _advance_aside(self, aside: Point, dt: float, *, is_blocked: bool) -> None:
        """Go to the place aside, stand there, and go back to the route."""
        self._stays -= dt
        route = self._route.at(self._along, self._sense)
        goal = aside if self._stays > 0.0 else (route.x, route.y)
        here = self.place.x, self.place.y
        left, step = dist(here, goal), self._person.speed * dt
        if self._stays <= 0.0 and left <= step:
            self._aside, self.place = None, route
        elif left > 0.0 and not is_blocked:
            step = min(left, step)
            self.walked += step
            heading = atan2(goal[1] - here[1], goal[0] - here[0])
            x, y = goal if step == left else Pose2D(*here, heading).transform(step, 0.0)
            self.place = Pose2D(x, y, heading)

    def _arrive(self) -> None:
        """Go on at a waypoint; at an end of the route rest, and begin anew or go back."""
        end = self._route.end(self._sense)
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
