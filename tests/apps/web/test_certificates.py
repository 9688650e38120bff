"""Who comes in by a certificate, and which certificates a page cannot be served with."""

import asyncio
import http.client
import ssl
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from fastapi import FastAPI, Request
from starlette.types import ASGIApp

from acromovi.authority import Authority
from apps.web.access import PasswordGate, PasswordHash, Sessions
from apps.web.certificates import CertificateGate, PageCertificate, owner_of, why_look_only
from apps.web.server import listening, page_server, serve_pages
from bus.secure import CA, CERTIFICATE, PRIVATE_KEY
from configs.loader import ConfigError
from tests.bus.secure_site import YEAR, Site
from tests.waiting import patience, wait_until

BRIEF_S = 3.0
"""For which a certificate is valid that expires during a test."""
OWNERS = ("router.lab", "operator.anna", "viewer.vera", "robot.happy")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    site = Site(tmp_path_factory.mktemp("site"))
    for owner in OWNERS:
        site.make(owner)
    site.make("operator.olga", site.now - 2 * YEAR)
    return site


@contextmanager
def served(site: Site, sessions: Sessions | None = None) -> Iterator[int]:
    """Serve a page that tells who is there; gives its port."""
    app = FastAPI(openapi_url=None)

    @app.get("/who")
    async def who(request: Request) -> list[str]:
        return [owner_of(request.scope), why_look_only(request.scope)]

    def guard(inner: ASGIApp) -> ASGIApp:
        return CertificateGate(inner, PasswordGate(inner, sessions) if sessions is not None else None)

    server = page_server(app, "test", "127.0.0.1", guard, PageCertificate.read(site.folder / "router.lab"))
    is_ready = threading.Event()
    with listening("127.0.0.1", 0) as listener:
        serving = threading.Thread(target=lambda: asyncio.run(serve_pages(server, listener, is_ready.set)))
        serving.start()
        assert is_ready.wait(patience())
        try:
            yield listener.getsockname()[1]
        finally:
            server.should_exit = True
            serving.join(patience())


def ask(site: Site, port: int, keys: Path | None, path: str = "/who") -> tuple[int, str]:
    """Ask for a path with the certificate in a folder; the status and the text of the reply."""
    context = ssl.create_default_context(cafile=site.folder / "router.lab" / CA)
    if keys is not None:
        context.load_cert_chain(keys / CERTIFICATE, keys / PRIVATE_KEY)
    connection = http.client.HTTPSConnection("127.0.0.1", port, context=context, timeout=patience())
    try:
        connection.request("GET", path)
        reply = connection.getresponse()
        return reply.status, reply.read().decode()
    finally:
        connection.close()


def test_the_role_in_a_certificate_decides_and_programs_and_strangers_are_refused(site: Site, tmp_path: Path) -> None:
    other = Site(tmp_path)
    stranger = other.make("operator.eve")
    with served(site) as port:
        assert ask(site, port, site.folder / "operator.anna") == (200, '["operator.anna",""]')
        viewer = '["viewer.vera","the role of your certificate permits looking only"]'
        assert ask(site, port, site.folder / "viewer.vera") == (200, viewer)
        status, words = ask(site, port, site.folder / "robot.happy")
        assert status == 403
        assert "the certificate of robot.happy is that of a program" in words
        status, words = ask(site, port, None)
        assert status == 403
        assert "acromovi keys export" in words
        for refused in (stranger, site.folder / "operator.olga"):
            with pytest.raises((ssl.SSLError, ConnectionError)):
                ask(site, port, refused)
        assert ask(site, port, site.folder / "operator.anna")[0] == 200  # nobody else is affected


def test_a_connection_may_nothing_more_once_its_certificate_has_expired(site: Site) -> None:
    brief = site.make("operator.brief", datetime.now(UTC), timedelta(seconds=BRIEF_S))
    context = ssl.create_default_context(cafile=site.folder / "router.lab" / CA)
    context.load_cert_chain(brief / CERTIFICATE, brief / PRIVATE_KEY)
    with served(site) as port:
        connection = http.client.HTTPSConnection("127.0.0.1", port, context=context, timeout=patience())
        told: list[tuple[int, str]] = []

        def has_expired() -> bool:
            connection.request("GET", "/who")  # by the same connection, as long as the page keeps it open
            reply = connection.getresponse()
            told.append((reply.status, reply.read().decode()))
            return reply.status == 403

        wait_until(has_expired, "the certificate has expired", 2 * BRIEF_S)
        connection.close()
    assert told[0] == (200, '["operator.brief",""]')
    assert "the certificate of operator.brief has expired on" in told[-1][1]


def test_without_a_certificate_the_password_is_asked_for_where_there_is_one(site: Site) -> None:
    sessions = Sessions(PasswordHash.of("correct horse"), 60.0, 0.0)
    with served(site, sessions) as port:
        assert ask(site, port, site.folder / "viewer.vera")[0] == 200
        assert ask(site, port, None) == (303, "")
        status, words = ask(site, port, None, "/login")
        assert status == 200
        assert "Password of the console" in words


def wrong(site: Site, folder: Path, **files: bytes | None) -> Path:
    """Copy the router's key with other contents of some files; None leaves a file out."""
    folder.mkdir()
    for name in (CA, CERTIFICATE, PRIVATE_KEY):
        data = files.get(name.partition(".")[0], (site.folder / "router.lab" / name).read_bytes())
        if data is not None:
            (folder / name).write_bytes(data)
    return folder


def test_a_page_is_not_served_with_a_key_that_browsers_would_not_accept(site: Site, tmp_path: Path) -> None:
    other_key = (site.folder / "operator.anna" / PRIVATE_KEY).read_bytes()
    Authority(site.folder, site.now).make("router", "old", site.now - 3 * YEAR, timedelta(days=1))
    for folder, why in (
        (tmp_path / "none", "there is no ca.pem in"),
        (wrong(site, tmp_path / "half", key=None), "there is no key.pem in"),
        (wrong(site, tmp_path / "mixed", key=other_key), "do not belong together"),
        (wrong(site, tmp_path / "noise", cert=b"noise"), "is no certificate with a name"),
        (wrong(site, tmp_path / "empty", ca=b""), "do not belong together"),
        (site.folder / "operator.anna", "does not permit to serve a page"),
        (site.folder / "router.old", "has expired on"),
    ):
        with pytest.raises(ConfigError, match=why):
            PageCertificate.read(folder)
    folder = wrong(site, tmp_path / "folder", key=None)
    (folder / PRIVATE_KEY).mkdir()
    with pytest.raises(ConfigError, match="cannot be read"):
        PageCertificate.read(folder)
