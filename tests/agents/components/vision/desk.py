"""An agent of the camera's images in real time, since it works in a thread; the test plays the camera."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import cv2
import numpy as np

from agents.components.vision.image_agent import ImageAgent
from agents.platform import Agent, Container, Outcome, Report
from bus import MemoryBus, Sample, keys, messages
from tests.waiting import waiting
from vision.image import Pixels

START = 1_700_000_000_000_000_000  # ns, the exposure of the first image
PERIOD = 100_000_000  # ns between two images, by their stamps


def jpeg(pixels: Pixels, quality: int = 90) -> bytes:
    """A JPEG file."""
    return bytes(cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])[1])


class Desk:
    """The agent, and `app@team`, which asks it. reports: what went wrong."""

    def __init__(self, agent: ImageAgent[Any]) -> None:
        self.bus = MemoryBus()
        self.reports: list[Report] = []
        self.agent = agent
        self.container = Container(
            MemoryBus(self.bus.network), "happy", self.reports.append, wall_time=lambda: START / 1e9 + 0.25
        )
        self.app = Agent("app@team")
        self.camera = self.bus.publisher(keys.CAMERA.key("happy"), keys.CAMERA.type_name)
        self.shown = 0

    @property
    def is_watched(self) -> bool:
        """Whether the images of the camera have a subscriber."""
        return self.camera.has_listeners

    def show(self, picture: Pixels | bytes) -> None:
        """Publish an image, a file or pixels."""
        data = picture if isinstance(picture, bytes) else jpeg(picture)
        head = messages.header(START + self.shown * PERIOD, "happy/camera")
        self.camera.put(messages.CompressedImage(header=head, format="jpeg", data=np.frombuffer(data, np.uint8)))
        self.shown += 1

    async def ask(self, name: str, /, **arguments: Any) -> Outcome:
        """Ask the agent for something."""
        return await self.app.request(self.agent.name, name, reply_within=20.0, **arguments)

    async def value(self, name: str, /, **arguments: Any) -> Any:
        """The same; it must be done."""
        return (await self.ask(name, **arguments)).value()

    async def asked_with(self, picture: Pixels | bytes, name: str, /, **arguments: Any) -> Outcome:
        """Ask for something, and show an image as soon as the agent subscribes to the camera."""
        asking = asyncio.ensure_future(self.ask(name, **arguments))
        await self.until(lambda: self.is_watched or asking.done())
        self.show(picture)
        return await asking

    async def until(self, condition: Callable[[], object]) -> None:
        """Wait for a condition."""
        async with waiting():
            while not condition():
                await asyncio.sleep(0.005)

    def hear(self, key: str) -> list[Sample]:
        """The samples on a key from now on, in a list that grows."""
        heard: list[Sample] = []
        self.bus.subscribe(key, heard.append)
        return heard


@asynccontextmanager
async def desk(agent: ImageAgent[Any]) -> AsyncIterator[Desk]:
    """A desk with this agent of the robot happy."""
    made = Desk(agent)
    async with made.container:
        assert await made.container.start(made.app)
        assert await made.container.start(agent)
        yield made
