"""A sequence diagram as SVG: one file that needs no other, for a browser, a report or a slide."""

from collections.abc import Iterator
from datetime import datetime
from itertools import pairwise

from acromovi.sniffer.sequence import Arrow, Diagram
from acromovi.sniffer.text import clock
from acromovi.svg import COLOURS, LETTER, STYLE, document, head, width_of, written
from agents.sniffer.captured import brief, shortened

PLAIN = "#6b7280"  # of messages that belong to no conversation
NO = "#c62828"  # of the word that says that something is not done
ROW = 30.0  # px from one message to the next
TIMES = 96.0  # px for the times at the left
TOP, BOTTOM = 84.0, 24.0  # px above the first message, and below the last
BOX = 26.0  # px, the height of a box with a name
NARROWEST = 130.0  # px between two lifelines
BESIDE = 28.0  # px of an arrow beside its label
SELF = 34.0  # px that a message to oneself reaches out
LONGEST_LABEL = 48  # characters
LONGEST_NAME = 28  # characters
LONGEST_HINT = 1000  # characters that are shown when the pointer rests on a message
OWN_STYLE = (
    ".time{font-family:ui-monospace,'DejaVu Sans Mono',monospace;font-size:10px;fill:#6b7280}"
    ".what{font-weight:600}.life{stroke:#cbd5e1}"
)


def svg(diagram: Diagram) -> str:
    """The diagram as an SVG document."""
    places = _places(diagram)
    lowest = TOP + ROW * max(len(diagram.arrows), 1)
    width = places[-1] + _reach(diagram) if places else 420.0
    height = lowest + BOX + BOTTOM
    heads = (head(f"head{number}", colour) for number, colour in enumerate((*COLOURS, PLAIN)))
    arrows = enumerate(diagram.arrows)
    return document(
        width,
        height,
        _title(diagram),
        STYLE + OWN_STYLE,
        [
            "<defs>",
            *heads,
            "</defs>",
            *_lifelines(diagram, places, lowest),
            *(part for row, arrow in arrows for part in _arrow(arrow, places, TOP + ROW * (row + 0.7))),
        ],
    )


def _title(diagram: Diagram) -> str:
    if not diagram.arrows:
        return "Nobody said anything"
    first = datetime.fromtimestamp(diagram.arrows[0].time)
    seconds = diagram.arrows[-1].time - diagram.arrows[0].time
    count = len(diagram.arrows)
    title = f"{first:%Y-%m-%d %H:%M:%S}, {count} message{'s' * (count > 1)} in {seconds:.3g} s"
    return f"{title}, {diagram.left_out} before them left out" if diagram.left_out else title


def _places(diagram: Diagram) -> list[float]:
    """Where each lifeline stands, in px, so that names and labels fit between them."""
    halves = [_box(name) / 2 for name in diagram.lifelines]
    gaps = [max(left + right + 16, NARROWEST) for left, right in pairwise(halves)]
    for arrow in sorted(diagram.arrows, key=lambda arrow: abs(arrow.end - arrow.start)):
        first, last = sorted((arrow.start, arrow.end))
        between = range(first, min(max(last, first + 1), len(gaps)))
        needed = width_of(arrow.label(LONGEST_LABEL)) + BESIDE + SELF * (first == last)
        lacking = needed - sum(gaps[each] for each in between)
        for each in between:
            gaps[each] += max(lacking / len(between), 0.0)
    places = [TIMES + halves[0]] if halves else []
    for gap in gaps:
        places.append(places[-1] + gap)
    return places


def _reach(diagram: Diagram) -> float:
    """How far the diagram goes on to the right of the last lifeline, px."""
    last = len(diagram.lifelines) - 1
    own = [arrow.label(LONGEST_LABEL) for arrow in diagram.arrows if arrow.start == arrow.end == last]
    return 16 + max([_box(diagram.lifelines[last]) / 2, *(SELF + 8 + width_of(label) for label in own)])


def _lifelines(diagram: Diagram, places: list[float], lowest: float) -> Iterator[str]:
    for name, x in zip(diagram.lifelines, places, strict=True):
        yield f'<line class="life" x1="{x:.1f}" y1="{TOP - 18:.1f}" x2="{x:.1f}" y2="{lowest + 8:.1f}"/>'
        for y in (TOP - 18 - BOX, lowest + 8):
            width = _box(name)
            yield (
                f'<rect x="{x - width / 2:.1f}" y="{y:.1f}" width="{width:.1f}" height="{BOX:.0f}" rx="5" '
                'fill="#f1f5f9" stroke="#94a3b8"/>'
            )
            shown = written(shortened(name, LONGEST_NAME))
            yield f'<text class="name" x="{x:.1f}" y="{y + 17:.1f}" text-anchor="middle">{shown}</text>'


def _arrow(arrow: Arrow, places: list[float], y: float) -> Iterator[str]:
    number = len(COLOURS) if arrow.colour is None else arrow.colour % len(COLOURS)
    colour = (*COLOURS, PLAIN)[number]
    here, there = places[arrow.start], places[arrow.end]
    yield "<g>"
    yield f"<title>{written(_hint(arrow))}</title>"
    yield f'<text class="time" x="16" y="{y + 3.5:.1f}">{clock(arrow.time)}</text>'
    line = f'fill="none" stroke="{colour}" stroke-width="1.5" marker-end="url(#head{number})"'
    if here == there:
        yield f'<path d="M{here:.1f} {y - 6:.1f} h{SELF - 8:.1f} v10 h-{SELF - 14:.1f}" {line}/>'
        yield _label(arrow, LONGEST_LABEL, here + SELF, y + 2, "start")
    else:
        end = there - 6 if there > here else there + 6  # the head's tip touches the lifeline
        yield f'<path d="M{here:.1f} {y:.1f} H{end:.1f}" {line}/>'
        room = max(int((abs(there - here) - BESIDE) / LETTER), LONGEST_LABEL)
        yield _label(arrow, room, (here + there) / 2, y - 5, "middle")
    yield "</g>"


def _label(arrow: Arrow, longest: int, x: float, y: float, anchor: str) -> str:
    what, _, text = arrow.label(longest).partition(" ")
    colour = f' style="fill:{NO}"' if arrow.is_no else ""
    return (
        f'<text class="label" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">'
        f'<tspan class="what"{colour}>{written(what)}</tspan> {written(text)}</text>'
    )


def _hint(arrow: Arrow) -> str:
    conversation = f"conversation {arrow.conversation}" if arrow.conversation else "no conversation"
    return f"{arrow.what} {brief(arrow.content, LONGEST_HINT)}\n{conversation}"


def _box(name: str) -> float:
    return width_of(shortened(name, LONGEST_NAME)) * 1.08 + 20  # a name is bold
