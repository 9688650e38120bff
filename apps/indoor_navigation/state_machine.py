"""A state machine for components: a transition table without tasks or a clock.

In the platform's `FiniteStateMachine` each state is a coroutine that runs until an event ends it. A component receives
data at any time and must react at once, whatever the state. So its owner calls this machine with each event.

    machine = StateMachine({("shut", "push"): "open", **from_each(("shut", "open"), "kick", "broken")}, "shut")
    machine.happens("push", now=3.0)
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

S = TypeVar("S", bound=str)
E = TypeVar("E", bound=str)


@dataclass(frozen=True, slots=True)
class Change(Generic[S, E]):
    """A change of state. at: s. why: the reason in words."""

    before: S
    event: E
    after: S
    at: float
    why: str


class StateMachine(Generic[S, E]):
    """The present state and how the machine came to it.

    since: time of the last change, s. why: its reason in words.
    """

    def __init__(
        self, transitions: Mapping[tuple[S, E], S], start: S, on_change: Callable[[Change[S, E]], None] | None = None
    ) -> None:
        """Enter the first state.

        Args:
            transitions: From state and event to the next state.
            start: The first state.
            on_change: Called with each change of state.
        """
        self._transitions = dict(transitions)
        self._on_change = on_change
        self.state = start
        self.since = 0.0
        self.why = ""

    def knows(self, event: E) -> bool:
        """Return whether there is a transition for an event in the present state."""
        return (self.state, event) in self._transitions

    def happens(self, event: E, now: float, why: str = "") -> S:
        """Change to the next state, and return it; an event that leads to the same state changes nothing.

        Raises:
            LookupError: There is no transition; the state stays.
        """
        if not self.knows(event):
            raise LookupError(f"the state {_word(self.state)!r} has no transition for {_word(event)!r}")
        before, after = self.state, self._transitions[self.state, event]
        if after != before:
            self.state, self.since, self.why = after, now, why
            if self._on_change is not None:
                self._on_change(Change(before, event, after, now, why))
        return after


def from_each(states: Iterable[S], event: E, after: S) -> dict[tuple[S, E], S]:
    """Return rows of a table: the event leads from each of these states to the same one."""
    return {(state, event): after for state in states}


def _word(name: str) -> str:
    return name.value if isinstance(name, StrEnum) else name
