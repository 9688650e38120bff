"""A drawing in layers: where boxes stand and how the lines between them run, so that no line crosses a box.

Boxes stand in rows. Between two rows of boxes is a row for the labels of the lines. A line that goes further passes
each row in between at a place of its own; so rows hold boxes, labels and passages, and are ordered so that few lines
cross (after Sugiyama, Tagawa and Toda, Methods for visual understanding of hierarchical system structures, 1981).
"""

from collections import defaultdict
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

ORDERING, MOVING = 12, 80  # sweeps; more change nothing that one would see
PASSAGE = 10.0  # px for a line that passes a row
BETWEEN = 14.0  # px between two things in a row


@dataclass(frozen=True, slots=True)
class GraphEdge:
    """A line from one box to another. label: its width, px."""

    start: Hashable
    end: Hashable
    label: float


@dataclass(slots=True)
class _Thing:
    """An item in a row: a box, a label or a passage."""

    row: int
    width: float
    x: float = 0.0
    near: list["_Thing"] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class GraphLayout:
    """Where everything is, px to the right of the left edge; rows are counted from the top, labels' rows included.

    boxes: the middle of each; widths: as they were given. ways: of each line, row and x of the places that it passes:
    where it leaves its box, its label, passages, and where it comes to the other box.
    """

    boxes: Mapping[Hashable, float]
    widths: Mapping[Hashable, float]
    ways: Sequence[Sequence[tuple[int, float]]]
    width: float


def lay_out(rows: Sequence[Mapping[Hashable, float]], lines: Sequence[GraphEdge]) -> GraphLayout:
    """Compute the places.

    Args:
        rows: From the top, the boxes in each and their widths, px.
        lines: Between boxes of different rows.
    """
    boxes = {name: _Thing(2 * row, width) for row, names in enumerate(rows) for name, width in names.items()}
    things: list[list[_Thing]] = [[] for _ in range(max(2 * len(rows) - 1, 1))]
    for thing in boxes.values():
        things[thing.row].append(thing)
    ways = [_way(boxes[line.start], boxes[line.end], line.label, things) for line in lines]
    for row in things:
        _close_up(row)
    for sweep in range(ORDERING + MOVING):
        for row in things if sweep % 2 else reversed(things):
            if sweep < ORDERING:
                row.sort(key=lambda thing: _wanted(thing))
            _pull(row)
    left = min((thing.x - thing.width / 2 for row in things for thing in row), default=0.0)
    right = max((thing.x + thing.width / 2 for row in things for thing in row), default=0.0)
    for thing in (thing for row in things for thing in row):
        thing.x -= left
    places = {name: thing.x for name, thing in boxes.items()}
    return GraphLayout(places, {name: thing.width for name, thing in boxes.items()}, _through(ways), right - left)


def ranks(names: Iterable[Hashable], before: Iterable[tuple[Hashable, Hashable]]) -> dict[Hashable, int]:
    """Return the row of each box, so that no connected pair shares one and the first of a pair is above.

    A pair that would close a circle with those before it stands the other way round.
    """
    rank = dict.fromkeys(names, 0)
    below: dict[Hashable, set[Hashable]] = {name: set() for name in rank}
    for first, second in before:
        if first != second and first not in _reached(below, second):
            below[first].add(second)
            _sink(rank, below, second, rank[first] + 1)
    return rank


def _reached(below: Mapping[Hashable, set[Hashable]], name: Hashable) -> set[Hashable]:
    found, look = set(), [name]
    while look:
        found.add(each := look.pop())
        look += below[each] - found
    return found


def _sink(rank: dict[Hashable, int], below: Mapping[Hashable, set[Hashable]], name: Hashable, least: int) -> None:
    if rank[name] < least:
        rank[name] = least
        for each in below[name]:
            _sink(rank, below, each, least + 1)


def _way(start: _Thing, end: _Thing, label: float, things: list[list[_Thing]]) -> list[_Thing]:
    """Return the items of a line, from box to box; the first between them has its label."""
    step = 1 if end.row > start.row else -1
    between = [_Thing(row, PASSAGE) for row in range(start.row + step, end.row, step)]
    between[0].width = max(label, PASSAGE)
    way = [start, *between, end]
    for thing, following in pairwise(way):
        thing.near.append(following)
        following.near.append(thing)
    for thing in between:
        things[thing.row].append(thing)
    return way


def _through(ways: Sequence[Sequence[_Thing]]) -> list[list[tuple[int, float]]]:
    """Return rows and x of the items that the lines pass; at a box the lines are side by side."""
    found = [[(thing.row, thing.x) for thing in way] for way in ways]
    sides: dict[tuple[int, bool], list[tuple[float, int, int]]] = defaultdict(list)
    for number, way in enumerate(ways):
        for end, following in ((0, 1), (-1, -2)):
            side = id(way[end]), way[following].row > way[end].row
            sides[side].append((way[following].x, number, end))
    for ends in sides.values():
        for place, (_, number, end) in enumerate(sorted(ends), 1):
            box = ways[number][end]
            found[number][end] = box.row, box.x + (place / (len(ends) + 1) - 0.5) * box.width
    return found


def _close_up(row: list[_Thing]) -> None:
    x = 0.0
    for thing in row:
        thing.x = x + thing.width / 2
        x += thing.width + BETWEEN


def _wanted(thing: _Thing) -> float:
    """Return the preferred place: the middle of the connected items."""
    return sum(each.x for each in thing.near) / len(thing.near) if thing.near else thing.x


def _pull(row: list[_Thing]) -> None:
    """Move each item as near to its preferred place as the others of its row allow."""
    wanted = [_wanted(thing) for thing in row]
    from_left = _spaced(row, wanted)
    mirrored = _spaced(row[::-1], [-x for x in wanted[::-1]])
    for thing, x, other in zip(row, from_left, [-x for x in mirrored[::-1]], strict=True):
        thing.x = (x + other) / 2


def _spaced(row: Sequence[_Thing], wanted: Sequence[float]) -> list[float]:
    places: list[float] = []
    for index, thing in enumerate(row):
        least = places[-1] + (row[index - 1].width + thing.width) / 2 + BETWEEN if places else wanted[0]
        places.append(max(wanted[index], least))
    return places
