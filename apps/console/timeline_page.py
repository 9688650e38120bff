"""The page Timeline: what has happened in the team, with filters."""

import time

from nicegui import ui
from nicegui.element import Element
from nicegui.events import ValueChangeEventArguments

from apps.console.page import panel
from apps.console.program import Console
from apps.console.timeline import KINDS
from apps.console.visits import Visit

_REFRESH = 0.5  # s
_MOST = 200  # events shown


class _EventTable(Element, component="event_table.js"):
    """A table of events; the browser makes the rows, since hundreds of elements would hold up the console."""

    def show(self, rows: list[list[str]]) -> None:
        """Show rows: time, kind, about, what."""
        self._props["rows"] = rows


def build(console: Console, visit: Visit) -> None:
    """Build the page."""
    _TimelinePage(console)


class _TimelinePage:
    def __init__(self, console: Console) -> None:
        self._console = console
        self._shown: tuple[object, ...] = ()
        self._kinds = set(KINDS)
        with panel("Timeline"):
            with ui.row().classes("rv-row"):
                self._about = ui.input("About", placeholder="robot or agent").props("dense clearable")
                for kind in KINDS:
                    ui.checkbox(
                        kind, value=True, on_change=lambda event, kind=kind: self._switch(kind, event.value)
                    ).props("dense")
            self._table = _EventTable()
        self._refresh()
        ui.timer(_REFRESH, self._refresh)

    def _switch(self, kind: str, event: ValueChangeEventArguments[bool]) -> None:
        (self._kinds.add if event.value else self._kinds.discard)(kind)
        self._refresh()

    def _refresh(self) -> None:
        about, kinds = self._about.value or "", frozenset(self._kinds)
        shown = (self._console.timeline.number, about, kinds)
        if shown == self._shown:
            return
        self._shown = shown
        events = self._console.timeline.newest(_MOST, kinds, about)
        self._table.show([[_clock(event.time), event.kind, event.about, event.what] for event in events])


def _clock(at: float) -> str:
    return time.strftime("%H:%M:%S", time.localtime(at))
