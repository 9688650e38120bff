"""Messages of FIPA's agent communication language (ACL), in JSON.

The performatives are those of FIPA SC00037J (Communicative Act Library), the fields those of FIPA SC00061G (ACL
Message Structure), with an underscore where FIPA has a hyphen. On the bus a message is one JSON object; an empty field
is left out, names are written `base@happy`.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any, Self

from agents.platform.errors import AclError, NameNotValid
from agents.platform.names import AgentName
from bus.errors import MessageError
from bus.payload import decode_json
from bus.validation import check_line, check_value

ONTOLOGY = "acromovi"
MAX_SIZE = 256 * 1024  # bytes of one message; pictures and streams are not sent by ACL
MAX_DEPTH = 32  # levels of lists and objects in one message
LONGEST_FIELD = 1000  # characters of a text field, such as the conversation id, except the content


class Performative(StrEnum):
    """The type of a message: FIPA's communicative acts."""

    ACCEPT_PROPOSAL = "accept-proposal"
    AGREE = "agree"
    CANCEL = "cancel"
    CFP = "cfp"
    CONFIRM = "confirm"
    DISCONFIRM = "disconfirm"
    FAILURE = "failure"
    INFORM = "inform"
    INFORM_IF = "inform-if"
    INFORM_REF = "inform-ref"
    NOT_UNDERSTOOD = "not-understood"
    PROPAGATE = "propagate"
    PROPOSE = "propose"
    PROXY = "proxy"
    QUERY_IF = "query-if"
    QUERY_REF = "query-ref"
    REFUSE = "refuse"
    REJECT_PROPOSAL = "reject-proposal"
    REQUEST = "request"
    REQUEST_WHEN = "request-when"
    REQUEST_WHENEVER = "request-whenever"
    SUBSCRIBE = "subscribe"


