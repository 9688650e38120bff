"""An agent for a program or a library by a wrapper file: it passes on requests, and publishes results."""

import asyncio
import base64
import binascii
import contextlib
import inspect
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from agents.platform import Agent, AgentName, OneShot, Restart, agree
from agents.wrappers import acts
from agents.wrappers.codec import ProgramCodec
from agents.wrappers.frames import FramesCodec
from agents.wrappers.lines import JsonLinesCodec, LinesCodec
from agents.wrappers.program import NotAnswered, ProgramEnded, ProgramRun
from agents.wrappers.wrapper_file import (
    ArgumentKind,
    Codec,
    Colours,
    FunctionArgument,
    FunctionRow,
    PictureRow,
    RequestRow,
    WrapperFile,
)
from bus import Refused
from bus.messages import CompressedImage, stamp_ns
from configs import ConfigError
from configs.extras import missing, needs

QUALITY = 90  # of JPEG, percent


C_KINDS = {
    "float": ArgumentKind.NUMBER,
    "double": ArgumentKind.NUMBER,
    "text": ArgumentKind.TEXT,
    "bytes": ArgumentKind.BYTES,
}
LIBRARY_READY_WITHIN = 10.0  # s
AGAIN = Restart(first=0.2, longest=10.0)
IMAGE = "image/compressed"


class Wrapped(Agent):
    """Starts and ends a program with itself, and restarts it when it ends by itself. Otherwise requests are refused."""

    def __init__(self, name: AgentName | str, wrapper: WrapperFile, file: Path) -> None:
        """Prepare it.

        Args:
            name: The agent's.
            wrapper: The contents of the file.
            file: Its path; paths in it are relative to its folder.
        Raises:
            ConfigError: The file demands something that its protocol does not have.
        """
        super().__init__(name, {"about": wrapper.about, "wrapper": file.stem})
        self._wrapper = wrapper
        self._file = file
        self._program: ProgramRun | None = None
        self._why_not = "it has not been started yet"
        self._tried = asyncio.Event()  # whether it has been, with or without success
        _check(wrapper, file)

    @property
    def image_key(self) -> str:
        """The key of the pictures that a function makes."""
        return f"{self.name.platform}/agents/{self.name.local}/{IMAGE}"

    def describe(self) -> dict[str, Any]:
        """Return the description with the services of the file."""
        return {**super().describe(), "services": list(self._wrapper.services)}

    async def setup(self) -> None:
        """Start the program; after a failure this is repeated, and requests are refused until then."""
        for row in self._wrapper.requests:
            self.answer(row.name, self._handler(row), agrees_itself=True)
        for function in self._wrapper.functions:
            self.answer(function.name, self._handler(_as_request(function)), agrees_itself=True)
        self.add(OneShot(self._keep, "keep its program running"), AGAIN)
        await self._tried.wait()
        for result in self._wrapper.results:
            if result.request:
                self.every(result.every_s, partial(self._poll, result.request))
        for picture in self._wrapper.pictures:
            self._watch(picture)

    async def take_down(self) -> None:
        """End the program."""
        if self._program is not None:
            await self._program.end()

    async def ask(self, name: str, arguments: Mapping[str, Any], within: float) -> dict[str, Any]:
        """Send a request to the program.

        Raises:
            NotAnswered, ProgramEnded: It was not done.
        """
        if self._program is None:
            raise ProgramEnded(self._why_not)
        return await self._program.ask(name, arguments, within)

    async def _keep(self) -> None:
        """Keep one run of the program."""
        part, library = self._wrapper.program, self._wrapper.library
        command = list(part.command) if part else [sys.executable, "-m", "agents.wrappers.library_process"]
        if library is not None:
            command.append(str(self._file))
        elif command and "/" in command[0]:
            command[0] = str(self._file.parent / command[0])
        program = ProgramRun(
            command, self._file.parent, part.address if part else "", _codec_of(self._wrapper), self._told
        )
        try:
            await program.start(part.ready_within_s if part else LIBRARY_READY_WITHIN)
            self._program = program
            self._tried.set()
            await program.run()
        except ProgramEnded as error:
            self._why_not = f"{error}; it is being started again"
            raise
        finally:
            self._program = None
            self._tried.set()
            await program.end()

    def _told(self, value: dict[str, Any]) -> None:
        self.publish(_without_bytes(value))

    def _handler(self, row: RequestRow) -> Callable[..., Any]:
        """Return a handler whose signature has the arguments of a request."""

        async def serve(**given: Any) -> dict[str, Any]:
            arguments = {**row.defaults, **given}
            for key in row.takes:
                if row.takes[key] is ArgumentKind.BYTES:
                    arguments[key] = _bytes(key, arguments[key])
            if self._program is None:
                raise Refused(self._why_not)
            agree()
            try:
                return _without_bytes(await self.ask(row.name, arguments, row.within_s))
            except (NotAnswered, ProgramEnded) as error:
                raise Refused(str(error)) from error

        keyword = inspect.Parameter.KEYWORD_ONLY
        parameters = [
            inspect.Parameter(key, keyword, default=row.defaults.get(key, inspect.Parameter.empty)) for key in row.takes
        ]
        serve.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]  # inspect reads it
        serve.__annotations__ = {key: KINDS[kind] for key, kind in row.takes.items()}
        return serve

    async def _poll(self, name: str) -> None:
        """Request what is published; nothing while the program does not run."""
        row = next(row for row in self._requests() if row.name == name)
        if self._program is not None:
            with contextlib.suppress(ProgramEnded):  # that is told by whoever keeps it running
                self._told(await self.ask(name, row.defaults, row.within_s))

    def _requests(self) -> list[RequestRow]:
        return [*self._wrapper.requests, *map(_as_request, self._wrapper.functions)]

    def _watch(self, row: PictureRow) -> None:
        function = next(each for each in self._wrapper.functions if each.name == row.function)

        async def look(message: CompressedImage) -> None:
            if self._program is None:
                return
            given = await asyncio.to_thread(_pixels, bytes(message.data), row.colours)
            found = await self.ask(row.function, {**function.defaults, **given}, function.within_s)
            if row.out:
                picture = await asyncio.to_thread(_compressed, found.pop(row.out), given["width"], given["height"])
                data = np.frombuffer(picture, np.uint8)
                self.bus.put(self.image_key, CompressedImage(message.header, format="jpeg", data=data))
            stamp = stamp_ns(message.header) * 1e-9
            self._told({**found, "stamp": stamp, "width": given["width"], "height": given["height"]})

        self.listen(f"{self.name.platform}/{row.topic}", look)


