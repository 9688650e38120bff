"""Serves an application of FastAPI, with the pages of NiceGUI in it, to browsers that come from nowhere else."""

import asyncio
import socket
from collections.abc import Callable
from typing import Any

import uvicorn
from fastapi import FastAPI
from nicegui import ui
from starlette.types import ASGIApp

from apps.web.certificates import CertifiedConnection, PageCertificate
from apps.web.origin import SameOrigin, served_names
from configs.loader import ConfigError

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
        raise ConfigError(f"the page cannot be served on {host}:{port}: {why}; choose another port or host") from err


def address(listener: socket.socket, host: str, scheme: str = "http") -> str:
    """Return the address of a page for a browser, with the port that the system has chosen."""
    return f"{scheme}://{f'[{host}]' if ':' in host else host}:{listener.getsockname()[1]}/"


def page_server(
    app: FastAPI,
    title: str,
    host: str,
    guard: Callable[[ASGIApp], ASGIApp] = lambda inner: inner,
    certificate: PageCertificate | None = None,
) -> uvicorn.Server:
    """Return a server for an application, with the pages that are registered with NiceGUI.

    Args:
        app: With the websockets of the pages.
        title: Of the pages.
        host: Under which it listens, as given by the user.
        guard: Middleware around the application, behind the check of the origin.
        certificate: With which it is served by TLS; None for a connection that is not encrypted.
    """
    names = served_names(host)
    encrypted: dict[str, Any] = {}
    if certificate is not None:
        names |= certificate.hosts
        context = certificate.context
        encrypted = {"http": CertifiedConnection, "ssl_context_factory": lambda config, default: context}
    ui.run_with(app, title=title, show_welcome_message=False, reconnect_timeout=5.0, tailwind=False)
    config = uvicorn.Config(
        SameOrigin(guard(app), names),
        log_level="error",
        lifespan="on",
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=_GRACE,
        server_header=False,
        **encrypted,
    )
    return uvicorn.Server(config)


async def serve_pages(server: uvicorn.Server, listener: socket.socket, on_ready: Callable[[], None]) -> None:
    """Serve until the program, or the server, is told to end; calls `on_ready` once a page can be opened."""
    announcing = asyncio.ensure_future(_announce(server, on_ready))
    try:
        await server.serve(sockets=[listener])
    finally:
        announcing.cancel()


async def _announce(server: uvicorn.Server, on_ready: Callable[[], None]) -> None:
    while not server.started:
        await asyncio.sleep(0.02)
    on_ready()
