"""Notation of faults: `NAME[:key=value,...][@START[+DURATION]]`, for example `line-cut:robot=happy@5+10`."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

_FORM = "NAME[:key=value,...][@START[+DURATION]]"
_SPEC = re.compile(r"(?P<name>[^:@]*)(?::(?P<parameters>[^@]*))?(?:@(?P<when>.*))?", re.DOTALL)
_NUMBER = re.compile(r"(\d+(\.\d*)?|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
_WORD = re.compile(r"[a-z][a-z0-9-]*")
_TEXT = re.compile(r"[^,=@:\s]+")


class FaultError(ValueError):
    """The notation or the use of a fault is wrong; the message says what to write."""


@dataclass(frozen=True, slots=True)
class FaultSpec:
    """A parsed fault; whether it exists and takes these parameters is not checked yet.

    start: s of emulated time, from the start of the emulator or from the moment it was asked for.
    duration: s; None lasts until it is cleared.
    """

    name: str
    parameters: Mapping[str, str] = field(default_factory=dict)
    start: float = 0.0
    duration: float | None = None

    def __str__(self) -> str:
        parameters = ",".join(f"{key}={value}" for key, value in self.parameters.items())
        text = self.name + (f":{parameters}" if parameters else "")
        if self.start or self.duration is not None:
            text += f"@{self.start!r}"
        if self.duration is not None:
            text += f"+{self.duration!r}"
        return text


def parse_fault(text: str) -> FaultSpec:
    """Read a fault as it is written on the command line and in the control socket.

    Raises:
        FaultError: The text does not have the form; the message names the part that is wrong.
    """
    match = _SPEC.fullmatch(text)
    if match is None or not _WORD.fullmatch(match["name"]):
        raise FaultError(f"fault {text!r} has no name of small letters and hyphens; write {_FORM}")
    parameters = _parse_parameters(text, match["parameters"])
    start, duration = _parse_when(text, match["when"])
    return FaultSpec(match["name"], parameters, start, duration)


def _parse_parameters(text: str, written: str | None) -> dict[str, str]:
    parameters: dict[str, str] = {}
    for part in [] if written is None else written.split(","):
        key, equals, value = part.partition("=")
        if not equals or not _WORD.fullmatch(key) or not _TEXT.fullmatch(value):
            raise FaultError(f"fault {text!r}: {part!r} is not key=value; write {_FORM}")
        if key in parameters:
            raise FaultError(f"fault {text!r} gives {key!r} twice; give it once")
        parameters[key] = value
    return parameters


def _parse_when(text: str, written: str | None) -> tuple[float, float | None]:
    if written is None:
        return 0.0, None
    # A number may hold a plus sign of its own, as in 1e+3: the first split into two numbers is meant.
    if _NUMBER.fullmatch(written):
        return _seconds(text, written), None
    for plus in (at.start() for at in re.finditer(r"\+", written)):
        start, duration = written[:plus], written[plus + 1 :]
        if _NUMBER.fullmatch(start) and _NUMBER.fullmatch(duration):
            return _seconds(text, start), _seconds(text, duration)
    raise FaultError(f"fault {text!r}: {written!r} is not START or START+DURATION in seconds; write {_FORM}")


def _seconds(text: str, number: str) -> float:
    seconds = float(number)
    if not math.isfinite(seconds):
        raise FaultError(f"fault {text!r}: {number} s is beyond any run; give a smaller number")
    return seconds
