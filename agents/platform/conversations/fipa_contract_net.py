"""FIPA's contract net (SC00029H), both ends: cfp, propose or refuse, accept or reject the proposal, inform or failure.

A call is one conversation with each peer. A proposal that comes too late is rejected unread; a peer that dies makes
none. The bidder computes a proposal in the method that `proposes` marks, and does the request of the same name once the
proposal is accepted.

In the iterated contract net (SC00030H) the initiator may call those who made a proposal again, with other arguments, in
the same conversations. Each round ends as the first; the request is done with the arguments of the last.
"""

import asyncio
import contextlib
import uuid
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import aclosing
from dataclasses import dataclass, replace
from typing import Any

from agents.platform.acl import AclMessage, Performative
from agents.platform.conversations.handler import NotUnderstood, ParsedRequest
from agents.platform.conversations.initiator_conversation import ConversationEnded, InitiatorConversation
from agents.platform.conversations.outcome import Ending, Outcome
from agents.platform.conversations.responder_conversation import ResponderConversation
from agents.platform.names import AgentName
from bus import Refused

PROTOCOL = "fipa-contract-net"
ITERATED = "fipa-iterated-contract-net"
BIDS_WITHIN = 2.0  # s for proposals, unless the initiator sets another time
MOST_ROUNDS = 20  # of an iterated call
PROPOSAL_TIME = 60.0  # s for which a bidder is bound by its proposal


@dataclass(frozen=True, slots=True)
class Bid:
    """A proposal of an agent, `bidder`."""

    bidder: AgentName
    proposal: Any


Choose = Callable[[list[Bid]], Bid | Iterable[Bid] | None]
Revise = Callable[[list[Bid]], Mapping[str, Any] | None]
"""Gets the bids of a round; returns the arguments of another one, or None to choose among these bids."""


@dataclass(frozen=True, slots=True)
class Tender:
    """The end of a call for proposals.

    bids: the proposals that came in time, in the order of arrival.
    outcomes: how it ended with each peer: `DONE` or not for accepted proposals, `REJECTED` for the others, and the
        reason
        for no proposal: `REFUSED`, `DIED`, `TIMED_OUT`, `NOT_UNDERSTOOD`.
    """

    bids: Sequence[Bid]
    outcomes: Mapping[AgentName, Outcome]

    @property
    def done(self) -> dict[AgentName, Any]:
        """The results of the peers that have done it."""
        return {peer: outcome.result for peer, outcome in self.outcomes.items() if outcome.is_done}


async def call_for(
    dialogues: Sequence[InitiatorConversation], choose: Choose, bids_within: float, revise: Revise = lambda bids: None
) -> Tender:
    """Call for proposals, accept some, and wait until those who made them have done it.

    Args:
        dialogues: One conversation with each peer.
        choose: Returns the bids to accept; not called when there are none.
        bids_within: s to wait for them, in each round.
        revise: Decides after each round whether there is another; not called when there are no bids.
    Raises:
        ValueError: `choose` has returned what is not one of the bids.
        AclError: The arguments have no JSON form, or are too many.
        BusUnavailable: The bus is closed.
    """
    bids: list[Bid] = []
    callers = [_Caller(initiated, bids) for initiated in dialogues]
    try:
        await _all_answered(callers, bids_within)
        rounds = 1
        while bids and rounds < MOST_ROUNDS and (arguments := revise(list(bids))) is not None:
            rounds += 1
            again = [caller for caller in callers if caller.bid is not None]
            for caller in callers:
                if caller.bid is None:
                    caller.decide(False, bids_within)
            bids.clear()
            for caller in again:
                caller.call_again(arguments)
            await _all_answered(again, bids_within)
        in_time = tuple(bids)
        accepted = _accepted(choose, in_time)
        for caller in callers:
            caller.decide(caller.bid in accepted, bids_within)
        return Tender(in_time, {caller.peer: await caller.outcome() for caller in callers})
    finally:
        await asyncio.gather(*(caller.leave() for caller in callers))


async def _all_answered(callers: Sequence["_Caller"], within: float) -> None:
    with contextlib.suppress(TimeoutError):  # a peer that has not answered by then makes no proposal
        async with asyncio.timeout(within):
            for caller in callers:
                await caller.answered.wait()


async def propose(conversation: ResponderConversation, opening: ParsedRequest) -> Any:
    """Make a proposal, and return the result of the task once it is accepted."""
    assert opening.task is not None
    arguments = opening.arguments
    while True:
        conversation.say(Performative.PROPOSE, await opening.handler.call(arguments))
        try:
            async with asyncio.timeout(PROPOSAL_TIME):
                revised = await _decision(conversation)
        except TimeoutError:
            conversation.commit()
            raise Refused(f"nobody has accepted this proposal within {PROPOSAL_TIME:g} s") from None
        if revised is None:
            break
        arguments = _revised_arguments(revised, opening)
        conversation.message = replace(conversation.message, content=revised.content, reply_with=revised.reply_with)
    conversation.commit()
    return await opening.task.call(arguments)


