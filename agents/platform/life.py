"""An agent's life: the states and steps of FIPA's agent platform (SC00023K, Agent Management, life cycle)."""

from enum import StrEnum

from agents.platform.errors import IllegalTransition


class State(StrEnum):
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
    (State.INITIATED, Step.INVOKE): State.ACTIVE,
    (State.ACTIVE, Step.SUSPEND): State.SUSPENDED,
    (State.WAITING, Step.SUSPEND): State.SUSPENDED,
    (State.SUSPENDED, Step.RESUME): State.ACTIVE,
    (State.ACTIVE, Step.WAIT): State.WAITING,
    (State.WAITING, Step.WAKE): State.ACTIVE,
    (State.INITIATED, Step.MOVE): State.TRANSIT,  # FIPA moves active agents only
    (State.ACTIVE, Step.MOVE): State.TRANSIT,
    (State.WAITING, Step.MOVE): State.TRANSIT,
    (State.SUSPENDED, Step.MOVE): State.TRANSIT,
    (State.TRANSIT, Step.EXECUTE): State.ACTIVE,
    (State.TRANSIT, Step.DELETE): State.DELETED,
    (State.INITIATED, Step.DELETE): State.DELETED,
    (State.ACTIVE, Step.DELETE): State.DELETED,
    (State.SUSPENDED, Step.DELETE): State.DELETED,
    (State.WAITING, Step.DELETE): State.DELETED,
}


def after(state: State, step: Step) -> State:
    """The state to which a step leads.

    Raises:
        IllegalTransition: Life knows no such step from this state.
    """
    if (state, step) not in TRANSITIONS:
        raise IllegalTransition(f"an agent that is {state} cannot {step}")
    return TRANSITIONS[state, step]
