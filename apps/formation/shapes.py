"""Shapes of formations as offsets from the leader, and the assignment of robots to them.

Offsets are in m, x forward and y to the left in the leader's frame.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations, count, islice, permutations
from pathlib import Path

import configs
from configs.suggestion import meant
from geometry import Point

FARTHEST = 20.0  # m; an offset beyond it is taken for a mistake of the unit
FILE_KEY = "offsets_m"
COLUMN = "column"
MOST_EXACT = 7
"""Robots for which all assignments are compared; 7 have 5040."""


class ShapeError(ValueError):
    """A shape that cannot be formed; the message says why and what to do."""


def shape_offsets(shape: str, followers: int, spacing: float, nearest: float) -> tuple[Point, ...]:
    """Return the virtual points of a shape.

    Args:
        shape: One of `SHAPES`, or a TOML file with `offsets_m = [[x, y], ...]`.
        followers: How many points are needed.
        spacing: Between neighbours, m; a file has its own.
        nearest: m between two robots, at least.
    Returns:
        One offset for each follower.
    Raises:
        ShapeError: There is no such shape, or robots would touch in it.
    """
    if shape.endswith(".toml"):
        points = _read(Path(shape), followers)
    elif shape in SHAPES:
        points = [(spacing * x, spacing * y) for x, y in islice(SHAPES[shape](), followers)]
    else:
        near = meant(shape, list(SHAPES))
        hint = f"did you mean {near}?" if near else f"choose {', '.join(SHAPES)}, or a .toml file with offsets"
        raise ShapeError(f"there is no shape {shape!r}; {hint}")
    _check_apart(shape, [(0.0, 0.0), *points], nearest)
    return tuple(points)


def check_behind(shape: str, points: Sequence[Point], aside: float) -> None:
    """Check that the target at the leader's back can be seen from all points of a shape.

    Args:
        shape: For the message.
        points: m in the leader's frame.
        aside: Off the leader's back, within which the target can be seen, rad.
    Raises:
        ShapeError: It cannot.
    """
    off = max((abs(math.atan2(y, -x)) for x, y in points), default=0.0)
    if off > aside:
        raise ShapeError(
            f"in {shape}, a place is {math.degrees(off):.0f} degrees off the leader's back, and its target is seen "
            f"within {math.degrees(aside):.0f} degrees; choose column, wedge, triangle or diamond, or poses=odometry"
        )


def _column() -> Iterator[Point]:
    """Yield one behind the other."""
    for row in count(1):
        yield -float(row), 0.0


def _line() -> Iterator[Point]:
    """Yield side by side with the leader in the middle."""
    for row in count(1):
        yield 0.0, float(row)
        yield 0.0, -float(row)


def _wedge() -> Iterator[Point]:
    """Yield two arms behind the leader, at right angles to each other."""
    for row in count(1):
        for side in (1.0, -1.0):
            yield -row * math.sqrt(0.5), side * row * math.sqrt(0.5)


def _triangle() -> Iterator[Point]:
    """Yield rows of two, three and more; neighbours form triangles with equal sides."""
    for row in count(1):
        for place in range(row + 1):
            yield -row * math.sqrt(0.75), row / 2 - place


def _diamond() -> Iterator[Point]:
    """Yield a square on its corner: of four robots, of nine beyond that, and so on."""
    done: set[Point] = set()
    for size in count(1):
        for row in range(1, 2 * size + 1):
            width = min(row, 2 * size - row)
            for place in range(width + 1):
                point = -row * math.sqrt(0.5), (width / 2 - place) * math.sqrt(2.0)
                if point not in done:
                    done.add(point)
                    yield point


SHAPES: Mapping[str, Callable[[], Iterator[Point]]] = {
    COLUMN: _column,
    "line": _line,
    "wedge": _wedge,
    "triangle": _triangle,
    "diamond": _diamond,
}
"""Endless points of each shape with a spacing of 1 m; the first ones are taken."""


def _read(file: Path, followers: int) -> list[Point]:
    try:
        table = configs.read(file)
    except configs.ConfigError as err:
        raise ShapeError(str(err)) from err
    rows = table.get(FILE_KEY)
    if not isinstance(rows, list) or set(table) != {FILE_KEY}:
        raise ShapeError(f"{file}: expected {FILE_KEY} = [[x, y], ...] and nothing else")
    points = [_point(file, row) for row in rows]
    if len(points) < followers:
        raise ShapeError(f"{file} has {len(points)} offsets for {followers} followers; add one for each follower")
    return points[:followers]


def _point(file: Path, row: object) -> Point:
    match row:
        case [int() | float() as x, int() | float() as y] if not isinstance(x, bool) and not isinstance(y, bool):
            if max(abs(x), abs(y)) <= FARTHEST:  # False for NaN as well
                return float(x), float(y)
    raise ShapeError(f"{file}: {row!r} is no offset; expected [x, y] in m within {FARTHEST:g} m")


def _check_apart(shape: str, points: Sequence[Point], nearest: float) -> None:
    for a, b in combinations(points, 2):
        if math.dist(a, b) < nearest:
            raise ShapeError(
                f"in {shape}, two robots are {math.dist(a, b):.2f} m apart; expected at least {nearest:.2f} m"
            )


def assign(robots: Mapping[str, Point], points: Sequence[Point]) -> dict[str, int]:
    """Assign each robot to a point of its own.

    The sum of the squared distances is smallest, so that the straight ways do not cross and nobody has far to go. For
    more than `MOST_EXACT` robots, pairs are exchanged until no exchange makes it smaller.

    Args:
        robots: Position by name, m.
        points: As many, m, in the same frame.
    Returns:
        Index of the point by name; of equal assignments the first in the order of the names.
    """
    names = sorted(robots)
    costs = [[math.dist(robots[name], point) ** 2 for point in points] for name in names]
    if len(names) <= MOST_EXACT:
        best = min(permutations(range(len(points))), key=lambda order: _cost(costs, order))
        return dict(zip(names, best, strict=True))
    return dict(zip(names, _exchanged(costs), strict=True))


def _cost(costs: Sequence[Sequence[float]], order: Sequence[int]) -> float:
    return sum(row[index] for row, index in zip(costs, order, strict=True))


def _exchanged(costs: Sequence[Sequence[float]]) -> list[int]:
    order = list(range(len(costs)))
    is_better = True
    while is_better:
        is_better = False
        for a in range(len(order)):
            for b in range(a + 1, len(order)):
                before = costs[a][order[a]] + costs[b][order[b]]
                if costs[a][order[b]] + costs[b][order[a]] < before - 1e-9:
                    order[a], order[b], is_better = order[b], order[a], True
    return order
