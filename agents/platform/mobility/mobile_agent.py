"""The side of an agent that moves from one container into another.

It is in transit from `depart` on, here until `come_back` or its end, and there from `arrive` until `settle`: nothing it
does begins, and what comes waits before its door.
"""

from abc import abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any

from agents.platform.acl import Performative
from agents.platform.container.delivery_gate import Caller, DeliveryGate, QueuedMessage
from agents.platform.conversations.initiator import Initiator
from agents.platform.conversations.request_dispatcher import RequestDispatcher
from agents.platform.errors import NotMoved
from agents.platform.life import AgentState, Step, after
from agents.platform.mailbox import Mailbox
from agents.platform.mobility.migration_state import MigrationState
from agents.platform.schedule import Schedule
from bus import Conversation


class MobileAgent(Initiator):
    """An agent as a container sees it that sends it away or takes it in."""

    mailbox: Mailbox
    _state: AgentState
    _dispatcher: RequestDispatcher
    _door: DeliveryGate
    _schedule: Schedule

    def pack(self) -> dict[str, Any]:
        """What the agent keeps when it moves into another container: a JSON object.

        Called when it answers nobody any more and no action of a behaviour begins; one that has begun may still be at
        work. What it does not pack it finds there as `setup` leaves it.
        """
        return {}

    def unpack(self, state: Mapping[str, Any]) -> None:
        """Go on with what `pack` has said, after `setup` in the new container and before any behaviour."""

    async def depart(self, within: float) -> MigrationState:
        """Begin to move: finish what others have asked for, and pack.

        Subscribers are told that they have to subscribe again; requests that come meanwhile wait.

        Args:
            within: s for what is under way to end.
        Raises:
            NotMoved: It has not ended; the agent goes on as before.
            IllegalTransition: It is not at work.
        """
        was = self._state
        after(was, Step.MOVE)
        self._door.keep_callers()  # before it is in transit, since who is let in is then admitted as before
        self._go(Step.MOVE)
        self._schedule.gate.shut()
        try:
            for responder in self._dispatcher.under_way:
                if responder.message.performative is Performative.SUBSCRIBE:
                    responder.cancel(f"{self.name} moves into another container; subscribe again")
            await self._dispatcher.rest(within)
            self._check_leaving(within)
            self._door.keep_letters()
            state = self.pack()
            return MigrationState(state, tuple(self.mailbox.empty()), was is AgentState.SUSPENDED)
        except BaseException:
            self.come_back(MigrationState({}, (), was is AgentState.SUSPENDED))
            raise

    def come_back(self, migration: MigrationState) -> None:
        """Go on where it was, since the move has failed; nothing that came meanwhile is lost."""
        if self._state is AgentState.TRANSIT:
            self._unload(migration)
            self._go_on(migration)

    def settle(self, migration: MigrationState, waiting: Iterable[QueuedMessage]) -> None:
        """Begin to live here.

        Args:
            migration: What it took along, already unpacked.
            waiting: Messages that came where it was, since it packed.
        """
        self._door.bring(waiting)
        self._go_on(migration)

    def forget_the_way(self) -> None:
        """Note that nothing comes twice any more, since all have heard where it lives."""
        self._door.forget()

    def deliver(self, waiting: Iterable[QueuedMessage]) -> None:
        """Take messages that came where it was; those that came here as well are left out."""
        self._door.bring(waiting)

    def call(self, message: dict[str, Any], conversation: Conversation) -> None:
        """Take a conversation that began where it was; one that came here as well is ended without a word."""
        self._door.caller(message, conversation)

    def come_since(self) -> list[QueuedMessage]:
        """The messages that have come since it packed, and that still wait here."""
        return self._door.waiting()

    def left_behind(self) -> tuple[list[QueuedMessage], list[Caller]]:
        """What came where it was, and is to follow it; it waits here no more."""
        return self._door.kept()

    def _unload(self, migration: MigrationState) -> None:
        for message in migration.mailbox:
            self.mailbox.deliver(message, len(message.encode()))

    def _go_on(self, migration: MigrationState) -> None:
        self._go(Step.EXECUTE)
        if migration.is_suspended:
            self._go(Step.SUSPEND)
        else:
            self._schedule.gate.open()
        self._door.open()

    def _check_leaving(self, within: float) -> None:
        if self._state is not AgentState.TRANSIT:
            raise NotMoved(f"{self.name} has ended before it could move")
        if busy := self._dispatcher.under_way:
            what = ", ".join(sorted({f"{each.message.performative} of {each.message.sender}" for each in busy}))
            raise NotMoved(f"{self.name} stays where it is: it has not finished within {within:g} s with the {what}")

    @abstractmethod
    def _go(self, step: Step) -> None:
        """Take a step in its life."""
