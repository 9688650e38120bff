"""Messages captured on a container's stream `said`: sender, receiver and content, or unreadable data.

A record is `{"time": s since 1970, "container": name, "message": {...}}`, as `Container.trace` puts it.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

from agents.platform.acl import AclMessage, Performative
from agents.platform.errors import AclError, NameNotValid
from agents.platform.names import AgentName, ContainerName
from bus import MessageError, Sample
from bus.payload import decode_json

ALL_THAT_IS_SAID = "*/containers/*/said"
SHORT_ID = 6  # characters of a conversation's id that people see
LONGEST_TIME = 1e11  # s since 1970, about the year 5138; no calendar shows much more
NO = (Performative.REFUSE, Performative.FAILURE, Performative.NOT_UNDERSTOOD)


@dataclass(frozen=True, slots=True)
class CapturedMessage:
    """One message.

    time: when it was said, s since 1970 on the clock of its container's machine.
    container: where its sender lives.
    """

    time: float
    container: str
    message: AclMessage

    @property
    def is_no(self) -> bool:
        """Whether it says that something is not done."""
        return self.message.performative in NO

    def record(self) -> dict[str, Any]:
        """The message as one JSON object."""
        return {"time": self.time, "container": self.container, "message": self.message.to_dict()}


@dataclass(frozen=True, slots=True)
class Unreadable:
    """Data on the stream of a container that is not a message.

    time: when it came, s since 1970 here.
    container: whose stream it is.
    size: bytes.
    """

    time: float
    container: str
    size: int
    why: str

    def record(self) -> dict[str, Any]:
        """What is known of it as one JSON object."""
        return {
            "time": self.time,
            "container": self.container,
            "message": None,
            "bytes": self.size,
            "error": self.why,
        }


Heard = CapturedMessage | Unreadable


def read(sample: Sample, now: float) -> Heard:
    """What a sample is, which may come from anyone; `now` is s since 1970."""
    try:
        container = ContainerName.of_key(sample.key).name
    except NameNotValid:
        container = sample.key
    try:
        return _read(decode_json(sample.payload), container)
    except (AclError, MessageError) as err:
        return Unreadable(now, container, len(sample.payload), str(err))


def _read(record: dict[str, Any], container: str) -> CapturedMessage:
    match record:
        case {"time": int() | float() as time, "message": dict(message)} if not isinstance(time, bool):
            if 0 <= time < LONGEST_TIME:  # what is no number is neither
                return CapturedMessage(float(time), container, AclMessage.from_dict(message))
    raise AclError("it is no record of what was said: it needs 'time', in s since 1970, and 'message'")


def wanted(patterns: Sequence[str], conversation: str | None) -> Callable[[Heard], bool]:
    """Filter of messages. Unreadable data passes only a filter without conditions.

    Args:
        patterns: Agents of which one must say or hear it: `base@happy`, `app-*`, `*@happy`; of any when there are none.
            A pattern without an `@` is that of the local part of a name.
        conversation: The beginning of the conversation's id.
    """

    def is_wanted(heard: Heard) -> bool:
        if isinstance(heard, Unreadable):
            return not patterns and conversation is None
        message = heard.message
        if conversation is not None and not message.conversation_id.startswith(conversation):
            return False
        return not patterns or any(matches(name, patterns) for name in (message.sender, *message.receivers))

    return is_wanted


def matches(name: AgentName, patterns: Sequence[str]) -> bool:
    """Whether an agent's name is one of these."""
    return any(fnmatchcase(str(name) if "@" in pattern else name.local, pattern) for pattern in patterns)


def brief(content: Any, longest: int) -> str:
    """A message's content for people, on one line of at most so many characters."""
    match content:
        case None:
            text = ""
        case {"action": str(action), "arguments": dict(arguments), **rest} if not rest:
            text = " ".join([action, *(f"{name}={_json(value)}" for name, value in arguments.items())])
        case {"why": str(why), **rest} if not rest:
            text = why
        case _:
            text = _json(content)
    return shortened(text, longest)


def shortened(text: str, longest: int) -> str:
    """A text on one line, cut where it is too long; what would move a terminal's cursor is left blank."""
    shown = "".join(each if each.isprintable() else " " for each in text[: longest + 1])
    return shown if len(shown) <= longest else shown[: longest - 1] + "…"


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)
