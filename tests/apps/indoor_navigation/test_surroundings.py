"""What goto and avoiding know of obstacles that have left the view, and of the walls behind faces."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apps.indoor_navigation.algorithms.bodies import Bodies
from apps.indoor_navigation.algorithms.perception import Perceived
from apps.indoor_navigation.algorithms.rays import Rays
from apps.indoor_navigation.algorithms.surroundings import DEPTHS, Surroundings, behind_faces
from apps.indoor_navigation.data import Floats, LaserRead, Pose, SonarRead
from apps.indoor_navigation.parameters import shipped_parameters

BEAMS = np.radians(np.linspace(-90.0, 90.0, 361))
RAYS = shipped_parameters("obstacle_avoiding").senses.rays
FAR = 6.0  # m
# A wall across the way, 0.6 m ahead; it ends 0.3 m to the left, where a door is.
FACE, END = 0.6, 0.3


def rays_of(ranges: Floats, pose: Pose = (0.0, 0.0, 0.0)) -> Rays:
    return Rays.of_laser(LaserRead(0.0, pose, (0.0, 0.0, 0.0), -pi / 2.0, pi / 360.0, FAR, ranges), RAYS)


def seen_at(ranges: Floats, stamp: float = 0.0, pose: Pose = (0.0, 0.0, 0.0)) -> Perceived:
    return Perceived(stamp, pose, rays_of(ranges, pose), Bodies.none())


@pytest.mark.parametrize("step", [0.005, 0.02, 0.05])
def test_what_leaves_the_view_is_remembered_however_slowly_it_does(step: float) -> None:
    surroundings = Surroundings()
    angles = np.radians(np.linspace(-90.0, 90.0, 361))
    along = np.arange(0.0, 0.61, step)
    for number, x in enumerate(along):
        ranges = 0.4 / np.maximum(np.abs(np.sin(angles)), 0.05)  # a corridor 0.8 m wide
        surroundings.see(seen_at(ranges, 0.1 * number, (float(x), 0.0, 0.0)))
    x, y = surroundings.places((float(along[-1]), 0.0, 0.0))
    behind = np.sort(x[(x < 0.0) & (y > 0.0)])
    assert behind[0] < -0.5
    assert np.diff(behind).max() < 0.08


def test_what_has_left_the_view_is_remembered_and_what_is_seen_through_is_not() -> None:
    surroundings = Surroundings()
    ranges = np.full(361, 5.0)
    ranges[:40] = 0.5  # to the right
    surroundings.see(seen_at(ranges))
    surroundings.see(seen_at(np.full(361, 5.0), 0.1, (0.4, 0.0, 0.0)))
    x, y = surroundings.places((0.4, 0.0, 0.0))
    assert len(x) > 3
    assert y.max() < -0.3
    surroundings.see(seen_at(np.full(361, 5.0), 0.2, (-0.5, 0.0, 0.0)))
    assert len(surroundings.places((0.0, 0.0, 0.0))[0]) == 0


def test_what_was_beside_the_robot_is_remembered_when_it_backs_up_to_it_again() -> None:
    surroundings = Surroundings()
    ranges = np.full(361, 5.0)
    ranges[:40] = 0.5  # to the right
    for number, x in enumerate((0.0, 0.4, 0.8, 1.2, 1.6, 1.2, 0.8, 0.4)):
        seen = ranges if number == 0 else np.full(361, 5.0)
        surroundings.see(seen_at(seen, 0.1 * number, (x, 0.0, 0.0)))
    assert len(surroundings.places((0.4, 0.0, 0.0))[0]) > 3
    surroundings.see(seen_at(np.full(361, 5.0), 1.0, (3.0, 0.0, 0.0)))
    surroundings.see(seen_at(np.full(361, 5.0), 1.1, (2.0, 0.0, 0.0)))
    assert len(surroundings.places((0.4, 0.0, 0.0))[0]) == 0, "it was too far away meanwhile"


def listened(stamp: float, x: float, *ranges: float) -> Perceived:
    """What two discs hear, ahead and to the left, of a robot that has driven so far."""
    headings, zeros = np.array([0.0, pi / 2.0]), np.zeros(2)
    echoes = SonarRead(stamp, (x, 0.0, 0.0), zeros, np.array([0.0, 0.01]), headings, np.array(ranges))
    return Perceived(stamp, echoes.pose, Rays.of_sonar(echoes), Bodies.none())


def test_without_a_laser_an_echo_is_remembered_between_the_cones_and_not_where_a_disc_hears_through() -> None:
    surroundings = Surroundings()
    surroundings.see(listened(0.0, 0.0, 5.0, 0.5))
    surroundings.see(listened(0.1, -0.4, 5.0, 5.0))  # the leg is ahead on the left, between the two cones
    x, y = surroundings.places((0.0, 0.0, 0.0))
    assert np.hypot(x, y - 0.51).min() < 0.01
    surroundings.see(listened(0.2, 0.0, 5.0, 5.0))
    assert len(surroundings.places((0.0, 0.0, 0.0))[0]) == 0


def test_what_was_seen_before_the_pose_jumped_is_forgotten() -> None:
    surroundings = Surroundings()
    ranges = np.full(361, 5.0)
    ranges[:40] = 0.5  # to the right
    surroundings.see(seen_at(ranges))
    surroundings.see(seen_at(np.full(361, 5.0), 0.1, (0.4, 0.0, 0.0)))
    assert len(surroundings.places((0.4, 0.0, 0.0))[0]) > 3
    surroundings.see(seen_at(np.full(361, 5.0), 0.2, (0.4, 0.9, 0.0)))
    assert len(surroundings.places((0.4, 0.0, 0.0))[0]) == 0


def test_nothing_is_seen_where_nothing_is() -> None:
    assert len(Rays.none().followed_by(Rays.none()).end_x) == 0
    assert len(Surroundings().places((0.0, 0.0, 0.0))[0]) == 0


def ranges_before(distance: float, end: float, *, heading: float = 0.0) -> Floats:
    """What a scanner measures so far before the face of that wall, with its end so far to the left."""
    cosine = np.cos(BEAMS + heading)
    to_face = np.where(cosine > 0.01, distance / np.maximum(cosine, 0.01), FAR)
    is_wall = (cosine > 0.01) & (to_face * np.sin(BEAMS + heading) < end)
    return np.minimum(np.where(is_wall, to_face, FAR), FAR)


@given(st.floats(-pi, pi), st.floats(-5.0, 5.0), st.floats(0.4, 1.0), st.integers(0, 1000))
def test_a_wall_is_behind_its_face_wherever_the_robot_stands_and_looks(
    heading: float, x: float, distance: float, seed: int
) -> None:
    ranges = ranges_before(distance, END) + np.random.default_rng(seed).normal(0.0, 0.004, len(BEAMS))
    seen = rays_of(np.clip(ranges, 0.1, FAR), (x, 0.0, heading))
    aside = cos(heading) * seen.end_y - sin(heading) * (seen.end_x - x)
    chosen = np.flatnonzero(seen.hits & (np.abs(aside) < END))
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
        surroundings.see(seen_at(ranges, 0.1 * number, (0.0, 0.0, float(heading))))
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
    for number in range(5):  # its beams are 2 cm apart there, and it turns a little
        heading = -pi / 2.0 + 0.01 * number
        turned = np.interp(BEAMS + 0.01 * number, BEAMS, ranges)
        surroundings.see(seen_at(turned, 15.0 + 0.1 * number, (FACE + beyond, y, heading)))
    x, _ = surroundings.places((0.0, 0.0, 0.0))
    assert np.any(np.abs(x - FACE) < 0.01), "the face is out of view there"
    assert not np.any(x > FACE + thickness + 0.01)