@dataclass(frozen=True, slots=True, kw_only=True)
class AclMessage:
    """One message.

    performative: its type.
    sender, receivers: names of agents. FIPA permits anonymous senders; here a sender is required.
    reply_to: the agents to which replies go, if not to the sender.
    content: any JSON value; a tuple arrives as a list.
    language, encoding, ontology: how to read the content.
    protocol, conversation_id: the conversation it belongs to, `fipa-request` for example.
    reply_with, in_reply_to: the label that a reply must carry, and the label of the message it replies to.
    reply_by: the time until which a reply is of use, s since 1970 on the sender's wall clock. Clocks of machines differ
        and step, so an initiator measures its timeout on its own steady clock, and sends this for logs and records.
    x_heartbeat: key of the sender's heartbeat while the conversation is open; a parameter that FIPA does not define,
        which the `X` marks as FIPA demands.
    """

    performative: Performative
    sender: AgentName
    receivers: tuple[AgentName, ...] = ()
    reply_to: tuple[AgentName, ...] = ()
    content: Any = None
    language: str = ""
    encoding: str = ""
    ontology: str = ""
    protocol: str = ""
    conversation_id: str = ""
    reply_with: str = ""
    in_reply_to: str = ""
    reply_by: float | None = None
    x_heartbeat: str = ""

    @property
    def why(self) -> str:
        """The reason in a refusal or failure, as one sentence."""
        match self.content:
            case {"why": str(why)} if why.strip():
                return why
            case None | {"why": str()}:
                return "no reason is given"
        return str(self.content)

    def reply(self, performative: Performative, content: Any = None, sender: AgentName | None = None) -> Self:
        """Return a reply to this message, with the fields that FIPA demands.

        It goes to `reply_to` if that is given, else to the sender, in the same conversation, protocol, ontology,
        language and encoding, and carries the label of `reply_with`.

        Args:
            performative: The type of the reply.
            content: Any JSON value.
            sender: The agent that replies; by default the receiver, if there is just one.
        Raises:
            AclError: The message has several receivers, and `sender` is not given.
        """
        if sender is None and len(self.receivers) != 1:
            raise AclError(f"a message to {len(self.receivers)} receivers does not say who answers it; name the sender")
        return type(self)(
            performative=performative,
            sender=sender or self.receivers[0],
            receivers=self.reply_to or (self.sender,),
            content=content,
            language=self.language,
            encoding=self.encoding,
            ontology=self.ontology,
            protocol=self.protocol,
            conversation_id=self.conversation_id,
            in_reply_to=self.reply_with,
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the message as a JSON object.

        Raises:
            AclError: A field is of the wrong type, or the message is too large or too deep.
        """
        return _json_object(self.encode())

    def encode(self) -> bytes:
        """Return the message as JSON.

        Raises:
            AclError: A field is of the wrong type, or the message is too large or too deep.
        """
        written = {name: _WRITERS[name](name, getattr(self, name)) for name in _WRITERS}
        said = {name: value for name, value in written.items() if value not in (None, "", [])}
        if self.content is not None:
            _check_value(self.content, MAX_DEPTH - 1)
            said["content"] = self.content
        try:
            payload = json.dumps(said, allow_nan=False, separators=(",", ":")).encode()
        except (TypeError, ValueError, RecursionError) as err:
            raise AclError(f"the content cannot be written as JSON: {err}") from err
        if len(payload) > MAX_SIZE:
            raise AclError(f"a message of {len(payload)} bytes is too large; at most {MAX_SIZE} are carried")
        return payload

    @classmethod
    def decode(cls, payload: bytes) -> Self:
        """Read a message.

        Raises:
            AclError: It is too large, too deep, no JSON object, or no message: a field is unknown, missing or wrong.
        """
        return cls._of(_json_object(payload))

    @classmethod
    def from_dict(cls, value: Mapping[str, Any]) -> Self:
        """Read a message that is a JSON object already.

        Raises:
            AclError: It is too large, too deep, no JSON, or a field is unknown, missing or wrong.
        """
        _check_value(value)
        return cls._of(value)

    @classmethod
    def _of(cls, value: Mapping[str, Any]) -> Self:
        for name in value:
            if name not in _READERS:
                raise AclError(f"{name!r} is no field of a message; the fields are {', '.join(_READERS)}")
        for name in ("performative", "sender"):
            if name not in value:
                raise AclError(f"a message needs the field {name!r}")
        return cls(**{name: _READERS[name](name, given) for name, given in value.items()})


def _json_object(payload: bytes) -> dict[str, Any]:
    """Read a JSON object from any program.

    Raises:
        AclError: It is too large, too deep, no JSON object, or holds a number or text that `bus.validation` refuses.
    """
    if not payload:
        raise AclError("a message is a JSON object, not 0 bytes")
    try:
        value = decode_json(payload, MAX_SIZE)
    except MessageError as err:
        raise AclError(str(err)) from err
    _check_value(value)
    return value


def _check_value(value: Any, depth: int = MAX_DEPTH) -> None:
    """Refuse a value that is nested too deep, or that a message must not contain.

    Raises:
        AclError: It is too deep or too large, or holds a number or text that `bus.validation` refuses.
    """
    try:
        check_value(value, depth, MAX_SIZE)
    except MessageError as err:
        raise AclError(str(err)) from err


def _kind(value: Any) -> str:
    return "nothing" if value is None else f"a {type(value).__name__}"


def _wrong(name: str, expected: str, value: Any) -> AclError:
    return AclError(f"the field {name!r} is {expected}, not {_kind(value)}")


def _read_performative(name: str, value: Any) -> Performative:
    if not isinstance(value, str):
        raise _wrong(name, "a performative", value)
    try:
        return Performative(value)
    except ValueError as err:
        raise AclError(f"{value[:40]!r} is no performative of FIPA") from err


def _read_agent(name: str, value: Any) -> AgentName:
    if not isinstance(value, str):
        raise _wrong(name, "an agent's name", value)
    try:
        return AgentName.parse(value)
    except NameNotValid as err:
        raise AclError(f"the field {name!r} is not an agent's name: {err}") from err


def _read_agents(name: str, value: Any) -> tuple[AgentName, ...]:
    if not isinstance(value, list):
        raise _wrong(name, "a list of agents' names", value)
    return tuple(_read_agent(name, item) for item in value)


def _read_text(name: str, value: Any) -> str:
    if not isinstance(value, str):
        raise _wrong(name, "a text", value)
    try:
        check_line(value, f"the field {name!r}", LONGEST_FIELD)
    except MessageError as err:
        raise AclError(str(err)) from err
    return value


def _read_time(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _wrong(name, "a time in s", value)
    try:
        return float(value)
    except OverflowError as err:
        raise AclError(f"the field {name!r} is no time: it is too large") from err


def _read_anything(name: str, value: Any) -> Any:
    return value


def _write_agent(name: str, value: Any) -> str:
    if not isinstance(value, AgentName):
        raise _wrong(name, "an AgentName", value)
    return str(value)


def _write_agents(name: str, value: Any) -> list[str]:
    if not isinstance(value, tuple):
        raise _wrong(name, "a tuple of AgentNames", value)
    return [_write_agent(name, item) for item in value]


def _write_time(name: str, value: Any) -> float | None:
    return None if value is None else _read_time(name, value)


_SPECIAL: dict[str, tuple[Callable[[str, Any], Any], Callable[[str, Any], Any]]] = {
    "performative": (_read_performative, _read_performative),
    "sender": (_read_agent, _write_agent),
    "receivers": (_read_agents, _write_agents),
    "reply_to": (_read_agents, _write_agents),
    "content": (_read_anything, _read_anything),
    "reply_by": (_read_time, _write_time),
}
_TEXT = (_read_text, _read_text)
_READERS = {field.name: _SPECIAL.get(field.name, _TEXT)[0] for field in fields(AclMessage)}
_WRITERS = {field.name: _SPECIAL.get(field.name, _TEXT)[1] for field in fields(AclMessage) if field.name != "content"}
