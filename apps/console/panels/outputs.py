"""The panel of digital inputs and outputs, and of what can be switched besides: sonar, power outputs."""

from nicegui import ui

from apps.console.page import disable_if_looking, panel
from apps.console.program import Console
from apps.console.visits import Visit
from bus import keys


class OutputsPanel:
    """Shows the inputs, and switches the outputs."""

    def __init__(self, console: Console, visit: Visit) -> None:
        """Build it."""
        self._console, self._visit = console, visit
        console.robots.reading(visit.robot, keys.IO)
        self._shown = (-1, -1)
        with panel("Inputs and outputs"):
            self._inputs = ui.label().classes("c-numbers")
            self._outputs = ui.row().classes("rv-row")
            self._analog = ui.label().classes("c-quiet c-numbers")

    def refresh(self) -> None:
        """Show the newest state."""
        state = self._console.robots.robots[self._visit.robot].newest(keys.IO)
        if state is None:
            self._inputs.text = "not reported yet"
            return
        self._inputs.text = f"inputs {_bits(state.digital_in)}"
        self._analog.text = ", ".join(f"{value:.2f} V" for value in state.analog_in)
        pins = tuple(bool(pin) for pin in state.digital_out)
        shown = (len(pins), sum(on << number for number, on in enumerate(pins)))
        if shown == self._shown:
            return
        self._shown = shown
        self._outputs.clear()
        with self._outputs:
            ui.label("outputs")
            for number, on in enumerate(pins):
                switch = ui.button(str(number), on_click=lambda number=number, on=on: self._switch(number, not on))
                look = "" if on else "outline"
                switch.props(f'dense no-caps {look} aria-label="Output {number}" aria-pressed={str(on).lower()}')
                switch.set_enabled(self._visit.may_command)

    async def _switch(self, number: int, on: bool) -> None:
        bit = 1 << number
        why = await self._console.command(self._visit.robot, keys.OUTPUT, mask=bit, value=bit if on else 0)
        self._console.say(self._visit, f"output {number}: {why or ('on' if on else 'off')}")


class SonarPanel:
    """Switches the sonar."""

    def __init__(self, console: Console, visit: Visit) -> None:
        """Build it."""
        self._console, self._visit = console, visit
        with panel("Sonar"), ui.row().classes("rv-row"):
            self._switch = ui.button(on_click=self._toggle).props("outline dense no-caps")
            self._nearest = ui.label().classes("c-numbers")
        console.robots.reading(visit.robot, keys.SONAR)

    def refresh(self) -> None:
        """Show whether it fires, and the nearest echo."""
        robot = self._console.robots.robots[self._visit.robot]
        on = robot.state is not None and bool(robot.state.sonar)
        self._switch.text = "Switch it off" if on else "Switch it on"
        self._switch.set_enabled(self._visit.may_command and robot.is_connected)
        message = robot.newest(keys.SONAR)
        ranges = [each.range for each in message.ranges if each.range < each.max_range] if message is not None else []
        self._nearest.text = f"nearest echo {min(ranges):.2f} m" if on and ranges else "no echo" if on else "off"

    async def _toggle(self) -> None:
        robot = self._console.robots.robots[self._visit.robot]
        on = not (robot.state is not None and robot.state.sonar)
        why = await self._console.command(robot.name, keys.SONAR_POWER, on=on)
        self._console.say(self._visit, f"sonar: {why or ('on' if on else 'off')}")


class PowerPanel:
    """Switches power outputs; whether they are on is not reported."""

    def __init__(self, console: Console, visit: Visit) -> None:
        """Build it."""
        self._console, self._visit = console, visit
        rows = console.robots.robots[visit.robot].elements["power"].get("outputs")
        names = [str(row) for row in rows] if isinstance(rows, list) else []
        with panel("Power outputs"), ui.row().classes("rv-row") as row:
            self._output = ui.select(names, label="Output", value=names[0] if names else None).classes("rv-name")
            for words, on in (("On", True), ("Off", False)):
                ui.button(words, on_click=lambda on=on: self._switch(on)).props("outline dense no-caps")
        disable_if_looking(visit, row)

    def refresh(self) -> None:
        """Nothing is reported of them."""

    async def _switch(self, on: bool) -> None:
        why = await self._console.command(self._visit.robot, keys.POWER, output=self._output.value, on=on)
        self._console.say(self._visit, f"power output {self._output.value}: {why or ('on' if on else 'off')}")


def _bits(pins: object) -> str:
    return " ".join("1" if pin else "0" for pin in pins) if hasattr(pins, "__iter__") else "-"
