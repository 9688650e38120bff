"""The list of what the commands of a page have come to."""

from nicegui import ui

from apps.console.visits import Visit

_REFRESH = 0.3  # s


class OutcomeList:
    """A live list in a page, the newest first."""

    def __init__(self, visit: Visit) -> None:
        """Add it to the page."""
        self._visit, self._shown = visit, -1
        self._log = ui.element("ol").classes("rv-log").props('aria-live="polite"')
        self._refresh()
        ui.timer(_REFRESH, self._refresh)

    def _refresh(self) -> None:
        if self._shown == self._visit.outcome_count:
            return
        self._shown = self._visit.outcome_count
        self._log.clear()
        with self._log:
            if not self._visit.outcomes:
                ui.label("nothing has been done from this page yet").classes("c-quiet")
            for clock, words in self._visit.outcomes:
                with ui.element("li"):
                    ui.label(clock).classes("rv-clock")
                    ui.label(words)
