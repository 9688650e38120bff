"""The panel of an arm: its joints, home, park, power."""

from collections.abc import Mapping
from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments

from apps.console.page import panel
from apps.console.program import Console
from apps.console.visits import Visit
from bus import keys

_SPEED = 0.4  # rad/s


class ArmPanel:
    """Moves the joints of an arm, for the page that has control."""

    def __init__(self, console: Console, visit: Visit) -> None:
        """Build it."""
        self._console, self._visit = console, visit
        for topic in (keys.ARM, keys.JOINT_STATES):
            console.robots.reading(visit.robot, topic)
        rows = console.robots.robots[visit.robot].elements["arm"].get("joints")
        self._joints = [row for row in rows if _is_joint(row)] if isinstance(rows, list) else []
        self._places: list[ui.label] = []
        self._controls: list[ui.slider | ui.button] = []
        with panel("Arm"):
            self._state = ui.label().props('role="status"')
            with ui.row().classes("rv-row"):
                for name, words, arguments in (
                    ("home", "Home", {}),
                    ("park", "Park", {}),
                    ("power", "Power on", {"on": True}),
                ):
                    self._controls.append(self._button(name, words, arguments))
                halt = ui.button("Halt", on_click=lambda: visit.cancel_motions())
                halt.props("outline dense no-caps color=negative").set_enabled(visit.may_command)
            with ui.element("div").classes("c-joints"):
                for number, row in enumerate(self._joints, 1):
                    ui.label(f"Joint {number}")
                    low, high = row["lower"], row["upper"]
                    slider = ui.slider(min=low, max=high, step=(high - low) / 100.0, value=row["home"])
                    slider.props(f'aria-label="Joint {number}"')
                    slider.on("change", lambda event, number=number: self._move(number, event))
                    self._controls.append(slider)
                    self._places.append(ui.label().classes("c-numbers"))

    def refresh(self) -> None:
        """Show where the joints are."""
        robot = self._console.robots.robots[self._visit.robot]
        for control in self._controls:
            control.set_enabled(self._console.is_driver(self._visit))
        arm, joints = robot.newest(keys.ARM), robot.newest(keys.JOINT_STATES)
        if arm is not None:
            words = ["power on" if arm.powered else "power off", "homed" if arm.homed else "not homed"]
            self._state.text = ", ".join(words + ["moving"] * bool(any(arm.moving)))
        found = dict(zip(joints.name, joints.position, strict=False)) if joints is not None else {}
        for row, place in zip(self._joints, self._places, strict=True):
            value = found.get(row["name"])
            place.text = "-" if value is None else f"{value:+.2f} {row.get('unit', '')}"

    def _button(self, name: str, words: str, arguments: Mapping[str, Any]) -> ui.button:
        def begin() -> None:
            self._console.begin_motion(self._visit, "arm", name, **arguments)

        return ui.button(words, on_click=begin).props("outline dense no-caps")

    def _move(self, number: int, event: GenericEventArguments) -> None:
        value = event.args if isinstance(event.args, int | float) else None
        if value is not None:
            self._console.begin_motion(self._visit, "arm", "move", joints={str(number): float(value)}, speed=_SPEED)


def _is_joint(row: Any) -> bool:
    match row:
        case {"name": str(), "lower": int() | float() as low, "upper": int() | float() as high, "home": home}:
            return isinstance(home, int | float) and bool(low < high)
    return False
