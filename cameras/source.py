"""Where pictures come from: a URL or a device. A source gives the newest picture there is, as a JPEG file."""

import base64
import re
import select
import socket
import time
from contextlib import suppress
from http import HTTPStatus
from http.client import HTTPConnection, HTTPException, HTTPSConnection
from ipaddress import ip_address
from typing import Protocol
from urllib.parse import SplitResult, unquote, urlsplit

from cameras.errors import CameraLost, CameraNotUsable
from cameras.multipart import CameraPicture, MultipartDecoder, NoPictures, boundary_of
from configs.extras import missing, needs

PATIENCE = 3.0
"""Seconds without a picture after which a camera has stalled."""
STALLED = f"no picture has come for {PATIENCE:g} s"
CHUNK = 1 << 16
SCHEMES = ("http", "https")
QUALITY = 85
"""Of what a device's pictures are packed with."""


class CameraSource(Protocol):
    """An open camera."""

    def read(self) -> CameraPicture:
        """Wait for a picture; older ones than the newest are passed over.

        It has the time when it was taken only if that is by the clock of this computer.

        Raises:
            CameraLost: None has come in time, or the camera is gone.
        """

    def interrupt(self) -> None:
        """Let a `read` under way in another thread end, where that can be done."""

    def close(self) -> None:
        """Let go of it."""


def check_source(where: str) -> None:
    """See that a camera can be opened in principle.

    Raises:
        CameraNotUsable: It is written wrong, or a part of the installation is missing.
    """
    parts = _split(where)
    if parts.scheme and parts.scheme not in SCHEMES:
        raise CameraNotUsable(
            f"{_shown(where)} is no camera; give a URL that begins with http://, or a device as /dev/video0"
        )
    if parts.scheme and not parts.hostname:
        raise CameraNotUsable(f"{_shown(where)} names no host; write http://HOST:PORT/PATH")
    if not parts.scheme and missing("vision"):
        raise CameraNotUsable(needs(f"the camera {where}", "vision"))


def open_source(where: str) -> CameraSource:
    """Open a camera.

    Args:
        where: A URL of an MJPEG stream; or a device, by its path or its number.
    Raises:
        CameraLost: It is not there, or gives no pictures.
        CameraNotUsable: `where` is not an address.
    """
    parts = _split(where)
    return _UrlSource(parts) if parts.scheme else _DeviceSource(where)


def _split(where: str) -> SplitResult:
    """Parse an address; a device has no scheme."""
    if not isinstance(where, str):
        raise CameraNotUsable(f"the camera is a text, as http://HOST:PORT/PATH or /dev/video0, not {where!r}")
    if not where:
        raise CameraNotUsable("the camera is empty text; give http://HOST:PORT/PATH, or a device as /dev/video0")
    try:
        parts = urlsplit(where)
        int(parts.port or 0)  # it is read here to see that it can be
        if parts.scheme:  # of what HTTP cannot carry
            (parts.hostname or "").encode("idna")
            f"{parts.path}?{parts.query}".encode("ascii")
    except ValueError as error:
        wanted = "write http://HOST:PORT/PATH, and other characters than ASCII as %XX"
        raise CameraNotUsable(f"{_shown(where)} is no address: {error}; {wanted}") from error
    return parts


