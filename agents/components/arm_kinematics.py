"""Kinematics of an arm on a robot: where the tip of its gripper is, and how it gets to a point.

Frames: `base_link`, m, x ahead, y left, z up from the floor under the middle of the axle (REP 103). Angles of joints in
rad, as the arm reports them. No bus, no clock.

Forward: a product of rotations about the joints' axes. Inverse: damped least squares [1], with the joints kept within
their limits, from the present posture first, then from home and others; the first solution counts in which, and on the
way to which, the arm meets neither the floor nor the robot's body. The hand's direction is free unless it is given.

[1] S. R. Buss: Introduction to inverse kinematics with Jacobian transpose, pseudoinverse and damped least squares
methods, 2004.
"""

from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, isfinite
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from agents.components.hand_direction import Floats, HandDirection, ReachError

_POSTURES = 12  # from which solutions are looked for, besides the present one and home
_BENT = 30  # of these before them where the direction of the hand is given, which bend the arm and do not twist it
_NEARBY = 1.0  # rad, the most that a joint turns to a solution from the present posture, before those are tried
_STEPS = 80  # of one solution at most
_DAMPING = 0.03  # m
_LONGEST_STEP = 0.1  # m, of the tip in one step
_TOLERANCE = 0.002  # m from the point, of a solution
_TOLERANCE_RAD = 0.01  # of the hand's direction
_LEVER = 0.15  # m; how much a rad of the hand's direction counts
_SEED = 11
_THICKNESS = 0.03  # m between the line through the joints and the surface of the arm
_SPACING = 0.03  # m between points of the arm that are checked
_WAY = 24  # moments of the way that are checked
_FREE_LINKS = 2  # at the base, which cannot meet the body or the floor


@dataclass(frozen=True, slots=True)
class HullBox:
    """The body of the robot under the arm, from the floor up: m before and behind the axle, to each side, and high."""

    front: float
    rear: float
    half_width: float
    top: float

    def contains(self, points: Floats, margin: float = 0.0) -> "NDArray[np.bool_]":
        """Return which points, shape (n, 3), are inside, or nearer to it than a margin, m."""
        x, y, z = points.T
        inside: NDArray[np.bool_] = (
            (x < self.front + margin)
            & (x > -self.rear - margin)
            & (np.abs(y) < self.half_width + margin)
            & (z < self.top + margin)
        )
        return inside


