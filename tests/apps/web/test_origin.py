"""Only the page itself may use the server: pages from elsewhere are refused, programs are not."""

import asyncio
from typing import Any

import pytest

from apps.web.origin import LOOPBACK, SameOrigin, refusal_of, served_names

ELSEWHERE = frozenset((*LOOPBACK, "lab.example"))


@pytest.mark.parametrize(
    ("host", "origin", "names", "is_refused"),
    [
        ("127.0.0.1:8080", None, LOOPBACK, False),
        ("127.0.0.1:8080", "http://127.0.0.1:8080", LOOPBACK, False),
        ("localhost:8080", "http://localhost:8080", LOOPBACK, False),
        ("[::1]:8080", "http://[::1]:8080", LOOPBACK, False),
        ("127.0.0.1:8080", "http://127.0.0.1:9000", LOOPBACK, True),
        ("127.0.0.1:8080", "http://evil.example", LOOPBACK, True),
        ("127.0.0.1:8080", "null", LOOPBACK, True),
        ("evil.example:8080", "http://evil.example:8080", LOOPBACK, True),
        ("192.168.1.5:8080", None, LOOPBACK, True),
        ("", None, LOOPBACK, True),
        ("[broken", None, LOOPBACK, True),
        ("192.168.1.5:8080", "http://192.168.1.5:8080", ELSEWHERE, False),
        ("lab.example:8080", "http://lab.example:8080", ELSEWHERE, False),
        ("evil.example:8080", "http://evil.example:8080", ELSEWHERE, True),
    ],
)
def test_who_is_refused(host: str, origin: str | None, names: frozenset[str], is_refused: bool) -> None:
    assert bool(refusal_of(host, origin, names)) is is_refused


def test_on_loopback_only_names_of_loopback_serve() -> None:
    assert served_names("127.0.0.1") == LOOPBACK
    assert "lab.example" in served_names("lab.example")


@pytest.mark.parametrize(("kind", "answer"), [("websocket", "websocket.close"), ("http", "http.response.start")])
def test_a_refused_request_does_not_reach_the_application(kind: str, answer: str) -> None:
    sent: list[dict[str, Any]] = []

    async def application(*_: Any) -> None:
        raise AssertionError("it was reached")

    async def send(message: Any) -> None:
        sent.append(message)

    async def receive() -> dict[str, Any]:
        return {"type": "http.request"}

    headers = [(b"host", b"127.0.0.1:8080"), (b"origin", b"http://evil.example")]
    scope = {"type": kind, "method": "POST", "path": "/", "headers": headers}
    asyncio.run(SameOrigin(application, LOOPBACK)(scope, receive, send))
    assert sent[0]["type"] == answer
    assert sent[0].get("status", 403) == 403
