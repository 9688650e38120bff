"""A state machine for components: a table of what follows what, and no time or task of its own.

The platform's `FiniteStateMachine` is a behaviour: each of its states is a coroutine that runs until it says what has
happened. What a component hears comes when it comes, whatever the state, and has to be answered at once. Here the table
is the machine, and whoever has it says what happens.

    machine = StateMachine({("shut", "push"): "open", **from_each(("shut", "open"), "kick", "broken")}, "shut")
    machine.happens("push", now=3.0)
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

S = TypeVar("S", bound=str)
E = TypeVar("E", bound=str)


class TransitionMissing(LookupError):
    """Nothing follows this event in this state."""


@dataclass(frozen=True, slots=True)
class Change(Generic[S, E]):
    """One state has followed another. at: s. why: in words."""

    before: S
    event: E
    after: S
    at: float
    why: str


class StateMachine(Generic[S, E]):
    """In one state at a time.

    state: the present one. since: when it came to be, s. why: in words.
    """

    def __init__(
        self, transitions: Mapping[tuple[S, E], S], start: S, on_change: Callable[[Change[S, E]], None] | None = None
    ) -> None:
        """Begin.

        Args:
            transitions: State and event to the state that follows.
            start: The first state.
            on_change: Told of each event that is followed by another state.
        """
        self._transitions = dict(transitions)
        self._on_change = on_change
        self.state = start
        self.since = 0.0
        self.why = ""

    def knows(self, event: E) -> bool:
        """Whether something follows this event now."""
        return (self.state, event) in self._transitions

    def happens(self, event: E, now: float, why: str = "") -> S:
        """Go on to the state that follows, and return it; an event that leads to the same state changes nothing.

        Raises:
            NoTransition: Nothing follows; the state stays as it is.
        """
        if not self.knows(event):
            raise TransitionMissing(f"nothing follows {_word(event)!r} in the state {_word(self.state)!r}")
        before, after = self.state, self._transitions[self.state, event]
        if after != before:
            self.state, self.since, self.why = after, now, why
            if self._on_change is not None:
                self._on_change(Change(before, event, after, now, why))
        return after


def from_each(states: Iterable[S], event: E, after: S) -> dict[tuple[S, E], S]:
    """Rows of a table: the event leads from each of these states to the same one."""
    return {(state, event): after for state in states}


def _word(name: str) -> str:
    return name.value if isinstance(name, StrEnum) else name
