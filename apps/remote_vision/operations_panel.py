"""The panel of operations: fields made from what the vision agent describes, and chains that it has saved."""

from typing import Any

from nicegui import ui
from nicegui.elements.mixins.value_element import ValueElement

from apps.remote_vision.operations import EntryNotValid, chain_of, expected, initial_value
from apps.remote_vision.program import RemoteVision
from apps.remote_vision.viewing import VISION, Viewing
from apps.web.viewer import ImageViewer

_NONE = ""


class OperationsPanel:
    """Chooses the operation whose result a page shows."""

    def __init__(self, program: RemoteVision, viewing: Viewing, image: ImageViewer) -> None:
        """Build the panel.

        Args:
            program: What all pages share.
            viewing: The page.
            image: Shows the result.
        """
        self._program = program
        self._viewing = viewing
        self._image = image
        self._known_of = ""  # the robot whose operations are known
        self._operations: dict[str, dict[str, Any]] = {}
        self._chains: dict[str, Any] = {}
        self._fields: dict[str, ValueElement[Any]] = {}
        self._before: list[dict[str, Any]] = []  # the steps before the chosen operation
        with ui.element("div").classes("rv-panel"):
            ui.label("Operation").classes("rv-heading")
            self._choice = ui.select({_NONE: "none"}, value=_NONE, label="Operation or saved chain")
            self._choice.on_value_change(self._chosen).classes("rv-select")
            self._purpose = ui.label().classes("rv-hint")
            self._form = ui.element("div").classes("rv-form")
            with ui.row().classes("rv-row"):
                self._add = ui.button("Add a step", on_click=self._add_step).props("outline dense no-caps")
                self._anew = ui.button("Remove steps", on_click=self._remove_steps).props("outline dense no-caps")
                self._steps = ui.label().classes("rv-hint")
            with ui.row().classes("rv-row"):
                self._name = ui.input("Save as").props("dense").classes("rv-name")
                self._save = ui.button("Save chain", on_click=self._save_chain).props("outline dense no-caps")

    @property
    def is_known(self) -> bool:
        """Whether the agent has answered since this camera was chosen, or is not there."""
        robot = self._viewing.robot
        return self._known_of == robot or not self._program.team.has(robot, VISION)

    async def refresh(self) -> None:
        """Read the operations and the saved chains of the robot's vision agent."""
        robot = self._viewing.robot
        if not self._program.team.has(robot, VISION):
            self._purpose.text = f"vision@{robot} is not there, so there are no operations"
            return
        operations = await self._program.ask(robot, VISION, "operations")
        chains = await self._program.ask(robot, VISION, "chains")
        if robot != self._viewing.robot:
            return
        if robot != self._known_of:
            self._before = []
        if not operations.is_done:
            self._purpose.text = f"the operations of vision@{robot} are not known: {operations.why}"
            return
        self._known_of = robot
        self._operations = {each["name"]: each for each in operations.result["operations"]}
        self._chains = chains.result["chains"] if chains.is_done else {}
        names = {_NONE: "none", **{name: name for name in self._operations}}
        names |= {name: f"{name} (saved chain)" for name in self._chains}
        self._choice.set_options(
            names, value=self._viewing.choice.name if self._viewing.choice.name in names else _NONE
        )
        if not self._viewing.choice.name:
            self._describe(_NONE)

    async def _chosen(self) -> None:
        name = self._choice.value or _NONE
        if name == self._viewing.choice.name:
            return
        self._describe(name)
        await self._apply()

    def _describe(self, name: str) -> None:
        """Make the fields of an operation."""
        operation = self._operations.get(name)
        self._fields.clear()
        self._form.clear()
        for button in (self._save, self._add):
            button.set_enabled(operation is not None)
        self._anew.set_enabled(bool(self._before))
        self._steps.text = "after " + ", ".join(step["operation"] for step in self._before) if self._before else ""
        self._purpose.text = operation["purpose"] if operation else "" if name in self._chains else "no operation"
        if operation is None:
            return
        with self._form:
            for parameter in operation["parameters"]:
                self._fields[parameter["name"]] = self._field(parameter)

    def _field(self, parameter: dict[str, Any]) -> ValueElement[Any]:
        """Return the field of one parameter."""
        name, value = parameter["name"], initial_value(parameter)
        match parameter["type"]:
            case "flag":
                made: ValueElement[Any] = ui.checkbox(name, value=bool(value))
            case "choice":
                made = ui.select(parameter["choices"], value=value, label=name).classes("rv-field")
            case "matrix":
                made = ui.textarea(name, value=value).props("dense autogrow").classes("rv-matrix")
            case kind:
                step = {"number": None, "odd": 2}.get(kind, 1)
                label = f"{name} ({parameter['unit']})" if parameter["unit"] else name
                made = ui.number(label, value=value, min=parameter["low"], max=parameter["high"], step=step)
                made.props("dense debounce=400").classes("rv-field").tooltip(expected(parameter))
        made.on_value_change(self._apply)
        return made

    async def _apply(self) -> None:
        """Show the result of what is chosen."""
        name = self._choice.value or _NONE
        try:
            chain = self._chain()
        except EntryNotValid as err:
            self._program.say(self._viewing, f"{name}: {err}")
            return
        if chain is None:
            self._program.hide_result(self._viewing)
            self._image.rename("no operation")
            return
        self._image.rename(name)
        await self._program.show_result(self._viewing, name, chain)

    def _chain(self) -> list[dict[str, Any]] | str | None:
        name = self._choice.value or _NONE
        if operation := self._operations.get(name):
            return chain_of(operation, {key: field.value for key, field in self._fields.items()}, self._before)
        return name if name in self._chains else None

    async def _add_step(self) -> None:
        """Take what is chosen as a step, after which the next operation is done; it begins as the same one."""
        try:
            chain = self._chain()
        except EntryNotValid as err:
            self._program.say(self._viewing, f"no step added: {err}")
            return
        if isinstance(chain, list):
            self._before = chain
            self._describe(self._choice.value or _NONE)
            self._program.say(self._viewing, "step added; choose the next operation")

    async def _remove_steps(self) -> None:
        self._before = []
        self._describe(self._choice.value or _NONE)
        await self._apply()

    async def _save_chain(self) -> None:
        name = (self._name.value or "").strip()
        try:
            chain = self._chain()
        except EntryNotValid as err:
            self._program.say(self._viewing, f"not saved: {err}")
            return
        outcome = await self._program.ask(self._viewing.robot, VISION, "save_chain", name=name, chain=chain)
        if outcome.is_done:
            await self.refresh()
        self._program.say(self._viewing, f"chain {name} saved" if outcome.is_done else f"not saved: {outcome.why}")
