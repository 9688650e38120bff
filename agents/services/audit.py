"""Who was given what, refused what, and how it ended: an arbiter's memory, bounded, and a file for who wants it."""

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
REFUSALS_A_SECOND = 20  # that are written down; the rest of a flood is counted


class AuditEvent(StrEnum):
    """What a row is about."""

    GRANTED = "granted"
    REFUSED = "refused"
    RENEWED = "renewed"  # for the first time, or for another while
    WARNED = "warned"  # somebody of higher priority wants it
    PREEMPTED = "preempted"
    EXPIRED = "expired"
    RELEASED = "released"
    DIED = "died"  # the holder has
    LOST = "lost"  # the gateway knew it no more
    ADOPTED = "adopted"  # it was given by an arbiter that is gone


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
        """Begin an empty one.

        Args:
            tell: Called with each row.
            clock: Steady, s.
            wall_time: s since 1970.
            complain: Told when the file cannot be written any more; then there are no more rows in it.
            file: To which rows are appended as lines.
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
        """Write something down. Of a flood of refusals a part is left out, and the next row says how many."""
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
        """The newest rows, oldest first."""
        return list(self._rows)[-rows:] if rows > 0 else []

    def close(self) -> None:
        """Let go of the file."""
        file, self._file = self._file, None
        if file is not None:
            with suppress(OSError):  # what could not be written is tried once more
                file.close()

    def _write(self, row: Mapping[str, Any]) -> None:
        if self._file is None:
            return
        try:
            self._file.write(json.dumps(row) + "\n")  # line by line, so that whoever kills the arbiter loses no row
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
