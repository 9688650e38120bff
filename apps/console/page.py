"""What a page of the console is, and the panels that pages are made of."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from nicegui import ui
from nicegui.elements.mixins.disableable_element import DisableableElement

from apps.console.program import Console
from apps.console.visits import Visit


@dataclass(frozen=True, slots=True)
class ConsolePage:
    """One page.

    path: its address. title: for people. icon: of Material Icons. build: puts its content into the frame; called with
    the program and the page that a browser has opened. is_offered: whether there is anything to show. is_of_robot:
    whether its address may be followed by the name of a robot: `/robot/happy`.
    """

    path: str
    title: str
    icon: str
    build: Callable[[Console, Visit], None]
    is_offered: Callable[[Console], bool] = lambda console: True
    is_of_robot: bool = False


@contextmanager
def panel(title: str, classes: str = "") -> Iterator[ui.element]:
    """A panel with a heading; what is built in the block is in it.

    Args:
        title: The heading, shown as text.
        classes: Of CSS, in addition.
    """
    with ui.element("section").classes(f"rv-panel c-panel {classes}") as box:
        with ui.element("h2").classes("rv-heading"):
            ui.label(title)
        yield box


def disable_if_looking(visit: Visit, box: ui.element) -> None:
    """Disable all controls in a box if a page can command nothing."""
    for each in box.descendants():
        if isinstance(each, DisableableElement) and not visit.may_command:
            each.set_enabled(False)
