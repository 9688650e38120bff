"""The life cycle of agents: states and steps of FIPA's agent platform (SC00023K, Agent Management)."""

from enum import StrEnum

from agents.platform.errors import IllegalTransition


class AgentState(StrEnum):
    """The state of an agent in its life cycle."""

    INITIATED = "initiated"  # constructed, not yet at work
    ACTIVE = "active"
    SUSPENDED = "suspended"  # requests are refused, messages wait
    WAITING = "waiting"  # by its own choice, until a message or a request comes
    TRANSIT = "transit"  # moving into another container; requests and messages wait
    DELETED = "deleted"


class Step(StrEnum):
    """A step from one state to another."""

    INVOKE = "invoke"
    SUSPEND = "suspend"
    RESUME = "resume"
    WAIT = "wait"
    WAKE = "wake"
    MOVE = "move"
    EXECUTE = "execute"  # continue in the new container
    DELETE = "delete"


TRANSITIONS = {
    (AgentState.INITIATED, Step.INVOKE): AgentState.ACTIVE,
    (AgentState.ACTIVE, Step.SUSPEND): AgentState.SUSPENDED,
    (AgentState.WAITING, Step.SUSPEND): AgentState.SUSPENDED,
    (AgentState.SUSPENDED, Step.RESUME): AgentState.ACTIVE,
    (AgentState.ACTIVE, Step.WAIT): AgentState.WAITING,
    (AgentState.WAITING, Step.WAKE): AgentState.ACTIVE,
    (AgentState.INITIATED, Step.MOVE): AgentState.TRANSIT,  # FIPA moves active agents only
    (AgentState.ACTIVE, Step.MOVE): AgentState.TRANSIT,
    (AgentState.WAITING, Step.MOVE): AgentState.TRANSIT,
    (AgentState.SUSPENDED, Step.MOVE): AgentState.TRANSIT,
    (AgentState.TRANSIT, Step.EXECUTE): AgentState.ACTIVE,
    (AgentState.TRANSIT, Step.DELETE): AgentState.DELETED,
    (AgentState.INITIATED, Step.DELETE): AgentState.DELETED,
    (AgentState.ACTIVE, Step.DELETE): AgentState.DELETED,
    (AgentState.SUSPENDED, Step.DELETE): AgentState.DELETED,
    (AgentState.WAITING, Step.DELETE): AgentState.DELETED,
}


class Life:
    """The life of one agent: its state, and the steps that change it."""

    def __init__(self) -> None:
        self.state = AgentState.INITIATED

    def go(self, step: Step) -> None:
        """Take a step.

        Raises:
            IllegalTransition: There is no such step from the present state.
        """
        self.state = self.after(step)

    def after(self, step: Step) -> AgentState:
        """Return the state to which a step leads, without taking it.

        Raises:
            IllegalTransition: There is no such step from the present state.
        """
        if (self.state, step) not in TRANSITIONS:
            raise IllegalTransition(f"an agent that is {self.state} cannot {step}")
        return TRANSITIONS[self.state, step]