def _check(wrapper: WrapperFile, file: Path) -> None:
    """Check that the protocol has what the file demands.

    Raises:
        ConfigError: It does not.
    """
    part = wrapper.program
    if part is None:
        return
    for row in wrapper.requests:
        if part.codec is Codec.ACTS and row.name not in acts.REQUESTS:
            known = ", ".join(acts.REQUESTS)
            raise ConfigError(f"{file}: ACTS has no request {row.name!r}; it has {known}")
        if part.codec is Codec.LINES and not row.send:
            raise ConfigError(f"{file}: request {row.name} needs `send`, the line that says it")
    if part.codec is Codec.ACTS and part.version not in acts.VERSIONS:
        known = ", ".join(filter(None, acts.VERSIONS))
        raise ConfigError(f"{file}: there is no version {part.version!r} of ACTS; there are {known}")


def _codec_of(wrapper: WrapperFile) -> ProgramCodec:
    """Return the protocol for one run."""
    if wrapper.program is None:
        return FramesCodec()
    match wrapper.program.codec:
        case Codec.ACTS:
            return acts.ActsCodec(wrapper.program.version)
        case Codec.JSON:
            return JsonLinesCodec()
        case Codec.LINES:
            return LinesCodec(wrapper.requests, wrapper.results)


def _as_request(row: FunctionRow) -> RequestRow:
    """Return a function as a request: its outputs are no arguments."""
    takes = {each.name: _kind(each) for each in row.arguments if each.kind != "out"}
    return RequestRow(name=row.name, takes=takes, defaults=row.defaults, within_s=row.within_s)


def _kind(argument: FunctionArgument) -> ArgumentKind:
    return C_KINDS.get(argument.kind, ArgumentKind.INTEGER)


def _bytes(name: str, value: str) -> bytes:
    try:
        return base64.b64decode(value, validate=True)
    except (binascii.Error, ValueError) as error:
        raise Refused(f"{name} must be base64: {error}") from error


def _without_bytes(value: Mapping[str, Any]) -> dict[str, Any]:
    """Return values for JSON: bytes become base64."""
    return {key: base64.b64encode(each).decode() if isinstance(each, bytes) else each for key, each in value.items()}


class _PicturesNotPossible(RuntimeError):
    """OpenCV is missing, or these bytes are no picture."""


def _pixels(picture: bytes, colours: Colours) -> dict[str, Any]:
    """Return arguments for a function: `image` (bytes, row by row from the top left), `width` and `height` in pixels.

    Raises:
        _PicturesNotPossible: OpenCV is missing, or these bytes are no picture.
    """
    cv2, numpy = _opencv()
    how = cv2.IMREAD_GRAYSCALE if colours is Colours.GREY else cv2.IMREAD_COLOR
    image = cv2.imdecode(numpy.frombuffer(picture, numpy.uint8), how) if picture else None
    if image is None:
        raise _PicturesNotPossible(f"{len(picture)} bytes are no picture that OpenCV can read")
    if colours is Colours.RGB:
        image = cv2.cvtColor(image, cv2.COLOR_BGR2RGB)
    return {"image": image.tobytes(), "width": image.shape[1], "height": image.shape[0]}


def _compressed(image: bytes, width: int, height: int) -> bytes:
    """Return a JPEG picture of pixels, grey or in colour by their number.

    Raises:
        _PicturesNotPossible: OpenCV is missing, or there are not as many pixels as there should be.
    """
    cv2, numpy = _opencv()
    channels = len(image) // (width * height) if width * height else 0
    if channels not in (1, 3) or len(image) != width * height * channels:
        raise _PicturesNotPossible(f"{len(image)} bytes are no picture of {width} by {height}, grey or in colour")
    array = numpy.frombuffer(image, numpy.uint8).reshape((height, width, channels))
    if channels == 3:
        array = cv2.cvtColor(array, cv2.COLOR_RGB2BGR)
    _, coded = cv2.imencode(".jpg", array, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return bytes(coded)


def _opencv() -> tuple[Any, Any]:
    if missing("vision"):
        raise _PicturesNotPossible(needs("a wrapper with pictures", "vision"))
    import cv2  # late: only wrappers with pictures need it
    import numpy

    return cv2, numpy


KINDS: Mapping[ArgumentKind, type] = {
    ArgumentKind.NUMBER: float,
    ArgumentKind.INTEGER: int,
    ArgumentKind.TEXT: str,
    ArgumentKind.BOOLEAN: bool,
    ArgumentKind.BYTES: str,
}
