"""Poses that agree best with what was measured between them: Levenberg-Marquardt with a robust weight.

An edge that disagrees with all others counts for less (dynamic covariance scaling), so one false loop does not bend a
map. The equations are dense: a map of a building has some hundreds of poses, for which they are solved in a fraction of
a second, and numpy is all that they need.

Sources: G. Grisetti et al., A tutorial on graph-based SLAM, 2010; P. Agarwal et al., Robust map optimization using
dynamic covariance scaling, ICRA 2013.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry import Pose2D
from maps.building.readings import Floats

ROUNDS = 12
DONE = 5e-4
"""m and rad; a step below it is the last one."""
TOLERANCE = 9.0
"""Squared Mahalanobis distance from which on an edge counts for less, of those that may be false."""


@dataclass(frozen=True, slots=True)
class Edge:
    """What was measured: pose of node `last` in the frame of node `first`.

    information: inverse covariance of x, y and heading, shape (3, 3). may_be_false: of a loop, not of odometry.
    """

    first: int
    last: int
    pose: Pose2D
    information: Floats
    may_be_false: bool = False


def optimised(poses: Sequence[Pose2D], edges: Sequence[Edge], fixed: Sequence[int] = (0,)) -> list[Pose2D]:
    """Return the poses that agree best with the edges.

    Args:
        poses: Where to begin; one for each node.
        edges: Which connect every node with a fixed one.
        fixed: Nodes that stay where they are.
    """
    if not edges or len(poses) < 2:
        return list(poses)
    graph = _Graph(edges)
    state = np.array([(pose.x, pose.y, pose.heading) for pose in poses])
    free = np.setdiff1d(np.arange(len(poses)), np.asarray(fixed))
    unknowns = (3 * free[:, None] + np.arange(3)).reshape(-1)
    damping = 1e-6
    hessian, gradient, cost = graph.linearised(state)
    for _ in range(ROUNDS):
        system = hessian[np.ix_(unknowns, unknowns)]
        system[np.diag_indices(len(unknowns))] *= 1.0 + damping
        step = np.zeros_like(state)
        step.reshape(-1)[unknowns] = -np.linalg.solve(system, gradient[unknowns])
        trial = state + step
        after = graph.linearised(trial)
        if after[2] <= cost:
            state, (hessian, gradient, cost), damping = trial, after, max(damping / 10.0, 1e-9)
            if np.abs(step).max() < DONE:
                break
        else:
            damping *= 100.0
            if damping > 1e9:
                break
    headings = np.arctan2(np.sin(state[:, 2]), np.cos(state[:, 2]))
    return [Pose2D(float(x), float(y), float(h)) for (x, y, _), h in zip(state, headings, strict=True)]


def weights(poses: Sequence[Pose2D], edges: Sequence[Edge]) -> Floats:
    """Return how much each edge counts, 0 to 1."""
    state = np.array([(pose.x, pose.y, pose.heading) for pose in poses])
    graph = _Graph(edges)
    return graph.weights(graph.errors(state)[0])


class _Graph:
    """Edges as arrays."""

    def __init__(self, edges: Sequence[Edge]) -> None:
        self._first = np.array([edge.first for edge in edges])
        self._last = np.array([edge.last for edge in edges])
        self._measured = np.array([(edge.pose.x, edge.pose.y, edge.pose.heading) for edge in edges])
        self._information = np.array([edge.information for edge in edges])
        self._doubted = np.array([edge.may_be_false for edge in edges])

    def errors(self, state: Floats) -> tuple[Floats, Floats, Floats]:
        """Return errors, shape (n, 3), and their derivatives by the first and the last pose, shape (n, 3, 3)."""
        first, last = state[self._first], state[self._last]
        c, s = np.cos(first[:, 2]), np.sin(first[:, 2])
        dx, dy = last[:, 0] - first[:, 0], last[:, 1] - first[:, 1]
        x, y = c * dx + s * dy, c * dy - s * dx
        turn = last[:, 2] - first[:, 2] - self._measured[:, 2]
        error = np.stack(
            (x - self._measured[:, 0], y - self._measured[:, 1], np.arctan2(np.sin(turn), np.cos(turn))), axis=1
        )
        by_first, by_last = np.zeros((len(error), 3, 3)), np.zeros((len(error), 3, 3))
        by_first[:, 0, 0], by_first[:, 0, 1], by_first[:, 0, 2] = -c, -s, y
        by_first[:, 1, 0], by_first[:, 1, 1], by_first[:, 1, 2] = s, -c, -x
        by_first[:, 2, 2] = -1.0
        by_last[:, 0, 0], by_last[:, 0, 1] = c, s
        by_last[:, 1, 0], by_last[:, 1, 1] = -s, c
        by_last[:, 2, 2] = 1.0
        return error, by_first, by_last

    def weights(self, error: Floats) -> Floats:
        """Return how much each edge counts."""
        squared = np.einsum("ni,nij,nj->n", error, self._information, error)
        scale = np.minimum(1.0, 2.0 * TOLERANCE / (TOLERANCE + squared))
        result: Floats = np.where(self._doubted, scale**2, 1.0)
        return result

    def linearised(self, state: Floats) -> tuple[Floats, Floats, float]:
        """Return the matrix, the gradient and the cost."""
        error, by_first, by_last = self.errors(state)
        weight = self.weights(error)
        squared = np.einsum("ni,nij,nj->n", error, self._information, error)
        information = self._information * weight[:, None, None]
        count = len(state)
        matrix = np.zeros((count, count, 3, 3))
        gradient = np.zeros((count, 3))
        ends = ((self._first, by_first), (self._last, by_last))
        for at, by in ends:
            np.add.at(gradient, at, np.einsum("nji,njk,nk->ni", by, information, error))
            for other, by_other in ends:
                np.add.at(matrix, (at, other), np.einsum("nji,njk,nkl->nil", by, information, by_other))
        # The cost whose gradient this is: quadratic within the tolerance, and then nearly flat.
        doubted = np.where(squared > TOLERANCE, 3.0 * TOLERANCE - 4.0 * TOLERANCE**2 / (TOLERANCE + squared), squared)
        cost = float(np.where(self._doubted, doubted, squared).sum())
        return matrix.transpose(0, 2, 1, 3).reshape(3 * count, 3 * count), gradient.reshape(-1), cost
