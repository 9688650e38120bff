"""FIPA's request protocol (SC00026H), both ends: request, then refuse, or agree and then inform or failure.

A request is one query on the bus, and its replies are the conversation. Its content is
`{"action": name, "arguments": {...}}`; that of an inform is what the action returned, that of every no is
`{"why": sentence}`.
"""

import asyncio
import contextlib
import inspect
import uuid
from collections.abc import Callable, Mapping
from contextlib import aclosing
from contextvars import ContextVar
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, get_type_hints

from agents.platform.acl import AclMessage, Performative
from agents.platform.errors import AclError, RequestNotDone
from agents.platform.names import AgentName
from agents.platform.talk import replies
from bus import Bus, BusUnavailable, Conversation, NoAnswer, Refused, TimedOut

PROTOCOL = "fipa-request"
ONTOLOGY = "acromovi"
LANGUAGE = "json"
Trace = Callable[[AclMessage], None]
LONGEST_REASON = 1000  # characters; an exception may quote anything


class Ending(StrEnum):
    """How a request ended."""

    DONE = "done"
    REFUSED = "refused"  # the other said no, and has done nothing
    FAILED = "failed"  # it tried, in vain
    NOT_UNDERSTOOD = "not-understood"  # one of the two does not understand the other
    TIMED_OUT = "timed out"  # no end in time; what was asked may still be done
    DIED = "peer died"  # nobody of this name is there, or not any more; what was asked may have been done


@dataclass(frozen=True, slots=True)
class Outcome:
    """The end of a request.

    result: what the action returned; None unless done.
    why: the reason in one sentence; empty if done.
    agreed: whether the other had agreed before.
    """

    ending: Ending
    result: Any = None
    why: str = ""
    agreed: bool = False

    @property
    def is_done(self) -> bool:
        """Whether it was done."""
        return self.ending is Ending.DONE

    def value(self) -> Any:
        """The result.

        Raises:
            RequestNotDone: It was not done; says how it ended and why.
        """
        if not self.is_done:
            raise RequestNotDone(f"{self.ending}: {self.why}")
        return self.result


async def ask_to(
    bus: Bus,
    trace: Trace,
    me: AgentName,
    peer: AgentName,
    action: str,
    arguments: Mapping[str, Any],
    within: float,
    reply_by: float,
) -> Outcome:
    """Ask another agent to do something, and wait for the end.

    Args:
        bus: Where both are.
        trace: Told of what is said.
        me: Who asks.
        peer: Who is asked.
        action: What to do.
        arguments: JSON values by name.
        within: s of the loop's time to wait for the end.
        reply_by: The same on the wall clock, for the message.
    Raises:
        AclError: The arguments have no JSON form, or are too many.
        BusUnavailable: The bus is closed.
    """
    label = uuid.uuid4().hex
    message = AclMessage(
        performative=Performative.REQUEST,
        sender=me,
        receivers=(peer,),
        content={"action": action, "arguments": dict(arguments)},
        language=LANGUAGE,
        ontology=ONTOLOGY,
        protocol=PROTOCOL,
        conversation_id=label,
        reply_with=label,
        reply_by=reply_by,
    )
    agreed = False
    late = Outcome(Ending.TIMED_OUT, why=f"{peer} has not come to an end within {within:g} s")
    written = message.to_dict()
    trace(message)
    try:
        async with aclosing(replies(bus, peer.acl_key, written, within)) as heard:
            async for answer in heard:
                outcome = _judged(message, answer.value, agreed)
                if outcome is not None:
                    return outcome
                agreed = True
    except TimedOut:
        return _with(late, agreed)
    except NoAnswer:
        return Outcome(Ending.DIED, why=f"nobody answers as {peer}")
    except TimeoutError:
        return _with(late, agreed)
    except Refused as err:
        return Outcome(Ending.FAILED, why=f"{peer} answers with an error: {err.why}", agreed=agreed)
    return Outcome(Ending.DIED, why=f"{peer} has gone before the end", agreed=agreed)


