"""Reading an IP camera over loopback."""

import socket
import sys
import threading
from collections.abc import Iterator
from ipaddress import ip_address

import pytest

from cameras import source as module
from cameras.errors import CameraLost, CameraNotUsable
from cameras.source import check_source, open_source
from tests.cameras.ip_camera import HEAD, LIMIT, IpCamera, part
from tests.waiting import join, patience


@pytest.fixture
def camera() -> Iterator[IpCamera]:
    camera = IpCamera()
    yield camera
    camera.close()


def test_newest_picture_is_read_and_older_ones_are_passed_over(camera: IpCamera) -> None:
    has_read = threading.Event()

    def serve(connection: socket.socket) -> None:
        connection.sendall(HEAD + part(b"one") + part(b"two") + part(b"three"))
        has_read.wait(patience(LIMIT))
        connection.sendall(part(b"four"))
        has_read.clear()
        has_read.wait(patience(LIMIT))

    camera.serve = serve
    source = open_source(camera.url)
    assert source.read().jpeg in (b"three", b"two", b"one")
    has_read.set()
    while source.read().jpeg != b"four":
        pass
    has_read.set()
    source.close()
    assert camera.requests[0].startswith(b"GET /video HTTP/1.1\r\n")


def test_name_and_password_of_the_url_are_shown_to_the_camera(camera: IpCamera) -> None:
    source = open_source(camera.url.replace("http://", "http://eye:open%20up@"))
    source.close()
    assert b"Authorization: Basic ZXllOm9wZW4gdXA=\r\n" in camera.requests[0]


def test_last_picture_before_the_camera_hangs_up_is_not_lost(camera: IpCamera) -> None:
    camera.serve = lambda connection: connection.sendall(HEAD + part(b"one"))
    source = open_source(camera.url)
    assert source.read().jpeg == b"one"
    with pytest.raises(CameraLost, match="has closed the connection"):
        source.read()
    source.close()


@pytest.mark.parametrize(
    ("address", "taken"), [("127.0.0.1", 1763812800.25), ("::1", 1763812800.25), ("192.0.2.7", None)]
)
def test_the_time_of_a_picture_is_believed_if_it_is_by_the_clock_of_this_computer(
    camera: IpCamera, monkeypatch: pytest.MonkeyPatch, address: str, taken: float | None
) -> None:
    monkeypatch.setattr("cameras.source.ip_address", lambda peer: ip_address(address))
    camera.serve = lambda connection: connection.sendall(HEAD + part(b"one", b"X-Timestamp: 1763812800.25\r\n"))
    source = open_source(camera.url)
    assert source.read() == (b"one", taken)
    source.close()


def test_camera_that_hangs_up_is_lost(camera: IpCamera) -> None:
    source = open_source(camera.url)
    with pytest.raises(CameraLost, match="has closed the connection"):
        source.read()
    source.close()


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (b"HTTP/1.0 404 Not Found\r\nContent-Length: 0\r\n\r\n", "404 Not Found"),
        (b"HTTP/1.0 200 OK\r\nContent-Type: text/html\r\n\r\n<html>", "200 OK, text/html"),
        (b"nonsense\r\n\r\n", "127.0.0.1 answers, but not in HTTP; check the camera's address and port$"),
        (b"\r\n\r\n", "127.0.0.1 answers, but not in HTTP; check the camera's address and port$"),
        (b"", r"127.0.0.1 does not answer: \w"),
    ],
)
def test_what_is_no_stream_of_pictures_is_lost_with_what_was_said(camera: IpCamera, answer: bytes, says: str) -> None:
    camera.serve = lambda connection: connection.sendall(answer)
    with pytest.raises(CameraLost, match=says):
        open_source(camera.url)


def test_a_login_that_fails_is_said_without_name_and_password(camera: IpCamera) -> None:
    camera.serve = lambda connection: connection.sendall(b"HTTP/1.0 401 Unauthorized\r\nContent-Length: 0\r\n\r\n")
    with pytest.raises(CameraLost, match=r"401 Unauthorized.*name or password is wrong") as lost:
        open_source(camera.url.replace("http://", "http://eye:secret@"))
    assert "eye" not in str(lost.value)
    assert "secret" not in str(lost.value)


@pytest.mark.parametrize(
    "where", ["http://eye:secret@cam:port/", "ftp://eye:secret@cam/", "http://eye:secret@/", "http://eye:secret@a..b/"]
)
def test_an_address_that_is_no_cameras_is_refused_without_name_and_password(where: str) -> None:
    with pytest.raises(CameraNotUsable) as refused:
        check_source(where)
    assert "secret" not in str(refused.value)


@pytest.mark.parametrize("where", ["http://192.168.1..5/video", "http://cam/stra\u00dfe", f"http://{'a' * 64}.org/"])
def test_an_address_that_http_cannot_carry_is_refused_at_once(where: str) -> None:
    with pytest.raises(CameraNotUsable, match="is no address"):
        check_source(where)


def test_nobody_there_is_lost() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    with pytest.raises(CameraLost, match="does not answer"):
        open_source(f"http://127.0.0.1:{port}/video")


def test_silence_is_lost(camera: IpCamera, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "PATIENCE", 0.05)
    is_over = threading.Event()

    def serve(connection: socket.socket) -> None:
        connection.sendall(HEAD + part(b"one"))
        is_over.wait(patience(LIMIT))

    camera.serve = serve
    source = open_source(camera.url)
    assert source.read().jpeg == b"one"
    with pytest.raises(CameraLost, match="no picture has come"):
        source.read()
    source.close()
    is_over.set()


def test_read_under_way_can_be_ended_from_elsewhere(camera: IpCamera) -> None:
    is_reading, is_over = threading.Event(), threading.Event()

    def serve(connection: socket.socket) -> None:
        connection.sendall(HEAD)
        is_over.wait(patience(LIMIT))

    camera.serve = serve
    source = open_source(camera.url)
    ends: list[CameraLost] = []

    def read() -> None:
        is_reading.set()
        try:
            source.read()
        except CameraLost as lost:
            ends.append(lost)

    reader = threading.Thread(target=read)
    reader.start()
    is_reading.wait(patience(LIMIT))
    source.interrupt()
    join(reader)
    source.close()
    is_over.set()
    assert len(ends) == 1


@pytest.mark.parametrize(
    ("where", "says"),
    [
        ("rtsp://camera/video", "give a URL that begins with http://"),
        ("http:///video", "names no host"),
        ("http://camera:eighty/video", "is no address: .*; write http://HOST:PORT/PATH"),
        ("http://camera:123456/video", "is no address"),
        ("http://[::1/video", "is no address"),
        ("", "give http://HOST:PORT/PATH, or a device"),
    ],
)
def test_what_is_no_camera_is_refused_with_what_is(where: str, says: str) -> None:
    with pytest.raises(CameraNotUsable, match=says):
        check_source(where)


def test_device_without_opencv_is_refused_with_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    check_source("http://camera/video")
    with pytest.raises(CameraNotUsable, match=r"needs the extra vision, not installed here; install with: "):
        check_source("/dev/video0")


def test_device_that_is_not_there_is_lost() -> None:
    with pytest.raises(CameraLost, match="cannot be opened"):
        open_source("/dev/video-of-nobody")
