"""The camera's agent: what it tells of a robot's pictures, and pictures that it takes itself."""

import asyncio
import base64
import socket
import sys
import threading
from collections.abc import Awaitable, Callable, Iterator
from contextlib import suppress

import cv2
import numpy as np
import pytest

from agents.components.camera import ATTENTION, LINGER, MOST, CameraAgent
from agents.platform import Agent, Container, Ending, Report
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, keys, messages
from tests.cameras.ip_camera import HEAD, LIMIT, IpCamera, part
from tests.waiting import patience, wait_until

JPEG = bytes.fromhex("FF D8  FF C0 00 0B 08 00 78 00 A0 01 11 00  FF D9")  # 160 by 120
PERIOD = 0.1  # s
STAMP = 1_700_000_000_250_000_000  # ns


class Desk:
    """An agent `camera@happy`, an application that asks it, and the bus between them.

    reports: what went wrong.
    """

    def __init__(self) -> None:
        self.bus = MemoryBus()
        self.reports: list[Report] = []
        self.container = Container(MemoryBus(self.bus.network), "happy", self.reports.append)
        self.app = Agent("app@team")

    def show(self, jpeg: bytes) -> None:
        """Publish a picture, as a gateway does."""
        head = messages.header(STAMP, "happy/camera")
        data = np.frombuffer(jpeg, np.uint8)
        self.bus.put(keys.CAMERA.key("happy"), messages.CompressedImage(header=head, format="jpeg", data=data))

    async def film(self, count: int) -> None:
        """Publish some, one after the other."""
        for _ in range(count):
            self.show(JPEG)
            await asyncio.sleep(PERIOD)


def play(
    story: Callable[[Desk], Awaitable[None]],
    camera: CameraAgent | None = None,
    loop_factory: Callable[[], asyncio.AbstractEventLoop] | None = VirtualTimeLoop,
) -> None:
    async def run() -> None:
        dispatcher = Desk()
        async with dispatcher.container:
            await dispatcher.container.start(dispatcher.app)
            await dispatcher.container.start(camera or CameraAgent("camera@happy"))
            await story(dispatcher)

    with asyncio.Runner(loop_factory=loop_factory) as runner:
        runner.run(run())


def test_camera_tells_of_its_pictures_and_sends_none_of_them() -> None:
    async def story(dispatcher: Desk) -> None:
        heard: list[dict[str, object]] = []

        async def hear(result: dict[str, object]) -> None:
            heard.append(result)

        dispatcher.app.listen("happy/agents/camera/results", hear, keep=100)
        await asyncio.sleep(2 * ATTENTION)
        await dispatcher.film(30)
        assert heard[-1] == {
            "stamp": pytest.approx(1_700_000_000.25),
            "width": 160,
            "height": 120,
            "format": "jpeg",
            "frames": 30,
            "rate": pytest.approx(10.0),
        }
        assert len(heard) == 30

    play(story)


def test_nobody_hears_the_pictures_while_nobody_wants_to_know_of_them() -> None:
    async def story(dispatcher: Desk) -> None:
        with dispatcher.bus.publisher(keys.CAMERA.key("happy"), keys.CAMERA.type_name) as gateway:

            def is_heard() -> bool:
                return gateway.has_listeners

            await asyncio.sleep(1.0)
            assert not is_heard()
            asking = asyncio.ensure_future(dispatcher.app.request("camera@happy", "read"))
            await asyncio.sleep(0.1)
            assert is_heard(), "it has been asked for a picture"
            dispatcher.show(JPEG)
            assert (await asking).value()["width"] == 160
            await asyncio.sleep(LINGER - 1.0)
            assert is_heard()
            await asyncio.sleep(1.0 + 2 * ATTENTION)
            assert not is_heard()
            with dispatcher.app.bus.subscribe("happy/agents/camera/results", lambda sample: None):
                await asyncio.sleep(LINGER + 1.0)
                assert is_heard()
            await asyncio.sleep(2 * ATTENTION)
            assert not is_heard()

    play(story)


def test_pictures_are_counted_while_they_are_wanted_and_an_old_one_is_never_given() -> None:
    async def story(dispatcher: Desk) -> None:
        asking = asyncio.ensure_future(dispatcher.app.request("camera@happy", "read"))
        await asyncio.sleep(0.1)
        await dispatcher.film(30)
        await asking
        read = (await dispatcher.app.request("camera@happy", "read")).value()
        assert (read["frames"], read["rate"]) == (30, pytest.approx(10.0))
        await asyncio.sleep(2 * LINGER)
        dispatcher.show(JPEG)
        assert (await dispatcher.app.request("camera@happy", "picture")).why == "camera@happy has heard nothing yet"

    play(story)