def _with(outcome: Outcome, agreed: bool) -> Outcome:
    return Outcome(outcome.ending, outcome.result, outcome.why, agreed)


_ENDINGS = {
    Performative.REFUSE: Ending.REFUSED,
    Performative.FAILURE: Ending.FAILED,
    Performative.NOT_UNDERSTOOD: Ending.NOT_UNDERSTOOD,
}


def _judged(request: AclMessage, value: Mapping[str, Any], agreed: bool) -> Outcome | None:
    """What one reply means: the outcome, or None for the agreement that comes before it."""
    (peer,) = request.receivers
    try:
        reply = AclMessage.from_dict(value)
    except AclError as err:
        return Outcome(Ending.NOT_UNDERSTOOD, why=f"{peer} answers nonsense: {err}", agreed=agreed)
    is_ours = reply.conversation_id == request.conversation_id and reply.sender == peer
    if reply.performative is Performative.AGREE and is_ours and not agreed:
        return None
    if reply.performative is Performative.INFORM and is_ours:
        return Outcome(Ending.DONE, reply.content, agreed=agreed)
    # Who has not understood a request may not even have read of which conversation it was.
    if reply.performative in _ENDINGS and (is_ours or reply.performative is Performative.NOT_UNDERSTOOD):
        return Outcome(_ENDINGS[reply.performative], why=why_of(reply), agreed=agreed)
    why = f"{peer} answers nonsense: {reply.performative} has no place in this conversation"
    return Outcome(Ending.NOT_UNDERSTOOD, why=why, agreed=agreed)


def why_of(message: AclMessage) -> str:
    """The reason that a no carries, in one sentence."""
    match message.content:
        case {"why": str(why)}:
            return why
        case None:
            return "no reason is given"
    return str(message.content)


class NotUnderstood(Exception):
    """A request cannot be read: an unknown action, or arguments that do not fit."""


class Handler:
    """A function that does what a request asks for, and the arguments it takes."""

    def __init__(self, name: str, function: Callable[..., Any], agrees_itself: bool) -> None:
        self.name = name
        self.function = function
        self.agrees_itself = agrees_itself
        self._signature = inspect.signature(function)
        self._hints = get_type_hints(function)

    def check(self, arguments: Mapping[str, Any]) -> None:
        """Refuse arguments that the function does not take.

        Raises:
            NotUnderstood: One is unknown, missing or of the wrong type.
        """
        try:
            self._signature.bind(**arguments)
        except TypeError as err:
            raise NotUnderstood(f"{self.name} does not take these arguments: {err}") from err
        for name, value in arguments.items():
            expected = self._hints.get(name)
            if isinstance(expected, type) and expected in _PLAIN and not _PLAIN[expected](value):
                raise NotUnderstood(f"{self.name} takes {name} as {expected.__name__}, not {type(value).__name__}")


_PLAIN: dict[Any, Callable[[Any], bool]] = {
    bool: lambda value: isinstance(value, bool),
    int: lambda value: isinstance(value, int) and not isinstance(value, bool),
    float: lambda value: isinstance(value, int | float) and not isinstance(value, bool),
    str: lambda value: isinstance(value, str),
    list: lambda value: isinstance(value, list),
    dict: lambda value: isinstance(value, dict),
}


