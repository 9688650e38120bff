"""The password in front of pages: its file, sessions, and what is refused without one."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from httpx import ASGITransport, AsyncClient
from starlette.responses import PlainTextResponse
from starlette.types import Receive, Scope, Send

from apps.web.access import COOKIE, PasswordGate, PasswordHash, Sessions
from configs.loader import ConfigError

PASSWORD = "correct horse"
HASH = PasswordHash.of(PASSWORD)


def test_a_password_is_found_again_in_its_file_and_not_in_plain(tmp_path: Path) -> None:
    file = tmp_path / "private" / "password"
    HASH.write(file)
    assert PASSWORD not in file.read_text()
    assert file.stat().st_mode & 0o777 == 0o600
    read = PasswordHash.read(file)
    assert read.fits(PASSWORD)
    assert not read.fits(PASSWORD + "s")
    assert PasswordHash.of(PASSWORD).digest != HASH.digest  # each has a salt of its own


@pytest.mark.parametrize("mode", [0o644, 0o640, 0o602])
def test_a_file_that_others_may_read_or_change_is_refused(tmp_path: Path, mode: int) -> None:
    file = tmp_path / "password"
    HASH.write(file)
    file.chmod(mode)
    with pytest.raises(ConfigError, match="chmod 600"):
        PasswordHash.read(file)


@pytest.mark.parametrize("content", ["", "[]", "{", json.dumps({"scrypt": {"salt": "xy", "digest": "00"}})])
def test_a_file_without_a_password_is_refused(tmp_path: Path, content: str) -> None:
    file = tmp_path / "password"
    file.touch(0o600)
    file.write_text(content)
    with pytest.raises(ConfigError, match="acromovi console --password"):
        PasswordHash.read(file)
    with pytest.raises(ConfigError, match="acromovi console --password"):
        PasswordHash.read(tmp_path / "none")


def test_a_short_password_is_refused() -> None:
    with pytest.raises(ConfigError, match="at least 8"):
        PasswordHash.of("short")


async def inside(scope: Scope, receive: Receive, send: Send) -> None:
    """What is protected."""
    if scope["type"] == "websocket":
        await send({"type": "websocket.accept"})
    else:
        await PlainTextResponse("inside")(scope, receive, send)


def visit(*steps: Callable[[AsyncClient, PasswordGate], Awaitable[None]]) -> None:
    """Do steps in one browser."""

    async def run() -> None:
        gate = PasswordGate(inside, Sessions(HASH, lasts=60.0, pause=0.0))
        async with AsyncClient(transport=ASGITransport(gate), base_url="http://console") as browser:
            for step in steps:
                await step(browser, gate)

    asyncio.run(run())


async def socket_reply(gate: PasswordGate, cookie: str) -> str:
    """What a browser with a cookie gets that opens a websocket."""
    sent: list[Any] = []

    async def send(message: Any) -> None:
        sent.append(message)

    async def receive() -> Any:
        raise AssertionError("nothing is asked for")

    await gate({"type": "websocket", "path": "/drive/x", "headers": [(b"cookie", cookie.encode())]}, receive, send)
    return str(sent[0]["type"])


async def is_refused(browser: AsyncClient, gate: PasswordGate) -> None:
    assert (await browser.get("/")).headers["location"] == "/login"
    assert (await browser.post("/stop")).status_code == 401
    assert (await browser.get("/login")).status_code == 200
    assert await socket_reply(gate, f"{COOKIE}=guessed") == "websocket.close"


async def logs_in(browser: AsyncClient, gate: PasswordGate) -> None:
    wrong = await browser.post("/login", data={"password": "wrong horse"})
    assert wrong.status_code == 403
    assert COOKIE not in wrong.cookies
    right = await browser.post("/login", data={"password": PASSWORD})
    assert "HttpOnly" in right.headers["set-cookie"]
    assert "samesite=strict" in right.headers["set-cookie"].lower()
    assert (await browser.get("/")).text == "inside"
    assert await socket_reply(gate, f"other=1; {COOKIE}={browser.cookies[COOKIE]}") == "websocket.accept"


async def logs_out(browser: AsyncClient, gate: PasswordGate) -> None:
    kept = browser.cookies[COOKIE]
    await browser.post("/logout")
    over = await browser.get("/", headers={"cookie": f"{COOKIE}={kept}"})
    assert over.headers["location"] == "/login?ended"
    assert "The session has ended" in (await browser.get("/login?ended")).text
    assert (await browser.get("/session.txt", headers={"cookie": f"{COOKIE}={kept}"})).status_code == 401
    assert await socket_reply(gate, f"{COOKIE}={kept}") == "websocket.close"


def test_everything_is_refused_without_the_password_and_after_logging_out() -> None:
    visit(is_refused, logs_in, logs_out, is_refused)


@pytest.mark.parametrize("cookie", ["", "=", f"{COOKIE}", f"{COOKIE}=", "a=\x00;;=;", "\xff" * 100])
def test_cookies_of_any_form_open_nothing(cookie: str) -> None:
    async def step(browser: AsyncClient, gate: PasswordGate) -> None:
        assert await socket_reply(gate, cookie) == "websocket.close"

    visit(step)


@pytest.mark.parametrize("other", ['settings={"dark":true}', "näme=1", "a b=c", "[x]=1", "=", 'open="'])
def test_a_cookie_of_another_program_on_the_same_computer_keeps_nobody_out(other: str) -> None:
    async def step(browser: AsyncClient, gate: PasswordGate) -> None:
        await browser.post("/login", data={"password": PASSWORD})
        own = f"{COOKIE}={browser.cookies[COOKIE]}"
        for cookie in (f"{other}; {own}", f"{own}; {other}"):
            assert await socket_reply(gate, cookie) == "websocket.accept"

    visit(step)


def test_a_session_ends_by_itself_and_its_end_is_told() -> None:
    ended: list[tuple[str, str]] = []

    async def note(session: str, why: str) -> None:
        ended.append((session, why))

    async def run() -> str:
        sessions = Sessions(HASH, lasts=0.0, pause=0.0)
        sessions.on_end = note
        session = await sessions.begin(PASSWORD)
        assert not sessions.is_valid(session)
        await sessions.end_old()
        return session

    session = asyncio.run(run())
    assert ended == [(session, "you logged in 0 s ago, and a session lasts no longer")]


def test_one_session_whose_end_takes_long_keeps_no_other_from_ending() -> None:
    ended: list[str] = []
    first: list[str] = []

    async def end(session: str, why: str) -> None:
        if session == first[0]:
            await asyncio.Event().wait()
        ended.append(session)

    async def run() -> str:
        sessions = Sessions(HASH, lasts=0.0, pause=0.0)
        sessions.on_end = end
        first.append(await sessions.begin(PASSWORD))
        second = await sessions.begin(PASSWORD)
        ending = asyncio.ensure_future(sessions.end_old())
        while not ended:
            await asyncio.sleep(0.0)
        ending.cancel()
        return second

    second = asyncio.run(run())
    assert ended == [second]
