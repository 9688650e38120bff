"""A robot that stands although it is told to drive."""

from typing import Any

import pytest

from gateway.motion import PATIENCE, Obedience
from p2os import StandardSip

CYCLE = 0.1
STANDS: dict[str, Any] = {"flags": 1}  # motors enabled


def judged(seconds: float, linear: float = 0.2, angular: float = 0.0, **sip: Any) -> Obedience:
    obedience = Obedience()
    for step in range(round(seconds / CYCLE) + 1):
        obedience.judge(linear, angular, StandardSip(**{**STANDS, **sip}), step * CYCLE)
    return obedience


def test_robot_has_a_while_to_obey() -> None:
    assert not judged(PATIENCE - 2 * CYCLE).is_ignored
    assert judged(PATIENCE + 2 * CYCLE).is_ignored


def test_turns_count_as_well() -> None:
    assert judged(2.0, linear=0.0, angular=-0.5).is_ignored


@pytest.mark.parametrize(
    "excuse",
    [
        {"linear": 0.0},
        {"linear": 0.01},
        {"left_velocity": 0.2, "right_velocity": 0.2},
        {"flags": 0},
        {"stall": 1},
        {"stall": 1 << 8},
    ],
)
def test_standing_has_its_reasons(excuse: dict[str, Any]) -> None:
    assert not judged(5.0, **excuse).is_ignored


def test_robot_that_rolls_again_is_forgiven_at_once() -> None:
    obedience = judged(2.0)
    obedience.judge(0.2, 0.0, StandardSip(flags=1, left_velocity=0.1, right_velocity=0.1), 2.1)
    assert not obedience.is_ignored
    obedience.judge(0.2, 0.0, StandardSip(flags=1), 2.2)
    assert not obedience.is_ignored
