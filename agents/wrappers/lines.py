"""Protocols of lines: text for programs that people use as well, or one JSON object a line."""

import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from agents.wrappers.codec import Answered, Event, NonsenseHeard, ProgramCodec, RequestFailed, Told
from agents.wrappers.wrapper_file import RequestRow, ResultRow
from bus.validation import printable

LONGEST_LINE = 64 * 1024  # bytes


class _Splitter:
    """Splits portions of bytes into lines."""

    def __init__(self) -> None:
        self._rest = b""

    def lines(self, data: bytes) -> list[str]:
        *whole, self._rest = (self._rest + data).split(b"\n")
        if len(self._rest) > LONGEST_LINE:
            raise NonsenseHeard(f"it says more than {LONGEST_LINE} bytes without an end of line")
        return [printable(line.decode("utf-8", "replace").rstrip("\r")) for line in whole]


class LinesCodec(ProgramCodec):
    """Lines of text, which the wrapper's file defines."""

    def __init__(self, requests: Sequence[RequestRow], results: Sequence[ResultRow]) -> None:
        self._requests = {row.name: row for row in requests}
        self._results = [re.compile(row.line) for row in results if row.line]
        self._splitter = _Splitter()
        self._under_way: RequestRow | None = None

    def ask(self, name: str, arguments: Mapping[str, Any]) -> bytes:
        """The request's line, with the arguments in it."""
        row = self._requests[name]
        for key, value in arguments.items():
            if isinstance(value, str) and not value.isprintable():
                raise ValueError(f"{key} holds what no line can carry, such as an end of line; leave it out")
        said = row.send.format_map({key: _said(value) for key, value in arguments.items()})
        self._under_way = row if self.wants_answer(name) else None
        return said.encode() + b"\n"

    def receive(self, data: bytes) -> list[Event]:
        """Decode each line: an answer, a refusal or a result; others are ignored."""
        return [event for line in self._splitter.lines(data) if (event := self._judged(line)) is not None]

    def wants_answer(self, name: str) -> bool:
        """Whether the file defines an answer."""
        return bool(self._requests[name].answer)

    def _judged(self, line: str) -> Event | None:
        row = self._under_way
        if row is not None:
            if answer := re.fullmatch(row.answer, line):
                self._under_way = None
                return Answered(_values(answer))
            if row.error and (no := re.fullmatch(row.error, line)):
                self._under_way = None
                return RequestFailed(no.groupdict().get("why") or line)
        for expression in self._results:
            if told := expression.fullmatch(line):
                return Told(_values(told))
        return None


class JsonLinesCodec(ProgramCodec):
    """`{"request": name, …arguments}` out; `{"answer": …}`, `{"error": why}` and `{"result": …}` in."""

    def __init__(self) -> None:
        self._splitter = _Splitter()
        self._is_under_way = False

    def ask(self, name: str, arguments: Mapping[str, Any]) -> bytes:
        """Encode one object on one line."""
        if "request" in arguments:
            raise ValueError("an argument cannot be called 'request' in this language; call it otherwise")
        self._is_under_way = True
        return json.dumps({"request": name, **arguments}).encode() + b"\n"

    def receive(self, data: bytes) -> list[Event]:
        """Decode each object."""
        return [event for line in self._splitter.lines(data) if line and (event := self._judged(line)) is not None]

    def _judged(self, line: str) -> Event | None:
        try:
            match json.loads(line):
                case {"result": dict(value)}:
                    return Told(value)
                case {"answer": dict(value)} if self._is_under_way:
                    self._is_under_way = False
                    return Answered(value)
                case {"error": str(why)} if self._is_under_way:
                    self._is_under_way = False
                    return RequestFailed(why)
        except ValueError as error:
            raise NonsenseHeard(f"it says {line[:60]!r}, which is no JSON") from error
        raise NonsenseHeard(f'it says {line[:60]!r}, which is no {{"answer": …}}, {{"error": …}} or {{"result": …}}')


def _said(value: Any) -> str:
    return json.dumps(value) if isinstance(value, bool) else str(value)


def _values(found: re.Match[str]) -> dict[str, Any]:
    """Return the named groups, as numbers where they are written like numbers."""
    return {name: _value(text) for name, text in found.groupdict().items() if text is not None}


def _value(text: str) -> Any:
    for kind in (int, float):
        try:
            number = kind(text)
        except ValueError:
            continue  # no such number
        return number if math.isfinite(number) else text
    return text
