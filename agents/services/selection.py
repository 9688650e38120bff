"""The selection of a subscriber: rate, fields and conditions of the values it gets. No clock.

A field is named by its path: `nearest`, `ranges.0`, `pose.pose.position.x`. What a source does not have is null, and
null is neither below nor above anything.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Self

from bus import Refused

FASTEST = 1000.0  # Hz
ROUNDING = 1e-9  # s; a time to wait, added to a clock, may fall short of the time that was meant
STAMP = "stamp"  # every result of a component carries it, and a part of a result keeps it


@dataclass(frozen=True, slots=True)
class Selection:
    """The selection of a subscriber.

    period: s between two values, at least; 0 for every value.
    fields: paths of the fields; empty for the whole value.
    on_change: tell only when one of these fields has moved by more than so much since it was told last; anything but
        numbers has changed when it is another. Empty tells every value.
    where: tell only while these fields are `below` or `above` a number or `equals` a value.
    """

    period: float = 0.0
    fields: tuple[str, ...] = ()
    on_change: Mapping[str, float] = field(default_factory=dict)
    where: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @classmethod
    def read(cls, rate: Any = None, fields: Any = None, on_change: Any = None, where: Any = None) -> Self:
        """Read the arguments of a request.

        Args:
            rate: Hz, at most.
            fields: A list of paths.
            on_change: Path to tolerance.
            where: Path to `{"below": number, "above": number, "equals": value}`, one or several of them.
        Raises:
            Refused: One of them is not valid.
        """
        return cls(_period(rate), _paths(fields), _tolerances(on_change), _conditions(where))

    @property
    def named(self) -> list[str]:
        """Return all paths in it."""
        return list(dict.fromkeys([*self.fields, *self.on_change, *self.where]))

    def missing(self, value: Mapping[str, Any]) -> list[str]:
        """Return the paths whose first field this value does not have, as after a typing error."""
        return [path for path in self.named if path not in value and path.partition(".")[0] not in value]

    def wants(self, value: Mapping[str, Any]) -> bool:
        """Return whether a value fulfils all conditions."""
        return all(_fulfils(_look_up(value, path), bounds) for path, bounds in self.where.items())

    def differs(self, value: Mapping[str, Any], told: Mapping[str, Any]) -> bool:
        """Return whether a value differs from the one sent before."""
        changes = self.on_change.items()
        return not changes or any(_moved(_look_up(told, path), _look_up(value, path), by) for path, by in changes)

    def part(self, value: Mapping[str, Any]) -> dict[str, Any]:
        """Return the selected part of a value: all, or the fields by their paths, with the stamp if there is one."""
        if not self.fields:
            return dict(value)
        stamp = {STAMP: value[STAMP]} if STAMP in value else {}
        return {path: _look_up(value, path) for path in self.fields} | stamp


class Sieve:
    """Filters values by a selection; a slow subscriber gets the newest one.

    told: number of values taken. skipped: number of selected values replaced by newer ones.
    """

    def __init__(self, selection: Selection) -> None:
        self.selection = selection
        self.told = 0
        self.skipped = 0
        self._last: Mapping[str, Any] | None = None  # told last; None when whatever comes is news
        self._waiting: Mapping[str, Any] | None = None
        self._is_wanted = False  # the newest value fulfils the conditions
        self._free_at = -math.inf

    def offer(self, value: Mapping[str, Any]) -> None:
        """Take a value of the source."""
        self._is_wanted = self.selection.wants(value)
        if not self._is_wanted:
            self._last = None  # coming back is news, though it be the same as before
            return
        is_news = self._last is None or self.selection.differs(value, self._last)
        self.skipped += self._waiting is not None
        self._waiting = value if is_news else None

    def due(self, now: float) -> float | None:
        """Return s until a value may be taken, 0 for now, None if none waits."""
        return None if self._waiting is None else max(self._free_at - ROUNDING - now, 0.0)

    def take(self, now: float) -> dict[str, Any] | None:
        """Return the value that is due, or None."""
        if self._waiting is None or now < self._free_at - ROUNDING:
            return None
        value, self._waiting = self._waiting, None
        self._last = value if self._is_wanted else None
        self._free_at = now + self.selection.period
        self.told += 1
        return self.selection.part(value)


def _look_up(value: Any, path: str) -> Any:
    """Return the field of a value at a path, through objects and lists; None if there is none."""
    if isinstance(value, Mapping) and path in value:
        return value[path]
    for name in path.split("."):
        if isinstance(value, Mapping):
            value = value.get(name)
        elif isinstance(value, list) and name.isdecimal() and int(name) < len(value):
            value = value[int(name)]
        else:
            return None
    return value


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _moved(before: Any, now: Any, by: float) -> bool:
    if _is_number(before) and _is_number(now):
        return bool(abs(now - before) > by)
    return type(before) is not type(now) or bool(before != now)


def _fulfils(value: Any, bounds: Mapping[str, Any]) -> bool:
    return all(_CONDITIONS[name](value, bound) for name, bound in bounds.items())


_CONDITIONS: dict[str, Callable[[Any, Any], bool]] = {
    "below": lambda value, bound: _is_number(value) and value < bound,
    "above": lambda value, bound: _is_number(value) and value > bound,
    "equals": lambda value, bound: not _moved(bound, value, 0.0),
}


def _period(rate: Any) -> float:
    if rate is None:
        return 0.0
    if not _is_number(rate) or not 1 / 86400.0 <= rate <= FASTEST:
        raise Refused(f"a rate is a number of Hz, once a day to {FASTEST:g}, not {_told(rate)}")
    return 1.0 / float(rate)


def _paths(fields: Any) -> tuple[str, ...]:
    if fields is None:
        return ()
    if not isinstance(fields, list) or not fields or not all(isinstance(path, str) and path for path in fields):
        raise Refused(f'fields are a list of names, like ["nearest"], not {_told(fields)}')
    return tuple(fields)


def _tolerances(on_change: Any) -> dict[str, float]:
    if on_change is None:
        return {}
    if not isinstance(on_change, Mapping) or not on_change:
        raise Refused(f'on_change says by how much, like {{"nearest": 0.05}}, not {_told(on_change)}')
    for path, by in on_change.items():
        if not _is_number(by) or by < 0:
            raise Refused(f"on_change takes {path} with a number that is not below 0, not {_told(by)}")
    return {path: float(by) for path, by in on_change.items()}


def _conditions(where: Any) -> dict[str, dict[str, Any]]:
    if where is None:
        return {}
    if not isinstance(where, Mapping) or not where:
        raise Refused(f'where is like {{"nearest": {{"below": 0.5}}}}, not {_told(where)}')
    return {path: _condition(path, bounds) for path, bounds in where.items()}


def _condition(path: str, bounds: Any) -> dict[str, Any]:
    known = ", ".join(_CONDITIONS)
    if not isinstance(bounds, Mapping) or not bounds or not bounds.keys() <= _CONDITIONS.keys():
        raise Refused(f"where compares {path} by one or several of {known}, not by {_told(bounds)}")
    for name, bound in bounds.items():
        if name != "equals" and not _is_number(bound):
            raise Refused(f"where takes {name} with a number, not {_told(bound)}")
    return dict(bounds)


def _told(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
