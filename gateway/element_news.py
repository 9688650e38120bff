"""What a person is told of the elements on cables of their own: found, lost, or not there at all."""

from collections.abc import Iterator, Sequence
from math import inf
from typing import NamedTuple

from gateway.cables.cable import ElementThread

PATIENCE = 10.0
"""Seconds in which an element must have answered for the first time; a laser finds its rate within that."""


class ElementChange(NamedTuple):
    """One change. element: its name. has_been: it answered before. reasons: why it does not answer, a sentence each."""

    element: str
    answers: bool
    has_been: bool
    reasons: Sequence[str]


class ElementNews:
    """Compares what elements do with what was told of them last.

    Args:
        elements: At work.
    """

    def __init__(self, elements: Sequence[ElementThread]) -> None:
        self._elements = elements
        self._told: dict[str, bool] = {}
        self._since = inf

    def since(self, now: float) -> Iterator[ElementChange]:
        """What has changed until now, steady time, s; patience begins with the first call."""
        self._since = min(self._since, now)
        for element in self._elements:
            answers, told = element.driver.is_connected, self._told.get(element.name)
            if answers == told or (told is None and not answers and now - self._since < PATIENCE):
                continue
            self._told[element.name] = answers
            yield ElementChange(element.name, answers, told is not None, () if answers else element.driver.faults())
