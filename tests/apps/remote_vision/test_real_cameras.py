"""The path of a real camera: a stream over HTTP, and a device that OpenCV opens, for which a file stands in."""

import asyncio
import json
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from agents.components.camera import CameraAgent
from agents.components.vision.vision_agent import VisionAgent
from agents.platform import Agent, Container
from apps.remote_vision.program import RemoteVision
from apps.remote_vision.settings import RemoteVisionSettings
from apps.remote_vision.viewing import ORIGINAL, RESULT, Viewing
from apps.web.viewer import LENGTH
from bus import MemoryBus
from tests.cameras.ip_camera import HEAD, IpCamera, part
from tests.waiting import waiting

PAUSE = 0.03  # s between two images
GREY = [{"operation": "grey"}]


def image(number: int) -> np.ndarray:
    """An image of its own, 64 x 48 px."""
    return np.full((48, 64, 3), 60 + number % 100, np.uint8)


@pytest.fixture
def stream() -> Iterator[str]:
    """The URL of an IP camera."""
    camera, is_over = IpCamera(), threading.Event()

    def serve(connection: socket.socket) -> None:
        connection.sendall(HEAD)
        for number in range(10_000):
            if is_over.wait(PAUSE):
                return
            connection.sendall(part(bytes(cv2.imencode(".jpg", image(number))[1])))

    camera.serve = serve
    yield camera.url
    is_over.set()
    camera.close()


@pytest.fixture
def file(tmp_path: Path) -> str:
    """A file that OpenCV opens as it opens a device."""
    path = tmp_path / "camera.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 15.0, (64, 48))
    for number in range(300):
        writer.write(image(number))
    writer.release()
    return str(path)


def shape(data: bytes) -> tuple[int, ...]:
    """Height and width of a file in px, and 3 for a colour image."""
    decoded = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    assert decoded is not None, "the file is damaged"
    height, width, *colours = decoded.shape
    return height, width, *colours


class BrowserEnd:
    """The websocket of a viewer that requests one image after the other. images: the files that have come."""

    def __init__(self) -> None:
        self.images: list[bytes] = []

    async def accept(self) -> None:
        pass

    async def receive_text(self) -> str:
        return "next"

    async def send_bytes(self, data: bytes) -> None:
        (length,) = LENGTH.unpack_from(data)
        head = json.loads(data[LENGTH.size : LENGTH.size + length])
        if image := data[LENGTH.size + length :]:
            assert head["age"] < 60.0
            self.images.append(image)
        await asyncio.sleep(0)


async def watched(program: RemoteVision, viewing: Viewing, place: str) -> list[bytes]:
    """Three images of a place, as a browser gets them."""
    end: Any = BrowserEnd()
    serving = asyncio.ensure_future(program.transport.serve(end, viewing.ticket, place))
    async with waiting():
        while len(end.images) < 3:
            await asyncio.sleep(0.01)
    serving.cancel()
    return list(end.images)


@pytest.mark.parametrize("source", ["stream", "file"])
def test_a_camera_without_a_gateway_is_shown_with_operations(source: str, request: pytest.FixtureRequest) -> None:
    where = request.getfixturevalue(source)

    async def story() -> None:
        bus = MemoryBus()
        async with Container(bus, "box") as box, Container(MemoryBus(bus.network), "page") as home:
            assert await box.start(CameraAgent("camera@eye", {"source": where}))
            assert await box.start(VisionAgent("vision@eye"))
            agent = Agent("page@apps")
            assert await home.start(agent)
            async with RemoteVision(agent, RemoteVisionSettings.load()) as program:
                await program.team.expect("eye")
                viewing = program.begin_viewing("eye", "here")
                assert not program.team.facts["eye"].has_head
                for data in await watched(program, viewing, ORIGINAL):
                    assert shape(data) == (48, 64, 3)
                await program.show_result(viewing, "grey", GREY)
                for data in await watched(program, viewing, RESULT):
                    assert shape(data) == (48, 64)

    asyncio.run(story())
