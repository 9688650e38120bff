"""Images to viewers: always the newest, one at a time, and nobody waits for a viewer that reads nothing."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any

import numpy as np
import pytest
from starlette.websockets import WebSocketDisconnect

from apps.remote_vision.settings import ImageTimes
from apps.remote_vision.streams import SharedStreams, read_item
from apps.remote_vision.transport import UNKNOWN_TICKET, ImageTransport
from apps.remote_vision.viewing import COLOURS, ORIGINAL, RESULT, Viewing, boxes, image_words
from apps.web.viewer import LENGTH
from bus import CDR, JSON, MemoryBus, Sample, keys, messages
from tests.waiting import waiting

KEY = keys.CAMERA.key("happy")
RESULT_KEY = "happy/agents/vision/results/edges"
TIMES = ImageTimes(old_s=0.5, wait_s=0.05, linger_s=0.1, most_bytes=1000)
START = 1_700_000_000  # s, the bus's clock


class Socket:
    """A browser's end: `ask` requests the next image; `replies` are those that were sent."""

    def __init__(self, reads: bool = True) -> None:
        self.replies: list[tuple[dict[str, Any], bytes]] = []
        self.closed: int | None = None
        self._asked: asyncio.Queue[bool] = asyncio.Queue()
        self._reads = reads

    async def accept(self) -> None:
        pass

    async def close(self, code: int) -> None:
        self.closed = code

    async def receive_text(self) -> str:
        if not await self._asked.get():
            raise WebSocketDisconnect
        return "next"

    async def send_bytes(self, data: bytes) -> None:
        if not self._reads:
            await asyncio.Event().wait()
        (length,) = LENGTH.unpack_from(data)
        end = LENGTH.size + length
        self.replies.append((json.loads(data[LENGTH.size : end]), data[end:]))

    def ask(self, is_open: bool = True) -> None:
        self._asked.put_nowait(is_open)

    async def next(self) -> tuple[dict[str, Any], bytes]:
        """The reply to one request."""
        count = len(self.replies)
        self.ask()
        async with waiting():
            while len(self.replies) == count:
                await asyncio.sleep(0.002)
        return self.replies[-1]


class Room:
    """A camera on a bus, and the transport."""

    def __init__(self) -> None:
        self.bus = MemoryBus()
        self.streams = SharedStreams(self.bus, TIMES.linger_s)
        self.viewing = Viewing("ticket", "viewer 1", "happy", {ORIGINAL: KEY})
        self.transport = ImageTransport(
            self.streams,
            {"ticket": self.viewing},
            TIMES,
            lambda viewing, place, silence: f"nothing from {viewing.robot}",
            lambda: START + 0.25,
        )
        self._camera = self.bus.publisher(KEY, keys.CAMERA.type_name)
        self.number = 0

    def show(self, data: bytes | None = None) -> bytes:
        """Publish an image; return its file."""
        self.number += 1
        file = b"image %d" % self.number if data is None else data
        head = messages.header(START * 10**9, "happy/camera")
        self._camera.put(messages.CompressedImage(header=head, format="jpeg", data=np.frombuffer(file, np.uint8)))
        return file

    def begin(self, socket: Socket, place: str = ORIGINAL, ticket: str = "ticket") -> "asyncio.Task[None]":
        serving: Any = self.transport.serve
        return asyncio.ensure_future(serving(socket, ticket, place))

    @property
    def is_watched(self) -> bool:
        return self._camera.has_listeners

    async def until_watched(self) -> None:
        async with waiting():
            while not self.is_watched:
                await asyncio.sleep(0.002)


def play(story: Callable[[Room], Awaitable[None]]) -> None:
    async def run() -> None:
        room = Room()
        with room.streams:
            await story(room)

    asyncio.run(run())


async def settle() -> None:
    """Let what came on the bus reach the loop."""
    for _ in range(5):
        await asyncio.sleep(0.002)


def test_a_viewer_gets_the_file_of_the_camera_unchanged_with_its_age() -> None:
    async def story(room: Room) -> None:
        socket = Socket()
        serving = room.begin(socket)
        socket.ask()
        await room.until_watched()
        file = room.show()
        async with waiting():
            while not (socket.replies and socket.replies[-1][1]):
                socket.ask()
                await asyncio.sleep(0.01)
        head, data = socket.replies[-1]
        assert data == file
        assert head["age"] == 0.25
        assert head["stamp"] == START
        serving.cancel()

    play(story)


def test_a_stream_that_is_chosen_again_after_it_has_ended_shows_its_first_image() -> None:
    async def story(room: Room) -> None:
        socket = Socket()
        serving = room.begin(socket)
        socket.ask()
        await room.until_watched()
        for _ in range(5):
            room.show()
            await settle()
        async with waiting():
            while not (socket.replies and socket.replies[-1][0].get("number", 0) > 1):
                await socket.next()
        room.viewing.keys.clear()
        async with waiting():
            while room.is_watched:  # it lingers for a while
                await socket.next()
        room.viewing.keys[ORIGINAL] = KEY
        socket.ask()
        await room.until_watched()
        file = room.show()
        async with waiting():
            while socket.replies[-1][1] != file:
                await socket.next()
        serving.cancel()

    play(story)


