"""The panel of a gripper."""

from nicegui import ui

from apps.console.page import panel
from apps.console.program import Console
from apps.console.visits import Visit
from bus import keys

_MOTIONS = (
    ("open", "Open"),
    ("close", "Close"),
    ("up", "Raise"),
    ("down", "Lower"),
    ("deploy", "Deploy"),
    ("store", "Store"),
)


class GripperPanel:
    """Opens, closes, raises and lowers a gripper, for the page that has control."""

    def __init__(self, console: Console, visit: Visit) -> None:
        """Build it."""
        self._console, self._visit = console, visit
        console.robots.reading(visit.robot, keys.GRIPPER)
        with panel("Gripper"):
            self._state = ui.label().props('role="status"')
            with ui.row().classes("rv-row"):
                self._buttons = [
                    ui.button(words, on_click=lambda name=name: console.begin_motion(visit, "gripper", name)).props(
                        "outline dense no-caps"
                    )
                    for name, words in _MOTIONS
                ]
                halt = ui.button("Halt", on_click=lambda: visit.cancel_motions())
                halt.props("outline dense no-caps color=negative").set_enabled(visit.may_command)

    def refresh(self) -> None:
        """Show where it is."""
        state = self._console.robots.robots[self._visit.robot].newest(keys.GRIPPER)
        for button in self._buttons:
            button.set_enabled(self._console.is_driver(self._visit))
        if state is None:
            self._state.text = "its state is not known yet"
            return
        paddles = "open" if state.paddles_open else "closed" if state.paddles_closed else "in between"
        lift = "up" if state.lift_up else "down" if state.lift_down else "in between"
        words = [f"paddles {paddles}", f"lift {lift}"]
        words += ["moving"] * bool(state.paddles_moving or state.lift_moving)
        words += ["something between the paddles"] * bool(state.outer_beam or state.inner_beam)
        words += ["contact"] * bool(state.left_contact or state.right_contact)
        self._state.text = ", ".join(words)
