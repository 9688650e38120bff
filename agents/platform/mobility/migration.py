"""The part of an agent that moves it from one container into another.

The agent is in transit from `depart` on, here until `come_back` or its end, and there from `arrive` until `settle`.
Meanwhile no action of a behaviour starts, and messages and conversations wait in the delivery gate.
"""

from collections.abc import Callable, Iterable
from typing import Any

from agents.platform.acl import Performative
from agents.platform.container.delivery_gate import DeliveryGate, QueuedMessage
from agents.platform.conversations.request_dispatcher import RequestDispatcher
from agents.platform.errors import AgentError
from agents.platform.life import AgentState, Life, Step
from agents.platform.mailbox import Mailbox
from agents.platform.mobility.migration_state import MigrationState
from agents.platform.names import AgentName
from agents.platform.schedule import Schedule


class Migration:
    """Moves one agent, for the containers that send it away or take it in.

    gate: where messages and conversations reach the agent.
    """

    def __init__(
        self,
        me: AgentName,
        life: Life,
        gate: DeliveryGate,
        mailbox: Mailbox,
        dispatcher: RequestDispatcher,
        schedule: Schedule,
    ) -> None:
        self.gate = gate
        self._me = me
        self._life = life
        self._mailbox = mailbox
        self._dispatcher = dispatcher
        self._schedule = schedule

    async def copy(self, within: float, pack: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """Return what the agent keeps, for a clone; the agent goes on where it is.

        Subscribers are told to subscribe again, since an agent packs when no conversation is under way.

        Args:
            within: s for the conversations under way to end; new requests wait meanwhile.
            pack: Returns what the agent keeps.
        Raises:
            AgentError: They have not ended.
            IllegalTransition: The agent is not at work.
        """
        migration = await self.depart(within, pack, "is cloned")
        self.come_back(migration)
        return dict(migration.state)

    async def depart(
        self, within: float, pack: Callable[[], dict[str, Any]], why: str = "moves into another container"
    ) -> MigrationState:
        """Begin to move: finish the conversations under way, and pack.

        Subscribers are told to subscribe again; new requests wait.

        Args:
            within: s for the conversations to end.
            pack: Returns what the agent keeps.
            why: What the agent does, for its subscribers.
        Raises:
            AgentError: They have not ended; the agent goes on as before.
            IllegalTransition: The agent is not at work.
        """
        was = self._life.state
        self._life.after(Step.MOVE)
        self.gate.keep_callers()  # before the agent is in transit, so that those let in are admitted as before
        self._life.go(Step.MOVE)
        self._schedule.gate.shut()
        is_suspended = was is AgentState.SUSPENDED
        try:
            for responder in self._dispatcher.under_way:
                if responder.message.performative is Performative.SUBSCRIBE:
                    responder.cancel(f"{self._me} {why}; subscribe again")
            await self._dispatcher.rest(within)
            self._check_leaving(within)
            self.gate.keep_letters()
            state = pack()
            return MigrationState(state, tuple(self._mailbox.empty()), is_suspended)
        except BaseException:
            self.come_back(MigrationState({}, (), is_suspended))
            raise

    def come_back(self, migration: MigrationState) -> None:
        """Go on in the old container, since the move has failed; nothing that came meanwhile is lost."""
        if self._life.state is AgentState.TRANSIT:
            self.refill_mailbox(migration)
            self._go_on(migration)

    def arrive(self) -> None:
        """Be in transit in the new container: all that comes waits until `settle`."""
        self._life.go(Step.MOVE)
        self._schedule.gate.shut()
        self.gate.wait_for_the_rest()

    def refill_mailbox(self, migration: MigrationState) -> None:
        """Put back the messages that waited in the mailbox."""
        for message in migration.mailbox:
            self._mailbox.deliver(message, len(message.encode()))

    def settle(self, migration: MigrationState, waiting: Iterable[QueuedMessage]) -> None:
        """Begin to live in the new container.

        Args:
            migration: What the agent took along, already unpacked.
            waiting: Messages that came to the old container after it packed.
        """
        self.gate.bring(waiting)
        self._go_on(migration)

    def _go_on(self, migration: MigrationState) -> None:
        self._life.go(Step.EXECUTE)
        if migration.is_suspended:
            self._life.go(Step.SUSPEND)
        else:
            self._schedule.gate.open()
        self.gate.open()

    def _check_leaving(self, within: float) -> None:
        if self._life.state is not AgentState.TRANSIT:
            raise AgentError(f"{self._me} has ended before it could move")
        if busy := self._dispatcher.under_way:
            what = ", ".join(sorted({f"{each.message.performative} of {each.message.sender}" for each in busy}))
            raise AgentError(f"{self._me} stays where it is: it has not finished within {within:g} s with the {what}")
