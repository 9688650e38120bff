"""The responder's end of a conversation: what is done for the initiator, and how its end is told."""

import asyncio
import contextlib
from collections.abc import Coroutine, Iterator
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
    """One conversation that is being answered. All of it happens in the agent's event loop."""

    def __init__(self, home: ContainerContext, me: AgentName, message: AclMessage, conversation: Conversation) -> None:
        self.message = message
        self._me = me
        self._conversation = conversation
        self._home = home
        self._has_agreed = False
        self._more: asyncio.Queue[AclMessage] = asyncio.Queue(maxsize=1)
        self._work: asyncio.Task[None] | None = None
        self._why_cancelled: str | None = None  # empty when there is nobody to be told

    @property
    def what(self) -> str:
        """What is being done for whom, in words."""
        return f"the {self.message.performative} {self.message.content['action']} of {self.message.sender}"

    @property
    def has_agreed(self) -> bool:
        """Whether it is bound: what goes wrong from now on is a failure and no refusal."""
        return self._has_agreed

    def works_in(self, task: "asyncio.Task[Any]") -> bool:
        """Whether that is done in this task."""
        return self._work is task

    def agree(self) -> None:
        """Say that it will be done; once."""
        if not self._has_agreed:
            self._has_agreed = True
            self.say(Performative.AGREE)

    def commit(self) -> None:
        """Be bound without saying so: whatever goes wrong from now on is a failure and no refusal."""
        self._has_agreed = True

    def say(self, performative: Performative, content: Any = None) -> None:
        """Say something to the initiator.

        Raises:
            AclError: The content has no JSON form, or is too large.
        """
        reply = self.message.reply(performative, content, sender=self._me)
        written = reply.to_dict()
        self._home.trace(reply)
        with contextlib.suppress(BusUnavailable):  # the bus was closed meanwhile: nobody listens any more
            self._conversation.reply(written)

    def hear(self, more: AclMessage) -> None:
        """What the initiator says later."""
        if more.performative is Performative.CANCEL:
            self.cancel(f"{more.sender} has cancelled it")
        elif more.performative is Performative.REJECT_PROPOSAL:
            self.cancel("")
        elif not self._more.full():
            self._more.put_nowait(more)

    async def heard(self) -> AclMessage:
        """The next thing that the initiator says."""
        return await self._more.get()

    def cancel(self, why: str) -> None:
        """Stop what is being done; the handler gets a `CancelledError`."""
        self._why_cancelled = why if self._why_cancelled is None else self._why_cancelled
        if self._work is not None:
            self._work.cancel()

    @contextlib.contextmanager
    def attended(self) -> Iterator[bool]:
        """Cancel what is being done when the initiator's heartbeat falls silent during a block.

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

    def asker_gone(self) -> None:
        """Stop what is being done, since there is nobody any more for whom."""
        self.cancel(f"{self.message.sender} has gone")

    async def run(self, name: str, work: Coroutine[Any, Any, None], agrees_itself: bool) -> Exception | None:
        """Do the work, and say how it ended, unless it was well, which the work itself says.

        What it raises as `Refused` before it first waits for something is a refusal; later, after it has agreed, it is
        a failure. Work that agrees itself may refuse until it has called `agree`.

        Args:
            name: What is being done, for people.
            work: Does it.
            agrees_itself: Whether it does.
        Returns:
            What it raised beyond a refusal, to be reported.
        """
        if self._was_cancelled():
            work.close()
            self.turn_away(self._why_cancelled or "")
            return None
        token = _SERVING.set(self)
        try:
            self._work = asyncio.ensure_future(work)
        finally:
            _SERVING.reset(token)
        try:
            await asyncio.sleep(0)  # the work begins first, since its task was made first
            if not self._work.done() and not agrees_itself:
                self.agree()
            await self._work
        except asyncio.CancelledError:
            if self._was_cancelled() and not _is_being_cancelled():
                self._say_no(self._why_cancelled or "")
                return None
            self._work.cancel()
            await asyncio.gather(self._work, return_exceptions=True)
            self._say_no(f"{self._me} has ended")
            raise
        except Refused as err:
            self._say_no(in_words(err))
        except Exception as err:
            self.say(Performative.FAILURE, {"why": sentence(f"{name} failed with {in_words(err)}")})
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

    def _was_cancelled(self) -> bool:
        return self._why_cancelled is not None

    def _say_no(self, why: str) -> None:
        if why:
            self.say(Performative.FAILURE if self._has_agreed else Performative.REFUSE, {"why": sentence(why)})


def _is_being_cancelled() -> bool:
    """Whether it is this very task that is told to end, and not the one for which it waits."""
    task = asyncio.current_task()
    return task is not None and task.cancelling() > 0


_SERVING: ContextVar[ResponderConversation] = ContextVar("serving")


def agree() -> None:
    """Agree to what is being answered; for handlers that agree themselves.

    Raises:
        LookupError: Nothing is being answered.
    """
    _being_answered().agree()


def attended() -> contextlib.AbstractContextManager[bool]:
    """Cancel what is being answered when the initiator's heartbeat falls silent during a block.

    It yields whether the initiator has a heartbeat.

    Raises:
        LookupError: Nothing is being answered.
    """
    return _being_answered().attended()


def asker() -> AgentName:
    """Who asks for what is being done; for handlers that are not to do the same for everyone.

    Raises:
        LookupError: Nothing is being answered.
    """
    return _being_answered().message.sender


def _being_answered() -> ResponderConversation:
    conversation = _SERVING.get(None)
    if conversation is None:
        raise LookupError("no request is being answered; call this in the method that answers it")
    return conversation
