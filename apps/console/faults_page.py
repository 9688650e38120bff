"""The page Faults, of emulated robots: faults, doors, people, time, and robots that are put elsewhere."""

from collections.abc import Mapping
from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments

from apps.console.data_view import DataTable
from apps.console.emulator import EmulatorRefused
from apps.console.map_canvas import MapCanvas
from apps.console.outcomes import OutcomeList
from apps.console.page import disable_if_looking, panel
from apps.console.program import Console
from apps.console.visits import Visit

_REFRESH = 0.7  # s
_SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0)
_STEPS = {1: "1 step (8 ms)", 12: "0.1 s", 120: "1 s"}


def build(console: Console, visit: Visit) -> None:
    """Build the page."""
    if console.emulator is None:
        with panel("Faults"):
            ui.label("No emulator is known to this console; robots that are real have no faults to inject.")
        return
    _FaultsPage(console, visit)


class _FaultsPage:
    def __init__(self, console: Console, visit: Visit) -> None:
        assert console.emulator is not None
        self._console, self._visit, self._emulator = console, visit, console.emulator
        self._known: dict[str, Any] = {}
        self._active: object = None
        self._doors: object = None
        self._people_rows: list[list[str]] = []
        self._fields: dict[str, ui.input] = {}
        with ui.element("div").classes("c-columns") as columns:
            with ui.element("div").classes("c-stack"):
                with panel("Inject a fault"):
                    self._choice = ui.select([], label="Fault", with_input=True, on_change=self._describe)
                    self._meaning = ui.label().classes("c-quiet")
                    self._robot = ui.select([], label="Robot")
                    self._form = ui.element("div").classes("c-form c-wide")
                    self._inject = ui.button("Inject", on_click=self._begin).props("dense no-caps")
                with panel("Faults of this run"):
                    self._list = ui.element("ul").classes("c-plain c-runs")
                    ui.button("Clear all", on_click=lambda: self._ask("clear", "all faults are cleared")).props(
                        "outline dense no-caps"
                    )
            with ui.element("div").classes("c-stack"):
                with panel("Time"):
                    self._time = ui.label().classes("c-numbers").props('role="status"')
                    with ui.row().classes("rv-row"):
                        self._pause = ui.button("Pause", on_click=self._toggle).props("outline dense no-caps")
                        for steps, words in _STEPS.items():
                            ui.button(words, on_click=lambda steps=steps: self._ask("step", "stepped", n=steps)).props(
                                "outline dense no-caps"
                            )
                        self._speed = ui.select(
                            {speed: f"{speed:g} times" for speed in _SPEEDS},
                            label="Speed",
                            on_change=self._change_speed,
                        ).classes("rv-name")
                with panel("Doors"):
                    self._door_list = ui.element("ul").classes("c-plain c-runs")
                with panel("People") as self._people_box:
                    self._people = DataTable(("Name", "Place", "Does"), "nobody")
                self._people_box.set_visibility(False)
                with panel("Outcomes"):
                    OutcomeList(visit)
            with panel("Put a robot elsewhere"):
                self._hint = ui.label(
                    "Drag a robot. Or click it, then a place; there, drag to set the heading."
                ).classes("c-quiet")
                self._map = MapCanvas(visit, mode="place")
                self._map.on("choose", self._choose)
                self._map.on("place", self._place)
        self._paused = False
        disable_if_looking(visit, columns)
        ui.timer(0.0, self._refresh, once=True)
        ui.timer(_REFRESH, self._refresh)

    async def _refresh(self) -> None:
        try:
            faults = await self._emulator.ask("faults")
            truth = await self._emulator.ask("truth")
        except EmulatorRefused as err:
            self._time.text = str(err)
            return
        self._show_choices(faults["known"], list(truth["robots"]))
        self._show_faults(faults["faults"])
        self._show_doors(truth["doors"])
        self._show_people(truth["people"])
        self._paused = bool(truth["paused"])
        self._pause.text = "Go on" if self._paused else "Pause"
        self._time.text = f"{truth['time']:.1f} s of emulated time" + (", paused" if self._paused else "")
        if truth["speed"] in _SPEEDS and self._speed.value != truth["speed"]:
            self._speed.value = truth["speed"]

    def _show_choices(self, known: Mapping[str, Any], robots: list[str]) -> None:
        if known == self._known:
            return
        self._known = dict(known)
        self._choice.set_options(sorted(known), value=self._choice.value if self._choice.value in known else None)
        self._robot.set_options(robots, value=self._robot.value if self._robot.value in robots else robots[0])
        self._describe()

    def _describe(self) -> None:
        """Show what the chosen fault does, and what it takes."""
        self._form.clear()
        self._fields = {}
        about = self._known.get(str(self._choice.value))
        self._inject.set_enabled(about is not None and self._visit.may_command)
        self._meaning.text = f"{about['meaning']}; at its end: {about['ending']}" if about else ""
        if not about:
            return
        self._robot.set_options(
            about["robots"], value=self._robot.value if self._robot.value in about["robots"] else None
        )
        with self._form:
            for name, meaning in about["parameters"].items():
                field = self._fields[name] = ui.input(name).props("dense stack-label bottom-slots")
                field.props["hint"] = str(meaning)  # below it, where long words are not cut

    async def _begin(self) -> None:
        name, robot = str(self._choice.value), self._robot.value
        values = {key: field.value.strip() for key, field in self._fields.items() if (field.value or "").strip()}
        if robot:
            values = {"robot": str(robot), **values}
        spec = ":".join([name, ",".join(f"{key}={value}" for key, value in values.items())]) if values else name
        if await self._ask("fault", f"{name} is injected", fault=spec):
            self._console.timeline.tell("fault", str(robot or "emulator"), f"{name} was injected by {self._visit.name}")

    def _show_faults(self, faults: list[dict[str, Any]]) -> None:
        if faults == self._active:
            return
        self._active = faults
        self._list.clear()
        with self._list:
            if not faults:
                ui.label("none").classes("c-quiet")
            for fault in faults:
                with ui.element("li").classes("c-run"):
                    ui.label(str(fault["fault"])).classes("c-grow")
                    ui.label("active" if fault["active"] else "over or to come").classes(
                        "c-alarmed" if fault["active"] else "c-quiet"
                    )
                    number = fault["number"]
                    clear = ui.button(
                        "Clear", on_click=lambda number=number: self._ask("clear", "cleared", number=number)
                    )
                    clear.props("outline dense no-caps").set_enabled(self._visit.may_command)

    def _show_doors(self, doors: Mapping[str, Any]) -> None:
        shown = {name: door["opening"] > 0.5 * door["width"] for name, door in doors.items()}
        if shown == self._doors:
            return
        self._doors = shown
        self._door_list.clear()
        with self._door_list:
            if not shown:
                ui.label("This world has no doors that move.").classes("c-quiet")
            for name, is_open in shown.items():
                with ui.element("li").classes("c-run"):
                    ui.label(name).classes("c-grow")
                    ui.label("open" if is_open else "shut").classes("c-quiet")
                    words = "Shut" if is_open else "Open"
                    button = ui.button(words, on_click=lambda name=name, to=not is_open: self._move_door(name, to))
                    button.props("outline dense no-caps").set_enabled(self._visit.may_command)

    def _show_people(self, people: Mapping[str, Any]) -> None:
        self._people_box.set_visibility(bool(people))
        rows = [
            [name, f"x {each['x']:.1f} m, y {each['y']:.1f} m", "walks" if each["walks"] else "stands"]
            for name, each in people.items()
        ]
        if rows != self._people_rows:
            self._people_rows = rows
            self._people.show(rows)

    async def _move_door(self, name: str, to: bool) -> None:
        await self._ask("door", f"{name} {'opens' if to else 'shuts'}", name=name, open=to)

    async def _toggle(self) -> None:
        await self._ask("pause", "time goes on" if self._paused else "time is paused", on=not self._paused)

    async def _change_speed(self) -> None:
        if isinstance(self._speed.value, float):
            await self._ask("speed", "", factor=self._speed.value)

    def _choose(self, event: GenericEventArguments) -> None:
        self._map.chosen = str(event.args.get("robot", ""))

    async def _place(self, event: GenericEventArguments) -> None:
        told = event.args
        robot = str(told.get("robot", ""))
        place = self._console.map.places.of(robot)
        if place is None:
            self._console.say(self._visit, f"{robot} was not moved: its place on the map is not known")
            return
        where = {"x": float(told["x"]), "y": float(told["y"])}
        if told.get("heading") is not None:
            where["heading"] = float(told["heading"])
        await self._ask("pose", f"{robot} is put at x {where['x']:.2f} m, y {where['y']:.2f} m", robot=robot, **where)

    async def _ask(self, do: str, words: str, **arguments: Any) -> bool:
        """Ask the emulator for something, and tell the page what has come of it."""
        if why := self._visit.look_only:
            self._console.say(self._visit, why)
            return False
        try:
            await self._emulator.ask(do, **arguments)
        except EmulatorRefused as err:
            self._console.say(self._visit, str(err))
            return False
        if words:
            self._console.say(self._visit, words)
        await self._refresh()
        return True
