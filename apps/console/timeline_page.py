"""The page Timeline: what has happened in the team, with filters."""

import time

from nicegui import ui
from nicegui.element import Element
from nicegui.events import GenericEventArguments, ValueChangeEventArguments

from apps.console.page import panel
from apps.console.program import Console
from apps.console.timeline import KINDS, TimelineEvent
from apps.console.visits import Visit

_REFRESH = 0.5  # s
_MOST = 200  # events shown
_MOST_RECORDED = 1000  # likewise of a recording
_SAME = 0.01  # s after the position at which an event is not a later one


class _EventTable(Element, component="event_table.js"):
    """A table of events; the browser makes the rows, since hundreds of elements would hold up the console."""

    def __init__(self, seeks: bool) -> None:
        """Add it. seeks: whether it emits `choose` {number} when an event is clicked."""
        super().__init__()
        self._props["seeks"] = seeks

    def show(self, rows: list[list[str | float]]) -> None:
        """Show rows: number, time of the day, kind, about, what, and the time in s since 1970."""
        self._props["rows"] = rows

    def show_now(self, now: float) -> None:
        """Show events after a time, s since 1970, as later ones."""
        if self._props.get("now") != now:
            self._props["now"] = now


def build(console: Console, visit: Visit) -> None:
    """Build the page."""
    _TimelinePage(console)


class _TimelinePage:
    def __init__(self, console: Console) -> None:
        self._console = console
        self._shown: tuple[object, ...] = ()
        self._events: list[TimelineEvent] = []
        self._kinds = set(KINDS)
        with panel("Timeline"):
            with ui.row().classes("rv-row"):
                self._about = ui.input("About", placeholder="robot or agent").props("dense clearable")
                for kind in KINDS:
                    ui.checkbox(
                        kind, value=True, on_change=lambda event, kind=kind: self._switch(kind, event.value)
                    ).props("dense")
            if console.replay is not None:
                ui.label("Click an event to go to its time.").classes("c-quiet")
            self._table = _EventTable(seeks=console.replay is not None)
            self._table.on("choose", self._seek)
        self._refresh()
        ui.timer(_REFRESH, self._refresh)

    def _switch(self, kind: str, event: ValueChangeEventArguments[bool]) -> None:
        (self._kinds.add if event.value else self._kinds.discard)(kind)
        self._refresh()

    def _refresh(self) -> None:
        about, kinds = self._about.value or "", frozenset(self._kinds)
        timeline, replay = self._console.timeline, self._console.replay
        shown = (timeline, timeline.number, about, kinds)
        if shown != self._shown:
            self._shown = shown
            self._events = timeline.newest(_MOST if replay is None else _MOST_RECORDED, kinds, about)
            self._table.show(
                [[each.number, _clock(each.time), each.kind, each.about, each.what, each.time] for each in self._events]
            )
        if replay is not None:  # the newest event that is not later: so nothing is sent until there is another one
            now = replay.now() + _SAME
            self._table.show_now(next((event.time for event in self._events if event.time <= now), 0.0))

    async def _seek(self, event: GenericEventArguments) -> None:
        replay, number = self._console.replay, event.args.get("number")
        chosen = next((each for each in self._events if each.number == number), None)
        if replay is not None and chosen is not None:
            await self._console.seek(replay.position_of(chosen.time))
            self._refresh()


def _clock(at: float) -> str:
    return time.strftime("%H:%M:%S", time.localtime(at))
