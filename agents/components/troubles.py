"""Possible reasons for a stop of an element: recent faults of its robot, or a change of a lease."""

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

RECENT = 5.0
"""Seconds for which what has happened may explain a motion that did not reach its goal."""
MOST = 8
"""Of what has happened that are kept in mind."""


class Troubles:
    """Collects the reasons for one element; `now` is any steady time, s."""

    def __init__(self, element: str) -> None:
        self._element = element
        self._news: deque[tuple[float, str]] = deque(maxlen=MOST)
        self._faults: Sequence[str] = ()
        self._holders: tuple[str | None, ...] | None = None  # until somebody has said

    def hear_faults(self, faults: Sequence[str], now: float) -> None:
        """Take the faults of the robot, a sentence each."""
        self._news.extend((now, fault) for fault in faults if fault not in self._faults)
        self._faults = tuple(faults)

    def hear_lease(self, lease: Mapping[str, Any], now: float) -> None:
        """Take the holders of the leases on the robot and its elements."""
        elements = lease.get("elements")
        mine = elements.get(self._element) if isinstance(elements, dict) else None
        holders = tuple(_holder(each) for each in (lease, mine))
        if self._holders is not None:
            for before, after in zip(self._holders, holders, strict=True):
                if before != after:
                    self._news.append((now, f"the lease passed to {after}" if after else f"{before}'s lease ended"))
        self._holders = holders

    def reasons(self, now: float) -> str:
        """Return why the element may have stopped; an empty text if nothing is known."""
        recent = [what for at, what in self._news if now - at <= RECENT]
        standing = [fault for fault in self._faults if self._element in fault]
        return "; ".join(dict.fromkeys(recent or standing))


def _holder(lease: object) -> str | None:
    match lease:
        case {"holder": str(holder)}:
            return holder
    return None
