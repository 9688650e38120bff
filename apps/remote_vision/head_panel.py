"""The panel of the camera head: control, buttons, and what pointer and keys do on the image."""

from typing import TYPE_CHECKING, Any

from nicegui import ui
from nicegui.events import GenericEventArguments

from apps.remote_vision.aiming import (
    STEPS,
    HeadPlace,
    centred,
    dragged,
    horizontal_view,
    stepped,
    view_of,
    zoomed,
)
from apps.remote_vision.program import RemoteVision
from apps.remote_vision.viewing import Viewing
from apps.web.viewer import ImageViewer

if TYPE_CHECKING:  # it loads OpenCV
    from vision.camera_model import PinholeModel

_VIEW = 0.8  # rad, for steps of a camera whose field of view is not known
_TAKE, _RELEASE = "Take control", "Release control"
_BUTTONS = (
    ("", "", ""),
    ("ArrowUp", "arrow_upward", "Look up"),
    ("+", "zoom_in", "Zoom in"),
    ("ArrowLeft", "arrow_back", "Look left"),
    ("c", "center_focus_strong", "Look straight ahead"),
    ("ArrowRight", "arrow_forward", "Look right"),
    ("Escape", "stop", "Stop the head"),
    ("ArrowDown", "arrow_downward", "Look down"),
    ("-", "zoom_out", "Zoom out"),
)


class HeadPanel:
    """Turns the head of the robot whose camera a page shows."""

    def __init__(self, program: RemoteVision, viewing: Viewing, image: ImageViewer) -> None:
        """Build the panel.

        Args:
            program: What all pages share.
            viewing: The page.
            image: On which pointer and keys steer.
        """
        self._program = program
        self._viewing = viewing
        self._drag_from: HeadPlace | None = None
        image.on("key", lambda event: self._key(event.args["key"]))
        image.on("point", self._point)
        image.on("drag", self._drag)
        with ui.element("div").classes("rv-panel"):
            with ui.row().classes("rv-row"):
                ui.label("Camera head").classes("rv-heading")
                self._control = ui.button(_TAKE, on_click=self._toggle).props("dense no-caps")
            self._who = ui.label().props('role="status"')
            self._buttons: list[ui.button] = []
            with ui.element("div").classes("rv-head"):
                with ui.element("div").classes("rv-pad"):
                    for key, icon, words in _BUTTONS:
                        self._add_button(key, icon, words)
                with ui.element("div"):
                    self._where = ui.label().classes("rv-where")
                    ui.label(
                        "On the image: click to centre, drag to turn; arrow keys, + and - to step, c for straight "
                        "ahead, space to stop."
                    ).classes("rv-hint")

    def refresh(self) -> None:
        """Show who steers, and where the head looks."""
        robot = self._viewing.robot
        facts = self._program.team.facts.get(robot)
        if facts is None or not facts.has_head:
            is_lost = facts is not None and bool(facts.head)
            self._who.text = f"{robot} has {'lost its' if is_lost else 'no'} camera head"
            self._where.text = ""
            self._enable(False)
            self._control.set_enabled(False)
            return
        holder = self._program.head(robot).holder
        mine = holder is self._viewing
        self._control.set_enabled(holder is None or mine)
        self._control.text = _RELEASE if mine else _TAKE
        self._who.text = "You steer." if mine else f"{holder.name} steers." if holder else "Nobody steers from here."
        place = self._program.known_place(robot)
        self._where.text = str(place) if place else ""
        self._enable(mine)

    async def leave(self) -> None:
        """Release control, since another camera is shown."""
        head = self._program.head(self._viewing.robot)
        if head.holder is self._viewing:
            await head.release()

    def _add_button(self, key: str, icon: str, words: str) -> None:
        if not key:
            ui.element("span")
            return
        button = ui.button(icon=icon, on_click=lambda: self._key(key)).props(f'dense outline aria-label="{words}"')
        button.tooltip(words)
        self._buttons.append(button)

    def _enable(self, on: bool) -> None:
        for button in self._buttons:
            button.set_enabled(on)

    async def _toggle(self) -> None:
        """Do what the button says: pressed twice, "Take control" does not release what it has just taken."""
        head = self._program.head(self._viewing.robot)
        if self._control.text == _RELEASE:
            if head.holder is self._viewing:
                await head.release()
        else:
            await head.take(self._viewing)
            await self._program.head_place(self._viewing.robot)

    async def _key(self, key: str) -> None:
        robot = self._viewing.robot
        if key in ("Escape", " "):
            await self._program.head(robot).stop(self._viewing)
        elif key == "c":
            self._program.head(robot).look(self._viewing, {"pan": 0.0, "tilt": 0.0})
        elif (place := await self._place()) is not None:
            limits = self._program.settings.control
            model = self._model(place, (4, 3))
            view = horizontal_view(model) if model is not None else _VIEW
            self._look(place, stepped(place, key, view, limits.step, limits.zoom_step), is_zoom=bool(STEPS[key][2]))

    async def _point(self, event: GenericEventArguments) -> None:
        place = await self._place()
        if place is not None and (model := self._known_model(place, event.args)) is not None:
            x, y = event.args["at"]
            self._look(place, centred(place, model, (x, y)))

    async def _drag(self, event: GenericEventArguments) -> None:
        if event.args["is_first"] or self._drag_from is None:
            self._drag_from = await self._place()
        if (start := self._drag_from) is not None and (model := self._known_model(start, event.args)) is not None:
            (x, y), (to_x, to_y) = event.args["from"], event.args["to"]
            self._look(start, dragged(start, model, (x, y), (to_x, to_y)))

    def _look(self, place: HeadPlace, aim: HeadPlace, *, is_zoom: bool = False) -> None:
        """Turn the head, within its limits."""
        robot = self._viewing.robot
        facts = self._program.team.facts.get(robot)
        limited = aim.limited(facts.head.get("limits") or {} if facts else {})
        if limited == place:
            self._program.say(self._viewing, f"the head of {robot} is at its limit")
        axes = {"zoom": limited.zoom} if is_zoom else {"pan": limited.pan, "tilt": limited.tilt}
        self._program.head(robot).look(self._viewing, axes)

    async def _place(self) -> HeadPlace | None:
        place = await self._program.head_place(self._viewing.robot)
        if place is None:
            self._program.say(self._viewing, f"the head of {self._viewing.robot} has not reported where it looks")
        return place

    def _known_model(self, place: HeadPlace, given: dict[str, Any]) -> "PinholeModel | None":
        width, height = given["size"]
        model = self._model(place, (int(width), int(height)))
        if model is None:
            words = "its field of view is not known; give camera.field_of_view_rad in the settings of the gateway"
            self._program.say(self._viewing, f"the camera of {self._viewing.robot} cannot be aimed by a point: {words}")
        return model

    def _model(self, place: HeadPlace, size: tuple[int, int]) -> "PinholeModel | None":
        """Return the model of the camera at its present zoom for images of a size, px; None if it is not known."""
        from vision.camera_model import camera_model  # it loads OpenCV

        facts = self._program.team.facts.get(self._viewing.robot)
        model = camera_model(view_of(facts.properties, facts.head), *size) if facts else None
        return None if model is None else zoomed(model, place.zoom)
