"""The agent of image operations: on one image by a request, or on each image as a stream."""

import asyncio
import hashlib
import json
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from agents.components.camera import LINGER
from agents.components.vision.image_agent import ImageAgent
from agents.platform import AgentName, request
from bus import JSON, BusError, Publisher, Refused, keys
from bus.messages import CompressedImage

if TYPE_CHECKING:  # these load OpenCV
    from agents.components.vision.chain_tools import ChainTools
    from vision.image import Image
    from vision.operation import Numbers

MOST_CHAINS = 64
MOST_STREAMS = 32
"""Streams of chains without a name, at a time."""
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,39}")

Steps = list[dict[str, Any]]


@dataclass(slots=True)
class _ChainStream:
    """A chain whose results are published while a program subscribes to them.

    until: s of the loop's time, until which it stays without a listener; None for that of a chain with a name.
    trouble: what is wrong with the latest image or why there is no result for it; None if nothing is.
    """

    steps: Steps
    is_numbers: bool
    key: str
    publisher: Publisher
    until: float | None
    trouble: str | None = None


class VisionAgent(ImageAgent["ChainTools"]):
    """`vision@happy`: operations on images and chains of them.

    A chain is the name of a saved one, the name of an operation, or a list of steps.
    """

    services = ("images", "operations")
    results: ClassVar[Mapping[str, str]] = {
        "age": "s since the exposure of the image",
        "trouble": "why the image is not usable, null if it is",
        "width, height": "px of the image",
        "kind": "of the image: colour or grey",
        "skipped": "images so far that came during a computation",
        "streams": "by key: null, or why there is no result",
    }

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._chains: dict[str, _ChainStream] = {}  # by their names
        self._streams: dict[str, _ChainStream] = {}  # of chains without a name, by what they compute
        self._all: tuple[_ChainStream, ...] = ()  # of both, for the bus's thread

    def load_tools(self) -> "ChainTools":
        """Return the operations."""
        from agents.components.vision.chain_tools import ChainTools

        return ChainTools(has_noise=self.has_noise)

    def pack(self) -> dict[str, Any]:
        """Return the chains, and the streams that are listened to."""
        return {
            "chains": {name: [stream.steps, stream.is_numbers] for name, stream in self._chains.items()},
            "streams": {name: [stream.steps, stream.is_numbers] for name, stream in self._streams.items()},
        }

    def unpack(self, state: Mapping[str, Any]) -> None:
        """Take them."""
        now = asyncio.get_running_loop().time()
        for name, (steps, is_numbers) in state["chains"].items():
            self._chains[name] = self._made(name, steps, is_numbers, None)
        for name, (steps, is_numbers) in state["streams"].items():
            self._streams[name] = self._made(name, steps, is_numbers, now + LINGER)
        self._list()

    def describe(self) -> dict[str, Any]:
        """Return its description, with the chains."""
        described = super().describe()
        chains = {name: stream.steps for name, stream in self._chains.items()}
        return {**described, "properties": {**described["properties"], "chains": chains}}

    async def take_down(self) -> None:
        """End the streams."""
        for stream in self._all:
            stream.publisher.close()
        await super().take_down()

    @property
    def is_wanted(self) -> bool:
        """Whether a program listens to the results or to a chain."""
        return self.is_heard or any(stream.publisher.has_listeners for stream in self._all)

    @request("operations")
    async def operations(self) -> dict[str, Any]:
        """Return all operations: purpose, kinds of image, parameters with units and ranges."""
        return {"operations": await self.work(lambda tools: tools.operations())}

    @request("apply", agrees_itself=True)
    async def apply(
        self, chain: list[Any] | str, image: str = "", quality: int = 90, **parameters: Any
    ) -> dict[str, Any]:
        """Return the result of a chain for the newest image, or for a JPEG or PNG file in base64.

        quality: of a JPEG, 1 to 100; 0 for PNG. parameters: of the operation, where `chain` is the name of one.
        """
        steps, _ = await self._steps(chain, parameters)
        message = None if image else await self.newest()

        def compute(tools: "ChainTools") -> dict[str, Any]:
            result = tools.run(steps, tools.image(message, image), {})
            made = {"numbers": result} if isinstance(result, dict) else tools.picture(result, quality)
            return {**self.head(message), "trouble": tools.trouble if message else None, **made}

        return await self.work(compute)

    @request("save_chain", agrees_itself=True)
    async def save_chain(self, name: str, chain: list[Any] | str) -> dict[str, Any]:
        """Give a chain a name; return its steps and the key of its stream. A chain that has the name is replaced."""
        steps, is_numbers = await self._steps(chain)
        taken = {each["name"] for each in await self.work(lambda tools: tools.operations())}
        if not NAME.fullmatch(name) or name in taken:
            raise Refused(
                f"{name[:60]!r} cannot name a chain; use up to 40 letters, digits, - and _, beginning with a letter, "
                "and not the name of an operation"
            )
        if name not in self._chains and len(self._chains) >= MOST_CHAINS:
            raise Refused(f"{self.name} has {MOST_CHAINS} chains; remove one with remove_chain first")
        if name in self._chains:
            self._chains.pop(name).publisher.close()
        self._chains[name] = self._made(name, steps, is_numbers, None)
        self._list()
        return self._described(self._chains[name])

    @request("remove_chain")
    async def remove_chain(self, name: str) -> dict[str, Any]:
        """Forget a chain; its stream ends."""
        if name not in self._chains:
            known = ", ".join(self._chains) or "none"
            raise Refused(f"there is no chain {name[:60]!r}; saved are: {known}")
        self._chains.pop(name).publisher.close()
        self._list()
        return {"chains": list(self._chains)}

    @request("chains")
    async def chains(self) -> dict[str, Any]:
        """Return the saved chains by name, with their steps and the keys and types of their streams."""
        return {"chains": {name: self._described(stream) for name, stream in self._chains.items()}}

    @request("stream", agrees_itself=True)
    async def stream(self, chain: list[Any] | str) -> dict[str, Any]:
        """Return the key of the stream of a chain, saved or not.

        Results are published on it while a program subscribes: pictures as CompressedImage, numbers as JSON. The stream
        of a chain without a name ends 10 s after its last subscriber.
        """
        if isinstance(chain, str) and chain in self._chains:
            return self._described(self._chains[chain])
        steps, is_numbers = await self._steps(chain)
        name = "chain-" + hashlib.sha256(json.dumps(steps).encode()).hexdigest()[:12]
        until = asyncio.get_running_loop().time() + LINGER
        if name not in self._streams:
            if len(self._streams) >= MOST_STREAMS:
                raise Refused(f"{self.name} has {MOST_STREAMS} streams; end one, or save the chain under a name")
            self._streams[name] = self._made(name, steps, is_numbers, until)
            self._list()
        self._streams[name].until = until
        return self._described(self._streams[name])

    def look(self, tools: "ChainTools", image: CompressedImage) -> Mapping[str, Any]:
        """Compute and publish what is listened to, and return what there is to say of the image."""
        decoded = tools.decoded(image)
        results: dict[str, Image | Numbers] = {}  # shared, so equal steps are computed once
        result: Image | Numbers | None
        streams = [stream for stream in self._all if stream.publisher.has_listeners]
        for stream in streams:
            try:
                result = tools.run(stream.steps, decoded, results)
                stream.trouble = tools.trouble
            except ValueError as err:  # a VisionError: the chain does not take this kind of image
                result, stream.trouble = None, str(err)
            self._publish(tools, stream, result, image)
        return {
            **self.head(image),
            "trouble": tools.trouble,
            "width": decoded.width,
            "height": decoded.height,
            "kind": decoded.kind.value,
            "skipped": self._stream.skipped if self._stream else 0,
            "streams": {stream.key: stream.trouble for stream in streams},
        }

    def _publish(
        self, tools: "ChainTools", stream: _ChainStream, result: "Image | Numbers | None", image: CompressedImage
    ) -> None:
        """Publish a result; None, which only a stream of numbers can show, if there is none."""
        head = {**self.head(image), "trouble": stream.trouble}
        with suppress(BusError):  # the stream has just been ended
            if stream.is_numbers:
                stream.publisher.put({**head, "numbers": result})
            elif result is not None and not isinstance(result, dict):
                form, data = tools.encoded(result)
                message = CompressedImage(header=image.header, format=form, data=np.frombuffer(data, np.uint8))
                stream.publisher.put(message, json.dumps(head).encode())

    async def _steps(self, chain: object, parameters: Mapping[str, Any] | None = None) -> tuple[Steps, bool]:
        """Return the steps of a chain, and whether it gives numbers.

        Raises:
            Refused: It is none; the message says why.
        """
        if isinstance(chain, str) and chain in self._chains and not parameters:
            saved = self._chains[chain]
            return saved.steps, saved.is_numbers
        if isinstance(chain, str):
            name = chain
            return await self.work(lambda tools: tools.operation(name, parameters or {}, list(self._chains)))
        if parameters:
            raise Refused(f"the parameters {', '.join(parameters)} belong into the steps of the chain")
        return await self.work(lambda tools: tools.checked(chain))

    async def _follow_interest(self) -> None:
        """Close streams that nobody listens to any more."""
        now, ended = asyncio.get_running_loop().time(), []
        for name, stream in self._streams.items():
            if stream.publisher.has_listeners:
                stream.until = now + LINGER
            elif stream.until is not None and now >= stream.until:
                ended.append(name)
        for name in ended:
            self._streams.pop(name).publisher.close()
        if ended:
            self._list()
        await super()._follow_interest()

    def _made(self, name: str, steps: Steps, is_numbers: bool, until: float | None) -> _ChainStream:
        key = f"{self.name.results_key}/{name}"
        publisher = self.bus.publisher(key, JSON if is_numbers else keys.CAMERA.type_name)
        return _ChainStream(steps, is_numbers, key, publisher, until)

    def _described(self, stream: _ChainStream) -> dict[str, Any]:
        return {
            "key": stream.key,
            "type": JSON if stream.is_numbers else keys.CAMERA.type_name,
            "steps": stream.steps,
        }

    def _list(self) -> None:
        self._all = (*self._chains.values(), *self._streams.values())
