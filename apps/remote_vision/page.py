"""The page: the image of a camera, a result beside it, and the panels of head, operations and colours; and serving it.

Bus, agent, image transport and NiceGUI are in one event loop.
"""

import socket
import time
from collections.abc import Callable

from fastapi import FastAPI, WebSocket
from nicegui import ui

from apps.remote_vision.cameras import CAMERA
from apps.remote_vision.colours_panel import ColoursPanel
from apps.remote_vision.head_panel import HeadPanel
from apps.remote_vision.operations_panel import OperationsPanel
from apps.remote_vision.program import RemoteVision
from apps.remote_vision.settings import RemoteVisionSettings
from apps.remote_vision.viewing import COLOURS, MOTION, ORIGINAL, RESULT, Viewing
from apps.web.agent import page_agent
from apps.web.server import page_server, serve_pages
from apps.web.viewer import STYLE, ImageViewer
from bus import Bus

_REFRESH = 0.3  # s between two looks at what has changed
_ASK = 1.0  # s between two looks whether agents are to be asked; asking takes long if one does not answer
_PROGRAM = "acromovi remote-vision"


async def serve(
    bus: Bus,
    robot: str,
    settings: RemoteVisionSettings,
    listener: socket.socket,
    host: str,
    on_ready: Callable[[], None],
) -> None:
    """Serve the page until the program is told to end.

    Args:
        bus: The bus.
        robot: Whose camera is shown first.
        settings: Settings.
        listener: The socket.
        host: As given by the user.
        on_ready: Called once the page can be opened.
    Raises:
        NotThere: There is no robot of this name with a camera.
    """
    async with page_agent(bus, "remote-vision") as (agent, _), RemoteVision(agent, settings) as program:
        await program.team.expect(robot)
        app = FastAPI(openapi_url=None)

        @app.websocket("/images/{ticket}/{place}")
        async def images(websocket: WebSocket, ticket: str, place: str) -> None:
            await program.transport.serve(websocket, ticket, place)

        _build_page(program, robot)
        await serve_pages(page_server(app, "Remote vision", host), listener, on_ready)


def _build_page(program: RemoteVision, robot: str) -> None:
    """Register the page.

    Args:
        program: What all pages share.
        robot: Whose camera is shown first.
    """

    @ui.page("/")
    def page() -> None:
        client = ui.context.client
        viewing = program.begin_viewing(robot, client.ip or "?")
        client.on_delete(lambda: program.end_viewing(viewing))
        ui.add_css(STYLE)
        ui.colors(primary="#1a5fb4")
        _VisionPage(program, viewing)


class _VisionPage:
    """One page in a browser."""

    def __init__(self, program: RemoteVision, viewing: Viewing) -> None:
        """Build it, in the context of its client."""
        self._program = program
        self._viewing = viewing
        self._seen = (-1, -1)  # changes of the team, and outcomes, that are shown
        self._asked = -1  # changes of the team, after which the agents were asked
        old = program.settings.images.old_s
        with ui.row().classes("rv-header"):
            ui.label("Remote vision").classes("rv-title")
            self._camera = ui.select([], label="Camera", on_change=self._choose).classes("rv-select")
            self._state = ui.label().classes("rv-state").props('role="status"')
        with ui.element("main").classes("rv-main"):
            with ui.element("section").classes("rv-column"):
                self._original = ImageViewer(
                    f"/images/{viewing.ticket}/{ORIGINAL}", viewing.robot, old, _PROGRAM, "steer"
                )
                with ui.row().classes("rv-row"):
                    ui.button("Save image", on_click=lambda: self._save(ORIGINAL)).props("outline dense no-caps")
                    self._overlays = {
                        agent: ui.checkbox(words, on_change=self._lay_over)
                        for agent, words in ((COLOURS, "Colour blobs"), (MOTION, "Motion"))
                    }
                self._head = HeadPanel(program, viewing, self._original)
            with ui.element("section").classes("rv-column"):
                self._result = ImageViewer(f"/images/{viewing.ticket}/{RESULT}", "no operation", old, _PROGRAM)
                with ui.row().classes("rv-row"):
                    ui.button("Save result", on_click=lambda: self._save(RESULT)).props("outline dense no-caps")
                self._operations = OperationsPanel(program, viewing, self._result)
        with ui.element("div").classes("rv-main"):
            with ui.element("section").classes("rv-column"):
                self._colours = ColoursPanel(program, viewing, self._original)
            with ui.element("section").classes("rv-column"), ui.element("div").classes("rv-panel"):
                ui.label("Outcomes").classes("rv-heading")
                self._log = ui.element("ol").classes("rv-log").props('aria-live="polite"')
        ui.timer(_REFRESH, self._refresh)
        ui.timer(_ASK, self._ask_agents)

    async def _ask_agents(self) -> None:
        """Ask the vision agents what they offer, after a change of the team and until they have answered."""
        changes = self._program.team.changes
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
