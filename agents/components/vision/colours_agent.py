"""The agent of colour tracking: 32 channels, as ACTS has them, also served to existing clients of ACTS."""

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, ClassVar

from agents.components.vision.acts_server import ActsServer
from agents.components.vision.image_agent import ImageAgent
from agents.platform import AgentName, OneShot, request
from agents.wrappers.acts import FIELDS, VERSIONS, packet
from bus import Refused
from bus.messages import CompressedImage

if TYPE_CHECKING:  # these load OpenCV
    from agents.components.vision.image_tools import ColourTools

SMALLEST = 4
"""Area in pixels that a blob has at least."""
FIRST_TIME = 1.0
"""Seconds that a client of ACTS waits for the first image; afterwards there are no blobs."""
OLDEST = (160, 120)
"""Pixels of the images of ACTS 1.0, whose coordinates have one byte. Larger images are scaled for its clients."""


class ColoursAgent(ImageAgent["ColourTools"]):
    """`colours@happy`: trains channels from regions of images, and finds their blobs.

    Properties: `colours`, the text of a file of colours; `acts_port`, the port for clients of ACTS [none], `acts_host`
    [127.0.0.1] and `acts_version` [2.0].
    """

    services = ("images", "blobs")
    results: ClassVar[Mapping[str, str]] = {
        "age": "s since the exposure of the image",
        "trouble": "why the image is not usable, null if it is",
        "width, height": "px of the image",
        "channels": "by number: up to ten blobs, the largest first",
    }

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._text = str(self.properties.get("colours", ""))  # of all channels, as in a file
        self._acts = ActsServer(self._acts_reply)
        self._acts_at: tuple[str, int, str] | None = None  # host, port and version
        self._seen: tuple[Mapping[str, Any], float] | None = None  # the latest blobs, and the loop's time of them
        self._has_seen = asyncio.Event()

    def load_tools(self) -> "ColourTools":
        """Return the channels."""
        from agents.components.vision.image_tools import ColourTools

        return ColourTools(self._text, has_noise=self.has_noise)

    async def setup(self) -> None:
        """Begin to serve clients of ACTS if the properties have a port."""
        await super().setup()
        if (port := self.properties.get("acts_port")) is not None:
            await self.serve_acts(port, str(self.properties.get("acts_version", "2.0")))

    async def take_down(self) -> None:
        """End the connections of clients of ACTS."""
        await self._acts.close()
        await super().take_down()

    def pack(self) -> dict[str, Any]:
        """Return the channels, and where clients of ACTS are served."""
        return {"colours": self._text, "acts": self._acts_at}

    def unpack(self, state: Mapping[str, Any]) -> None:
        """Take them."""
        self._text, acts = state["colours"], state["acts"]
        if acts is not None:
            host, port, version = acts
            self.add(OneShot(lambda: self._serve_acts(host, port, version), "serve clients of ACTS"))

    @property
    def is_wanted(self) -> bool:
        """Whether a program listens, or a client of ACTS is connected."""
        return self.is_heard or self._acts.has_clients

    @request("channels")
    async def channels(self) -> dict[str, Any]:
        """Return the trained channels, and the port for clients of ACTS."""
        return {"channels": await self.work(lambda tools: tools.channels()), "acts_port": self._acts.port}

    @request("train", agrees_itself=True)
    async def train(
        self, channel: int, region: list[Any], name: str = "", image: str = "", light: float = 2.5
    ) -> dict[str, Any]:
        """Add the colour of a region to a channel; return how well the channel finds it.

        channel: 1 to 32. region: left, top, width, height in px. image: a JPEG or PNG file in base64; without it the
        newest image. light: factor by which the light may change.
        """
        place = _place(region)
        message = None if image else await self.newest()

        def train(tools: "ColourTools") -> dict[str, Any]:
            source = tools.image(message, image)
            tools.table.train(channel, source.pixels, place, name, light)
            self._text = tools.table.save().decode()
            return {**self.head(message), **asdict(tools.table.test(channel, source.pixels, place))}

        return await self.work(train)

    @request("test", agrees_itself=True)
    async def test(self, channel: int, region: list[Any], image: str = "") -> dict[str, Any]:
        """Return `hits`, the share of the region, `strays`, px outside it, and the same in words."""
        place = _place(region)
        message = None if image else await self.newest()

        def test(tools: "ColourTools") -> dict[str, Any]:
            source = tools.image(message, image)
            return {**self.head(message), **asdict(tools.table.test(channel, source.pixels, place))}

        return await self.work(test)

    @request("clear", agrees_itself=True)
    async def clear(self, channel: int) -> dict[str, Any]:
        """Forget the colours of a channel."""

        def clear(tools: "ColourTools") -> list[dict[str, Any]]:
            tools.table.clear(channel)
            self._text = tools.table.save().decode()
            return tools.channels()

        return {"channels": await self.work(clear)}

    @request("save")
    async def save(self) -> dict[str, Any]:
        """Return the text of a file with all channels."""
        return {"colours": await self.work(lambda tools: tools.table.save().decode())}

    @request("load", agrees_itself=True)
    async def load(self, colours: str) -> dict[str, Any]:
        """Replace all channels by those of a file, given as text."""

        def load(tools: "ColourTools") -> list[dict[str, Any]]:
            tools.table = type(tools.table).load(colours.encode())
            self._text = colours
            return tools.channels()

        return {"channels": await self.work(load)}

    @request("blobs", agrees_itself=True)
    async def blobs(self, image: str = "", smallest: int = SMALLEST) -> dict[str, Any]:
        """Return the blobs in the newest image, or in a JPEG or PNG file in base64.

        smallest: px of area that a blob has at least.
        """
        if smallest < 1:
            raise Refused(f"smallest is an area of at least 1 px, not {smallest}")
        message = None if image else await self.newest()
        return await self.work(lambda tools: self._found(tools, message, image, smallest))

    @request("serve_acts", agrees_itself=True)
    async def serve_acts(self, port: int, version: str | float = "2.0") -> dict[str, Any]:
        """Serve clients of ACTS on a TCP port; 0 to end it. version: 1.0, 1.2 or 2.0."""
        if port == 0:
            await self._acts.close()
            self._acts_at = None
        else:
            host = str(self.properties.get("acts_host", "127.0.0.1"))
            await self._serve_acts(host, port, str(version))  # a command line makes a number of it
        return {"acts_port": self._acts.port}

    def look(self, tools: "ColourTools", image: CompressedImage) -> Mapping[str, Any]:
        """Return the blobs."""
        return self._found(tools, image, "", SMALLEST)

    def _show(self, result: Mapping[str, Any]) -> None:
        self._seen = result, asyncio.get_running_loop().time()
        self._has_seen.set()
        super()._show(result)

    def _found(
        self, tools: "ColourTools", message: CompressedImage | None, image: str, smallest: int
    ) -> dict[str, Any]:
        source = tools.image(message, image)
        found = tools.blobs(source, self.properties, smallest)
        return {**self.head(message), "trouble": tools.trouble if message else None, **found}

    async def _serve_acts(self, host: str, port: int, version: str) -> None:
        if version not in VERSIONS:
            raise Refused(f"there is no version {version[:20]!r} of ACTS; there are 1.0, 1.2 and 2.0")
        if not isinstance(port, int) or not 0 < port < 1 << 16:
            raise Refused(f"a TCP port is a number from 1 to 65535, not {port!r}")
        await self._acts.start(host, port)
        self._acts_at = host, port, version

    async def _acts_reply(self) -> bytes:
        """Return header and blobs; there are no blobs without an image that is new enough."""
        assert self._acts_at is not None  # it serves
        loop = asyncio.get_running_loop()
        if not self._is_fresh() and (self._hearing is None or loop.time() - self._heard_from < FIRST_TIME):
            self._has_seen.clear()  # the camera is just being opened
            with suppress(TimeoutError):  # without an image there are no blobs
                async with asyncio.timeout(FIRST_TIME):
                    await self._has_seen.wait()
        version = self._acts_at[2]
        channels = self._seen[0].get("channels", {}) if self._seen and self._is_fresh() else {}
        if not channels:
            return packet({}, version)
        assert self._seen is not None
        size = self._seen[0]["width"], self._seen[0]["height"]
        scale = min(1.0, OLDEST[0] / size[0], OLDEST[1] / size[1]) if version == "1.0" else 1.0
        return packet(
            {int(number): [_scaled(blob, scale) for blob in blobs] for number, blobs in channels.items()}, version
        )

    def _is_fresh(self) -> bool:
        return self._seen is not None and asyncio.get_running_loop().time() - self._seen[1] <= self.fresh


def _scaled(blob: Mapping[str, float], scale: float) -> Mapping[str, float]:
    """Return area and places of a blob in an image that is smaller by a factor."""
    return {name: blob[name] * scale * (scale if name == "area" else 1.0) for name in FIELDS}


def _place(region: object) -> tuple[int, int, int, int]:
    """Return a region of an image if it is one.

    Raises:
        Refused: It is not made of four whole numbers.
    """
    if isinstance(region, list) and [type(each) for each in region] == [int] * 4:
        left, top, width, height = region
        return left, top, width, height
    raise Refused(
        f"a region is [left, top, width, height] in whole pixels, such as [40, 30, 20, 20], not {repr(region)[:40]}"
    )
