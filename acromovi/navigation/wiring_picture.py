"""The wiring of a navigation as SVG: components in their layers, processes as shades, and connections as arrows."""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import cycle, pairwise
from typing import Any, Self

from acromovi.navigation.layers import GraphEdge, GraphLayout, lay_out, ranks
from acromovi.svg import STYLE, document, head, width_of, written

LAYERS = ("deliberative", "monitor", "reactive", "hardware")
COLOURS = {"push": "#1f77b4", "send": "#c2571a", "query": "#6b7280"}  # by pattern
LINES = {
    "push": 'stroke-width="1.4"',
    "send": 'stroke-width="2.4"',
    "query": 'stroke-width="1.4" stroke-dasharray="3 3"',
}
MEANINGS = {
    "push": "whenever there is something new",
    "send": "to one, and it must arrive",
    "query": "from the one who asks",
}
SHADES = ("#dbeafe", "#dcfce7", "#fef3c7", "#fce7f3", "#ede9fe", "#cffafe", "#ffedd5", "#e5e7eb", "#ecfccb", "#fee2e2")
NOT_ACTIVE = "#c62828"
BOX, LABELS, BAND = 40.0, 66.0, 12.0  # px, heights of a box and of the room below it, and of a band beyond its boxes
SIDE, TOP = 110.0, 44.0  # px at the left for the layers' names, and above for the title
LINE = 18.0  # px from line to line in the legend
TIP = 6.0  # px from the end of a line to its arrow's tip
NARROWEST = 560.0  # px
OWN = ".small{font-size:9px;fill:#475569}.layer{font-weight:600;fill:#64748b}"

Wire = tuple[str, str, str]
"""Sender, receiver and pattern of a connection."""


@dataclass(frozen=True, slots=True)
class Seen:
    """A running component, from its description.

    hears: source and kind of data. tells: kind of data to receivers. asks: query to the component that answers.
    """

    name: str
    role: str
    container: str
    state: str = "active"
    hears: Sequence[tuple[str, str]] = ()
    tells: Mapping[str, Sequence[str]] = field(default_factory=dict)
    asks: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def from_description(cls, told: Mapping[str, Any]) -> Self:
        """Build from a description of the directory.

        Raises:
            LookupError, TypeError, ValueError: It is no component's.
        """
        wiring = told["properties"]
        return cls(
            str(told["name"]).partition("@")[0],
            str(told["role"]),
            str(told["container"]),
            str(told["state"]),
            [(str(source), str(what)) for source, what in wiring.get("hears", ())],
            {str(what): [str(each) for each in receivers] for what, receivers in dict(wiring.get("tells", {})).items()},
            {str(what): str(answerer) for what, answerer in dict(wiring.get("asks", {})).items()},
        )

    def wires(self) -> Iterator[tuple[Wire, str]]:
        """Yield its connections, with the data of each."""
        yield from (((source, self.name, "push"), what) for source, what in self.hears)
        yield from (((self.name, to, "send"), what) for what, receivers in self.tells.items() for to in receivers)
        yield from (((self.name, answerer, "query"), what) for what, answerer in self.asks.items())


def svg(robot: str, components: Iterable[Seen]) -> str:
    """Return the wiring as an SVG document."""
    seen = {each.name: each for each in sorted(components, key=lambda each: each.name)}
    wires = _wires(seen.values())
    drawn = {wire: what for wire, what in wires.items() if wire[0] in seen and wire[1] in seen and wire[0] != wire[1]}
    missing = ", ".join(sorted({name for wire in wires for name in wire[:2]} - seen.keys()))
    complaint = f"not there, though others are wired to them: {missing}" if missing else ""
    rows = _rows(seen, drawn)
    layout = lay_out(
        [{name: _box_width(seen[name], drawn) for name in names} for _, names in rows],
        [GraphEdge(start, end, width_of(what) + 6) for (start, end, _), what in drawn.items()],
    )
    shades = dict(zip(sorted({each.container for each in seen.values()}), cycle(SHADES), strict=False))
    bottom = _y(2 * len(rows) - 2) + BOX + BAND if rows else TOP
    width = max(SIDE + max(layout.width, width_of(complaint)) + 24, NARROWEST)
    parts = [
        "<defs>",
        *(head(pattern, colour) for pattern, colour in COLOURS.items()),
        "</defs>",
        *_bands(rows, width),
        *(part for wire, way in zip(drawn.items(), layout.ways, strict=True) for part in _arrow(*wire, way)),
        *_boxes(seen, rows, layout, shades),
        *_legend(shades, complaint, bottom + LINE),
    ]
    title = f"{robot}: {len(seen)} components of the navigation" if seen else f"Nobody navigates {robot}"
    return document(width, bottom + LINE * (len(COLOURS) + len(shades) + 2), title, STYLE + OWN, parts)


def _wires(components: Iterable[Seen]) -> dict[Wire, str]:
    """Return all connections, with the kinds of their data."""
    found: dict[Wire, list[str]] = {}
    for wire, what in (each for component in components for each in component.wires()):
        found.setdefault(wire, []).append(what)
    return {wire: ", ".join(sorted(set(whats))) for wire, whats in sorted(found.items())}


