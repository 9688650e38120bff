"""The IP camera's face, over loopback, with pictures that the test makes."""

import http.client
import socket
import threading
from collections.abc import Callable, Iterator

import pytest

from p2os_emu.camera.feed import Feed
from p2os_emu.camera.server import CameraServer
from tests.waiting import join, patience

LIMIT = 10.0


class Served:
    """A server with its feed."""

    def __init__(self) -> None:
        self.feed = Feed()
        listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = listener.getsockname()[1]
        self.server = CameraServer(listener, self.feed, "The camera of happy")
        self.thread = threading.Thread(target=self.server.serve_forever, kwargs={"poll_interval": 0.01})
        self.thread.start()

    def get(self, path: str) -> http.client.HTTPResponse:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=patience(LIMIT))
        connection.request("GET", path)
        return connection.getresponse()

    def shoot(self, *pictures: bytes) -> threading.Thread:
        """Make pictures as soon as somebody looks."""

        def make() -> None:
            for picture in pictures:
                self.feed.wait_for_viewers()
                self.feed.put(picture, 2.0)

        thread = threading.Thread(target=make)
        thread.start()
        return thread

    def close(self) -> None:
        self.server.shutdown()
        self.server.server_close()
        join(self.thread)


@pytest.fixture
def served() -> Iterator[Served]:
    served = Served()
    yield served
    served.close()


def test_single_picture_is_a_fresh_one(served: Served) -> None:
    served.feed.put(b"old", 1.0)
    maker = served.shoot(b"new")
    with served.get("/image") as answer:
        assert answer.headers["Content-Type"] == "image/jpeg"
        assert answer.read() == b"new"
    join(maker)


def test_video_is_a_part_for_each_picture_with_its_length_and_time(served: Served) -> None:
    with served.get("/video") as answer:
        assert answer.headers["Content-Type"] == "multipart/x-mixed-replace; boundary=picture"
        for picture in (b"first", b"second"):
            served.feed.wait_for_viewers()
            served.feed.put(picture, 1763812800.25)
            head = b"--picture\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n" % len(picture)
            part = head + b"X-Timestamp: 1763812800.250000\r\n\r\n" + picture + b"\r\n"
            assert answer.read(len(part)) == part


def test_page_says_what_it_is_and_other_paths_what_there_is(served: Served) -> None:
    with served.get("/") as answer:
        page = answer.read().decode()
    assert "The camera of happy" in page
    assert 'src="/video"' in page
    with served.get("/elsewhere") as answer:
        assert answer.status == 404
        assert "/image and /video" in answer.reason


def test_nobody_looks_when_the_viewer_has_gone(served: Served, until: Callable[..., None]) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=patience(LIMIT))
    connection.request("GET", "/video")
    with connection.getresponse():
        served.feed.wait_for_viewers()
    connection.close()

    def nobody_looks() -> bool:
        served.feed.put(bytes(1 << 16), 3.0)  # what nobody reads shows that nobody is there
        waiter = threading.Thread(target=served.feed.wait_for_viewers, daemon=True)
        waiter.start()
        waiter.join(0.05)
        return waiter.is_alive()

    until(nobody_looks)
