"""What a page of remote vision shows: the image of a camera, a result beside it, and panels.

The panels are those of the head, the operations and the colours. The page of this application has nothing else; the
console shows it as one of its pages.
"""

import time

from nicegui import ui

from apps.remote_vision.cameras import CAMERA
from apps.remote_vision.colours_panel import ColoursPanel
from apps.remote_vision.head_panel import HeadPanel
from apps.remote_vision.operations_panel import OperationsPanel
from apps.remote_vision.program import RemoteVision
from apps.remote_vision.viewing import COLOURS, MOTION, ORIGINAL, RESULT, Viewing
from apps.web.viewer import ImageViewer

_REFRESH = 0.3  # s between two looks at what has changed
_ASK = 1.0  # s between two looks whether agents are to be asked; asking takes long if one does not answer


class VisionView:
    """One page in a browser."""

    def __init__(
        self, program: RemoteVision, viewing: Viewing, name: str, *, title: str = "", look_only: str = ""
    ) -> None:
        """Build it, in the context of its client.

        Args:
            program: What all pages share.
            viewing: The page.
            name: Of the program that serves it, for people whose browser has lost it.
            title: Above the images; empty for none.
            look_only: Why it can command nothing, in words; empty if it can. Such a page has no panels that command,
                so that nothing that its browser sends is obeyed.
        """
        self._program = program
        self._viewing = viewing
        self._seen = (-1, -1)  # changes of the team, and outcomes, that are shown
        self._asked = -1  # changes of the team, after which the agents were asked
        old = program.settings.images.old_s
        with ui.row().classes("rv-header"):
            if title:
                ui.label(title).classes("rv-title")
            self._camera = ui.select([], label="Camera", on_change=self._choose).classes("rv-select")
            self._state = ui.label().classes("rv-state").props('role="status"')
        with ui.element("main").classes("rv-main"):
            with ui.element("section").classes("rv-column"):
                self._original = ImageViewer(f"/images/{viewing.ticket}/{ORIGINAL}", viewing.robot, old, name, "steer")
                with ui.row().classes("rv-row"):
                    ui.button("Save image", on_click=lambda: self._save(ORIGINAL)).props("outline dense no-caps")
                    self._overlays = {
                        agent: ui.checkbox(words, on_change=self._lay_over)
                        for agent, words in ((COLOURS, "Colour blobs"), (MOTION, "Motion"))
                    }
                self._head = HeadPanel(program, viewing, self._original) if not look_only else None
            with ui.element("section").classes("rv-column"):
                self._result = ImageViewer(f"/images/{viewing.ticket}/{RESULT}", "no operation", old, name)
                with ui.row().classes("rv-row"):
                    ui.button("Save result", on_click=lambda: self._save(RESULT)).props("outline dense no-caps")
                self._operations = OperationsPanel(program, viewing, self._result) if not look_only else None
        with ui.element("div").classes("rv-main"):
            with ui.element("section").classes("rv-column"):
                self._colours = ColoursPanel(program, viewing, self._original) if not look_only else None
                if look_only:
                    ui.label(look_only).classes("rv-hint")
            with ui.element("section").classes("rv-column"), ui.element("div").classes("rv-panel"):
                ui.label("Outcomes").classes("rv-heading")
                self._log = ui.element("ol").classes("rv-log").props('aria-live="polite"')
        ui.timer(_REFRESH, self._refresh)
        ui.timer(_ASK, self._ask_agents)

    async def _ask_agents(self) -> None:
        """Ask the vision agents what they offer, after a change of the team and until they have answered."""
        changes = self._program.team.changes
        if self._operations is None or self._colours is None:
            return
        if changes != self._asked or not self._operations.is_known:
            self._asked = changes
            await self._operations.refresh()
            await self._colours.refresh()

    def _refresh(self) -> None:
        """Show what has changed since the last time."""
        seen = self._program.team.changes, self._viewing.outcome_count
        if seen[0] != self._seen[0]:
            self._show_team()
        if seen[1] != self._seen[1]:
            self._show_outcomes()
        self._seen = seen
        if self._head is not None:
            self._head.refresh()

    def _show_team(self) -> None:
        team, robot = self._program.team, self._viewing.robot
        options = sorted({*team.facts, robot})
        labels = {each: each if team.has(each, CAMERA) else f"{each} (away)" for each in options}
        self._camera.set_options(labels, value=robot)
        self._state.text = "" if team.has(robot, CAMERA) else team.words(robot, 0.0)
        for agent, box in self._overlays.items():
            box.set_enabled(team.has(robot, agent))

    def _show_outcomes(self) -> None:
        self._log.clear()
        with self._log:
            for clock, words in self._viewing.outcomes:
                with ui.element("li"):
                    ui.label(clock).classes("rv-clock")
                    ui.label(words)

    async def _choose(self) -> None:
        robot = self._camera.value
        if not robot or robot == self._viewing.robot:
            return
        if self._head is not None:
            await self._head.leave()
        self._program.choose_camera(self._viewing, robot)
        self._original.rename(robot)
        self._result.rename("no operation")
        self._program.say(self._viewing, f"camera of {robot} chosen")
        self._seen, self._asked = (-1, -1), -1

    def _lay_over(self) -> None:
        self._viewing.overlays = {agent for agent, box in self._overlays.items() if box.value}

    def _save(self, place: str) -> None:
        """Let the browser save the image that it shows, as it came."""
        item = self._viewing.shown.get(place)
        if item is None or not item.image:
            self._program.say(self._viewing, "nothing was saved: there is no image")
            return
        suffix = {"jpeg": "jpg"}.get(item.format, item.format)
        at = time.strftime("%Y%m%d-%H%M%S", time.localtime(item.stamp or time.time()))
        what = self._viewing.choice.name if place == RESULT else "image"
        name = f"{self._viewing.robot}-{what}-{at}.{suffix}"
        ui.download.content(item.image, name)
        self._program.say(self._viewing, f"{name} saved, {len(item.image) / 1000:.0f} kB")
