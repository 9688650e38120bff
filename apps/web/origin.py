"""Refuses requests of pages that come from elsewhere: no other page in the same browser may steer a robot.

A browser sends the origin of a page with each websocket and each POST. The name in `Host` is checked as well, since a
foreign page can have its own name resolved to this computer (DNS rebinding). Browsers show no page in a frame, since a
foreign page could lay something over it and have its buttons pressed (clickjacking).
"""

import ipaddress
import socket
from collections.abc import Iterable
from urllib.parse import urlsplit

from starlette.datastructures import MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

LOOPBACK = frozenset(("localhost", "127.0.0.1", "::1"))
_UNFRAMED = {"Content-Security-Policy": "frame-ancestors 'none'", "X-Frame-Options": "DENY"}


class SameOrigin:
    """ASGI middleware that passes on what comes from the page itself, or from a program that is no browser."""

    def __init__(self, app: ASGIApp, names: Iterable[str]) -> None:
        """Protect an application.

        Args:
            app: The application.
            names: Under which this computer is addressed.
        """
        self._app = app
        self._names = frozenset(names)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""

        async def send_unframed(message: Message) -> None:
            if message["type"] == "http.response.start":
                message.setdefault("headers", [])
                headers = MutableHeaders(scope=message)
                for name, value in _UNFRAMED.items():
                    headers.setdefault(name, value)
            await send(message)

        if scope["type"] in ("http", "websocket"):
            headers = {name.decode("latin-1"): value.decode("latin-1") for name, value in scope["headers"]}
            if refusal := refusal_of(headers.get("host", ""), headers.get("origin"), self._names):
                if scope["type"] == "websocket":
                    await send({"type": "websocket.close", "code": 1008, "reason": refusal})
                else:
                    await PlainTextResponse(refusal, 403)(scope, receive, send_unframed)
                return
        await self._app(scope, receive, send_unframed)


def refusal_of(host: str, origin: str | None, names: frozenset[str]) -> str:
    """Return why a request is refused; empty if it is not.

    Args:
        host: The header `Host`.
        origin: The header `Origin`; None if there is none.
        names: Allowed names of this computer; addresses in numbers are allowed if there is one that is no loopback.
    """
    name = _name(f"//{host}")
    if name not in names and not (names - LOOPBACK and _is_address(name)):
        return (
            f"this page is not served as {name or 'a computer without a name'}; start it with --host {name or 'NAME'}"
        )
    if origin is not None and origin.partition("://")[2] != host:
        return f"a page of {origin[:100]} may not use this one"
    return ""


def served_names(host: str) -> frozenset[str]:
    """Return the names under which a computer is addressed that listens at an address."""
    if host in LOOPBACK:
        return LOOPBACK
    return LOOPBACK | {host, socket.gethostname().lower(), socket.getfqdn().lower()}


def _name(address: str) -> str:
    try:
        return (urlsplit(address).hostname or "").lower()
    except ValueError:  # brackets that do not match, for example
        return ""


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:  # that is what is asked
        return False
    return True
