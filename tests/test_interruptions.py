"""What tests do again, and what they do not."""

import pytest

from tests.interruptions import TRIES, again_if_interrupted, what_interrupted


@pytest.mark.parametrize(
    "said",
    [
        "failed: ask-a7745f@terminal, who asked for it, has been silent for 0.5 s",
        "base@grumpy could not move: the connection to grumpy was lost after 0.41 m",
        "the gripper was stopped: its commander, happy/agents/gripper/heartbeat, was silent for 0.5 s",
        "the robot is not connected; the gateway goes on looking for it",
        "the gateway has just been frozen and does not know how old this command is",
        "a picture did not come within 60 s; the machine is too busy, and the emulator has given up camera images",
    ],
)
def test_what_a_busy_machine_interrupts_is_done_again(said: str) -> None:
    left = [said]

    @again_if_interrupted
    def move() -> str:
        if left:
            raise AssertionError(left.pop())
        return "there"

    assert move() == "there"


def test_what_is_interrupted_each_time_fails() -> None:
    tries: list[int] = []

    @again_if_interrupted
    def move() -> None:
        tries.append(len(tries))
        raise AssertionError("the connection to happy was lost")

    with pytest.raises(AssertionError, match="was lost"):
        move()
    assert len(tries) == TRIES


def test_what_fails_for_another_reason_fails_at_once() -> None:
    tries: list[int] = []

    @again_if_interrupted
    def move() -> None:
        tries.append(len(tries))
        raise AssertionError("stalled after 0.47 of 0.50 m")

    with pytest.raises(AssertionError, match="stalled"):
        move()
    assert len(tries) == 1


def test_what_interrupted_a_test_is_found_in_the_text_of_its_failure() -> None:
    said = "failed: ask-a7745f@terminal, who asked for it, has been silent for 0.5 s"
    failure = (
        f"    raise failure\nE   agents.client.errors.RequestFailed: {said}\n\nagents/client/robot.py:99: RequestFailed"
    )
    assert what_interrupted(failure) == f"agents.client.errors.RequestFailed: {said}"
    assert what_interrupted("E   assert 1 == 2") == "it is not said"
