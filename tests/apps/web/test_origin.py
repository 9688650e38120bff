"""Only the page itself may use the server: pages from elsewhere are refused, programs are not."""

import asyncio
from typing import Any

import pytest
from httpx import ASGITransport, AsyncClient, Headers
from starlette.responses import PlainTextResponse

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


def headers_of(own: dict[str, str], **asked: str) -> Headers:
    """The headers of the reply to a request with headers, where the application sends its own ones."""

    async def run() -> Headers:
        served = SameOrigin(PlainTextResponse("inside", headers=own), LOOPBACK)
        async with AsyncClient(transport=ASGITransport(served), base_url="http://localhost:8080") as browser:
            return (await browser.get("/", headers=asked)).headers

    return asyncio.run(run())


def test_no_page_is_shown_in_a_frame_of_another_one_and_neither_is_a_refusal() -> None:
    for headers in (headers_of({}), headers_of({}, origin="http://evil.example")):
        assert headers["content-security-policy"] == "frame-ancestors 'none'"
        assert headers["x-frame-options"] == "DENY"


def test_a_policy_that_a_page_has_of_its_own_is_kept() -> None:
    own = {"content-security-policy": "default-src 'self'", "x-frame-options": "SAMEORIGIN"}
    assert headers_of(own).items() >= own.items()
    assert headers_of(own).get_list("content-security-policy") == ["default-src 'self'"]
