"""The page of remote vision, and serving it.

Bus, agent, image transport and NiceGUI are in one event loop.
"""

import socket
from collections.abc import Callable

from fastapi import FastAPI, WebSocket
from nicegui import ui

from apps.remote_vision.program import RemoteVision
from apps.remote_vision.settings import RemoteVisionSettings
from apps.remote_vision.view import VisionView
from apps.web.agent import page_agent
from apps.web.server import page_server, serve_pages
from apps.web.viewer import STYLE
from bus import Bus

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
        VisionView(program, viewing, _PROGRAM, title="Remote vision")
