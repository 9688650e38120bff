"""A plan: pieces that the robot drives forward, backward, or turns on the spot."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from apps.indoor_navigation.algorithms.planning.ground import Ground
from apps.indoor_navigation.algorithms.planning.terrain import BARRED
from apps.indoor_navigation.data import Floats, Place, Pose


class Motion(StrEnum):
    """How a piece is driven."""

    GO = "go"
    BACK = "back"
    TURN = "turn"


@dataclass(frozen=True, slots=True)
class PlanPiece:
    """A part of a plan without a stop in it.

    poses: x, y and heading in odom, of shape (n, 3), from the end of the piece before. weights: of shape (n,); a pose
    costs its weight, m, times the cost of a metre there. fixed: cost beside that.
    """

    motion: Motion
    poses: Floats
    weights: Floats
    fixed: float

    @property
    def end(self) -> Pose:
        """The last pose."""
        x, y, heading = self.poses[-1].tolist()
        return x, y, heading

    def nearest(self, place: Place, among: int) -> int:
        """Return the number of the pose that is nearest to a place, among so many first ones."""
        return int(np.hypot(self.poses[:among, 0] - place[0], self.poses[:among, 1] - place[1]).argmin())

    def nearest_turn(self, heading: float) -> int:
        """Return the number of the pose whose heading is nearest to another one, rad."""
        off = (self.poses[:, 2] - heading + np.pi) % (2.0 * np.pi) - np.pi
        return int(np.abs(off).argmin())

    def after(self, number: int) -> "PlanPiece":
        """Return the piece from a pose on."""
        return PlanPiece(self.motion, self.poses[number:], self.weights[number:], self.fixed)


@dataclass(frozen=True, slots=True)
class Plan:
    """The rest of a way. beyond: places behind an obstacle that may go away, before which the plan ends."""

    pieces: tuple[PlanPiece, ...]
    beyond: tuple[Place, ...] = ()

    @property
    def poses(self) -> Floats:
        """All poses, of shape (n, 3)."""
        return np.concatenate([piece.poses for piece in self.pieces])

    @property
    def lengths(self) -> Floats:
        """Length of the way to each pose, m."""
        poses = self.poses
        return np.concatenate(([0.0], np.hypot(*np.diff(poses[:, :2], axis=0).T).cumsum()))

    def costs(self, ground: Ground) -> Floats:
        """Return the cost of a metre at each pose."""
        return ground.costs(*self.poses.T)

    def cost(self, ground: Ground) -> float:
        """Return the cost of the whole; BARRED where the robot does not fit at a pose."""
        costs = self.costs(ground)
        if costs.max(initial=0.0) >= BARRED:
            return BARRED
        weights = np.concatenate([piece.weights for piece in self.pieces])
        return float(costs @ weights) + sum(piece.fixed for piece in self.pieces)

    def first_barred(self, ground: Ground) -> float | None:
        """Return the length of the way to the first pose where the robot does not fit, m; None where there is none."""
        barred = np.flatnonzero(self.costs(ground) >= BARRED)
        return float(self.lengths[barred[0]]) if len(barred) else None

    def advanced(self, number: int) -> "Plan":
        """Return the plan from a pose of its first piece on."""
        return Plan((self.pieces[0].after(number), *self.pieces[1:]), self.beyond) if number else self

    def without_first(self) -> "Plan":
        """Return the plan without its first piece."""
        return Plan(self.pieces[1:], self.beyond)

    def shortened(self, length: float) -> "Plan":
        """Return the plan up to so many m, with the places of the rest in `beyond`."""
        kept: list[PlanPiece] = []
        count = max(1, int(np.searchsorted(self.lengths, length)))
        beyond = tuple((float(x), float(y)) for x, y, _ in self.poses[count - 1 :])
        for piece in self.pieces:
            if count <= 0:
                break
            kept.append(PlanPiece(piece.motion, piece.poses[:count], piece.weights[:count], piece.fixed))
            count -= len(piece.poses)
        return Plan(tuple(kept), beyond)
