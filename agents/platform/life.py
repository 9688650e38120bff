"""An agent's life: the states and steps of FIPA's agent platform (SC00023K, Agent Management, life cycle)."""

from enum import StrEnum

from agents.platform.errors import IllegalTransition


class AgentState(StrEnum):
    """Where an agent is in its life."""

    INITIATED = "initiated"  # made, not yet at work
    ACTIVE = "active"
    SUSPENDED = "suspended"  # made to rest; requests are refused, messages wait
    WAITING = "waiting"  # rests by itself until a message or a request comes
    TRANSIT = "transit"  # on its way into another container; requests and messages wait
    DELETED = "deleted"


class Step(StrEnum):
    """What leads from state to state."""

    INVOKE = "invoke"
    SUSPEND = "suspend"
    RESUME = "resume"
    WAIT = "wait"
    WAKE = "wake"
    MOVE = "move"
    EXECUTE = "execute"  # begin to live where one has arrived
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
        self.state = after(self.state, step)


def after(state: AgentState, step: Step) -> AgentState:
    """Return the state to which a step leads.

    Raises:
        IllegalTransition: There is no such step from this state.
    """
    if (state, step) not in TRANSITIONS:
        raise IllegalTransition(f"an agent that is {state} cannot {step}")
    return TRANSITIONS[state, step]
