"""The panel for driving: control by lease, keys, a joystick on the screen, a gamepad."""

import asyncio
from functools import partial

from nicegui import ui
from nicegui.element import Element
from nicegui.events import ValueChangeEventArguments

from apps.console.driving import DriveControl
from apps.console.page import panel
from apps.console.program import Console
from apps.console.robots import WatchedRobot
from apps.console.visits import Visit
from apps.web.viewer import SHARED

_TAKE, _RELEASE = "Take control", "Release control"
_FASTEST, _FASTEST_TURN = 1.5, 2.0  # m/s and rad/s that can be chosen
_SLOWEST = 0.05


class DrivePad(Element, component="../drive_pad.js", esm=SHARED):
    """The joystick; it sends its commands by a websocket of its own (`driving.py`)."""

    def __init__(self, visit: Visit) -> None:
        """Add it to the page."""
        super().__init__()
        self._props["path"] = f"/drive/{visit.ticket}"
        self._props["active"] = False

    def activate(self, on: bool) -> None:
        """Let it send commands, or not."""
        if self._props["active"] != on:
            self._props["active"] = on


class DrivePanel:
    """Drives the robot of a page."""

    def __init__(self, console: Console, visit: Visit) -> None:
        """Build it."""
        self._console, self._visit = console, visit
        drive = console.drive_of(visit.robot) if visit.may_command else None
        limits = console.robots.robots[visit.robot].description.get("limits")
        fastest = limits if isinstance(limits, dict) else {}
        with panel("Drive"):
            with ui.row().classes("rv-row"):
                self._control = ui.button(_TAKE, on_click=self._toggle).props("dense no-caps")
                self._who = ui.label().props('role="status"')
            self._pad = DrivePad(visit)
            speeds = drive.speeds if drive is not None else (0.0, 0.0)
            most = _FASTEST, _FASTEST_TURN
            self._sliders: list[tuple[ui.slider, float]] = []  # each with its greatest value
            for index, (words, unit, key) in enumerate(
                (("Speed ahead", "m/s", "linear"), ("Turning speed", "rad/s", "angular"))
            ):
                limit = fastest.get(key)
                top = min(most[index], float(limit)) if isinstance(limit, int | float) else most[index]
                with ui.row().classes("rv-row c-slider"):
                    ui.label(words)
                    slider = ui.slider(min=_SLOWEST, max=round(top, 2), step=0.05, value=min(speeds[index], top))
                    slider.on_value_change(partial(self._choose, index))
                    slider.set_enabled(visit.may_command)
                    slider.props(f'aria-label="{words}, {unit}"')
                    self._sliders.append((slider, top))
                    ui.label().bind_text_from(slider, "value", partial("{1:.2f} {0}".format, unit))

    def refresh(self) -> None:
        """Show who drives, and how fast: the speeds are those of the robot, whichever page has chosen them."""
        console, robot = self._console, self._console.robots.robots[self._visit.robot]
        if why := self._visit.look_only:
            self._who.text = f"{why[0].upper()}{why[1:]}."
            self._control.set_enabled(False)
            return
        drive = console.drive_of(robot.name)
        mine = drive.holder is self._visit
        self._control.text = _RELEASE if mine else _TAKE
        self._control.set_enabled(robot.is_connected and (mine or drive.holder is None))
        for (slider, top), speed in zip(self._sliders, drive.speeds, strict=True):
            slider.set_enabled(mine or drive.holder is None)
            slider.set_value(min(speed, top))
        self._pad.activate(mine)
        self._who.text = self._words(robot, drive)

    def _words(self, robot: WatchedRobot, drive: DriveControl) -> str:
        """Return who drives, and what prevents it."""
        if not robot.is_connected:
            return "The robot is not connected."
        if robot.is_stopped:
            return "The e-stop holds the robot; release it to drive."
        if robot.state is not None and not robot.state.motors:
            return "The motors are off; switch them on to drive."
        if drive.holder is self._visit:
            return "You drive."
        if drive.holder is not None:
            return f"{drive.holder.name} drives."
        holder = robot.holder()
        return f"{holder} has the lease; control is given when it lets go." if holder else "Nobody drives."

    async def _toggle(self) -> None:
        """Do what the button says: pressed twice, "Take control" does not release what it has just taken."""
        if not self._visit.may_command:
            return
        robot = self._console.robots.robots[self._visit.robot]
        drive = self._console.drive_of(robot.name)
        if self._control.text == _RELEASE:
            if drive.holder is self._visit:
                await drive.release()
        else:
            await drive.take(self._visit, robot.elements, asyncio.get_running_loop().time())
        self.refresh()

    def _choose(self, index: int, event: ValueChangeEventArguments[float]) -> None:
        if not self._visit.may_command:
            return
        drive = self._console.drive_of(self._visit.robot)
        if drive.holder in (None, self._visit):
            linear, angular = drive.speeds
            value = float(event.value)
            drive.speeds = (value, angular) if index == 0 else (linear, value)
