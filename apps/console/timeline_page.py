"""The page Timeline: what has happened in the team, with filters."""

import time

from nicegui import ui
from nicegui.events import ValueChangeEventArguments

from apps.console.page import panel
from apps.console.program import Console
from apps.console.timeline import KINDS
from apps.console.visits import Visit

_REFRESH = 0.5  # s
_MOST = 200  # events shown


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
            with ui.element("table").classes("c-table"):
                with ui.element("thead"), ui.element("tr"):
                    for title in ("Time", "Kind", "About", "What"):
                        with ui.element("th").props('scope="col"'):
                            ui.label(title)
                self._rows = ui.element("tbody").props('aria-live="polite"')
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
        self._rows.clear()
        with self._rows:
            for event in events:
                with ui.element("tr"):
                    clock = time.strftime("%H:%M:%S", time.localtime(event.time))
                    for words, look in (
                        (clock, "c-numbers c-quiet"),
                        (event.kind, f"c-kind c-kind-{event.kind}"),
                        (event.about, "c-strong"),
                        (event.what, ""),
                    ):
                        with ui.element("td"):
                            ui.label(words).classes(look)
            if not events:
                with ui.element("tr"), ui.element("td").props("colspan=4"):
                    ui.label("nothing has happened that these filters show").classes("c-quiet")
