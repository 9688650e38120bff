"""The page Agents."""

from nicegui import ui

from apps.console.page import panel
from apps.console.program import Console
from apps.console.visits import Visit


def build(console: Console, visit: Visit) -> None:
    """Build the page."""
    with panel("Agents"):
        listed = ui.element("ul").classes("c-plain")

    def refresh() -> None:
        listed.clear()
        with listed:
            for name in console.directory.names:
                with ui.element("li"):
                    ui.label(str(name))

    refresh()
    ui.timer(1.0, refresh)
