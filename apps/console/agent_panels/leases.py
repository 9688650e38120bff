"""The panel of the leases of all robots, and of the arbiter's record."""

import time
from collections.abc import Mapping
from typing import Any

from nicegui import ui

from agents.services.gateway_leases import held_leases
from agents.services.leases import SERVICE
from apps.console.agent_control import why_not_ask
from apps.console.data_view import DataTable
from apps.console.program import Console
from apps.console.visits import Visit
from bus import BusError

_LAST = 30  # rows of the record
_NAMES = ("event", "element", "holder", "priority")


class LeasesPanel:
    """Who holds what, as the gateways of the robots know it."""

    def __init__(self, console: Console, visit: Visit) -> None:
        """Add it to the page."""
        self._console, self._visit = console, visit
        self._table = DataTable(("Element", "Holder", "Priority", "Expires in"), "nobody holds a lease")
        record = ui.button("Record of the arbiter", on_click=self._read_record).props("outline dense no-caps")
        record.set_enabled(visit.may_command)
        self._words = ui.label().classes("c-quiet")
        self._record = DataTable(("Time", "Event", "Element", "Holder", "Priority", "More"), "no event")
        self._record.set_visibility(False)

    async def refresh(self) -> None:
        """Read the leases again."""
        try:
            rows, left_out = await held_leases(self._console.agent.bus)
        except (BusError, TimeoutError):
            return  # the bus is closed; what was shown stays until the page ends
        self._words.text = left_out
        self._table.show(
            [[row["element"], row["holder"], str(row["priority"]), f"{row['expires_in']:.1f} s"] for row in rows]
        )

    async def _read_record(self) -> None:
        arbiters = await self._console.directory.search(SERVICE)
        if not arbiters:
            ui.notify("There is no arbiter; acromovi up starts one with a team.")
            return
        name = arbiters[0].name
        if why_not := why_not_ask(self._console, self._visit, name):
            ui.notify(why_not)
            return
        outcome = await self._console.ask(str(name), "audit", last=_LAST)
        if not outcome.is_done:
            ui.notify(f"{name}: {outcome.why}")
            return
        self._record.set_visibility(True)
        self._record.show(record_rows(outcome.result))


def record_rows(rows: Any) -> list[list[str]]:
    """Return the rows of an arbiter's record as text, the newest first."""
    found = [row for row in rows if isinstance(row, Mapping)] if isinstance(rows, list) else []
    return [_record_row(row) for row in reversed(found)]


def _record_row(row: Mapping[str, Any]) -> list[str]:
    at = row.get("time")
    clock = time.strftime("%H:%M:%S", time.localtime(at)) if isinstance(at, int | float) else "?"
    more = ", ".join(f"{name} {value}" for name, value in row.items() if name not in (*_NAMES, "time"))
    return [clock, *(str(row.get(name, "")) for name in _NAMES), more]
