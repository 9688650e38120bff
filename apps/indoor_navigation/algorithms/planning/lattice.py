"""The cheapest plan over the poses of a robot: a hybrid A* search with the outline of the robot.

The search grows motions from the pose of the robot: arcs forward and backward, and turns on the spot. Of all poses that
fall into one cell of place and heading, it keeps the cheapest. What a metre costs depends on the room about the whole
outline, so tight passages, backing out and turning where there is room follow from the search. The cost that is left
is estimated by the way of a point with the robot's least width, which no plan can fall below.

In each round all poses are taken at once whose estimate is within STEP_COST of the best, so that numpy handles many.

Source: Dolgov, Thrun, Montemerlo, Diebel, "Practical search techniques in path planning for autonomous driving", 2008;
the rounds: Meyer, Sanders, "Delta-stepping: a parallelizable shortest path algorithm", 2003.
"""

from dataclasses import replace
from itertools import groupby, pairwise
from math import ceil, copysign, pi
from typing import NamedTuple

import numpy as np

from apps.indoor_navigation.algorithms.planning.ground import Ground
from apps.indoor_navigation.algorithms.planning.plan import Motion, Plan, PlanPiece
from apps.indoor_navigation.algorithms.planning.search import NO_WAY, costs_to, find_way
from apps.indoor_navigation.algorithms.planning.terrain import BARRED
from apps.indoor_navigation.data import Bools, Floats, Ints, Place, Pose

HEADINGS = 48  # of cells; a straight line is at most 3.75 degrees from one of them
CELL = 0.1  # m, edge of a cell of places
SPACING = 0.15  # m between two poses that are checked, and in turns rad
STEP_COST = 0.4  # of the estimate, within which poses are handled together
MAX_POSES = 50_000  # of a search; plans through offices need a few thousand
WIDTH_STEP = 0.02  # m, to which the width is found that the robot would have to lack
BETTER = 1e-3  # of costs, by which another way to a cell must be cheaper

GREED = 1.3  # of the estimate; plans cost a few percent more than the cheapest, and are found ten times sooner
TURN_COST = 0.6  # m, of a turn by 1 rad on the spot
STOP_COST = 0.3  # m, of a change between driving forward, driving backward and turning
BACK_COST = 2.5  # of a metre backward, where few sensors look
BEND_COST = 0.25  # m, of a bend by 1 rad: the robot is slower there


class _Moves(NamedTuple):
    """The motions that are tried from each pose.

    motions, kinds: of each move; kinds are numbers of motions. fixed: cost of each. lengths: sums of its weights.
    starts, ends: indices of its first and last sample. along, aside, turn: of each sample, relative to the pose that it
    begins at. weights: of each sample, m.
    """

    motions: tuple[Motion, ...]
    kinds: Ints
    fixed: Floats
    lengths: Floats
    starts: Ints
    ends: Ints
    along: Floats
    aside: Floats
    turn: Floats
    weights: Floats


KINDS = tuple(Motion)


def _moves() -> _Moves:
    unit = 2.0 * pi / HEADINGS
    drives = [(0.3, 0), (0.9, 0), *((0.3, bins) for bins in (-4, -1, 1, 4))]
    drives += [(-0.3, bins) for bins in (-3, 0, 3)]
    turns = [-6, -1, 1, 6]
    motions, fixed, samples = [], [], []
    for length, bins in drives:
        count = max(2, round(abs(length) / SPACING))
        parts = np.arange(1, count + 1) / count
        turned = bins * unit * parts
        chords = length * parts * np.sinc(turned / (2.0 * pi))
        weight = abs(length) / count * (BACK_COST if length < 0.0 else 1.0)
        motions.append(Motion.GO if length > 0.0 else Motion.BACK)
        fixed.append(BEND_COST * abs(bins) * unit)
        samples.append((chords * np.cos(turned / 2.0), chords * np.sin(turned / 2.0), turned, weight))
    for bins in turns:
        count = max(1, round(abs(bins) * unit / SPACING))
        parts = np.arange(1, count + 1) / count
        motions.append(Motion.TURN)
        fixed.append(0.0)
        samples.append((0.0 * parts, 0.0 * parts, bins * unit * parts, TURN_COST * abs(bins) * unit / count))
    counts = np.array([len(each[0]) for each in samples])
    ends = counts.cumsum() - 1
    along, aside, turn = (np.concatenate([each[number] for each in samples]) for number in range(3))
    weights = np.repeat([each[3] for each in samples], counts)
    starts = ends - counts + 1
    kinds = np.array([KINDS.index(motion) for motion in motions])
    lengths = np.add.reduceat(weights, starts)
    return _Moves(tuple(motions), kinds, np.array(fixed), lengths, starts, ends, along, aside, turn, weights)


