"""Access by client certificate: TLS for a page, and what the role in the certificate of a browser permits.

The folder is one that `acromovi keys make` writes: `ca.pem`, `cert.pem` and `key.pem`. Its certificate must permit
incoming connections, as a router's does. Browsers show a certificate of the same authority; its common name is
ROLE.NAME.
"""

import asyncio
import math
import ssl
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Receive, Scope, Send
from uvicorn.protocols.http.h11_impl import H11Protocol

from bus import BusUnavailable
from bus.secure import CA, CERTIFICATE, PRIVATE_KEY, valid_name
from configs.extras import require
from configs.loader import ConfigError

ROLES = {"viewer": False, "operator": True, "admin": True}
"""The roles of people, and whether their owners may command robots and agents."""
_OWNER, _EXPIRES = "certificate_owner", "certificate_expires"  # in the state of a connection
_MAKE = "make one with: acromovi keys make --role router --name NAME --host HOST"


@dataclass(frozen=True, slots=True)
class PageCertificate:
    """The certificate with which a page is served.

    context: accepts browsers with a certificate of its authority, and browsers without one. hosts: names and
    addresses for which it is valid.
    """

    context: ssl.SSLContext
    hosts: frozenset[str]

    @classmethod
    def read(cls, folder: Path) -> Self:
        """Read a folder of keys.

        Raises:
            ConfigError: A file is missing or cannot be read, they do not belong together, the certificate is not valid
                now, or it does not permit incoming connections.
        """
        require("access by certificate", "security")
        from cryptography import x509

        for name in (CA, CERTIFICATE, PRIVATE_KEY):
            _check(folder / name)
        try:
            owner = valid_name(folder / CERTIFICATE)
        except BusUnavailable as err:
            raise ConfigError(str(err)) from err
        found = x509.load_pem_x509_certificate((folder / CERTIFICATE).read_bytes())
        try:
            names = found.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
        except x509.ExtensionNotFound:
            raise ConfigError(f"the certificate of {owner} does not permit to serve a page; {_MAKE}") from None
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        context.num_tickets = 0  # each connection proves anew who is there
        try:
            context.load_cert_chain(folder / CERTIFICATE, folder / PRIVATE_KEY)
            context.load_verify_locations(folder / CA)
        except ssl.SSLError as err:
            raise ConfigError(f"the files in {folder} do not belong together ({err.reason or err}); {_MAKE}") from err
        context.verify_mode = ssl.CERT_OPTIONAL  # whoever has none gets an answer that says so
        hosts = (*names.get_values_for_type(x509.DNSName), *map(str, names.get_values_for_type(x509.IPAddress)))
        return cls(context, frozenset(host.lower() for host in hosts))


class CertifiedConnection(H11Protocol):
    """A connection of uvicorn's that tells the application who the browser is, as its certificate proves."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # typed as in uvicorn
        """Note the owner. The state is the connection's own; that of uvicorn belongs to all of them."""
        super().connection_made(transport)
        connection = transport.get_extra_info("ssl_object")
        told = connection.getpeercert() if connection is not None else None
        known = {_OWNER: _common_name(told), _EXPIRES: ssl.cert_time_to_seconds(told["notAfter"])} if told else {}
        self.app_state = {**self.app_state, **known}


class CertificateGate:
    """ASGI middleware that passes on those with the certificate of a person, and refuses other certificates."""

    def __init__(self, app: ASGIApp, otherwise: ASGIApp | None) -> None:
        """Protect an application.

        Args:
            app: For those with a certificate.
            otherwise: For those without, such as a gate that asks for a password; None to refuse them.
        """
        self._app, self._otherwise = app, otherwise

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        owner = owner_of(scope)
        if owner and time.time() >= expiry_of(scope):  # while its connection was open
            await _refuse(scope, receive, send, why_expired(owner, expiry_of(scope)))
        elif owner.partition(".")[0] in ROLES:
            await self._app(scope, receive, send)
        elif owner:
            why = f"the certificate of {owner} is that of a program; use the one of a viewer, an operator or an admin"
            await _refuse(scope, receive, send, why)
        elif self._otherwise is not None:
            await self._otherwise(scope, receive, send)
        else:
            why = "this page asks for a certificate; import one of its authority into the browser: acromovi keys export"
            await _refuse(scope, receive, send, why)


def owner_of(scope: Mapping[str, Any]) -> str:
    """Return the owner of the certificate of a connection, ROLE.NAME; empty without one."""
    owner = scope.get("state", {}).get(_OWNER, "")
    return owner if isinstance(owner, str) else ""


def expiry_of(scope: Mapping[str, Any]) -> float:
    """Return when the certificate of a connection expires, s since 1970; infinity without one."""
    expires = scope.get("state", {}).get(_EXPIRES, math.inf)
    return float(expires) if isinstance(expires, int | float) else math.inf


def why_expired(owner: str, expired: float) -> str:
    """Return in words that a certificate is not valid any more; expired: s since 1970."""
    at = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(expired))
    return f"the certificate of {owner} has expired on {at}; import a new one"


def why_look_only(scope: Mapping[str, Any]) -> str:
    """Return why the browser of a connection may only look, by its certificate; empty if it may command."""
    owner = owner_of(scope)
    return (
        "" if not owner or ROLES.get(owner.partition(".")[0]) else "the role of your certificate permits looking only"
    )


async def _refuse(scope: Scope, receive: Receive, send: Send, why: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": why[:120]})
    else:
        await PlainTextResponse(why, 403)(scope, receive, send)


def _common_name(certificate: Mapping[str, Any]) -> str:
    """Return the common name in what `ssl` tells of a certificate; empty if it has none or several."""
    parts = [part for row in certificate.get("subject", ()) for part in row]
    names = [value for key, value in parts if key == "commonName"]
    return names[0] if len(names) == 1 else ""


def _check(file: Path) -> None:
    """Raise for a file that cannot be read."""
    try:
        file.open("rb").close()
    except FileNotFoundError:
        raise ConfigError(f"there is no {file.name} in {file.parent}; {_MAKE}") from None
    except OSError as err:
        raise ConfigError(f"{file} cannot be read: {err.strerror}") from err
