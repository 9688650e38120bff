"""A password in front of a page: the file of its hash, the sessions of those who have given it, and the page for it.

The hash is scrypt (RFC 7914) from hashlib, with a salt of its own. The file can be read by its owner only, or it is
refused.
"""

import asyncio
import hashlib
import hmac
import json
import os
import secrets
import stat
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Self
from urllib.parse import parse_qs

from starlette.requests import HTTPConnection, Request
from starlette.responses import HTMLResponse, PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Receive, Scope, Send

from configs.loader import ConfigError

COOKIE = "acromovi-session"
SHORTEST = 8  # characters of a password
_COST = {"n": 1 << 15, "r": 8, "p": 1, "maxmem": 1 << 26}  # 32 MB, about 0.1 s
_LONGEST = 1000  # characters of a password
_MOST_SESSIONS = 1000
_ENDED = "ended"  # query of the page for the password, for somebody whose session is over
_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Log in · Acromovi</title><style>
:root { color-scheme: light dark; font-family: Roboto, system-ui, sans-serif; }
body { margin: 0; min-height: 100vh; display: grid; place-items: center; background: Canvas; color: CanvasText; }
form { width: min(320px, 88vw); display: grid; gap: 12px; padding: 28px; border: 1px solid #8886; border-radius: 10px; }
h1 { margin: 0 0 4px; font-size: 22px; } label { font-size: 14px; }
input, button { font: inherit; padding: 10px 12px; border-radius: 6px; border: 1px solid #8888; }
button { background: #2f6fd0; color: #fff; border: 0; cursor: pointer; } p { margin: 0; color: #d3382c; }
</style></head><body><form method="post" action="/login"><h1>Acromovi</h1>
<label for="password">Password of the console</label>
<input id="password" name="password" type="password" autocomplete="current-password" autofocus required>
<button>Log in</button>WORDS</form></body></html>"""


@dataclass(frozen=True, slots=True)
class PasswordHash:
    """The hash of a password. salt, digest: in hexadecimal digits."""

    salt: str
    digest: str

    @classmethod
    def of(cls, password: str) -> Self:
        """Hash a password, with a new salt.

        Raises:
            ConfigError: It is too short or too long.
        """
        if not SHORTEST <= len(password) <= _LONGEST:
            raise ConfigError(
                f"the password has {len(password)} characters; use at least {SHORTEST} and at most {_LONGEST}"
            )
        salt = secrets.token_bytes(16)
        return cls(salt.hex(), _digest(password, salt).hex())

    @classmethod
    def read(cls, file: Path) -> Self:
        """Read the file of a hash.

        Raises:
            ConfigError: It cannot be read, is not valid, or others may read or write it.
        """
        try:
            with file.open(encoding="utf-8") as stream:
                about = os.fstat(stream.fileno())
                told = json.load(stream)
        except FileNotFoundError:
            raise ConfigError(f"there is no password in {file}; write one with: acromovi console --password") from None
        except (OSError, ValueError) as err:
            raise ConfigError(f"{file} cannot be read: {err}; write it anew with: acromovi console --password") from err
        if about.st_uid != os.getuid() or stat.S_IMODE(about.st_mode) & 0o077:
            raise ConfigError(f"{file} is not private: others may read or change it; correct it with: chmod 600 {file}")
        match told:
            case {"scrypt": {"salt": str(salt), "digest": str(digest)}} if _is_hex(salt) and _is_hex(digest):
                return cls(salt, digest)
        raise ConfigError(f"{file} holds no password; write it anew with: acromovi console --password")

    def write(self, file: Path) -> None:
        """Write it to a file that its owner alone can read, in place of one that is there."""
        file.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        new = file.with_name(f"{file.name}.{secrets.token_hex(4)}")
        descriptor = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "w", encoding="utf-8") as stream:
            json.dump({"scrypt": {"salt": self.salt, "digest": self.digest}}, stream)
            stream.write("\n")
        new.replace(file)

    def fits(self, password: str) -> bool:
        """Return whether a password is the one; takes about 0.1 s."""
        given = _digest(password[:_LONGEST], bytes.fromhex(self.salt))
        return hmac.compare_digest(given, bytes.fromhex(self.digest))


class Sessions:
    """Those who have given the password. on_end: called with a session that ends, and why; empty for a log-out."""

    def __init__(self, password: PasswordHash, lasts: float, pause: float) -> None:
        """Begin without any.

        Args:
            password: The password.
            lasts: s for which a session lasts.
            pause: s after a wrong password, in which no other one is looked at.
        """
        self.on_end: Callable[[str, str], Awaitable[None]] | None = None
        self._password, self._lasts, self._pause = password, lasts, pause
        self._ends: dict[str, float] = {}
        self._looking = asyncio.Lock()

    async def begin(self, password: str) -> str:
        """Return a new session for a password; empty if that is wrong."""
        async with self._looking:  # one at a time: guessing is slow for everybody together
            if not await asyncio.to_thread(self._password.fits, password):
                await asyncio.sleep(self._pause)
                return ""
        session = secrets.token_urlsafe(32)
        while len(self._ends) >= _MOST_SESSIONS:
            await self.end(next(iter(self._ends)), f"more than {_MOST_SESSIONS} people have logged in since you did")
        self._ends[session] = time.monotonic() + self._lasts
        return session

    def is_valid(self, session: str) -> bool:
        """Return whether a session has begun and not ended."""
        return time.monotonic() < self._ends.get(session, 0.0)

    async def end(self, session: str, why: str = "") -> None:
        """End a session; why: in words, empty for somebody who logs out."""
        if self._ends.pop(session, None) is not None and self.on_end is not None:
            await self.on_end(session, why)

    async def end_old(self) -> None:
        """End the sessions whose time is over."""
        old = [session for session in self._ends if not self.is_valid(session)]
        why = f"you logged in {_time_in_words(self._lasts)} ago, and a session lasts no longer"
        # all at once: one whose leases are given back slowly keeps no other from ending
        await asyncio.gather(*(self.end(session, why) for session in old))


class PasswordGate:
    """ASGI middleware that passes on what belongs to a session, and asks everybody else for the password."""

    def __init__(self, app: ASGIApp, sessions: Sessions) -> None:
        """Protect an application."""
        self._app, self._sessions = app, sessions

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, answer it, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        session = HTTPConnection(scope).cookies.get(COOKIE, "")
        if scope["type"] == "http" and scope["path"] in ("/login", "/logout"):
            response = await self._answer(Request(scope, receive), session)
            await response(scope, receive, send)
        elif self._sessions.is_valid(session):
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008, "reason": "log in first"})
        elif scope["method"] == "GET" and "." not in scope["path"]:
            await RedirectResponse(f"/login?{_ENDED}" if session else "/login", 303)(scope, receive, send)
        else:
            await PlainTextResponse("log in first", 401)(scope, receive, send)

    async def _answer(self, request: Request, session: str) -> HTMLResponse | PlainTextResponse | RedirectResponse:
        """Log somebody in or out."""
        if request.url.path == "/logout":
            if request.method != "POST":
                return PlainTextResponse("log out by POST", 405)
            await self._sessions.end(session)
            gone = PlainTextResponse("logged out")
            gone.delete_cookie(COOKIE)
            return gone
        if request.method != "POST":
            words = "<p>The session has ended; log in again.</p>" if request.url.query == _ENDED else ""
            return HTMLResponse(_PAGE.replace("WORDS", words))
        body = await _body_of(request)
        given = parse_qs(body.decode("utf-8", "replace")).get("password", [""])[0]
        if not (begun := await self._sessions.begin(given)):
            words = '<p role="alert">This is not the password.</p>'
            return HTMLResponse(_PAGE.replace("WORDS", words), 403)
        inside = RedirectResponse("/", 303)
        inside.set_cookie(COOKIE, begun, httponly=True, samesite="strict", secure=request.url.scheme == "https")
        return inside


async def _body_of(request: Request) -> bytes:
    """Return the beginning of a request's body: more than a password needs is not kept."""
    body = b""
    async for chunk in request.stream():
        body += chunk
        if len(body) > 8 * _LONGEST:
            break
    return body[: 8 * _LONGEST]


def _time_in_words(seconds: float) -> str:
    return f"{seconds / 3600:g} hours" if seconds >= 3600 else f"{seconds:g} s"


def _digest(password: str, salt: bytes) -> bytes:
    return hashlib.scrypt(password.encode(), salt=salt, **_COST)


def _is_hex(text: str) -> bool:
    try:
        return bool(bytes.fromhex(text))
    except ValueError:  # that is what is asked
        return False
