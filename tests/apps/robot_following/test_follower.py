"""The follower behind a leader that moves by equations."""

from dataclasses import replace
from math import atan2, cos, hypot, inf, pi, sin
from random import Random

import numpy as np
import pytest

from apps.robot_following.follower import FollowerState, SightFollower
from apps.robot_following.leader import Sighting
from apps.robot_following.settings import FollowingSettings
from geometry import Point, Pose2D, Twist2D
from tests.apps.robot_following.stage import LEG, Stage

SETTINGS = FollowingSettings.load()
GAP = SETTINGS.drive.gap


def course(seed: int, seconds: float) -> list[LEG]:
    """A leader that drives straight, turns and stops as chance has it."""
    rng, legs = Random(f"course {seed}"), list[LEG]()
    while sum(leg[0] for leg in legs) < seconds:
        kind = rng.random()
        if kind < 0.15:
            legs.append((rng.uniform(1.5, 4.0), 0.0, 0.0))
        elif kind < 0.5:
            legs.append((rng.uniform(1.0, 3.0), 0.3, rng.choice((-1, 1)) * rng.uniform(0.2, 0.5)))
        else:
            legs.append((rng.uniform(2.0, 7.0), 0.3, 0.0))
    return legs


def bending(path: list[Point]) -> float:
    """Root of the mean square of a path's curvature, 1/m, over pieces of 10 cm."""
    places = [path[0]]
    for place in path:
        if hypot(place[0] - places[-1][0], place[1] - places[-1][1]) > 0.1:
            places.append(place)
    steps = np.diff(np.array(places), axis=0)
    return float(np.sqrt(np.mean(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))) ** 2))) / 0.1


@pytest.mark.parametrize("seed", [1])
def test_the_gap_is_kept_and_the_path_is_smoother_than_the_leaders(seed: int) -> None:
    stage = Stage(seed)
    stage.play(course(seed, 60.0))
    assert np.quantile(np.abs(np.array(stage.gaps[20:]) / GAP - 1.0), 0.95) < 0.15
    assert min(stage.gaps) > SETTINGS.drive.nearest
    assert bending(stage.robot_path) < bending(stage.leader_path)
    assert {step.state for step in stage.steps[1:]} <= {FollowerState.FOLLOWING, FollowerState.STANDING}


def test_behind_a_leader_that_stops_suddenly_it_stands_in_time() -> None:
    stage = Stage()
    stage.play([(8.0, 0.3, 0.0), (4.0, 0.0, 0.0)])
    assert stage.state is FollowerState.STANDING
    assert stage.speed == 0.0
    assert min(stage.gaps) > 0.85 * GAP


def test_it_does_not_move_before_it_sees_a_leader() -> None:
    stage = Stage(hidden=lambda time: True)
    stage.play([(5.0, 0.3, 0.0)])
    assert stage.state is FollowerState.WAITING
    assert stage.robot_path[-1] == (0.0, 0.0)


def test_a_short_loss_is_bridged() -> None:
    stage = Stage(hidden=lambda time: 6.0 < time < 6.5)
    stage.play([(12.0, 0.3, 0.0)])
    states = [step.state for step in stage.steps[1:]]
    assert FollowerState.COASTING in states
    assert FollowerState.SEARCHING not in states


def test_a_leader_out_of_sight_stops_it_and_it_goes_on_when_it_sees_it_again() -> None:
    stage = Stage(hidden=lambda time: 6.0 < time < 10.0)
    stage.play([(6.0, 0.3, 0.0), (2.0, 0.0, 0.0)])
    assert (stage.state, stage.speed) == (FollowerState.SEARCHING, 0.0)
    stage.play([(2.5, 0.0, 0.0), (6.0, 0.3, 0.0)])
    assert stage.steps[-1].state is FollowerState.FOLLOWING
    assert stage.gaps[-1] == pytest.approx(GAP, rel=0.15)


def test_the_head_looks_first_to_the_side_to_which_the_leader_turned() -> None:
    stage = Stage(hidden=lambda time: time > 6.0)
    stage.play([(4.0, 0.3, 0.0), (2.0, 0.3, -0.5)])
    before = len(stage.steps)
    stage.play([(5.0, 0.3, -0.5)])
    pans = [step.pan for step in stage.steps[before:] if step.state is FollowerState.SEARCHING]
    assert min(pans) == pytest.approx(-SETTINGS.search.pan, abs=0.1)
    assert pans.index(min(pans)) < next(number for number, pan in enumerate(pans) if pan > 0.1)


