"""A sequence diagram as text: lifelines are columns, each message is a line.

                     ask-1f@terminal              base@happy
                            │                          │
12:30:01.204  8c1d0a        │─ request move distance=1 ▶│
12:30:01.205  8c1d0a        │◀ agree ──────────────────│
"""

from collections.abc import Iterator
from datetime import datetime
from itertools import pairwise

from acromovi.sniffer.sequence import Arrow, Diagram
from agents.sniffer.captured import SHORT_ID, shortened

LINE, DASH, TO_RIGHT, TO_LEFT, SELF = "│", "─", "▶", "◀", "↺"
NAME_ROOM = 24  # characters of a lifeline's name
LONGEST_LABEL = 44  # characters
NARROWEST = 20  # characters between two lifelines
MARGIN = 4  # characters of an arrow beside its label: a dash, two blanks and the head


def lines(diagram: Diagram, width: int = 160) -> Iterator[str]:
    """The lines of a diagram, as wide as it needs to be, and no wider than `width` characters if that can be."""
    if not diagram.arrows:
        yield "nobody said anything"
        return
    if diagram.left_out:
        yield f"{diagram.left_out} earlier messages are left out"
    places = _places(diagram, width - len(_head(diagram.arrows[0])))
    left = " " * len(_head(diagram.arrows[0]))
    names = (left + _names(diagram, places)).rstrip()
    yield names
    yield left + _lifelines(places)
    for arrow in diagram.arrows:
        yield (_head(arrow) + _arrow(arrow, places)).rstrip()
    yield left + _lifelines(places)
    yield names


def clock(time: float) -> str:
    """The time of day here, to the millisecond."""
    return f"{datetime.fromtimestamp(time):%H:%M:%S.%f}"[:-3]


def _head(arrow: Arrow) -> str:
    return f"{clock(arrow.time)}  {shortened(arrow.conversation[:SHORT_ID], SHORT_ID):<{SHORT_ID}} "


def _places(diagram: Diagram, width: int) -> list[int]:
    """In which column each lifeline stands, so that labels fit between them."""
    names = [min(len(name), NAME_ROOM) for name in diagram.lifelines]
    gaps = [max((left + right) // 2 + 2, NARROWEST) for left, right in pairwise(names)] + [names[-1] // 2]
    narrow = list(gaps)
    for arrow in sorted(diagram.arrows, key=lambda arrow: abs(arrow.end - arrow.start)):
        first, last = sorted((arrow.start, arrow.end))
        between = range(first, max(last, first + 1))
        lacking = len(arrow.label(LONGEST_LABEL)) + MARGIN + 1 - sum(gaps[each] for each in between)
        for each in between:
            gaps[each] += max(-(-lacking // len(between)), 0)
    first = names[0] // 2
    spare = max(width - first - sum(narrow), 0)
    wanted = sum(gaps) - sum(narrow)
    share = min(spare / wanted, 1.0) if wanted else 0.0
    places = [first]
    for least, most in zip(narrow[:-1], gaps[:-1], strict=True):
        places.append(places[-1] + least + int((most - least) * share))
    return places


def _names(diagram: Diagram, places: list[int]) -> str:
    row = ""
    for name, place in zip(diagram.lifelines, places, strict=True):
        shown = shortened(name, NAME_ROOM)
        row = row.ljust(place - len(shown) // 2) + shown
    return row


def _lifelines(places: list[int]) -> str:
    row = [" "] * (places[-1] + 1)
    for place in places:
        row[place] = LINE
    return "".join(row)


def _arrow(arrow: Arrow, places: list[int]) -> str:
    row = list(_lifelines(places))
    here, there = places[arrow.start], places[arrow.end]
    if here == there:
        label = f"{SELF} {arrow.label(LONGEST_LABEL)}"
        row[here + 1 : here + 1 + len(label)] = label
        return "".join(row)
    first, last = sorted((here, there))
    room = last - first - 1
    text = f" {arrow.label(room - MARGIN)} "
    if there > here:
        row[first + 1 : last] = f"{DASH}{text:{DASH}<{room - 2}}{TO_RIGHT}"
    else:
        row[first + 1 : last] = f"{TO_LEFT}{text:{DASH}<{room - 2}}{DASH}"
    return "".join(row)
