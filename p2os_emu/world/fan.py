"""A fan of few rays in a plane, met with sides and cylinders by plain arithmetic.

For seven rays and the few sides that they may meet this takes less time than the calls of numpy would (`planar.py` is
for hundreds of beams). Places and directions are complex numbers, x + iy, m: one product of a conjugate and another
number is the dot product and the cross product of two vectors, at the price of one operation of the interpreter.

Surfaces count from outside only: a ray that starts inside a body leaves it unseen, as with the physics engine.
"""

from collections.abc import Iterable, Sequence
from math import inf, sqrt
from typing import NamedTuple

_ROUNDING = 1e-9  # m; where two sides meet, a ray must not slip between them


class BoxSide(NamedTuple):
    """A side of a box; seen from outside it runs from left to right.

    normal: of length 1, outward, as its conjugate. offset: of the side from the origin along the normal, m.
    start, end: its ends. nearest: no ray that is cast meets it before, m; sides are in this order.
    """

    normal: complex
    offset: float
    start: complex
    end: complex
    nearest: float = -1.0


class Cylinder(NamedTuple):
    """An upright cylinder: middle and radius, m."""

    middle: complex
    radius: float


class Fan(NamedTuple):
    """Rays of a robot that pass through one point.

    point: where. heading: of the ray in the middle, rad. rays: directions of length 1, counter-clockwise, less than
    half a turn together. setback: how far behind the point they start, m. reach: how far ahead of it they end, m.
    """

    point: complex
    heading: float
    rays: Sequence[complex]
    setback: float
    reach: float


class FirstHit:
    """A fan at a place in the world, and the nearest surface that any of its rays has met so far.

    point: of the fan. farthest: how far ahead of it the rays end, m. cosine: of the angle of incidence; 0 where nothing
    is met. is_sure: False where something is met behind the point, which is not followed here.
    """

    __slots__ = ("_ahead", "_left", "_rays", "_right", "_setback", "cosine", "farthest", "is_sure", "point")

    def __init__(self, fan: Fan, place: complex, ahead: complex) -> None:
        """Place the fan of a robot that is at a place, and whose heading is a direction of length 1."""
        self.point = place + ahead * fan.point
        # Sides are turned into the frame of the robot, not the rays into the world: they are fewer.
        self._ahead = ahead
        rays = self._rays = fan.rays
        self._right = (ahead * rays[0]).conjugate()
        self._left = (ahead * rays[-1]).conjugate()
        self._setback = fan.setback
        self.farthest = fan.reach
        self.cosine = 0.0
        self.is_sure = True

    def nearest(self, least: float) -> float | None:
        """Return the least distance at which a ray meets a surface whose cosine is greater, m, `inf` for none.

        None: there may be one behind a nearer surface with less, of which only `AllHits` knows.
        """
        if not self.is_sure:
            return None
        if self.cosine > least:
            return self.farthest
        return None if self.cosine else inf

    def among(self, places: Iterable[tuple[int, complex, float]]) -> list[int]:
        """Select bodies.

        Args:
            places: Number, middle and radius (m) of each body.
        Returns:
            Numbers of all bodies that a ray may meet before what it has met; also of some that none meets.
        """
        point, right, left, setback, farthest = self.point, self._right, self._left, self._setback, self.farthest
        return [
            body
            for body, place, radius in places
            if abs(place - point) <= farthest + radius
            and (right * (place - point)).imag >= -radius - setback
            and (left * (place - point)).imag <= radius + setback
        ]

    def meet_sides(self, sides: Iterable[BoxSide]) -> None:
        """Follow the rays to sides, no further than to what they have met."""
        point, right, left, farthest = self.point, self._right, self._left, self.farthest
        for normal, offset, start, end, nearest in sides:
            if nearest >= farthest:
                break
            height = (normal * point).real - offset  # of the point above the side
            if 0.0 < height < farthest:
                start -= point
                end -= point
                if not (
                    ((left * end).imag > _ROUNDING and (left * start).imag > _ROUNDING)
                    or ((right * start).imag < -_ROUNDING and (right * end).imag < -_ROUNDING)
                ):
                    self._meet_ahead(normal, height, start, end)
                    farthest = self.farthest
            elif -self._setback <= height <= 0.0:
                self._meet_behind(normal, height, start - point, end - point)
                farthest = self.farthest

    def _covered(self, start: complex, end: complex) -> tuple[int, int]:
        """Return which rays a side ahead covers: the first, and the one behind the last."""
        rays = self._rays
        first, last = 0, len(rays)
        if (self._right * end).imag > _ROUNDING:
            right = end.conjugate() * self._ahead
            while first < last and (right * rays[first]).imag < -_ROUNDING:
                first += 1
        if (self._left * start).imag < -_ROUNDING:
            left = start.conjugate() * self._ahead
            while last > first and (left * rays[last - 1]).imag > _ROUNDING:
                last -= 1
        return first, last

    def _meet_ahead(self, normal: complex, height: float, start: complex, end: complex) -> None:
        """Meet a side that faces the point with the rays between its ends, which are seen from the point."""
        first, last = self._covered(start, end)
        normal *= self._ahead
        cosine = -min([(normal * ray).real for ray in self._rays[first:last]], default=0.0)
        if height < cosine * self.farthest:
            self.farthest = height / cosine
            self.cosine = cosine

    def _meet_behind(self, normal: complex, height: float, start: complex, end: complex) -> None:
        """Meet a side between the starts of the rays and the point, from which its ends are seen."""
        if (normal * start).imag <= self._setback and (normal * end).imag >= -self._setback:
            self.is_sure = False

    def meet_cylinder(self, cylinder: Cylinder) -> None:
        """Follow the rays to a cylinder, no further than to what they have met."""
        middle, radius = (cylinder.middle - self.point).conjugate() * self._ahead, cylinder.radius
        for ray in self._rays:
            turned = middle * ray
            if abs(turned.imag) < radius:
                depth = sqrt(radius * radius - turned.imag * turned.imag)
                distance = turned.real - depth
                if distance <= 0.0:
                    self.is_sure = self.is_sure and distance < -self._setback
                elif distance < self.farthest:
                    self.farthest = distance
                    self.cosine = depth / radius


