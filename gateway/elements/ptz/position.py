"""The position of a camera head: reported, or estimated from its speeds where the head reports nothing."""

from math import radians
from typing import NamedTuple

from p2os.accessories.head_model import HeadModel

ARRIVED = radians(0.3)
"""rad; nearer to its goal than this, a head is there: more than a count of any axis."""
ZOOM_ARRIVED = 0.02
"""Likewise of the magnification, as a part of it."""
SLACK = 1.0
"""Seconds that a head may take beyond its speeds before it counts as resting elsewhere."""
STILL_MOVES = 0.5
"""Seconds for which a head that has just moved, without a command, counts as moving."""


class HeadPosition(NamedTuple):
    """pan: rad to the left. tilt: rad up. zoom: magnification."""

    pan: float = 0.0
    tilt: float = 0.0
    zoom: float = 1.0


class HeadTracker:
    """Follows one head.

    goal: of the last command.
    """

    def __init__(self, model: HeadModel) -> None:
        self.goal = HeadPosition()
        self._model = model
        self._place = HeadPosition()
        self._at = 0.0
        self._moves_until = 0.0
        self._is_reckoned = False

    def reckon(self, now: float) -> None:
        """Estimate the position from now on: the head sends nothing."""
        self._is_reckoned = True
        self._at = now

    def now(self, now: float) -> HeadPosition:
        """Return the position, as far as is known."""
        if not self._is_reckoned:
            return self._place
        model, lens, seconds = self._model, self._model.lens, now - self._at
        count = _towards(
            lens.count_at(self._place.zoom), lens.count_at(self.goal.zoom), lens.counts / lens.travel_s * seconds
        )
        return HeadPosition(
            _towards(self._place.pan, self.goal.pan, model.pan.top_speed * seconds),
            _towards(self._place.tilt, self.goal.tilt, model.tilt.top_speed * seconds),
            lens.ratio_at(count),
        )

    def changed(self, pan: float | None, tilt: float | None, zoom: float | None) -> HeadPosition:
        """Return the goal with these values; None leaves a value as it is."""
        return HeadPosition(
            *(old if new is None else new for new, old in zip((pan, tilt, zoom), self.goal, strict=True))
        )

    def travel_time(self, pan: float | None, tilt: float | None, zoom: float | None) -> float:
        """Return the seconds to a goal that is changed so."""
        return self._travel_time(self.changed(pan, tilt, zoom))

    def is_moving(self, now: float) -> bool:
        """Return whether it moves."""
        return now < self._moves_until

    @property
    def zooms(self) -> bool:
        """The lens has not reached its goal."""
        return abs(self._place.zoom - self.goal.zoom) > ZOOM_ARRIVED * self.goal.zoom

    @property
    def turns(self) -> bool:
        """Pan or tilt have not reached their goals."""
        return max(abs(self._place.pan - self.goal.pan), abs(self._place.tilt - self.goal.tilt)) > ARRIVED

    def send(self, goal: HeadPosition, now: float) -> None:
        """Note a command to move to a goal."""
        self._place, self._at, self.goal = self.now(now), now, goal
        self._moves_until = now + self._travel_time(goal) + (0.0 if self._is_reckoned else SLACK)

    def postpone(self, at: float) -> None:
        """Note that it is busy and that the command is repeated at a time, s."""
        self._moves_until = max(self._moves_until, at + self._travel_time(self.goal) + SLACK)

    def stop(self, now: float) -> None:
        """Note a command to stop."""
        self.send(self.now(now), now)

    def expect(self, seconds: float, now: float) -> None:
        """Note that it moves by itself for some time, s."""
        self._moves_until = max(self._moves_until, now + seconds)

    def see(self, place: HeadPosition, now: float) -> bool:
        """Take a reported position; return whether it has changed."""
        has_moved = place != self._place
        self._place, self._at = place, now
        if has_moved:
            self._moves_until = max(self._moves_until, now + STILL_MOVES)
        elif not (self.turns or self.zooms):
            self._moves_until = min(self._moves_until, now)
        return has_moved

    def _travel_time(self, goal: HeadPosition) -> float:
        lens = self._model.lens
        way = abs(lens.count_at(goal.zoom) - lens.count_at(self._place.zoom)) / lens.counts
        return max(
            abs(goal.pan - self._place.pan) / self._model.pan.top_speed,
            abs(goal.tilt - self._place.tilt) / self._model.tilt.top_speed,
            way * lens.travel_s,
        )


def _towards(start: float, goal: float, reach: float) -> float:
    return goal if abs(goal - start) <= reach else start + (reach if goal > start else -reach)
