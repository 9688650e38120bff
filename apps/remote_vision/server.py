"""Serves the page: bus, agent, image transport and NiceGUI in one event loop."""

import asyncio
import socket
import uuid
from collections.abc import Callable

import uvicorn
from fastapi import FastAPI, WebSocket
from nicegui import ui

from agents.platform import Agent, AgentName, Container
from apps.remote_vision.origin import SameOrigin, served_names
from apps.remote_vision.page import build_page
from apps.remote_vision.program import RemoteVision
from apps.remote_vision.settings import RemoteVisionSettings
from bus import Bus, NotAllowed
from configs.loader import ConfigError

PLATFORM = "apps"
_GRACE = 1  # s for websockets to end when the program does


def listening(host: str, port: int) -> socket.socket:
    """Return a socket that listens; port 0 is any free one.

    Raises:
        ConfigError: The address cannot be used.
    """
    try:
        return socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET)
    except OSError as err:
        why = err.strerror or err
        raise ConfigError(
            f"the page cannot be served on {host}:{port}: {why}; choose another --port or --host"
        ) from err


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
    name = f"remote-vision-{uuid.uuid4().hex[:6]}"
    async with Container(bus, name) as container:
        agent = Agent(AgentName(name, bus.own_name or PLATFORM))
        try:
            await container.start(agent)
        except NotAllowed:  # a certificate for looking only: the page shows images, and cannot move a head
            await agent.look_on(container)
        async with RemoteVision(agent, settings) as program:
            await program.team.expect(robot)
            app = FastAPI(openapi_url=None)

            @app.websocket("/images/{ticket}/{place}")
            async def images(websocket: WebSocket, ticket: str, place: str) -> None:
                await program.transport.serve(websocket, ticket, place)

            build_page(program, robot)
            ui.run_with(app, title="Remote vision", show_welcome_message=False, reconnect_timeout=5.0, tailwind=False)
            protected = SameOrigin(app, served_names(host))
            config = uvicorn.Config(
                protected,
                log_level="error",
                lifespan="on",
                ws_per_message_deflate=False,
                timeout_graceful_shutdown=_GRACE,
                server_header=False,
            )
            server = uvicorn.Server(config)
            announcing = asyncio.ensure_future(_announce(server, on_ready))
            try:
                await server.serve(sockets=[listener])
            finally:
                announcing.cancel()


async def _announce(server: uvicorn.Server, on_ready: Callable[[], None]) -> None:
    while not server.started:
        await asyncio.sleep(0.02)
    on_ready()