def _rows(seen: Mapping[str, Seen], wires: Collection[Wire]) -> list[tuple[str, list[str]]]:
    """Return each row's layer and boxes, from the top; in a layer, receivers of pushed data are below the senders."""
    rows = []
    for layer in sorted({each.role for each in seen.values()}, key=lambda role: (*LAYERS, role).index(role)):
        names = [name for name, each in seen.items() if each.role == layer]
        within = [wire for wire in wires if wire[0] in names and wire[1] in names]
        incoming = Counter(wire[1] for wire in within)
        within.sort(key=lambda wire: (list(COLOURS).index(wire[2]), incoming[wire[0]]))  # pushes decide, and sources
        rank = ranks(names, [(start, end) for start, end, _ in within])
        rows += [(layer, [name for name in names if rank[name] == row]) for row in range(max(rank.values()) + 1)]
    return rows


def _bands(rows: Sequence[tuple[str, Sequence[str]]], width: float) -> Iterator[str]:
    """Yield a band behind each layer, with its name."""
    layers = [layer for layer, _ in rows]
    for number, layer in enumerate(dict.fromkeys(layers)):
        first, last = layers.index(layer), len(layers) - 1 - layers[::-1].index(layer)
        top, bottom = _y(2 * first) - BAND, _y(2 * last) + BOX + BAND
        fill = ("#f8fafc", "#f1f5f9")[number % 2]
        yield f'<rect x="0" y="{top:.1f}" width="{width:.0f}" height="{bottom - top:.1f}" fill="{fill}"/>'
        yield f'<text class="layer" x="16" y="{(top + bottom) / 2 + 4:.1f}">{written(layer)}</text>'


def _arrow(wire: Wire, what: str, way: Sequence[tuple[int, float]]) -> Iterator[str]:
    start, end, pattern = wire
    points = [(SIDE + x, _y(row) + BOX / 2) for row, x in way]
    down = way[1][0] > way[0][0]
    points[0] = points[0][0], points[0][1] + (BOX / 2 if down else -BOX / 2)
    points[-1] = points[-1][0], points[-1][1] - (BOX / 2 + TIP if down else -BOX / 2 - TIP)
    path = f"M{points[0][0]:.1f} {points[0][1]:.1f}"
    for (x, y), (to_x, to_y) in pairwise(points):
        middle = (y + to_y) / 2
        path += f" C{x:.1f} {middle:.1f} {to_x:.1f} {middle:.1f} {to_x:.1f} {to_y:.1f}"
    x, y = points[1]
    yield f"<g><title>{written(f'{start} → {end}: {pattern} {what}')}</title>"
    yield f'<path d="{path}" fill="none" stroke="{COLOURS[pattern]}" {LINES[pattern]} marker-end="url(#{pattern})"/>'
    yield (
        f'<text class="label" x="{x:.1f}" y="{y + 4:.1f}" text-anchor="middle" '
        f'style="fill:{COLOURS[pattern]}">{written(what)}</text></g>'
    )


def _boxes(
    seen: Mapping[str, Seen], rows: Sequence[tuple[str, Sequence[str]]], layout: GraphLayout, shades: Mapping[str, str]
) -> Iterator[str]:
    for number, (_, names) in enumerate(rows):
        y = _y(2 * number)
        for each in (seen[name] for name in names):
            x, width = SIDE + layout.boxes[each.name], layout.widths[each.name]
            line = "#64748b" if each.state == "active" else NOT_ACTIVE
            yield f"<g><title>{written(f'{each.name} in {each.container}, {each.state}')}</title>"
            yield (
                f'<rect x="{x - width / 2:.1f}" y="{y:.1f}" width="{width:.1f}" height="{BOX:.0f}" rx="6" '
                f'fill="{shades[each.container]}" stroke="{line}"/>'
            )
            yield f'<text class="name" x="{x:.1f}" y="{y + 17:.1f}" text-anchor="middle">{written(each.name)}</text>'
            below = written(_below(each))
            yield f'<text class="small" x="{x:.1f}" y="{y + 31:.1f}" text-anchor="middle">{below}</text></g>'


def _below(component: Seen) -> str:
    return component.container if component.state == "active" else f"{component.container}: {component.state}"


def _legend(shades: Mapping[str, str], complaint: str, y: float) -> Iterator[str]:
    for pattern, colour in COLOURS.items():
        yield f'<path d="M{SIDE:.0f} {y:.1f} h40" stroke="{colour}" {LINES[pattern]} marker-end="url(#{pattern})"/>'
        yield f'<text x="{SIDE + 60:.0f}" y="{y + 4:.1f}">{pattern}: {MEANINGS[pattern]}</text>'
        y += LINE
    for container, shade in shades.items():
        yield f'<rect x="{SIDE:.0f}" y="{y - 7:.1f}" width="46" height="13" rx="3" fill="{shade}" stroke="#64748b"/>'
        yield f'<text x="{SIDE + 60:.0f}" y="{y + 4:.1f}">the process of {written(container)}</text>'
        y += LINE
    if complaint:
        yield f'<text x="{SIDE:.0f}" y="{y + 4:.1f}" style="fill:{NOT_ACTIVE}">{written(complaint)}</text>'


def _box_width(component: Seen, wires: Iterable[Wire]) -> float:
    """Return the width of a box, px, for its texts and arrows."""
    ends = sum(component.name in wire[:2] for wire in wires)
    text = max(width_of(component.name) * 1.08, width_of(_below(component)) * 0.85)
    return max(text + 20, 16.0 * ends)


def _y(row: int) -> float:
    """Return the upper edge of a row, px; rows of boxes and rows of labels alternate."""
    return TOP + BAND + row * (BOX + LABELS) / 2
