"""Serves the console: bus, agent, websockets and pages in one event loop."""

import socket
import time
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from fastapi import FastAPI, Request, WebSocket
from nicegui import ui
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp

from apps.console.agent_panels.conversations import SNIFFER_PATH
from apps.console.pages import PAGES
from apps.console.program import Console, ConsoleInputs
from apps.console.settings import ConsoleSettings
from apps.console.shell import SESSION_PATH, STOP_PATH, begin_page
from apps.web.access import PasswordGate, Sessions
from apps.web.agent import page_agent
from apps.web.certificates import CertificateGate, PageCertificate, why_look_only
from apps.web.server import page_server, serve_pages
from bus import Bus

if TYPE_CHECKING:
    from apps.console.replay import Replay  # of the extra `recorder`


async def serve(
    bus: Bus,
    settings: ConsoleSettings,
    inputs: ConsoleInputs,
    sessions: Sessions | None,
    listener: socket.socket,
    host: str,
    on_ready: Callable[[], None],
    replay: "Replay | None" = None,
    certificate: PageCertificate | None = None,
) -> None:
    """Serve the console until the program is told to end.

    Args:
        bus: The bus.
        settings: Settings.
        inputs: What is known at the start.
        sessions: Who has given the password; None where none is asked for.
        listener: The socket.
        host: As given by the user.
        on_ready: Called once the pages can be opened.
        replay: The recording that is shown, on `bus`; None for a live team.
        certificate: With which it is served, and which tells the browsers that may come in; None for neither.
    """
    async with (
        page_agent(bus, "console", replay.now if replay is not None else time.time, is_hidden=replay is not None) as (
            agent,
            may_command,
        ),
        Console(agent, settings, inputs, _look_only(replay, may_command), replay, sessions) as console,
    ):

        def guard(inner: ASGIApp) -> ASGIApp:
            by_password = PasswordGate(inner, sessions) if sessions is not None else None
            return CertificateGate(inner, by_password) if certificate is not None else by_password or inner

        server = page_server(_application(console), "Acromovi", host, guard, certificate)
        await serve_pages(server, listener, on_ready)


def _look_only(replay: "Replay | None", may_command: bool) -> str:
    """Return why nothing can be commanded; empty if it can."""
    if replay is not None:
        return "this is a recording: its robots and agents cannot be commanded"
    return "" if may_command else "the role of this certificate permits looking only"


def _application(console: Console) -> FastAPI:
    """Return the application with all pages and websockets."""
    app = FastAPI(openapi_url=None)

    @app.post(STOP_PATH)
    async def stop(request: Request) -> dict[str, Any]:
        return {"robots": await console.stop_all(why_look_only(request.scope)), "away": console.away}

    @app.get(SESSION_PATH)
    async def session() -> PlainTextResponse:
        return PlainTextResponse("valid")  # otherwise the gates have answered

    @app.websocket("/drive/{ticket}")
    async def drive(websocket: WebSocket, ticket: str) -> None:
        await console.serve_driver(websocket, ticket)

    @app.websocket("/images/{ticket}/{place}")
    async def images(websocket: WebSocket, ticket: str, place: str) -> None:
        await console.vision.transport.serve(websocket, ticket, place)

    @app.websocket("/map/{ticket}")
    async def map_updates(websocket: WebSocket, ticket: str) -> None:
        await console.map.serve(websocket, lambda: ticket in console.visits)

    @app.websocket(f"{SNIFFER_PATH}/{{ticket}}")
    async def messages(websocket: WebSocket, ticket: str) -> None:
        await console.sniffer.serve(websocket, lambda: ticket in console.visits)

    for page in PAGES:
        ui.page(page.path)(partial(begin_page, console, page, PAGES))
        if page.is_of_robot:
            ui.page(f"{page.path}/{{robot}}")(partial(begin_page, console, page, PAGES))

    return app
