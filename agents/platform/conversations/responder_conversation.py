"""The responder's end of a conversation: it runs the handler and sends the replies."""

import asyncio
import contextlib
from collections.abc import Awaitable, Callable, Iterator
from contextvars import ContextVar
from typing import Any

from agents.platform.acl import AclMessage, Performative
from agents.platform.container.context import ContainerContext
from agents.platform.errors import in_words
from agents.platform.heartbeat import watched
from agents.platform.names import AgentName
from bus import BusUnavailable, Conversation, KeyNotValid, Refused
from bus.heartbeat import SILENCE, heartbeat_key
from bus.validation import sentence


class ResponderConversation:
    """One conversation that an agent answers, in the agent's event loop.

    accepted: set when the initiator has accepted a proposal. revised: further calls for proposals in the conversation.
    """

    def __init__(self, home: ContainerContext, me: AgentName, message: AclMessage, conversation: Conversation) -> None:
        self.message = message
        self.accepted = asyncio.Event()
        self.revised: asyncio.Queue[AclMessage] = asyncio.Queue()
        self._me = me
        self._conversation = conversation
        self._home = home
        self._has_agreed = False
        self._is_concluded = False
        self._task: asyncio.Task[Any] | None = None
        self._why_cancelled: str | None = None  # empty when the initiator is not to be told
        self._is_ending = False
        self._release: Callable[[], None] = lambda: None  # the initiator is watched no more

    @property
    def what(self) -> str:
        """What is done, and for whom, as text."""
        return f"the {self.message.performative} {self.action} of {self.message.sender}"

    @property
    def action(self) -> str:
        """The name of what is requested."""
        return str(self.message.content["action"])

    @property
    def has_agreed(self) -> bool:
        """Whether the agent is committed: an error from now on is a failure, not a refusal."""
        return self._has_agreed

    def works_in(self, task: "asyncio.Task[Any]") -> bool:
        """Whether it is answered in this task."""
        return self._task is task

    def agree(self) -> None:
        """Send agree, once."""
        if not self._has_agreed:
            self._has_agreed = True
            self.say(Performative.AGREE)

    def commit(self) -> None:
        """Be committed without sending agree: an error from now on is a failure, not a refusal."""
        self._has_agreed = True

    def conclude(self, performative: Performative, content: Any = None) -> None:
        """Send the last reply, in a protocol that ends neither with inform nor with a failure."""
        self._is_concluded = True
        self.say(performative, content)

    def say(self, performative: Performative, content: Any = None) -> None:
        """Send a reply to the initiator.

        Raises:
            AclError: The content has no JSON form, or is too large.
        """
        reply = self.message.reply(performative, content, sender=self._me)
        written = reply.to_dict()
        self._home.trace(reply)
        with contextlib.suppress(BusUnavailable):  # the bus has been closed, and no initiator can be reached
            self._conversation.reply(written)

    def hear(self, more: AclMessage) -> None:
        """Take a later message of the initiator."""
        if more.performative is Performative.CANCEL:
            self.cancel(f"{more.sender} has cancelled it")
        elif more.performative is Performative.REJECT_PROPOSAL:
            self.cancel("")
        elif more.performative is Performative.CFP:
            self.revised.put_nowait(more)
        else:
            self.accepted.set()

    def cancel(self, why: str) -> None:
        """Cancel the handler, which gets a `CancelledError`."""
        self._why_cancelled = why if self._why_cancelled is None else self._why_cancelled
        if self._task is not None:
            self._task.cancel()

    def end(self) -> None:
        """Cancel the handler, since its agent ends."""
        self._is_ending = True
        if self._task is not None:
            self._task.cancel()

    @contextlib.contextmanager
    def attended(self) -> Iterator[bool]:
        """Cancel the handler when the initiator's heartbeat stops during a block.

        Yields:
            Whether the initiator has a heartbeat.
        """
        key = self.message.x_heartbeat
        if not key:
            yield False
            return
        try:
            heartbeat_key(key)
        except KeyNotValid as err:
            raise Refused(str(err)) from err
        why = f"{self.message.sender}, who asked for it, has been silent for {SILENCE} s"
        with watched(self._home.bus, key, lambda: self.cancel(why)):
            yield True

    def watch_initiator(self) -> None:
        """Cancel the handler, which may not have begun, when the initiator dies."""
        gone = f"{self.message.sender} has gone"
        self._release = self._home.attend(self.message.sender, lambda: self.cancel(gone))

    async def run(
        self, what: str, carry_out: Callable[[], Awaitable[Any]], agrees_itself: bool, ended: Callable[[], None]
    ) -> None:
        """Do what was requested, and send the result or the reason why there is none.

        `Refused`, raised before the handler first waits, is a refusal; later, when the agent has agreed, it is a
        failure. A handler that agrees itself may refuse until it has called `agree`.

        Args:
            what: The request, as text.
            carry_out: Does it; returns the content of the last inform.
            agrees_itself: Whether it calls `agree`.
            ended: Called in every case at the end.
        """
        self._task = asyncio.current_task()
        serving = _SERVING.set(self)
        agreeing: asyncio.Handle | None = None
        try:
            if self._is_cancelled:
                raise asyncio.CancelledError
            if not agrees_itself:
                agreeing = asyncio.get_running_loop().call_soon(self.agree)  # when the handler first waits
            result = await carry_out()
            if not self._is_concluded:
                self.agree()
                self.say(Performative.INFORM, result)
        except asyncio.CancelledError:
            if self._why_cancelled is None or self._is_ending:
                self._say_no(f"{self._me} has ended")
                raise
            self._say_no(self._why_cancelled)
        except Refused as err:
            self._say_no(in_words(err))
        except Exception as err:
            self.say(Performative.FAILURE, {"why": sentence(f"{self.action} failed with {in_words(err)}")})
            self._home.report(self._me, f"{what} failed", err)
        finally:
            if agreeing is not None:
                agreeing.cancel()
            _SERVING.reset(serving)
            self._release()
            self.close()
            ended()

    def turn_away(self, why: str) -> None:
        """Refuse without having begun, and end the conversation."""
        self._say_no(why)
        self.close()

    def close(self) -> None:
        """End the conversation, if it has not ended."""
        self._conversation.close()

    @property
    def _is_cancelled(self) -> bool:
        return self._is_ending or self._why_cancelled is not None

    def _say_no(self, why: str) -> None:
        if why:
            self.say(Performative.FAILURE if self._has_agreed else Performative.REFUSE, {"why": sentence(why)})


_SERVING: ContextVar[ResponderConversation] = ContextVar("serving")


def agree() -> None:
    """Agree to the current request; for handlers that agree themselves.

    Raises:
        LookupError: There is no current request.
    """
    _being_answered().agree()


def attended() -> contextlib.AbstractContextManager[bool]:
    """Cancel the current request when the initiator's heartbeat stops during a block.

    It yields whether the initiator has a heartbeat.

    Raises:
        LookupError: There is no current request.
    """
    return _being_answered().attended()


def asker() -> AgentName:
    """Return the initiator of the current request.

    Raises:
        LookupError: There is no current request.
    """
    return _being_answered().message.sender


def _being_answered() -> ResponderConversation:
    conversation = _SERVING.get(None)
    if conversation is None:
        raise LookupError("no request is being answered; call this in the method that answers it")
    return conversation