class AllHits(FirstHit):
    """Likewise, with the first surface that each of the rays has met so far.

    farthest: how far ahead of the point the longest ray ends, m.
    """

    __slots__ = ("cosines", "distances")

    def __init__(self, fan: Fan, place: complex, ahead: complex) -> None:
        """As `FirstHit`."""
        super().__init__(fan, place, ahead)
        self.distances = [fan.reach] * len(fan.rays)
        self.cosines = [0.0] * len(fan.rays)

    def nearest(self, least: float) -> float:
        """As `FirstHit`, but certain."""
        pairs = zip(self.distances, self.cosines, strict=True)
        return min((distance for distance, cosine in pairs if cosine > least), default=inf)

    def _meet_ahead(self, normal: complex, height: float, start: complex, end: complex) -> None:
        normal *= self._ahead
        for number in range(*self._covered(start, end)):
            cosine = -(normal * self._rays[number]).real
            if cosine > 0.0:
                self._note(number, height / cosine, cosine)
        self.farthest = max(self.distances)

    def _meet_behind(self, normal: complex, height: float, start: complex, end: complex) -> None:
        begin, last = (normal * start).imag - _ROUNDING, (normal * end).imag + _ROUNDING
        normal *= self._ahead
        for number, ray in enumerate(self._rays):
            turned = normal * ray
            if turned.real < 0.0:
                distance = -height / turned.real
                if begin <= distance * turned.imag <= last:
                    self._note(number, distance, -turned.real)
        self.farthest = max(self.distances)

    def meet_cylinder(self, cylinder: Cylinder) -> None:
        """As `FirstHit`, ray by ray."""
        middle, radius = (cylinder.middle - self.point).conjugate() * self._ahead, cylinder.radius
        for number, ray in enumerate(self._rays):
            turned = middle * ray
            if abs(turned.imag) < radius:
                depth = sqrt(radius * radius - turned.imag * turned.imag)
                self._note(number, turned.real - depth, depth / radius)
        self.farthest = max(self.distances)

    def _note(self, number: int, distance: float, cosine: float) -> None:
        if -self._setback <= distance < self.distances[number]:
            self.distances[number] = distance
            self.cosines[number] = cosine


def box_sides(middle: complex, ahead: complex, corners: Sequence[complex]) -> list[BoxSide]:
    """Return the sides of a box seen from above.

    Args:
        middle: Origin of the box's frame.
        ahead: Direction of its x axis, of length 1.
        corners: Of the box in its frame: in front on the right, in front on the left, and on behind.
    """
    one, two, three, four = (middle + ahead * corner for corner in corners)
    forward, left = ahead.conjugate(), (ahead * 1j).conjugate()
    return [
        BoxSide(forward, (forward * one).real, one, two),
        BoxSide(left, (left * two).real, two, three),
        BoxSide(-forward, -(forward * three).real, three, four),
        BoxSide(-left, -(left * four).real, four, one),
    ]


def box_corners(front: float, rear: float, half_width: float) -> tuple[complex, complex, complex, complex]:
    """Return the corners of a box that reaches so far from its origin ahead, behind and to each side, m."""
    return (
        complex(front, -half_width),
        complex(front, half_width),
        complex(-rear, half_width),
        complex(-rear, -half_width),
    )
