"""The audit of an arbiter: a bounded list of events on leases, and optionally a file."""

import json
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from enum import StrEnum
from pathlib import Path
from typing import Any, TextIO

from agents.platform import AgentError
from bus.bus import Closeable

MEMORY = 1000  # rows
REFUSALS_A_SECOND = 20  # refusals a second that are recorded; the rest is counted


class AuditEvent(StrEnum):
    """The event in a row."""

    GRANTED = "granted"
    REFUSED = "refused"
    RENEWED = "renewed"  # for the first time, or for another while
    WARNED = "warned"  # a holder of higher priority wants it
    PREEMPTED = "preempted"
    EXPIRED = "expired"
    RELEASED = "released"
    DIED = "died"  # the holder has
    LOST = "lost"  # the gateway had lost it
    ADOPTED = "adopted"  # it is from an arbiter that has gone


class Audit(Closeable):
    """Rows of JSON, each with `time` (s since 1970), `event`, `holder`, `element` and `priority`."""

    def __init__(
        self,
        tell: Callable[[Mapping[str, Any]], None],
        clock: Callable[[], float],
        wall_time: Callable[[], float],
        complain: Callable[[OSError], None],
        file: str | None = None,
    ) -> None:
        """Make an empty one.

        Args:
            tell: Called with each row.
            clock: Steady, s.
            wall_time: s since 1970.
            complain: Called when the file cannot be written any more; then no more rows are added to it.
            file: The file to which rows are appended as lines.
        Raises:
            AgentError: The file cannot be written.
        """
        self._tell = tell
        self._clock = clock
        self._wall_time = wall_time
        self._complain = complain
        self._rows: deque[dict[str, Any]] = deque(maxlen=MEMORY)
        self._file: TextIO | None = _open(file) if file else None
        self._second = 0
        self._refusals = 0
        self._left_out = 0

    def note(self, event: AuditEvent, holder: str, element: str, priority: int, **more: Any) -> None:
        """Add a row. Of a flood of refusals some are left out, and the next row has their number."""
        if event is AuditEvent.REFUSED and self._is_flooded():
            self._left_out += 1
            return
        row = {
            "time": self._wall_time(),
            "event": str(event),
            "holder": holder,
            "element": element,
            "priority": priority,
            **more,
        }
        if self._left_out:
            row["left_out"], self._left_out = self._left_out, 0
        self._rows.append(row)
        self._tell(row)
        self._write(row)

    def last(self, rows: int) -> list[dict[str, Any]]:
        """Return the newest rows, the oldest first."""
        return list(self._rows)[-rows:] if rows > 0 else []

    def close(self) -> None:
        """Close the file."""
        file, self._file = self._file, None
        if file is not None:
            with suppress(OSError):  # buffered rows are written once more
                file.close()

    def _write(self, row: Mapping[str, Any]) -> None:
        if self._file is None:
            return
        try:
            self._file.write(json.dumps(row) + "\n")  # line by line, so that no row is lost when the arbiter is killed
        except OSError as err:
            self.close()
            self._complain(err)

    def _is_flooded(self) -> bool:
        second = int(self._clock())
        if second != self._second:
            self._second, self._refusals = second, 0
        self._refusals += 1
        return self._refusals > REFUSALS_A_SECOND


def _open(file: str) -> TextIO:
    try:
        return Path(file).open("a", encoding="utf-8", buffering=1)
    except OSError as err:
        raise AgentError(f"the audit cannot be written into {file}: {err.strerror}; give another audit_file") from err