MOVES = _moves()


class _Poses:
    """All poses of a search: where, at what cost, and by which move from which other pose."""

    def __init__(self, start: Pose, cell: int) -> None:
        self.x, self.y, self.heading, self.cost = (np.empty(MAX_POSES) for _ in range(4))
        self.parent, self.move, self.cell = (np.empty(MAX_POSES, np.intp) for _ in range(3))
        self.x[0], self.y[0], self.heading[0] = start
        self.cost[0], self.parent[0], self.move[0], self.cell[0] = 0.0, -1, -1, cell
        self.count = 1

    def add(self, x: Floats, y: Floats, heading: Floats, cost: Floats, parent: Ints, move: Ints, cell: Ints) -> Ints:
        """Add poses, and return their numbers; those above MAX_POSES are left out."""
        here = slice(self.count, min(self.count + len(x), MAX_POSES))
        fit = here.stop - here.start
        self.x[here], self.y[here], self.heading[here], self.cost[here] = x[:fit], y[:fit], heading[:fit], cost[:fit]
        self.parent[here], self.move[here], self.cell[here] = parent[:fit], move[:fit], cell[:fit]
        self.count = here.stop
        return np.arange(here.start, here.stop)


def missing_width(ground: Ground, goal: Place, tolerance: float) -> tuple[float, Place] | None:
    """Return by how many m the robot is too wide for every way to a place, and where; None where no gap is known.

    Args:
        ground: With the pose of the robot; no plan leads to the goal.
        goal: In odom.
        tolerance: m from it where a way may end.
    """
    found, least, most = None, 0.0, ground.outline.width / 2.0
    while found is None or most - least > WIDTH_STEP:
        lack = most if found is None else (least + most) / 2.0
        flat = ground._replace(outline=replace(ground.outline, width=ground.outline.width - lack)).flat()
        way = find_way(flat, ground.robot[:2], goal, tolerance)
        if way is not None:
            found, most = way, lack
        elif found is None:
            return None
        else:
            least = lack
    points = np.concatenate([np.linspace(a, b, 20) for a, b in pairwise(found)])
    places: list[Place] = [(float(x), float(y)) for x, y in points]
    rows, columns = np.array([ground.area.cell(*place) for place in places]).T
    room = ground.clearance.distances[rows, columns]
    if ground.area.unknown[rows, columns][room < ground.outline.width / 2.0].any():
        return None  # a gap that nobody has looked through, as between two hits on a far wall
    return max(ground.outline.width - 2.0 * float(room.min()), most), places[int(room.argmin())]


def turn_piece(ground: Ground, heading: float) -> PlanPiece:
    """Return a turn on the spot from the robot's pose to a heading, the longer way round if the shorter is barred."""
    x, y, start = ground.robot
    short = float(wrapped(np.array([heading - start]))[0])
    pieces = []
    for turn in (short, short - copysign(2.0 * pi, short)):
        parts = np.linspace(0.0, turn, max(2, ceil(abs(turn) / SPACING) + 1))
        poses = np.stack((np.full(len(parts), x), np.full(len(parts), y), start + parts), axis=1)
        weights = np.full(len(parts), TURN_COST * abs(turn) / len(parts))
        pieces.append(PlanPiece(Motion.TURN, poses, weights, STOP_COST))
    return min(pieces, key=lambda piece: Plan((piece,)).cost(ground))