@dataclass(frozen=True, slots=True, eq=False)
class ArmKinematics:
    """An arm of turning joints.

    base: of its first joint, m. axes, offsets: of each joint, when all angles are zero: unit vectors, and m from the
    joint before; shape (n, 3). tip: between the ends of the fingers, m from the last joint. lower, upper, home: of each
    joint, rad. hull: of the robot. fingers: unit vector along which they part when all angles are zero; zero if it is
    not known.
    """

    base: Floats
    axes: Floats
    offsets: Floats
    tip: Floats
    lower: Floats
    upper: Floats
    home: Floats
    hull: HullBox
    fingers: Floats

    @classmethod
    def of(cls, properties: Mapping[str, Any]) -> Self | None:
        """Return the kinematics by the description of an arm and its robot; None where it has none."""
        chain, hull = properties.get("chain"), properties.get("hull")
        rows = [row for row in properties.get("joints", []) if row.get("unit") == "rad"]
        if not chain or not hull or len(chain["axes"]) != len(rows):
            return None
        base, axes, offsets, tip = (np.array(chain[name], np.float64) for name in ("base", "axes", "offsets", "tip"))
        lower, upper, home = (np.array([row[name] for row in rows], np.float64) for name in ("lower", "upper", "home"))
        top = float(base[2]) - 0.02  # the deck that carries the arm
        body = HullBox(float(hull["length_front"]), float(hull["length_rear"]), float(hull["width"]) / 2.0, top)
        fingers = np.array(chain.get("fingers", (0.0, 0.0, 0.0)), np.float64)
        return cls(base, axes, offsets, tip, lower, upper, home, body, fingers)

    def forward(self, angles: Sequence[float] | Floats) -> Floats:
        """Return where the tip is, m, shape (3,).

        Args:
            angles: Of each turning joint, rad.
        """
        points, _, _ = self._chain(np.asarray(angles, np.float64))
        last: Floats = points[-1]
        return last

    def direction(self, angles: Sequence[float] | Floats) -> HandDirection:
        """Return where the hand points and along which line its fingers part.

        Args:
            angles: Of each turning joint, rad.
        """
        return self._hand(self._chain(np.asarray(angles, np.float64))[2])

    def reach(
        self,
        point: Sequence[float] | Floats,
        present: Sequence[float] | Floats,
        pitch: float | None = None,
        yaw: float | None = None,
    ) -> Floats:
        """Return what `reaching` returns in the end.

        Raises:
            ReachError: As there.
        """
        search = self.reaching(point, present, pitch, yaw)
        while True:
            try:
                next(search)
            except StopIteration as end:
                angles: Floats = end.value
                return angles

    def reaching(
        self,
        point: Sequence[float] | Floats,
        present: Sequence[float] | Floats,
        pitch: float | None = None,
        yaw: float | None = None,
    ) -> Generator[None, None, Floats]:
        """Return the angles with the tip at a point, rad, shape (n,); yield after each posture that was begun from.

        One posture takes some 20 ms, and a point out of reach takes all of them; others may go on meanwhile.

        Args:
            point: x, y, z in m.
            present: The angles now, rad.
            pitch: Of the hand, rad below level, -pi/2 to pi/2; the fingers part level then. None: any direction.
            yaw: Of the hand with a pitch, rad to the left, -pi to pi. None: away from the arm's base.
        Raises:
            ReachError: The point is not three finite numbers; in or below the floor, or inside the body; out of reach,
                or out of reach with the hand in this direction; or the arm would meet floor or body.
        """
        goal, words = self._checked(point)
        wanted = self._wanted(goal, pitch, yaw)
        begin = np.clip(np.asarray(present, np.float64), self.lower, self.upper)
        found: list[tuple[Floats, float]] = []
        stands, spare = False, None
        for posture in self._postures(begin, wanted):
            angles, off = self._solved(goal, posture, wanted)
            found.append((angles, off))
            yield
            if off <= _TOLERANCE and not self._meets(angles):
                if self._meets_on_the_way(begin, angles):
                    stands = True
                elif wanted is None or len(found) > 1 or np.abs(angles - begin).max() <= _NEARBY:
                    return angles
                else:
                    spare = angles  # the arm may have twisted itself on such a way
        if spare is not None:
            return spare
        if min(off for _, off in found) > _TOLERANCE:
            if wanted is not None:
                raise ReachError(self._out_of_direction(goal, words, wanted, found))
            raise ReachError(self._out_of_reach(goal, words, found))
        what = "on its way to" if stands else "at"
        raise ReachError(f"the arm would meet the floor or the robot's own body {what} {words}; try another point")

    def _checked(self, point: Sequence[float] | Floats) -> tuple[Floats, str]:
        """Return a point as an array, m, and in words.

        Raises:
            ReachError: As `reaching`.
        """
        goal = np.asarray(point, np.float64)
        if goal.shape != (3,) or not all(map(isfinite, goal.tolist())):
            raise ReachError(f"a point is x, y and z in m, such as 0.4, 0, 0.3, not {str(list(point))[:60]}")
        words = f"({goal[0]:.3g}, {goal[1]:.3g}, {goal[2]:.3g}) m"
        if goal[2] < 0.0:
            raise ReachError(f"the point {words} is below the floor; the nearest one is {-goal[2]:.3g} m above it")
        if self.hull.contains(goal[None])[0]:
            raise ReachError(f"the point {words} is inside the robot's own body; {self._way_out(goal)}")
        return goal, words

    def _wanted(self, goal: Floats, pitch: float | None, yaw: float | None) -> HandDirection | None:
        """Return the direction that the hand is to have; None where it is free.

        Raises:
            ReachError: An angle is out of its limits, or the arm does not tell how its fingers part.
        """
        if pitch is None:
            if yaw is not None:
                raise ReachError(f"yaw {yaw:.3g} rad needs a pitch; give both, or pitch alone")
            return None
        if not self.fingers.any():
            raise ReachError("how the fingers of this arm part is not known; leave out pitch and yaw")
        if yaw is None:
            yaw = atan2(goal[1] - self.base[1], goal[0] - self.base[0])
        return HandDirection.of(pitch, yaw)

    def _postures(self, begin: Floats, wanted: HandDirection | None) -> list[Floats]:
        """Return postures to begin with, the same ones for the same arm and direction."""
        rng = np.random.default_rng(_SEED)
        home, span = np.clip(self.home, self.lower, self.upper), self.upper - self.lower
        others = [home, *(self.lower + span * rng.random((_POSTURES, len(begin))))]
        if wanted is None:
            return [begin, *others]
        bends = np.abs(self.axes[:, 1]) > 0.5  # in the plane that is upright and points ahead
        bent = np.where(bends, self.lower + span * rng.random((_BENT, len(begin))), home)
        return [begin, *(self._rolled(each, wanted) for each in bent), *others]

    def _rolled(self, angles: Floats, wanted: HandDirection) -> Floats:
        """Return a posture whose last joint, if it rolls the hand, has turned the fingers to where they are wanted."""
        hand = self.direction(angles)
        if self.axes[-1] @ self.tip < 0.99 * float(np.linalg.norm(self.tip)):
            return angles
        rolled: Floats = np.append(angles[:-1], angles[-1] + hand.roll_to(wanted))
        return np.clip(rolled, self.lower, self.upper)

    def _solved(
        self, goal: Floats, angles: Floats, wanted: HandDirection | None, *, bounded: bool = True
    ) -> tuple[Floats, float]:
        """Return the angles of the nearest posture that was found from one, and how far it is from the goal, m.

        Of a hand with a direction, the distance is the tip's, or what its angle is of the tolerance, if that is more.
        """
        best, least = angles, np.inf
        for _ in range(_STEPS):
            points, axes, rotation = self._chain(angles)
            off = goal - points[-1]
            jacobian = np.cross(axes, points[-1] - points[:-1]).T
            away = float(np.linalg.norm(off))
            if wanted is not None:
                turn = wanted.turn_from(self._hand(rotation))
                off = np.concatenate((off, _LEVER * turn))
                jacobian = np.concatenate((jacobian, _LEVER * axes.T))
                away = max(away, float(np.linalg.norm(turn)) / _TOLERANCE_RAD * _TOLERANCE)
            if away < least:
                best, least = angles, away
            if away <= _TOLERANCE / 10.0:
                break
            length = float(np.linalg.norm(off))
            step = off * min(1.0, _LONGEST_STEP / length)
            if bounded:  # joints at a limit that the step would pass do not take part
                pull = jacobian.T @ step
                jacobian = jacobian * ~(
                    ((angles <= self.lower) & (pull < 0.0)) | ((angles >= self.upper) & (pull > 0.0))
                )
            square = jacobian @ jacobian.T + _DAMPING**2 * min(1.0, length / _LONGEST_STEP) * np.eye(len(off))
            angles = angles + jacobian.T @ np.linalg.solve(square + 1e-9 * np.eye(len(off)), step)
            if bounded:
                angles = np.clip(angles, self.lower, self.upper)
        return best, least

    def _hand(self, rotation: Floats) -> HandDirection:
        """Return the direction of a hand that is turned by a rotation."""
        return HandDirection(rotation @ self.tip / float(np.linalg.norm(self.tip)), rotation @ self.fingers)

    def _chain(self, angles: Floats) -> tuple[Floats, Floats, Floats]:
        """Return joints and tip, m, shape (n + 1, 3), the joints' axes, shape (n, 3), and the hand's rotation."""
        place, rotation = self.base, np.eye(3)
        points, axes = [], []
        for axis, offset, angle in zip(self.axes, self.offsets, angles, strict=True):
            place = place + rotation @ offset
            points.append(place)
            axes.append(rotation @ axis)
            rotation = rotation @ _rotation(axis, float(angle))
        points.append(place + rotation @ self.tip)
        return np.array(points), np.array(axes), rotation

    def _meets(self, angles: Floats) -> bool:
        """Return whether the arm meets floor or body in a posture."""
        points = self._chain(angles)[0][_FREE_LINKS - 1 :]
        dense = [points[:1]]
        for first, second in pairwise(points):
            count = max(1, int(np.ceil(np.linalg.norm(second - first) / _SPACING)))
            dense.append(first + (second - first) * (np.arange(1, count + 1)[:, None] / count))
        arm = np.concatenate(dense)
        # The fingers' ends may touch the floor, and stand at the side of the hull.
        is_finger = np.linalg.norm(arm - points[-1], axis=1) < float(np.linalg.norm(self.tip))
        low = arm[:, 2] < np.where(is_finger, -0.001, _THICKNESS)
        hull = self.hull.contains(arm[~is_finger], 0.01).any() or self.hull.contains(arm[is_finger]).any()
        return bool(low.any() or hull)

    def _meets_on_the_way(self, begin: Floats, end: Floats) -> bool:
        """Return whether the arm meets something while all joints turn evenly; where it stands now does not count."""
        shares = np.arange(1, _WAY) / _WAY
        met = [self._meets(begin + share * (end - begin)) for share in shares]
        if self._meets(begin):  # it may leave what it touches already
            met = met[_WAY // 4 :]
        return any(met)

    def _out_of_reach(self, goal: Floats, words: str, found: Sequence[tuple[Floats, float]]) -> str:
        angles, off = min(found, key=lambda each: each[1])
        nearest = self.forward(angles)
        free = min(self._solved(goal, posture, None, bounded=False)[1] for posture, _ in found[:4])
        at = [str(number) for number, at in enumerate((angles <= self.lower) | (angles >= self.upper), 1) if at]
        reason = "it is out of the arm's reach"
        if free <= _TOLERANCE and at:
            reason = f"the limit of joint {' and '.join(at)} is in the way"
        return (
            f"the tip cannot get to {words}: {reason}; the nearest point that it reaches is {off:.3g} m away, at "
            f"({nearest[0]:.3g}, {nearest[1]:.3g}, {nearest[2]:.3g})"
        )

    def _out_of_direction(
        self, goal: Floats, words: str, wanted: HandDirection, found: Sequence[tuple[Floats, float]]
    ) -> str:
        angles, _ = min(found, key=lambda each: each[1])
        off = float(np.linalg.norm(self.forward(angles) - goal))
        turn = float(np.linalg.norm(wanted.turn_from(self.direction(angles))))
        return (
            f"the tip cannot get to {words} with the hand in this direction; the nearest posture that was found is "
            f"{off:.3g} m and {turn:.3g} rad off; try another point, pitch or yaw"
        )

    def _way_out(self, goal: Floats) -> str:
        """Return in words how far the surface of the body is."""
        hull = self.hull
        away = min(
            hull.front - goal[0], goal[0] + hull.rear, hull.half_width - abs(goal[1]), max(hull.top - goal[2], 0.0)
        )
        return f"its surface is {away:.3g} m away"


def _rotation(axis: Floats, angle: float) -> Floats:
    """Return the rotation about a unit vector, shape (3, 3) (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotated: Floats = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
    return rotated
