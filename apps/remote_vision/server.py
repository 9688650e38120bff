"""Serves the page: bus, agent, image transport and NiceGUI in one event loop."""

import socket
from collections.abc import Callable

from fastapi import FastAPI, WebSocket

from apps.remote_vision.page import build_page
from apps.remote_vision.program import RemoteVision
from apps.remote_vision.settings import RemoteVisionSettings
from apps.web.agent import page_agent
from apps.web.server import page_server, serve_pages
from bus import Bus


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

        build_page(program, robot)
        await serve_pages(page_server(app, "Remote vision", host), listener, on_ready)
