"""The agent of a camera: it publishes size and rate of the pictures, and returns a picture on request.

The stream of all pictures is `<robot>/camera/image/compressed`. A camera without a gateway is opened by its agent,
which publishes there. A camera makes pictures only while a program subscribes to them, so the agent subscribes only
while a program subscribes to its results, or has just requested a picture.
"""

import asyncio
import base64
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, ClassVar

import numpy as np

from agents.components.component import ElementAgent, failure
from agents.platform import AgentName, request
from bus import BusError, MessageError, Publisher, Refused, Sample, Subscription, keys
from bus.aio import hand_over
from bus.keys import frame
from bus.messages import NS_PER_S, CompressedImage, decode, header, stamp_ns
from cameras import CameraFrame, CameraNotUsable, CameraReader, check_source, picture_size, shrunk

MOST = 190_000
"""Bytes of a picture that a message can carry: 4/3 of it in base64, and what stands around it, are 256 KiB."""
RATE_TIME = 3.0
"""Seconds over which the rate is taken."""
MOST_TIMES = 200
LINGER = 10.0
"""Seconds for which the agent goes on hearing pictures after a request has been answered."""
ATTENTION = 0.1
"""Seconds between two looks whether somebody listens to its results."""


class CameraAgent(ElementAgent):
    """`camera@happy`.

    With the property `source`, a URL or a device, it opens that camera itself; without, its robot's gateway does.
    """

    source = keys.CAMERA
    first_within = 8.0  # it is opened only on request
    results: ClassVar[Mapping[str, str]] = {
        "width, height": "pixels",
        "format": "jpeg or png",
        "frames": "pictures that the agent has received",
        "rate": "Hz, of the last 3 s",
    }

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._hearing: Subscription | None = None
        self._wanted_until = 0.0  # s of the loop's time
        self._newest: Sample | None = None
        self._frames = 0
        self._times: deque[float] = deque(maxlen=MOST_TIMES)  # of the last frames
        self._reader: CameraReader | None = None  # of a camera that is opened here
        self._publisher: Publisher | None = None  # likewise
        self._complaint = ""  # why there are no pictures

    async def setup(self) -> None:
        """Subscribe; open the camera if it has no gateway.

        Raises:
            CameraNotUsable: The source is not valid, or a part of the installation is missing.
        """
        where = self.properties.get("source")
        if where is not None:
            check_source(str(where))
        await super().setup()
        self.every(ATTENTION, self._follow_interest)
        if where is not None:
            publisher = self._publisher = self.bus.publisher(keys.CAMERA.key(self.robot), keys.CAMERA.type_name)
            self._reader = CameraReader(
                str(where), self._publish_picture, self._lose, is_wanted=lambda: publisher.has_listeners
            )
            self._reader.start()

    async def _follow_interest(self) -> None:
        """Subscribe to the pictures while a program needs them."""
        if self.is_heard:
            self._hear_pictures()
        elif self._hearing is not None and asyncio.get_running_loop().time() >= self._wanted_until:
            self._hearing.close()
            self._hearing = None

    async def take_down(self) -> None:
        """Close the camera."""
        if self._hearing is not None:
            self._hearing.close()
        if self._reader is not None:
            await asyncio.to_thread(self._reader.close)
        if self._publisher is not None:
            self._publisher.close()

    def result(self, message: Any) -> Mapping[str, Any]:
        """Return size and rate of the pictures."""
        size = picture_size(message.data.tobytes()) or (None, None)
        return {
            "width": size[0],
            "height": size[1],
            "format": message.format,
            "frames": self._frames,
            "rate": self._rate(),
        }

    @request("read")
    async def read(self) -> dict[str, Any]:
        """Return the latest result; fail with the known reason where no picture has come for a while."""
        loop = asyncio.get_running_loop()
        self._wanted_until = loop.time() + self.first_within + LINGER
        self._hear_pictures()
        try:
            return await super().read()
        except Refused as err:
            raise failure(f"{err.why}: {self._complaint}" if self._complaint else err.why) from err
        finally:
            self._wanted_until = loop.time() + LINGER

    @request("picture")
    async def picture(self) -> dict[str, Any]:
        """Return the newest picture in base64, reduced in size if it is too large for a message."""
        await self.read()
        assert self._newest is not None  # it has been read
        try:
            image = decode(self._newest.type_name, self._newest.payload)
        except MessageError as err:
            raise failure(f"{self.name} cannot read what it hears: {err}") from err
        taken = image.data.tobytes()
        data = taken if len(taken) <= MOST else await self._smaller(taken)
        size = picture_size(data) or (None, None)
        return {
            "stamp": stamp_ns(image.header) / NS_PER_S,
            "format": image.format if data is taken else "jpeg",
            "width": size[0],
            "height": size[1],
            "data": base64.b64encode(data).decode(),
        }

    def _begin_to_hear(self, key: str) -> None:
        """Do not subscribe yet: `_follow_interest` does."""

    def _hear_pictures(self) -> None:
        """Subscribe to the pictures, and forget earlier ones."""
        if self._hearing is None:
            self._unread.clear()
            self._latest = None
            self._has_heard.clear()
            self._hearing = self.bus.subscribe(keys.CAMERA.key(self.robot), self._take_sample, urgent=True)

    async def _smaller(self, data: bytes) -> bytes:
        try:
            return await asyncio.to_thread(shrunk, data, MOST)
        except CameraNotUsable as err:
            raise failure(
                f"a picture of {len(data) // 1000} kB does not fit into a message of {MOST // 1000} kB; "
                f"subscribe to {keys.CAMERA.key(self.robot)} instead ({err})"
            ) from err

    def _rate(self) -> float:
        """Hz; zero before the second frame."""
        times = list(self._times)
        recent = [at for at in times if times[-1] - at <= RATE_TIME]
        if len(recent) < 2 or recent[-1] == recent[0]:
            return 0.0
        return round((len(recent) - 1) / (recent[-1] - recent[0]), 1)

    # On the bus's thread.

    def _take_reading(self, sample: Sample) -> None:
        assert self._loop is not None  # it lives
        self._newest = sample
        self._frames += 1
        self._times.append(self._loop.time())
        super()._take_reading(sample)

    # On the thread of a camera that is opened here.

    def _publish_picture(self, picture: CameraFrame) -> None:
        """Publish a picture as a gateway would; this agent receives it like other programs."""
        self._complaint = ""
        assert self._publisher is not None  # declared before the camera was opened
        image = CompressedImage(
            header=header(picture.stamp_ns, frame(self.robot, "camera")),
            format="jpeg",
            data=np.frombuffer(picture.jpeg, np.uint8),
        )
        with suppress(BusError):  # the bus is being closed
            self._publisher.put(image)

    def _lose(self, why: str) -> None:
        if not self._complaint and self._loop is not None:
            hand_over(self._loop, self.home.report, self.name, f"the camera gives no pictures: {why}", None)
        self._complaint = why