@pytest.mark.parametrize(("pan_reach", "side"), [(1.5, 1.0), (1.5, -1.0), (0.0, 1.0)])
def test_where_the_leader_was_last_it_turns_about_all_the_way(pan_reach: float, side: float) -> None:
    stage = Stage(pan_reach=pan_reach, hidden=lambda time: time > 6.0)
    stage.play([(4.0, 0.3, 0.0), (2.0, 0.3, 0.3 * side), (8.0, 0.3, 0.0)])
    stage.play([(30.0, 0.0, 0.0)])
    turns = [step.twist.angular for step in stage.steps if step.twist == Twist2D(0.0, step.twist.angular)]
    assert stage.state is FollowerState.SEARCHING
    assert set(turns[-100:]) == {SETTINGS.search.turn * side}  # in 10 s it turns by 5 rad


def test_a_long_search_ends() -> None:
    settings = replace(SETTINGS, search=replace(SETTINGS.search, give_up=20.0))
    stage = Stage(settings=settings, hidden=lambda time: time > 6.0)
    stage.play([(6.0, 0.3, 0.0), (22.0, 0.0, 0.0)])
    assert stage.state is FollowerState.GIVEN_UP
    assert stage.speed == 0.0


@pytest.mark.parametrize("aside", [0.0, 0.1, -0.2])
def test_an_obstacle_between_the_robots_holds_it(aside: float) -> None:
    stage = Stage(obstacles=[(3.0, aside)])
    stage.play([(20.0, 0.3, 0.0)])
    assert FollowerState.HELD in {step.state for step in stage.steps}
    assert 3.0 - stage.robot.x > 0.25  # the hull ends at 0.21 m


def test_an_obstacle_beside_the_way_does_not() -> None:
    stage = Stage(obstacles=[(3.0, 0.35), (4.0, -0.3)])
    stage.play([(20.0, 0.3, 0.0)])
    assert FollowerState.HELD not in {step.state for step in stage.steps}
    assert stage.gaps[-1] == pytest.approx(GAP, rel=0.15)


def test_it_never_drives_nearer_than_it_may_to_a_leader_that_comes_back() -> None:
    stage = Stage()
    stage.play([(5.0, 0.3, 0.0), (1.0, 0.0, 0.0)])
    stopped_at = stage.robot.x
    stage.play([(2.0, -0.2, 0.0)])
    assert stage.robot.x == pytest.approx(stopped_at, abs=0.05)


def test_without_a_head_the_robot_turns_to_a_leader_beside_it() -> None:
    stage = Stage(pan_reach=0.0, leader=Pose2D(1.15, 0.4, 0.0))
    stage.play([(6.0, 0.0, 0.0)])
    assert abs(stage.robot.bearing_to(stage.leader.x, stage.leader.y)) <= SETTINGS.drive.face + 0.05
    assert abs(stage.steps[-1].pan) == 0.0


def test_the_same_seed_gives_the_same_path() -> None:
    paths = []
    for _ in range(2):
        stage = Stage(seed=7)
        stage.play(course(7, 20.0))
        paths.append(stage.robot_path)
    assert paths[0] == paths[1]


@pytest.mark.parametrize("seed", range(4))
def test_speeds_are_never_above_the_limits(seed: int) -> None:
    rng = Random(seed)
    stage = Stage(
        seed, hidden=lambda time: rng.random() < 0.5, leader=Pose2D(1.5, rng.uniform(-0.5, 0.5), rng.uniform(-1, 1))
    )
    stage.play([(rng.uniform(0.5, 2.0), rng.uniform(-0.3, 0.6), rng.uniform(-pi, pi)) for _ in range(15)])
    fastest = max((abs(step.twist.linear) for step in stage.steps), default=inf)
    turns = max((abs(step.twist.angular) for step in stage.steps), default=inf)
    assert fastest <= SETTINGS.drive.speed
    assert turns <= SETTINGS.drive.turn
    assert all(step.twist.linear >= 0.0 for step in stage.steps)


def test_the_camera_looks_at_the_target_and_where_it_will_be_when_the_head_is_there() -> None:
    leader, known = Pose2D(0.9, 0.6, 0.7), SETTINGS.leader
    x = leader.x - known.carried * cos(leader.heading) - SETTINGS.camera.forward
    bearing = atan2(leader.y - known.carried * sin(leader.heading), x)
    follower = SightFollower(SETTINGS, 1.5)
    follower.see(Sighting(leader, 0.01, 0.05), 0.0)
    step = follower.step(0.0, Pose2D(), ())
    assert (step.state, step.twist.linear) == (FollowerState.STANDING, 0.0)
    assert step.pan == pytest.approx(bearing)
    assert step.twist.angular > 0.5
    turned = step.twist.angular * SETTINGS.search.pan_lead
    # The camera is before the middle about which the robot turns, so the bearing changes by a little less.
    assert follower.step(0.05, Pose2D(), ()).pan == pytest.approx(bearing - turned, abs=0.04)