def test_a_slow_viewer_gets_the_newest_image_and_none_that_came_meanwhile() -> None:
    async def story(room: Room) -> None:
        socket = Socket()
        serving = room.begin(socket)
        await socket.next()
        room.show()
        await settle()
        assert (await socket.next())[1] == b"image 1"
        for _ in range(50):
            room.show()
        await settle()
        assert (await socket.next())[1] == b"image 51"
        head, data = await socket.next()  # it has been shown already
        assert data == b""
        assert head["words"] == "nothing from happy"
        serving.cancel()

    play(story)


def test_a_viewer_that_reads_nothing_holds_up_no_other() -> None:
    async def story(room: Room) -> None:
        stuck, quick = Socket(reads=False), Socket()
        servings = [room.begin(stuck), room.begin(quick)]
        await quick.next()
        room.show()
        stuck.ask()
        await settle()
        for number in range(2, 5):
            room.show()
            await settle()
            assert (await quick.next())[1] == b"image %d" % number
        assert stuck.replies == []
        for serving in servings:
            serving.cancel()

    play(story)


def test_a_camera_is_watched_only_while_a_viewer_looks() -> None:
    async def story(room: Room) -> None:
        first, second = Socket(), Socket()
        servings = [room.begin(first), room.begin(second)]
        await first.next()
        await second.next()
        assert room.streams.keys == [KEY]
        assert room.viewing.sockets == 2
        for socket in (first, second):
            socket.ask(is_open=False)
        await asyncio.gather(*servings)
        assert not room.viewing.is_open
        async with waiting():
            while room.streams.keys:
                await asyncio.sleep(0.01)

    play(story)


def test_an_image_that_is_too_large_is_told_and_not_sent() -> None:
    async def story(room: Room) -> None:
        socket = Socket()
        serving = room.begin(socket)
        await socket.next()
        room.show(b"x" * 2000)
        await settle()
        head, data = await socket.next()
        assert data == b""
        assert "is not sent" in head["words"]
        room.show()
        await settle()
        assert (await socket.next())[1] == b"image 2"
        serving.cancel()

    play(story)


def test_why_there_is_no_result_is_what_the_vision_agent_reports() -> None:
    async def story(room: Room) -> None:
        socket = Socket()
        serving = room.begin(socket, RESULT)
        assert (await socket.next())[0]["is_empty"]
        room.viewing.keys[RESULT] = RESULT_KEY
        await socket.next()
        room.bus.put("happy/agents/vision/results", {"streams": {RESULT_KEY: "canny takes a grey image"}})
        await settle()
        assert (await socket.next())[0]["words"] == "canny takes a grey image"
        room.bus.put(RESULT_KEY, {"stamp": START, "trouble": None, "numbers": {"grey": [1, 2]}})
        await settle()
        assert (await socket.next())[0]["numbers"] == {"grey": [1, 2]}
        serving.cancel()

    play(story)


def test_blobs_come_with_the_image_while_their_overlay_is_chosen() -> None:
    blob = {"left": 1, "top": 2, "right": 3, "bottom": 4, "area": 9}

    async def story(room: Room) -> None:
        socket = Socket()
        serving = room.begin(socket)
        room.viewing.overlays = {COLOURS}
        await socket.next()
        room.bus.put("happy/agents/colours/results", {"channels": {"7": [blob]}})
        room.show()
        await settle()
        (box,) = (await socket.next())[0]["boxes"]
        assert (box["label"], box["left"], box["bottom"]) == ("channel 7", 1, 4)
        room.bus.put("happy/agents/colours/results", {"trouble": "the image is black"})
        room.show()
        await settle()
        assert (await socket.next())[0]["words"] == "colours: the image is black"
        room.viewing.overlays = set()
        room.show()
        await settle()
        assert (await socket.next())[0]["boxes"] == []
        serving.cancel()

    play(story)


def test_a_page_that_is_not_known_is_closed() -> None:
    async def story(room: Room) -> None:
        socket = Socket()
        await room.begin(socket, ticket="guessed")
        assert socket.closed == UNKNOWN_TICKET

    play(story)


@pytest.mark.parametrize(
    "sample",
    [
        Sample(KEY, b"torn", f"{CDR};sensor_msgs/msg/CompressedImage"),
        Sample(KEY, b"{torn", JSON),
        Sample(KEY, b"", "text/plain"),
        Sample(KEY, messages.encode(messages.twist(0.1, 0.0)), f"{CDR};geometry_msgs/msg/Twist"),
    ],
)
def test_what_cannot_be_read_is_told(sample: Sample) -> None:
    item = read_item(sample, 1, 0.0)
    assert "cannot be read" in item.trouble
    assert not item.image


def test_silence_is_explained_by_what_is_missing() -> None:
    assert "not on the bus" in image_words("happy", 2.0, False, False)
    assert "camera of happy is lost" in image_words("happy", 2.0, True, False)
    assert "for 2.0 s" in image_words("happy", 2.0, True, True)
    assert boxes("colours", None) == []
