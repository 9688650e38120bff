"""The filter: what robots hear of each other corrects their odometry, and what else they hear does not."""

import math
from random import Random

from apps.formation.members import MemberState, RangeEcho
from apps.formation.pose_filter import PoseFilter
from apps.formation.settings import FormationSettings
from geometry import Pose2D, Twist2D, integrate

SETTINGS = FormationSettings.load().poses
DISCS = [Pose2D(0.1 * math.cos(a), 0.1 * math.sin(a), a) for a in (math.radians(20 * n + 10) for n in range(18))]
BEND = 0.005  # rad/m that the follower turns in excess of its odometry


def drive(seconds: float, wall: float | None = None) -> tuple[float, float]:
    """Drive two robots side by side in a circle; returns the error of their relative position without and with filter.

    wall: a range, m, that all discs without an echo of a robot have.
    """
    rng, fused = Random(1), PoseFilter(SETTINGS)
    twists = {"a": Twist2D(0.25, 0.1), "b": Twist2D(0.35, 0.1)}
    true = {"a": Pose2D(), "b": Pose2D(0.0, -1.0, 0.0)}
    odometry = dict(true)
    corrected = dict(true)
    for step in range(round(seconds / 0.1)):
        for name, twist in twists.items():
            excess = BEND * twist.linear if name == "b" else 0.0
            true[name] = integrate(true[name], Twist2D(twist.linear, twist.angular + excess), 0.1)
            odometry[name] = integrate(odometry[name], twist, 0.1)
        states, world = {}, knowing(true)
        for name in true:
            echoes = [ranged(world, name, number, rng, wall) for number in range(len(DISCS)) if number % 6 == step % 6]
            heard = tuple(echo for echo in echoes if math.isfinite(echo.distance))
            states[name] = MemberState(odometry[name], twists[name], 0.1 * step, heard)
        corrected = {name: state.pose for name, state in fused.update(states).items()}
    expected = true["b"].relative_to(true["a"])
    alone, both = (poses["b"].relative_to(poses["a"]) for poses in (odometry, corrected))
    return (
        math.dist((alone.x, alone.y), (expected.x, expected.y)),
        math.dist((both.x, both.y), (expected.x, expected.y)),
    )


def knowing(true: dict[str, Pose2D]) -> PoseFilter:
    """A filter that knows where the robots are, and computes the ranges that they measure."""
    found = PoseFilter(SETTINGS)
    found.update({name: MemberState(pose, Twist2D(), 0.0) for name, pose in true.items()})
    return found


def ranged(world: PoseFilter, name: str, number: int, rng: Random, wall: float | None) -> RangeEcho:
    other = "b" if name == "a" else "a"
    distance = float(world.expected_ranges(name, other, RangeEcho(number, DISCS[number], 0.0))[0])
    if not math.isfinite(distance) and wall is not None:
        distance = wall
    return RangeEcho(number, DISCS[number], distance + rng.gauss(0.0, 0.01))


def test_echoes_of_the_other_robot_correct_the_drift() -> None:
    alone, corrected = drive(40.0)
    assert alone > 0.1
    assert corrected < 0.05


def test_echoes_of_a_wall_do_no_harm() -> None:
    _, corrected = drive(20.0, wall=1.8)
    assert corrected < 0.06


def test_without_echoes_the_poses_are_those_of_the_odometry() -> None:
    fused = PoseFilter(SETTINGS)
    pose = Pose2D(1.0, 2.0, 3.0)
    for _ in range(50):
        pose = integrate(pose, Twist2D(0.3, 0.3), 0.1)
        found = fused.update({"a": MemberState(pose, Twist2D(), 0.0)})["a"].pose
    assert math.dist((found.x, found.y), (pose.x, pose.y)) < 1e-9