async def _decision(conversation: ResponderConversation) -> AclMessage | None:
    """Wait until the proposal is accepted, and return None; or return another call for proposals."""
    accepted = asyncio.ensure_future(conversation.accepted.wait())
    revised = asyncio.ensure_future(conversation.revised.get())
    try:
        await asyncio.wait((accepted, revised), return_when=asyncio.FIRST_COMPLETED)
        return revised.result() if revised.done() and not accepted.done() else None
    finally:
        accepted.cancel()
        revised.cancel()


def _revised_arguments(call: AclMessage, opening: ParsedRequest) -> Mapping[str, Any]:
    """Return the arguments of a further call.

    Raises:
        Refused: It calls for something else, or the arguments do not fit.
    """
    match call.content:
        case {"action": opening.handler.name, "arguments": dict(arguments)}:
            try:
                opening.handler.check(arguments)
            except NotUnderstood as err:
                raise Refused(str(err)) from err
            return arguments
    raise Refused(f"a further call in this conversation is for {opening.handler.name} with other arguments")


class _Caller:
    """The call to one peer.

    bid: its proposal. answered: set once it has made one, or will not.
    """

    def __init__(self, initiated: InitiatorConversation, bids: list[Bid]) -> None:
        self.peer = initiated.peer
        self.bid: Bid | None = None
        self.answered = asyncio.Event()
        self._initiated = initiated
        self._bids = bids
        self._label = initiated.opening.reply_with
        self._is_accepted = False
        self._turned_down: Outcome | None = None
        self._hearing = asyncio.ensure_future(self._hear())

    def call_again(self, arguments: Mapping[str, Any]) -> None:
        """Call it in another round; its bid of this one does not hold any more."""
        self.bid = None
        self._label = uuid.uuid4().hex
        if self._hearing.done():
            return
        self.answered.clear()
        content = {"action": self._initiated.opening.content["action"], "arguments": dict(arguments)}
        self._initiated.say(Performative.CFP, content, self._label)

    def decide(self, accept: bool, within: float) -> None:
        """Accept or reject its proposal, or one that may still come."""
        if self._hearing.done():
            return
        if accept:
            self._is_accepted = True
            self._initiated.say(Performative.ACCEPT_PROPOSAL)
            return
        self._initiated.say(Performative.REJECT_PROPOSAL)
        self._initiated.end()
        why = f"{self.peer} has proposed nothing within {within:g} s"
        self._turned_down = (
            Outcome(Ending.REJECTED, why="another proposal was accepted, or none")
            if self.bid is not None
            else Outcome(Ending.TIMED_OUT, why=why)
        )

    async def outcome(self) -> Outcome:
        """Return how it has ended."""
        return self._turned_down or await self._hearing

    async def leave(self) -> None:
        """Leave the conversation; it is cancelled unless it has ended."""
        self._hearing.cancel()
        await asyncio.gather(self._hearing, return_exceptions=True)  # it was cancelled

    async def _hear(self) -> Outcome:
        try:
            async with aclosing(self._initiated.replies()) as heard:
                async for reply in heard:
                    if reply.performative is Performative.PROPOSE and reply.in_reply_to != self._label:
                        continue  # late, in a round before
                    if reply.performative is Performative.PROPOSE and self.bid is None:
                        self._note(reply)
                    elif reply.performative is Performative.INFORM and self._is_accepted:
                        return self._initiated.done(reply.content)
                    else:
                        raise self._initiated.misplaced(reply)
        except ConversationEnded as over:
            self._withdraw()
            return over.outcome
        finally:
            self.answered.set()
        raise AssertionError("a dialogue ends with a reply or with ConversationEnded")

    def _note(self, reply: AclMessage) -> None:
        self.bid = Bid(self.peer, reply.content)
        self._bids.append(self.bid)
        self.answered.set()

    def _withdraw(self) -> None:
        """Remove the bid of a peer that has gone, unless it has been accepted."""
        if self.bid is not None and not self._is_accepted:
            self._bids.remove(self.bid)


def _accepted(choose: Choose, bids: Sequence[Bid]) -> list[Bid]:
    """Return the bids that are chosen.

    Raises:
        ValueError: A chosen bid has not been made.
    """
    chosen = choose(list(bids)) if bids else None
    accepted = [] if chosen is None else [chosen] if isinstance(chosen, Bid) else list(chosen)
    for one in accepted:
        if one not in bids:
            raise ValueError(f"{one} is none of the bids; choose among {', '.join(map(str, bids))}")
    return accepted