def test_camera_gives_its_newest_picture() -> None:
    async def story(dispatcher: Desk) -> None:
        asking = asyncio.ensure_future(dispatcher.app.request("camera@happy", "picture"))
        await asyncio.sleep(1.0)
        dispatcher.show(JPEG)
        picture = (await asking).value()
        assert base64.b64decode(picture.pop("data")) == JPEG
        assert picture == {"stamp": pytest.approx(1_700_000_000.25), "format": "jpeg", "width": 160, "height": 120}

    play(story)


def test_camera_from_which_nothing_comes_gives_no_old_picture() -> None:
    async def story(dispatcher: Desk) -> None:
        assert (await dispatcher.app.request("camera@happy", "picture")).why == "camera@happy has heard nothing yet"
        dispatcher.show(JPEG)
        await asyncio.sleep(5.0)
        outcome = await dispatcher.app.request("camera@happy", "picture")
        assert outcome.ending is Ending.FAILED
        assert outcome.why == "camera@happy has heard nothing for 5.0 s"

    play(story)


def test_picture_that_is_no_jpeg_has_no_size() -> None:
    async def story(dispatcher: Desk) -> None:
        asking = asyncio.ensure_future(dispatcher.app.request("camera@happy", "read"))
        await asyncio.sleep(0.1)
        dispatcher.show(b"PNG")
        assert (await asking).value()["width"] is None

    play(story)


def test_picture_that_is_too_large_comes_smaller() -> None:
    noise = np.random.default_rng(1).integers(0, 256, (720, 1280, 3), np.uint8)
    jpeg = bytes(cv2.imencode(".jpg", noise)[1])
    assert len(jpeg) > MOST

    async def story(dispatcher: Desk) -> None:
        asking = asyncio.ensure_future(dispatcher.app.request("camera@happy", "picture"))
        await asyncio.sleep(0.1)
        dispatcher.show(jpeg)
        picture = (await asking).value()
        assert len(base64.b64decode(picture["data"])) <= MOST
        assert 160 < picture["width"] < 1280

    play(story, loop_factory=None)


def test_picture_that_is_too_large_and_cannot_be_made_smaller_says_where_the_stream_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)

    async def story(dispatcher: Desk) -> None:
        asking = asyncio.ensure_future(dispatcher.app.request("camera@happy", "picture"))
        await asyncio.sleep(0.1)
        dispatcher.show(JPEG[:-2] + bytes(MOST) + JPEG[-2:])
        outcome = await asking
        assert outcome.ending is Ending.FAILED
        assert "190 kB does not fit into a message" in outcome.why
        assert "subscribe to happy/camera/image/compressed" in outcome.why
        assert "pip install" in outcome.why

    play(story, loop_factory=None)


@pytest.fixture
def ip_camera(monkeypatch: pytest.MonkeyPatch) -> Iterator[IpCamera]:
    monkeypatch.setattr("cameras.reader.RETRY", 0.02)
    camera = IpCamera()
    yield camera
    camera.close()


def test_camera_that_the_agent_opens_itself_is_on_the_topic_of_any_camera_and_comes_back(ip_camera: IpCamera) -> None:
    pictures, is_enough = threading.Semaphore(0), threading.Semaphore(0)

    def serve(connection: socket.socket) -> None:
        with suppress(OSError):  # the agent closes the connection while it wants no pictures
            connection.sendall(HEAD)
            while not is_enough.acquire(timeout=0.02):  # and then it hangs up
                connection.sendall(part(JPEG))

    ip_camera.serve = serve

    async def story(dispatcher: Desk) -> None:
        dispatcher.bus.subscribe("happy/camera/image/compressed", lambda sample: pictures.release())
        picture = (await dispatcher.app.request("camera@happy", "picture")).value()
        assert base64.b64decode(picture["data"]) == JPEG
        connections = len(ip_camera.requests)
        is_enough.release()
        await asyncio.to_thread(wait_until, lambda: len(ip_camera.requests) > connections, "it asked again")
        while pictures.acquire(blocking=False):
            pass  # those of the connection before
        assert await asyncio.to_thread(pictures.acquire, timeout=patience(LIMIT))
        assert any("the camera has closed the connection" in report.what for report in dispatcher.reports)

    play(story, CameraAgent("camera@happy", {"source": ip_camera.url}), None)


def test_camera_that_is_not_there_says_why() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]

    async def story(dispatcher: Desk) -> None:
        outcome = await dispatcher.app.request("camera@happy", "read")
        assert outcome.ending is Ending.FAILED
        assert "camera@happy has heard nothing yet: 127.0.0.1 does not answer" in outcome.why

    play(story, CameraAgent("camera@happy", {"source": f"http://127.0.0.1:{port}/video"}), None)


def test_source_that_is_no_camera_is_told_at_the_start() -> None:
    async def story(dispatcher: Desk) -> None:
        assert [agent.name.local for agent in dispatcher.container.agents] == ["app"]
        assert "ftp://eye is no camera; give a URL" in str(dispatcher.reports[0].error)

    play(story, CameraAgent("camera@happy", {"source": "ftp://eye"}))
