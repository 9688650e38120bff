"""A sequence diagram before it is drawn: lifelines, and the arrows between them from top to bottom."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from agents.sniffer.captured import CapturedMessage, brief


@dataclass(frozen=True, slots=True)
class Arrow:
    """One message to one receiver.

    time: when it was said, s since 1970.
    start, end: lifelines, by number; equal when an agent speaks to itself, or to nobody.
    what: the performative.
    is_no: whether it says that something is not done.
    content: any JSON value.
    conversation: its id; empty for a message that belongs to none.
    colour: the number of its conversation, from 0; None for a message that belongs to none.
    """

    time: float
    start: int
    end: int
    what: str
    is_no: bool
    content: Any
    conversation: str
    colour: int | None

    def label(self, longest: int) -> str:
        """What is written at it, on one line of at most so many characters."""
        room = max(longest - len(self.what) - 1, 0)
        text = brief(self.content, room) if room > 3 else ""
        return f"{self.what} {text}".rstrip()


@dataclass(frozen=True, slots=True)
class Diagram:
    """What was said, as a diagram shows it.

    lifelines: names of agents, in the order in which they first speak or are spoken to.
    left_out: messages before the first that are not shown.
    """

    lifelines: Sequence[str]
    arrows: Sequence[Arrow]
    left_out: int = 0


def diagram_of(said: Iterable[CapturedMessage], left_out: int = 0) -> Diagram:
    """The diagram of what was said, in the order of the times."""
    lifelines: dict[str, int] = {}
    colours: dict[str, int] = {}
    arrows = []
    for each in sorted(said, key=lambda each: each.time):
        message = each.message
        start = lifelines.setdefault(str(message.sender), len(lifelines))
        conversation = message.conversation_id
        colour = colours.setdefault(conversation, len(colours)) if conversation else None
        for receiver in message.receivers or (message.sender,):
            end = lifelines.setdefault(str(receiver), len(lifelines))
            arrows.append(
                Arrow(
                    each.time, start, end, str(message.performative), each.is_no, message.content, conversation, colour
                )
            )
    return Diagram(list(lifelines), arrows, left_out)
