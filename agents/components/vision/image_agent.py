"""The base class of agents that work on the newest image of their robot's camera.

The camera is subscribed to only while a program listens, or has just asked. Work is done in one thread for each agent;
images that come meanwhile are skipped except the latest. Subclasses load what imports OpenCV in that thread.
"""

import asyncio
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any, ClassVar, Generic, TypeVar

from agents.components.camera import LINGER
from agents.components.component import ElementAgent, failure
from agents.platform import AgentName, request
from bus import MessageError, Refused, Sample, Subscription, keys
from bus.aio import hand_over
from bus.keys import Topic
from bus.messages import NS_PER_S, CompressedImage, decode, stamp_ns
from configs.extras import require

_ATTENTION = 0.5
"""Seconds between two looks whether a program listens: a robot has three of these agents, which mostly have none."""
MOST_JOBS = 8
"""Pieces of work that wait for the thread of an agent; further requests are refused."""

_MOST_MESSAGES = 64
"""Of each agent, of what moves its camera, between two images."""
Tools = TypeVar("Tools")
"""What does the work of an agent; only the agent's thread uses it."""
T = TypeVar("T")


class ImageAgent(ElementAgent, Generic[Tools]):
    """An agent beside the camera's. Each result has `stamp` and `age`: exposure in s since 1970, and s since then."""

    source = keys.CAMERA
    first_within = 8.0  # a camera is opened only on request
    services: ClassVar[tuple[str, ...]] = ("images",)
    moved_by: ClassVar[tuple[Topic, ...]] = ()  # what moves the camera, heard while the images are

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._worker = ThreadPoolExecutor(1, thread_name_prefix=str(self.name))
        self._tools: Tools | None = None
        self._jobs = 0
        self._hearing: Subscription | None = None
        # Of `moved_by`, not decoded yet; the bus's thread appends.
        self._moved: deque[Sample] = deque(maxlen=_MOST_MESSAGES)
        self._listening: list[Subscription] = []  # to `moved_by`
        self._heard_from = 0.0  # s of the loop's time, when the subscription began
        self._wanted_until = 0.0  # likewise, after a request
        self._newest: tuple[Sample, float] | None = None  # and when it came
        self._trouble: str | None = None
        self._is_silent = False  # the camera, and it was told

    @classmethod
    def properties_of(cls, robot: Mapping[str, Any], element: Mapping[str, Any]) -> dict[str, Any]:
        """Return size, px, and field of view, rad, of the camera or its head; None where they are not known.

        A calibrated camera has a `model` as well.
        """
        about = {"size": element.get("size"), "emulated": robot.get("emulated")}
        about |= {"robot_model": robot.get("model"), "robot_class": robot.get("class")}
        heads = [row for row in robot["elements"] if isinstance(row, dict) and row.get("name") == "ptz"]
        angles = (row.get("field_of_view") for row in (element, *heads))
        about["field_of_view"] = next((angle for angle in angles if angle is not None), None)
        return about if element.get("model") is None else {**about, "model": element["model"]}

    def load_tools(self) -> Tools:
        """Return what does the work; called once, in the agent's thread."""
        raise NotImplementedError

    def look(self, tools: Tools, image: CompressedImage) -> Mapping[str, Any]:
        """Return the result for an image; called in the agent's thread.

        Raises:
            VisionError: The image cannot be used.
        """
        raise NotImplementedError

    @property
    def has_noise(self) -> bool:
        """Whether images of the camera differ even if nothing moves; those of an emulated one do not."""
        return not self.properties.get("emulated")

    @property
    def is_wanted(self) -> bool:
        """Whether each image is to be worked on now; any thread."""
        return self.is_heard

    def describe(self) -> dict[str, Any]:
        """Return its description; it is not the agent of an element."""
        described = super().describe()
        return {**described, "services": [each for each in described["services"] if each != "component"]}

    async def setup(self) -> None:
        """Prepare, without the camera.

        Raises:
            ExtraMissing: OpenCV is not installed.
        """
        require(str(self.name), "vision")
        await super().setup()
        self.every(_ATTENTION, self._follow_interest)

    async def take_down(self) -> None:
        """Give up the camera, and work that waits."""
        self._give_up_images()
        self._worker.shutdown(wait=False, cancel_futures=True)

    @request("read")
    async def read(self) -> dict[str, Any]:
        """The result for the newest image; fails where there is none."""
        image = await self.newest()
        return dict(await self.work(lambda tools: self.look(tools, image)))

    async def newest(self) -> CompressedImage:
        """Return the newest image; it waits for the first one.

        Raises:
            Refused: There is none, or an old one only.
        """
        loop = asyncio.get_running_loop()
        self._wanted_until = loop.time() + self.first_within + LINGER
        self._hear_images()
        if self._newest is None:
            try:
                async with asyncio.timeout(self.first_within):
                    await self._has_heard.wait()
            except TimeoutError:
                raise failure(f"{self.name} has received no image; is the camera of {self.robot} there?") from None
        assert self._newest is not None  # it has been heard
        sample, at = self._newest
        self._wanted_until = loop.time() + LINGER
        if (silence := loop.time() - at) > self.fresh:
            raise failure(f"{self.name} has received no image for {silence:.1f} s")
        try:
            image: CompressedImage = decode(sample.type_name, sample.payload)
        except MessageError as err:
            raise failure(f"{self.name} cannot read what it hears: {err}") from err
        return image

    async def work(self, job: Callable[[Tools], T]) -> T:
        """Do something in the agent's thread, after what waits for it.

        Raises:
            Refused: Too much waits, or something cannot be used; the message says what.
        """
        if self._jobs >= MOST_JOBS:
            raise Refused(f"{self.name} is busy: {self._jobs} operations wait; ask again later")
        self._jobs += 1
        try:
            return await self._in_thread(job)
        finally:
            self._jobs -= 1

    def head(self, image: CompressedImage | None) -> dict[str, Any]:
        """Return `stamp` and `age` of a result now; None of an image that does not come from the camera."""
        if image is None:
            return {"stamp": None, "age": None}
        stamp = stamp_ns(image.header) / NS_PER_S
        return {"stamp": stamp, "age": round(self.home.wall_time() - stamp, 4)}

    async def _in_thread(self, job: Callable[[Tools], T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._worker, self._do, job)

    def _do(self, job: Callable[[Tools], T]) -> T:
        from vision.image import VisionError  # it loads OpenCV, which takes long, so not in the event loop

        if self._tools is None:
            self._tools = self.load_tools()
        try:
            return job(self._tools)
        except VisionError as err:
            raise Refused(str(err)) from err

    async def _hear(self, message: CompressedImage) -> None:
        """Work on an image; meanwhile the next ones replace each other."""
        self._is_silent = False
        try:
            result = dict(await self._in_thread(lambda tools: self.look(tools, message)))
        except Refused as err:
            result = {**self.head(message), "trouble": err.why}
        self._show(result)

    def _show(self, result: Mapping[str, Any]) -> None:
        """Publish a result, and report a new trouble once."""
        trouble = result.get("trouble")
        if trouble is not None and self._trouble is None:
            self.home.report(self.name, f"the images of the camera: {trouble}", None)
        self._trouble = trouble
        if self.is_heard:
            self.publish(result)

    async def _follow_interest(self) -> None:
        """Subscribe to the images while a program needs them."""
        now = asyncio.get_running_loop().time()
        if self.is_wanted:
            self._hear_images()
            heard = self._newest[1] if self._newest else self._heard_from
            if now - heard > self.fresh and not self._is_silent:
                self._is_silent = True
                self._show({"stamp": None, "age": None, "trouble": f"no image has come for {now - heard:.1f} s"})
        elif now >= self._wanted_until:
            self._give_up_images()

    def _begin_to_hear(self, key: str) -> None:
        """Do not subscribe yet: `_follow_interest` does."""

    def _hear_images(self) -> None:
        """Subscribe to the images, and forget earlier ones."""
        if self._hearing is None:
            self._newest = None
            self._has_heard.clear()
            self._heard_from = asyncio.get_running_loop().time()
            self._hearing = self.bus.subscribe(keys.CAMERA.key(self.robot), self._take_sample, urgent=True)
            self._listening = [
                self.bus.subscribe(topic.key(self.robot), self._moved.append, urgent=True) for topic in self.moved_by
            ]

    def _give_up_images(self) -> None:
        """End the subscription to the images."""
        if self._hearing is not None:
            self._hearing.close()
            self._hearing, self._newest, self._trouble = None, None, None
            self._is_silent = False
        while self._listening:
            self._listening.pop().close()

    # On the bus's thread.

    def _take_reading(self, sample: Sample) -> None:
        assert self._loop is not None  # it lives
        assert self._stream is not None
        self._newest = sample, self._loop.time()
        if self.is_wanted:
            self._stream.take(sample)
        if not self._has_heard.is_set():
            hand_over(self._loop, self._has_heard.set)
