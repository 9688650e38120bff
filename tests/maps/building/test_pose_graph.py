"""Pose graphs: loops spread an error over the way, and a false one does not bend the map."""

from math import hypot, pi

import numpy as np
import pytest

from geometry import Pose2D
from maps.building.pose_graph import Edge, optimised, weights

EXACT = np.diag([1e4, 1e4, 1e5])
STEP = Pose2D(1.0, 0.0, pi / 10)  # along a circle: twenty steps lead back


def circle(bias: float) -> tuple[list[Pose2D], list[Edge]]:
    """Poses by dead reckoning whose turns err by rad, and their edges."""
    measured = Pose2D(STEP.x, STEP.y, STEP.heading + bias)
    poses = [Pose2D()]
    for _ in range(20):
        poses.append(poses[-1].compose(measured))
    return poses, [Edge(number, number + 1, measured, np.diag([1e3, 1e3, 1e3])) for number in range(20)]


def ends_apart(poses: list[Pose2D]) -> float:
    return hypot(poses[-1].x - poses[0].x, poses[-1].y - poses[0].y)


@pytest.mark.parametrize("bias", [0.01, -0.02])
def test_a_loop_brings_the_end_back_to_the_start(bias: float) -> None:
    poses, edges = circle(bias)
    assert ends_apart(poses) > 0.5
    closed = optimised(poses, [*edges, Edge(0, 20, Pose2D(), EXACT, may_be_false=False)])
    assert ends_apart(closed) < 0.02
    true = [Pose2D()]
    for _ in range(10):
        true.append(true[-1].compose(STEP))
    assert hypot(closed[10].x - true[10].x, closed[10].y - true[10].y) < 0.1


def test_a_loop_that_contradicts_all_others_counts_for_next_to_nothing() -> None:
    poses, edges = circle(0.0)
    right = Edge(0, 20, Pose2D(), EXACT, may_be_false=True)
    wrong = Edge(3, 14, Pose2D(0.2, 0.1, 0.3), EXACT, may_be_false=True)
    found = optimised(poses, [*edges, right, wrong])
    assert max(hypot(a.x - b.x, a.y - b.y) for a, b in zip(found, poses, strict=True)) < 0.05
    assert weights(found, [right, wrong])[0] > 0.9
    assert weights(found, [right, wrong])[1] < 0.01


def test_the_fixed_pose_stays_and_one_pose_needs_no_edges() -> None:
    poses, edges = circle(0.02)
    moved = [Pose2D(3.0, 4.0, 1.0).compose(pose) for pose in poses]
    found = optimised(moved, [*edges, Edge(0, 20, Pose2D(), EXACT)], fixed=(5,))
    assert found[5] == moved[5]
    assert optimised([Pose2D(1.0, 2.0)], []) == [Pose2D(1.0, 2.0)]
