"""What is behind a face: the wall, which a robot may have seen from one side only."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apps.indoor_navigation.algorithms.bodies import Bodies
from apps.indoor_navigation.algorithms.perception import Perceived
from apps.indoor_navigation.algorithms.rays import Rays
from apps.indoor_navigation.algorithms.surroundings import DEPTHS, Surroundings, behind_faces
from apps.indoor_navigation.data import Floats, LaserRead, Pose

BEAMS = np.radians(np.linspace(-90.0, 90.0, 181))
FAR = 6.0  # m
# A wall across the way, 1 m ahead; it ends 0.5 m to the left, where a door is.
FACE, END = 1.0, 0.5


def ranges_before(distance: float, end: float, *, heading: float = 0.0) -> Floats:
    """What a scanner measures so far before the face of that wall, with its end so far to the left."""
    cosine = np.cos(BEAMS + heading)
    to_face = np.where(cosine > 0.01, distance / np.maximum(cosine, 0.01), FAR)
    is_wall = (cosine > 0.01) & (to_face * np.sin(BEAMS + heading) < end)
    return np.minimum(np.where(is_wall, to_face, FAR), FAR)


def rays_of(ranges: Floats, pose: Pose = (0.0, 0.0, 0.0)) -> Rays:
    return Rays.of_laser(LaserRead(0.0, pose, (0.0, 0.0, 0.0), -pi / 2.0, pi / 180.0, FAR, ranges), 181)


def perceived(ranges: Floats, stamp: float, pose: Pose) -> Perceived:
    return Perceived(stamp, pose, rays_of(ranges, pose), Bodies.none())


@given(st.floats(-pi, pi), st.floats(-5.0, 5.0), st.floats(0.4, 2.0), st.integers(0, 1000))
def test_a_wall_is_behind_its_face_wherever_the_robot_stands_and_looks(
    heading: float, x: float, distance: float, seed: int
) -> None:
    ranges = ranges_before(distance, END) + np.random.default_rng(seed).normal(0.0, 0.004, len(BEAMS))
    seen = rays_of(np.clip(ranges, 0.1, FAR), (x, 0.0, heading))
    chosen = np.flatnonzero(seen.hits & (np.abs(BEAMS) < 0.5))
    behind_x, behind_y = behind_faces(seen, chosen)
    ahead = cos(heading) * (behind_x - x) + sin(heading) * behind_y
    assert len(ahead) > len(chosen)
    assert np.all(ahead > distance + min(DEPTHS) - 0.04)
    assert np.all(ahead < distance + max(DEPTHS) + 0.04)


@pytest.mark.parametrize("width", [0.03, 0.06])
def test_nothing_is_known_to_be_behind_a_thin_leg(width: float) -> None:
    ranges = np.where(np.abs(np.sin(BEAMS)) < width / 2.0, 1.0, FAR)
    seen = rays_of(ranges)
    assert seen.hits.any()
    assert len(behind_faces(seen, np.flatnonzero(seen.hits))[0]) == 0


def test_no_chosen_ray_has_nothing_behind_it() -> None:
    assert len(behind_faces(rays_of(np.full(181, 2.0)), np.empty(0, np.intp))[0]) == 0
    assert len(behind_faces(Rays.none(), np.empty(0, np.intp))[0]) == 0


def turned_from_the_wall() -> Surroundings:
    """What a robot knows that has seen the face only, and has turned away from it to the right."""
    surroundings = Surroundings()
    for number, heading in enumerate(np.linspace(0.0, -2.6, 27)):
        ranges = ranges_before(FACE, END, heading=float(heading))
        surroundings.see(perceived(ranges, 0.1 * number, (0.0, 0.0, float(heading))))
    return surroundings


def test_the_end_of_a_wall_that_was_seen_from_its_face_only_is_an_obstacle_as_deep_as_a_wall() -> None:
    x, y = turned_from_the_wall().places((0.0, 0.0, 0.0))
    end = np.hypot(x - (FACE + max(DEPTHS)), y - END)
    assert end.min() < 0.04


def test_what_is_behind_a_face_is_forgotten_when_the_laser_looks_through_it() -> None:
    surroundings = turned_from_the_wall()
    assert np.any(surroundings.places((0.0, 0.0, 0.0))[0] > FACE + min(DEPTHS) - 0.02)
    # It was a thin board: when the robot has driven round it, the laser sees its back.
    thickness, beyond, y = 0.03, 0.6, 1.0
    to_back = (beyond - thickness) / np.maximum(-np.sin(BEAMS), 0.01)
    is_back = (BEAMS < 0.0) & (y - to_back * np.cos(BEAMS) < END)
    ranges = np.minimum(np.where(is_back, to_back, FAR), FAR)
    surroundings.see(perceived(ranges, 15.0, (FACE + beyond, y, -pi / 2.0)))
    x, _ = surroundings.places((0.0, 0.0, 0.0))
    assert np.any(np.abs(x - FACE) < 0.01), "the face is out of view there"
    assert not np.any(x > FACE + thickness + 0.01)
