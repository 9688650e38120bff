import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry import Point
from p2os_emu.world.touches import Bumper

RING = Bumper(segments=5, reach=0.3, width=0.4)  # 1 m round half of the hull, 0.2 m a segment


@pytest.mark.parametrize(
    ("along", "left", "segment"),
    [
        (0.0, -0.2, 0),  # at the axle, right side
        (0.19, -0.2, 0),
        (0.25, -0.2, 1),
        (0.3, -0.15, 1),
        (0.3, 0.0, 2),  # dead ahead
        (0.3, 0.15, 3),
        (0.25, 0.2, 3),
        (0.1, 0.2, 4),
        (0.0, 0.2, 4),  # at the axle, left side
        (0.31, -0.01, 2),  # a little outside, as contacts are
    ],
)
def test_segments_are_counted_from_right_to_left(along: float, left: float, segment: int) -> None:
    assert RING.pressed([(along, left)]) == 1 << segment


def test_a_flat_obstacle_presses_all_between_the_ends_of_its_contact() -> None:
    assert RING.pressed([(0.3, -0.2), (0.3, 0.2)]) == 0b01110


def test_no_contact_presses_nothing() -> None:
    assert RING.pressed([]) == 0


def test_a_hull_without_segments_feels_nothing() -> None:
    assert Bumper(0, 0.3, 0.4).pressed([(0.3, 0.0)]) == 0


@given(st.integers(1, 7), st.lists(st.tuples(st.floats(0.0, 0.5), st.floats(-0.4, 0.4)), min_size=1))
def test_any_contact_presses_one_run_of_segments_that_exist(segments: int, contacts: list[Point]) -> None:
    pressed = Bumper(segments, 0.3, 0.4).pressed(contacts)
    assert 0 < pressed < 1 << segments
    run = pressed // (pressed & -pressed)
    assert run & (run + 1) == 0
