"""A pair in lockstep with rendered pictures, as the benchmark drives it."""

import math
from itertools import pairwise
from random import Random

import numpy as np
import pytest

from apps.robot_following.settings import FollowingSettings
from benchmarks.following_course import BENDS, FollowingCourse, route
from benchmarks.formation_course import straight
from p2os_emu.world import load_world
from p2os_emu.world.free_space import FreeSpace

SECONDS = 1.8


def test_a_follower_sees_its_leader_and_drives_and_the_same_seed_gives_the_same_paths() -> None:
    paths = []
    for _ in range(2):
        with FollowingCourse(load_world("office"), ("doc", "happy"), 10.0, FollowingSettings.load(), seed=1) as course:
            course.run(SECONDS)
            assert max(course.followers[0].track.unseen[20:]) < 0.3
            assert course.touches() == []
            paths.append(course.paths["happy"])
    assert math.dist((paths[0][0].x, paths[0][0].y), (paths[0][-1].x, paths[0][-1].y)) > 0.03
    assert paths[0] == paths[1]


@pytest.mark.parametrize("seed", range(5))
def test_routes_are_free_and_turn_in_curves_only(seed: int) -> None:
    line = straight(*route(Random(seed), 60.0))
    assert FreeSpace(load_world("office"), 0.4).are_free(np.array(line)).all()
    ways = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(line) if math.dist(a, b) > 1e-6]
    sharpest = max(abs(math.remainder(b - a, math.tau)) for a, b in pairwise(ways))
    assert sharpest < 1.5 * math.pi / 2.0 / 12.0
    assert min(BENDS) >= 0.5