class PlanSearch:
    """The search of one plan. estimate: of its cost from the robot's pose, never more than GREED times as much."""

    def __init__(self, ground: Ground, goal: Place, tolerance: float) -> None:
        """Prepare the search.

        Args:
            ground: With the pose of the robot; the goal must be within its area.
            goal: In odom.
            tolerance: m from it where the plan may end.
        """
        self._ground = ground
        self._goal, self._tolerance = goal, max(tolerance, 0.75 * CELL)
        flat = ground.flat()
        self._area = flat.area
        left = costs_to(flat, goal, tolerance) * flat.area.resolution
        self._left = np.where(left < NO_WAY * flat.area.resolution, left, np.inf)
        self._downhill = _downhill(self._left)
        rows, columns = self._left.shape
        self._best = np.full(rows * columns * HEADINGS, np.inf)
        self._unit = 2.0 * pi / HEADINGS
        x, y, heading = (np.array([each]) for each in ground.robot)
        row, column, cell = self._cells(x, y, heading)
        self._poses = _Poses(ground.robot, int(cell[0]))
        self._best[cell] = 0.0
        self.estimate = GREED * float(self._left[row[0], column[0]])

    def find(self) -> Plan | None:
        """Return the cheapest plan; None where there is none."""
        last = self._run()
        return None if last is None else self._plan(last)

    def _run(self) -> int | None:
        """Return the number of the last pose of the cheapest plan; None where there is none."""
        poses = self._poses
        waiting, estimate = np.zeros(1, np.intp), np.array([self.estimate])
        while len(waiting) and poses.count < MAX_POSES and np.isfinite(estimate.min()):
            is_next = estimate <= estimate.min() + STEP_COST
            taken, waiting = waiting[is_next], waiting[~is_next]
            at_goal = taken[self._is_goal(taken)]
            if len(at_goal):
                return int(at_goal[poses.cost[at_goal].argmin()])
            taken = taken[poses.cost[taken] <= self._best[poses.cell[taken]]]
            new, new_estimate = self._expanded(taken)
            waiting = np.concatenate((waiting, new))
            estimate = np.concatenate((estimate[~is_next], new_estimate))
        return None

    def _is_goal(self, numbers: Ints) -> Bools:
        x, y = self._poses.x[numbers] - self._goal[0], self._poses.y[numbers] - self._goal[1]
        return np.asarray(np.hypot(x, y) <= self._tolerance)

    def _expanded(self, taken: Ints) -> tuple[Ints, Floats]:
        """Add the poses that moves lead to, and return their numbers and the estimated costs of plans over them."""
        poses, moves = self._poses, MOVES
        before = np.where(poses.move[taken] < 0, -1, moves.kinds[poses.move[taken]])[:, None]
        spent = moves.fixed + np.where((before != moves.kinds) & (before >= 0), STOP_COST, 0.0)
        spent = poses.cost[taken, None] + spent
        x, y, heading = self._reached(taken[:, None], moves.ends)
        row, column, cell = self._cells(x, y, heading)
        # A metre costs 1 at least. Most moves lead to cells that are known to be reached for less than that.
        is_worth = (spent + moves.lengths < self._best[cell] - BETTER) & np.isfinite(self._left[row, column])
        of, move = np.nonzero(is_worth)
        dear, is_free = self._driven(taken[of], move)
        of, move = of[is_free], move[is_free]
        total = spent[of, move] + dear[is_free]
        x, y, heading = x[of, move], y[of, move], heading[of, move]
        row, column, cell = row[of, move], column[of, move], cell[of, move]
        order = np.argsort(total, kind="stable")
        order = order[(total < self._best[cell] - BETTER)[order]]
        _, first = np.unique(cell[order], return_index=True)
        chosen = order[np.sort(first)]
        self._best[cell[chosen]] = total[chosen]
        numbers = poses.add(
            x[chosen], y[chosen], heading[chosen], total[chosen], taken[of[chosen]], move[chosen], cell[chosen]
        )
        bend = np.abs(wrapped(heading[chosen] - self._downhill[row[chosen], column[chosen]]))
        left = self._left[row[chosen], column[chosen]]
        estimate = total[chosen] + GREED * (left + BEND_COST * np.nan_to_num(bend))
        return numbers, estimate[: len(numbers)]

    def _driven(self, numbers: Ints, move: Ints) -> tuple[Floats, Bools]:
        """Return what each move from each pose costs beside its fixed cost, and whether the robot fits all along it."""
        if not len(move):
            return np.zeros(0), np.zeros(0, np.bool_)
        starts = MOVES.starts[move]
        counts = MOVES.ends[move] - starts + 1
        first = counts.cumsum() - counts
        sample = np.arange(counts.sum()) + np.repeat(starts - first, counts)
        costs = self._ground.costs(*self._reached(np.repeat(numbers, counts), sample))
        is_free = np.maximum.reduceat(costs, first) < BARRED
        return np.add.reduceat(costs * MOVES.weights[sample], first), is_free

    def _reached(self, numbers: Ints, sample: Ints) -> tuple[Floats, Floats, Floats]:
        """Return the poses of samples of moves that begin at some poses; the shapes are broadcast."""
        poses, moves = self._poses, MOVES
        heading = poses.heading[numbers]
        c, s = np.cos(heading), np.sin(heading)
        x = poses.x[numbers] + (c * moves.along[sample] - s * moves.aside[sample])
        y = poses.y[numbers] + (s * moves.along[sample] + c * moves.aside[sample])
        return x, y, heading + moves.turn[sample]

    def _cells(self, x: Floats, y: Floats, heading: Floats) -> tuple[Ints, Ints, Ints]:
        """Return row and column of places, limited to the area, and the number of the cell of poses."""
        rows, columns = self._left.shape
        row, column = (y - self._area.y) / self._area.resolution, (x - self._area.x) / self._area.resolution
        row = np.minimum(np.maximum(row, 0.0), rows - 1.0).astype(np.intp)
        column = np.minimum(np.maximum(column, 0.0), columns - 1.0).astype(np.intp)
        sector = np.round((heading - self._ground.robot[2]) / self._unit).astype(np.intp) % HEADINGS
        return row, column, (row * columns + column) * HEADINGS + sector

    def _plan(self, last: int) -> Plan:
        """Return the plan to a pose."""
        poses, numbers = self._poses, [last]
        while poses.parent[numbers[-1]] >= 0:
            numbers.append(int(poses.parent[numbers[-1]]))
        numbers.reverse()
        steps = [(parent, int(poses.move[number])) for parent, number in pairwise(numbers)]
        pieces = tuple(
            self._piece(motion, list(group)) for motion, group in groupby(steps, lambda step: MOVES.motions[step[1]])
        )
        return Plan(pieces or (PlanPiece(Motion.GO, np.array([self._ground.robot]), np.zeros(1), 0.0),))

    def _piece(self, motion: Motion, steps: list[tuple[int, int]]) -> PlanPiece:
        first = steps[0][0]
        poses, weights = (
            [np.array([[each[first] for each in (self._poses.x, self._poses.y, self._poses.heading)]])],
            [np.zeros(1)],
        )
        for parent, move in steps:
            samples = np.arange(MOVES.starts[move], MOVES.ends[move] + 1)
            poses.append(np.stack(self._reached(np.array([parent]), samples), axis=1))
            weights.append(MOVES.weights[samples])
        fixed = STOP_COST + sum(float(MOVES.fixed[move]) for _, move in steps)
        return PlanPiece(motion, np.concatenate(poses), np.concatenate(weights), fixed)


def _downhill(left: Floats) -> Floats:
    """Return the direction in which the cost that is left decreases in each cell, rad; NaN where that is not known."""
    with np.errstate(invalid="ignore"):  # between two infinite costs; NaN is returned
        up, right = np.gradient(left)
        return np.asarray(np.where(np.isfinite(up) & np.isfinite(right), np.arctan2(-up, -right), np.nan))


def wrapped(angles: Floats) -> Floats:
    """Return angles in [-pi, pi)."""
    return np.asarray((angles + pi) % (2.0 * pi) - pi)