class Serving:
    """One request that is being answered. All of it happens in the agent's event loop."""

    def __init__(self, me: AgentName, message: AclMessage, conversation: Conversation, trace: Trace) -> None:
        self.message = message
        self._me = me
        self._conversation = conversation
        self._trace = trace
        self._has_agreed = False

    def agree(self) -> None:
        """Say that it will be done; once."""
        if not self._has_agreed:
            self._has_agreed = True
            self._say(Performative.AGREE, None)

    async def run(self, handler: Handler, arguments: Mapping[str, Any]) -> Exception | None:
        """Do it, and say how it went; what the handler raised beyond a refusal is returned, to be reported.

        What it raises as `Refused` before it first waits for something is a refusal; later, after it has agreed, it is
        a failure. A handler that agrees itself may refuse until it has called `agree`.
        """
        token = _SERVING.set(self)
        try:
            work = asyncio.ensure_future(_called(handler.function, arguments))
        finally:
            _SERVING.reset(token)
        try:
            await asyncio.sleep(0)  # the handler begins first, since its task was made first
            if not work.done() and not handler.agrees_itself:
                self.agree()
            result = await work
            self.agree()
            self._say(Performative.INFORM, result)
        except asyncio.CancelledError:
            work.cancel()
            await asyncio.gather(work, return_exceptions=True)
            self._say_no(f"{self._me} has ended")
            raise
        except Refused as err:
            self._say_no(err.why)
        except Exception as err:
            why = f"{handler.name} failed with {type(err).__name__}: {err}"
            self._say(Performative.FAILURE, {"why": why[:LONGEST_REASON]})
            return err
        finally:
            self.close()
        return None

    def turn_away(self, why: str) -> None:
        """Say no without having begun, and end the conversation."""
        self._say_no(why)
        self.close()

    def close(self) -> None:
        """End the conversation, if it has not ended."""
        self._conversation.close()

    def _say_no(self, why: str) -> None:
        self._say(Performative.FAILURE if self._has_agreed else Performative.REFUSE, {"why": why})

    def _say(self, performative: Performative, content: Any) -> None:
        reply = self.message.reply(performative, content, sender=self._me)
        written = reply.to_dict()
        self._trace(reply)
        with contextlib.suppress(BusUnavailable):  # the bus was closed meanwhile: nobody listens any more
            self._conversation.reply(written)


async def _called(function: Callable[..., Any], arguments: Mapping[str, Any]) -> Any:
    """Call it, whether or not it is a coroutine function."""
    result = function(**arguments)
    return await result if inspect.isawaitable(result) else result


_SERVING: ContextVar[Serving] = ContextVar("serving")


def agree() -> None:
    """Agree to the request that is being answered; for handlers that agree themselves.

    Raises:
        LookupError: No request is being answered.
    """
    _SERVING.get().agree()


def asker() -> AgentName:
    """Who asks for what is being done; for handlers that are not to do the same for everyone.

    Raises:
        LookupError: No request is being answered.
    """
    return _SERVING.get().message.sender


def read_request(message: AclMessage, handlers: Mapping[str, Handler]) -> tuple[Handler, dict[str, Any]]:
    """The handler that a request calls for, and its arguments.

    Raises:
        NotUnderstood: It is not one that any of the handlers can answer.
    """
    if message.performative is not Performative.REQUEST:
        raise NotUnderstood(f"{message.performative} begins no conversation that is known here")
    if message.protocol not in ("", PROTOCOL):
        raise NotUnderstood(f"the protocol {message.protocol!r} is not known here; {PROTOCOL} is")
    if message.ontology not in ("", ONTOLOGY):
        raise NotUnderstood(f"the ontology {message.ontology!r} is not known here; {ONTOLOGY} is")
    match message.content:
        case {"action": str(action), "arguments": dict(arguments)}:
            pass
        case {"action": str(action), **rest} if not rest:
            arguments = {}
        case _:
            raise NotUnderstood('a request\'s content is {"action": name, "arguments": {...}}')
    if action not in handlers:
        known = ", ".join(sorted(handlers)) or "none"
        raise NotUnderstood(f"there is no request {action!r} here; known: {known}")
    handlers[action].check(arguments)
    return handlers[action], arguments


def turn_away(
    me: AgentName,
    trace: Trace,
    message: AclMessage | None,
    performative: Performative,
    why: str,
    conversation: Conversation,
) -> None:
    """End a conversation with a no before anything was done; without a message when it could not be read."""
    no = (
        AclMessage(performative=performative, sender=me, protocol=PROTOCOL, content={"why": why})
        if message is None
        else message.reply(performative, {"why": why}, sender=me)
    )
    trace(no)
    with conversation:
        conversation.reply(no.to_dict())
