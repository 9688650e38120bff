"""What a person writes to make an agent of a program or a library: one TOML file."""

import re
import string
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any, Self

from configs import ConfigError, build, find, read


class Codec(StrEnum):
    """The language of a program: lines of text, JSON objects a line each, or ACTS's colour protocol."""

    LINES = "lines"
    JSON = "json"
    ACTS = "acts"


class ArgumentKind(StrEnum):
    """What an argument of a request is."""

    NUMBER = "number"
    INTEGER = "integer"
    TEXT = "text"
    BOOLEAN = "boolean"
    BYTES = "bytes"  # base64 in a request


class Colours(StrEnum):
    """How a picture is handed to a function: one byte a pixel, or three (red, green, blue)."""

    GREY = "grey"
    RGB = "rgb"


@dataclass(frozen=True, slots=True)
class _ProgramPart:
    """An executable, a server, or both.

    command: what to start; a path with a slash is relative to the file. Without it the server is somebody else's.
    address: HOST:PORT where it listens; without it, it talks on its standard streams.
    codec: its language. version: of the language, where there are several (ACTS: "1.0", "1.2", "2.0").
    ready_within_s: after its start it must be there, or be listening, in so many seconds.
    """

    command: tuple[str, ...] = ()
    address: str = ""
    codec: Codec = Codec.LINES
    version: str = ""
    ready_within_s: float = 10.0

    def __post_init__(self) -> None:
        if not self.command and not self.address:
            raise ValueError("program needs a command to start, the address of a server, or both")
        if self.address and not re.fullmatch(r".+:\d{1,5}", self.address):
            raise ValueError(f"program.address must be HOST:PORT, not {self.address!r}")
        if self.ready_within_s <= 0.0:
            raise ValueError("program.ready_within_s must be above 0")


@dataclass(frozen=True, slots=True)
class _LibraryPart:
    """A shared library; its functions are called in a process of their own, which a crash may end. file: its path,
    relative to the wrapper's file where it has a slash, else as the system finds it."""

    file: str


@dataclass(frozen=True, slots=True)
class RequestRow:
    """A request that the program serves.

    takes: its arguments and their kinds. defaults: of those that may be left out.
    send: in the language of lines, what is said: `SPEED {value}`; elsewhere left out.
    answer: in the language of lines, a regular expression of the line that answers; its named groups are the result.
    Without it nothing is waited for. error: of the line that says no; its group `why` says why.
    within_s: when no answer came by then, the program is taken for broken and started again.
    """

    name: str
    takes: Mapping[str, ArgumentKind] = field(default_factory=dict)
    defaults: Mapping[str, Any] = field(default_factory=dict)
    send: str = ""
    answer: str = ""
    error: str = ""
    within_s: float = 5.0

    def __post_init__(self) -> None:
        used = {name for _, name, _, _ in string.Formatter().parse(self.send) if name is not None}
        if strange := sorted(used - set(self.takes)):
            raise ValueError(f"request {self.name}: send names {strange[0]!r}, which it does not take")
        if strange := sorted(set(self.defaults) - set(self.takes)):
            raise ValueError(f"request {self.name}: there is a default for {strange[0]!r}, which it does not take")
        for expression in (self.answer, self.error):
            _check_expression(f"request {self.name}", expression)


@dataclass(frozen=True, slots=True)
class ResultRow:
    """What the agent publishes: lines that come unasked and fit `line`, or the answer of a request every so often."""

    line: str = ""
    request: str = ""
    every_s: float = 0.0

    def __post_init__(self) -> None:
        _check_expression("results", self.line)
        if bool(self.line) == bool(self.request) or bool(self.request) != (self.every_s > 0.0):
            raise ValueError("a result is either a line that comes unasked, or a request with every_s above 0")


@dataclass(frozen=True, slots=True)
class FunctionArgument:
    """One argument of a C function.

    kind: int8 … uint64, float, double, text (char *), bytes (const uint8_t *), or out (uint8_t *, for results).
    size: of `out`, in bytes: an argument's name for as many as that one has, or a product such as `width*height*3`.
    """

    name: str
    kind: str
    size: str = ""


@dataclass(frozen=True, slots=True)
class FunctionRow:
    """A request that a C function serves. symbol: its name in the library, if it is another. returns: its type, as
    of an argument, or void. fails_below: a return value below this one is a failure, named in words by `why`."""

    name: str
    arguments: tuple[FunctionArgument, ...] = ()
    symbol: str = ""
    returns: str = "int32"
    defaults: Mapping[str, Any] = field(default_factory=dict)
    fails_below: int | None = None
    why: str = "the function failed"
    within_s: float = 5.0


@dataclass(frozen=True, slots=True)
class PictureRow:
    """Each picture of the robot's camera goes through a function that takes image, width and height.

    out: the argument that is the picture made of it, published under the agent's keys. topic: of the pictures.
    """

    function: str
    colours: Colours = Colours.GREY
    topic: str = "camera/image/compressed"
    out: str = ""


@dataclass(frozen=True, slots=True)
class WrapperFile:
    """The file. services, about: for the directory."""

    about: str = ""
    services: tuple[str, ...] = ()
    program: _ProgramPart | None = None
    library: _LibraryPart | None = None
    requests: tuple[RequestRow, ...] = ()
    results: tuple[ResultRow, ...] = ()
    functions: tuple[FunctionRow, ...] = ()
    pictures: tuple[PictureRow, ...] = ()

    @classmethod
    def load(cls, name: str) -> tuple[Self, Path]:
        """Read a wrapper's file; also gives where it is, since paths in it are relative to it.

        Args:
            name: Of a file in `configs/wrappers`, or a path.
        Raises:
            ConfigError: There is none, or it has an error; the message names it.
        """
        path = find("wrappers", name)
        try:
            wrapper = build(cls, read(path), str(path))
        except ConfigError:
            raise
        except ValueError as error:  # of values that no type rules out
            raise ConfigError(f"{path}: {error}") from error
        library = wrapper.library.file if wrapper.library else ""
        if "/" in library and not (path.parent / library).exists():
            raise ConfigError(f"{path}: there is no library {path.parent / library}; a path is relative to this file")
        return wrapper, path.resolve()

    def __post_init__(self) -> None:
        if (self.program is None) == (self.library is None):
            raise ValueError("a wrapper has either a [program] or a [library]")
        if self.library is None and (self.functions or self.pictures):
            raise ValueError("functions and pictures belong to a [library]")
        if self.library is not None and (self.requests or not self.functions):
            raise ValueError("a [library] has [[functions]], and no [[requests]]")
        names = [*(row.name for row in self.requests), *(row.name for row in self.functions)]
        if doubled := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"there are two requests {doubled[0]!r}")
        for asked in (*(row.request for row in self.results if row.request), *(row.function for row in self.pictures)):
            if asked not in names:
                raise ValueError(f"there is no request {asked!r}; there are {', '.join(names) or 'none'}")


def _check_expression(where: str, expression: str) -> None:
    try:
        re.compile(expression)
    except re.error as error:
        raise ValueError(f"{where}: {expression!r} is no regular expression: {error}") from error