class _UrlSource:
    """An IP camera; its pictures are passed on as they are."""

    def __init__(self, url: SplitResult) -> None:
        kind = HTTPSConnection if url.scheme == "https" else HTTPConnection
        self._connection = kind(url.hostname or "", url.port, timeout=PATIENCE)
        try:
            self._connection.connect()
            assert self._connection.sock is not None  # connected
            self._socket = self._connection.sock
            # The clock of another computer may be off by more than a picture is late.
            self._is_here = ip_address(self._socket.getpeername()[0]).is_loopback
            self._connection.request("GET", url._replace(scheme="", netloc="").geturl() or "/", headers=_login(url))
            self._answer = self._connection.getresponse()
        except (OSError, HTTPException) as error:
            self._connection.close()
            raise CameraLost(_unanswered(str(url.hostname), error)) from error
        boundary = boundary_of(self._answer.getheader("Content-Type", ""))
        if self._answer.status != HTTPStatus.OK or boundary is None:
            said = f"{self._answer.status} {self._answer.reason}, {self._answer.getheader('Content-Type', 'no type')}"
            self.close()
            if self._answer.status == HTTPStatus.UNAUTHORIZED:
                said += "; name or password is wrong, or the camera wants another login than Basic"
            raise CameraLost(f"{_shown(url.geturl())} is no stream of pictures: {said}")
        self._decoder = MultipartDecoder(boundary)

    def read(self) -> CameraPicture:
        """Wait for a picture."""
        newest: CameraPicture | None = None
        until = time.monotonic() + PATIENCE
        while newest is None or self._has_more():
            try:
                data = self._answer.read1(CHUNK)
                if come := self._decoder.receive(data):
                    newest = come[-1]
            except TimeoutError as error:
                raise CameraLost(STALLED) from error
            except (OSError, NoPictures, HTTPException) as error:
                raise CameraLost(f"the camera is lost: {_in_words(error)}") from error
            if not data and newest is not None:
                break  # the last one; who reads on learns that there are no more
            if not data:
                raise CameraLost("the camera has closed the connection")
            if newest is None and time.monotonic() >= until:
                raise CameraLost(STALLED)
        return newest if self._is_here else CameraPicture(newest.jpeg)

    def interrupt(self) -> None:
        """Hang up, so that nothing more comes."""
        with suppress(OSError):  # the camera has hung up already
            self._socket.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Hang up and forget it."""
        self.interrupt()
        self._answer.close()
        self._connection.close()

    def _has_more(self) -> bool:
        """A newer picture may be on its way already."""
        return self._socket.fileno() >= 0 and bool(select.select([self._socket], (), (), 0.0)[0])


class _DeviceSource:
    """A camera of this computer."""

    def __init__(self, where: str) -> None:
        import cv2  # here and not at the top: it is a large part that only this needs

        self._pack = cv2.imencode
        self._parameters = [cv2.IMWRITE_JPEG_QUALITY, QUALITY]
        self._capture = cv2.VideoCapture(int(where) if where.isdecimal() else where)
        self._capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)  # the newest picture, where the device can
        if not self._capture.isOpened():
            raise CameraLost(f"{where} cannot be opened")

    def read(self) -> CameraPicture:
        """Wait for a picture."""
        has_come, picture = self._capture.read()
        if not has_come:
            raise CameraLost("the camera gives no more pictures")
        is_packed, data = self._pack(".jpg", picture, self._parameters)
        if not is_packed:
            raise CameraLost("the camera's picture cannot be packed")
        return CameraPicture(bytes(data))

    def interrupt(self) -> None:
        """A device gives a picture soon, or hangs; nothing ends that."""

    def close(self) -> None:
        """Let go of the device."""
        self._capture.release()


def _shown(where: str) -> str:
    """Return an address as it may be logged and published: without name and password."""
    return re.sub(r"//[^/]*@", "//", where)


def _login(url: SplitResult) -> dict[str, str]:
    """The header for a name and a password in the URL, where there are any."""
    if url.username is None:
        return {}
    login = f"{unquote(url.username)}:{unquote(url.password or '')}"
    return {"Authorization": "Basic " + base64.b64encode(login.encode()).decode()}


def _unanswered(host: str, error: OSError | HTTPException) -> str:
    """What happened when a camera was asked for its stream."""
    if isinstance(error, HTTPException) and not isinstance(error, OSError):
        return f"{host} answers, but not in HTTP; check the camera's address and port"
    return f"{host} does not answer: {_in_words(error)}"


def _in_words(error: Exception) -> str:
    """The reason that an error gives; its type where it gives none."""
    return getattr(error, "strerror", None) or str(error).strip() or type(error).__name__
