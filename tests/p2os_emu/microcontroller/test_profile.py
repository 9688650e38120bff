from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os_emu.microcontroller.profile import approach, braking_speed

DT = 1 / 120
REACTION = 0.1

speeds = st.integers(-3000, 3000).map(lambda millimetres: millimetres / 1000)
changes = st.floats(0.05, 5)
distances = st.floats(0.01, 10)


@given(speed=speeds, goal=speeds, acceleration=changes, deceleration=changes)
def test_a_step_never_changes_the_speed_by_more_than_its_limit(
    speed: float, goal: float, acceleration: float, deceleration: float
) -> None:
    after = approach(speed, goal, acceleration, deceleration, DT)
    limit = deceleration if abs(after) < abs(speed) else acceleration
    assert abs(after - speed) <= limit * DT * (1 + 1e-9) + 1e-12


@given(speed=speeds, goal=speeds, acceleration=changes, deceleration=changes)
def test_a_step_never_passes_its_goal_nor_moves_away_from_it(
    speed: float, goal: float, acceleration: float, deceleration: float
) -> None:
    after = approach(speed, goal, acceleration, deceleration, DT)
    assert min(speed, goal) - 1e-12 <= after <= max(speed, goal) + 1e-12


@given(speed=speeds, goal=speeds, acceleration=changes, deceleration=changes)
def test_both_directions_are_mirror_images(speed: float, goal: float, acceleration: float, deceleration: float) -> None:
    forward = approach(speed, goal, acceleration, deceleration, DT)
    backward = approach(-speed, -goal, acceleration, deceleration, DT)
    assert forward == -backward


@given(speed=speeds, goal=speeds, acceleration=changes, deceleration=changes)
def test_every_speed_reaches_its_goal_in_the_time_that_the_limits_say(
    speed: float, goal: float, acceleration: float, deceleration: float
) -> None:
    longest = (abs(speed) + abs(goal)) / min(acceleration, deceleration)
    for _ in range(int(longest / DT) + 3):
        speed = approach(speed, goal, acceleration, deceleration, DT)
    assert speed == goal


def test_reversing_brakes_to_zero_before_it_accelerates() -> None:
    assert approach(0.001, -1.0, 0.3, 0.3, DT) == 0.0


@pytest.mark.parametrize("speed", [0.0, 0.4, -0.4])
def test_a_goal_that_is_reached_is_kept(speed: float) -> None:
    assert approach(speed, speed, 0.3, 0.3, DT) == speed


@given(remaining=distances, deceleration=changes)
def test_braking_speed_is_the_one_from_which_the_distance_suffices(remaining: float, deceleration: float) -> None:
    speed = braking_speed(remaining, deceleration, REACTION)
    assert speed * REACTION + speed**2 / (2 * deceleration) == pytest.approx(remaining)


def test_nothing_remaining_means_standing_still() -> None:
    assert braking_speed(0.0, 0.3, REACTION) == 0.0


@given(
    distance=distances,
    start=st.floats(0, 1),
    cruise=st.floats(0.05, 2),
    acceleration=changes,
    deceleration=changes,
)
def test_a_profile_ends_at_its_target_within_all_limits(
    distance: float, start: float, cruise: float, acceleration: float, deceleration: float
) -> None:
    """Start at rest, or at a speed from which the target can still be met."""
    speed = min(start, cruise, braking_speed(distance, deceleration, REACTION))
    remaining = distance
    highest = 0.0
    longest = distance / cruise + (cruise + 1) / acceleration + (cruise + 1) / deceleration + 3
    for _ in range(int(longest / DT)):
        goal = min(cruise, braking_speed(remaining, deceleration, REACTION))
        after = approach(speed, goal, acceleration, deceleration, DT)
        assert after >= goal or after >= speed, "the deceleration limit was not enough"
        speed = after
        remaining -= speed * DT
        highest = max(highest, speed)
        assert remaining > -0.001
    assert abs(remaining) < 0.005
    assert highest <= max(cruise, start) < inf
