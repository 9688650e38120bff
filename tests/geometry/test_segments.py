from math import cos, hypot, inf, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry import Polygon, Pose2D, Segment, polygon_edges, polygons_overlap

metres = st.floats(-10.0, 10.0)
segments = st.builds(Segment, metres, metres, metres, metres)


def test_a_ray_reaches_the_wall_it_faces() -> None:
    wall = Segment(2.0, -1.0, 2.0, 1.0)
    assert wall.hit_by(0.0, 0.0, 0.0) == pytest.approx(2.0)
    assert wall.hit_by(0.0, 0.0, 0.3) == pytest.approx(2.0 / cos(0.3))


def test_a_ray_misses_what_lies_behind_beside_or_along_it() -> None:
    wall = Segment(2.0, -1.0, 2.0, 1.0)
    assert wall.hit_by(0.0, 0.0, pi) == inf
    assert wall.hit_by(0.0, 0.0, 1.0) == inf
    assert Segment(1.0, 0.0, 2.0, 0.0).hit_by(0.0, 0.0, 0.0) == inf


@given(st.floats(0.5, 50.0), st.floats(-pi, pi), st.floats(0.2, 2.9), st.floats(0.1, 5.0), metres, metres)
def test_a_ray_reaches_a_segment_laid_across_it(
    range_: float, direction: float, slant: float, half: float, x: float, y: float
) -> None:
    middle = x + range_ * cos(direction), y + range_ * sin(direction)
    dx, dy = half * cos(direction + slant), half * sin(direction + slant)
    across = Segment(middle[0] - dx, middle[1] - dy, middle[0] + dx, middle[1] + dy)
    assert across.hit_by(x, y, direction) == pytest.approx(range_, abs=1e-6)


@given(segments, metres, metres, st.floats(0.0, 1.0))
def test_no_point_of_the_segment_is_nearer_than_its_distance(segment: Segment, x: float, y: float, t: float) -> None:
    on_it = segment.x1 + t * (segment.x2 - segment.x1), segment.y1 + t * (segment.y2 - segment.y1)
    assert hypot(on_it[0] - x, on_it[1] - y) >= segment.distance_to(x, y) - 1e-9


def test_a_segment_without_length_is_a_point() -> None:
    assert Segment(1.0, 1.0, 1.0, 1.0).distance_to(4.0, 5.0) == pytest.approx(5.0)


def test_the_edges_of_a_polygon_close_it() -> None:
    edges = polygon_edges(((0.0, 0.0), (2.0, 0.0), (2.0, 1.0)))
    assert edges == (Segment(0.0, 0.0, 2.0, 0.0), Segment(2.0, 0.0, 2.0, 1.0), Segment(2.0, 1.0, 0.0, 0.0))
    assert edges[0].length == 2.0


SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))


@pytest.mark.parametrize(
    ("other", "overlap"),
    [
        (((0.5, 0.5), (2.0, 0.5), (2.0, 2.0)), True),
        (((0.2, 0.2), (0.4, 0.2), (0.3, 0.4)), True),  # inside
        (((1.0, 0.0), (2.0, 0.0), (2.0, 1.0)), True),  # touching
        (((1.1, 0.0), (2.0, 0.0), (2.0, 1.0)), False),
        (((1.0, 1.5), (1.5, 1.0), (2.0, 2.0)), False),  # past the corner, apart along a diagonal only
    ],
)
def test_polygons_overlap_unless_an_edge_parts_them(other: Polygon, overlap: bool) -> None:
    assert polygons_overlap(SQUARE, other) is overlap
    assert polygons_overlap(other, SQUARE) is overlap


@given(metres, metres, st.floats(-pi, pi))
def test_a_polygon_overlaps_itself_wherever_it_lies(x: float, y: float, heading: float) -> None:
    moved = tuple(Pose2D(x, y, heading).transform(*corner) for corner in SQUARE)
    assert polygons_overlap(moved, moved)
