"""Every step of an agent's life is in the table, and no other is taken."""

import pytest

from agents.platform import AgentState, IllegalTransition, Step
from agents.platform.life import TRANSITIONS, Life


@pytest.mark.parametrize("state", AgentState)
@pytest.mark.parametrize("step", Step)
def test_only_the_steps_of_the_table_are_taken(state: AgentState, step: Step) -> None:
    life = Life()
    life.state = state
    if (state, step) in TRANSITIONS:
        assert life.after(step) is TRANSITIONS[state, step]
    else:
        with pytest.raises(IllegalTransition, match=f"an agent that is {state} cannot {step}"):
            life.go(step)


def test_every_state_but_the_last_can_be_left_and_the_last_cannot() -> None:
    assert {state for state, _ in TRANSITIONS} == set(AgentState) - {AgentState.DELETED}
    assert all((state, Step.DELETE) in TRANSITIONS for state in AgentState if state is not AgentState.DELETED)
