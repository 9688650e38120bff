"""What flows between components comes out as it went in."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apps.indoor_navigation.data import Data, DLEData, Door, GoalPoint, LaserRead, MotionCmd, WorldCoord
from bus import MessageError

METRES = st.floats(-1000.0, 1000.0)


def sent(data: Data) -> Data:
    """What is made of it after a journey as JSON."""
    return type(data).from_json(json.loads(json.dumps(data.to_json(), allow_nan=False)))


@given(METRES, METRES, st.none() | METRES)
def test_a_goal_comes_out_as_it_went_in(x: float, y: float, heading: float | None) -> None:
    goal = GoalPoint("m1", x, y, heading)
    assert sent(goal) == goal


@given(st.lists(METRES).map(tuple))
def test_a_path_among_what_needs_no_converting_comes_out_as_it_went_in(path: tuple[float, ...]) -> None:
    coord = WorldCoord(1.5, 7, "go", 1.0, 2.0, path=path)
    assert sent(coord) == coord


def test_doors_come_out_as_they_went_in() -> None:
    doors = DLEData(1.5, (0.0, 1.0, 0.5), (Door(1.0, 2.0, 0.9, 0.1, 0.8), Door(3.0, 2.0, 1.2, -0.1, 0.5)))
    assert sent(doors) == doors


@given(st.lists(st.floats(0.0, 80.0) | st.just(math.inf), max_size=40))
def test_ranges_travel_to_the_millimetre_and_infinite_ones_stay_infinite(ranges: list[float]) -> None:
    scan = LaserRead(0.0, (0.0, 0.0, 0.0), (0.1, 0.0, 0.0), -1.57, 0.00873, 8.0, np.array(ranges, dtype=float))
    come = sent(scan)
    assert isinstance(come, LaserRead)
    np.testing.assert_allclose(come.ranges, ranges, atol=0.00051)


@pytest.mark.parametrize("told", [{}, {"stamp": 1.0}, {"stamp": 1.0, "source": "goto", "velocity": 1.0}])
def test_something_else_is_told_apart(told: dict[str, object]) -> None:
    with pytest.raises(MessageError, match="this is not a valid MotionCmd"):
        MotionCmd.from_json(told)
