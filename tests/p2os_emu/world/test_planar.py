"""Planar rays against geometry, and against the physics engine's own rays."""

from collections.abc import Callable
from dataclasses import replace
from math import cos, hypot, inf, pi, radians, sin

import numpy as np
import pytest

from geometry import Pose2D
from p2os.robot_model import RobotModel
from p2os_emu.body import Echoes, ScanBeams
from p2os_emu.world import Block, RobotBody, World, WorldSpec, load_world
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.rays import cast

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]

HALF_TURN = ScanBeams(0.0, 0.0, 0.2, -pi / 2, pi / 180, 181, 30.0)


def engine_ranges(world: World, body: RobotBody, beams: ScanBeams) -> list[float]:
    """The same beams, cast by the physics engine."""
    pose = body.pose
    x, y = pose.transform(beams.x, beams.y)
    bearings = [pose.heading + beams.first + beams.step * i for i in range(beams.count)]
    ends = [(x + beams.reach * cos(each), y + beams.reach * sin(each), beams.height) for each in bearings]
    hits = cast(world._client, [(x, y, beams.height)] * beams.count, ends, body.body_id)
    return [hit[2] * beams.reach if hit[0] >= 0 else inf for hit in hits]


@pytest.mark.parametrize("heading", [0.01, 0.7, -2.9])
def test_office_full_of_robots_looks_as_the_physics_engine_sees_it(
    heading: float, model: Models, make_world: MakeWorld
) -> None:
    world = make_world(load_world("office"))
    bodies = [world.add_robot(f"robot {number}", model("p3dx")) for number in range(6)]
    for name, body in zip(world.robots, bodies, strict=True):
        # Odd headings: a beam that meets a corner exactly may do so or not.
        world.place(name, replace(body.pose, heading=body.pose.heading + heading))
    for body in bodies:
        found, cosines, _ = body.scan(HALF_TURN)
        expected = np.array(engine_ranges(world, body, HALF_TURN))
        both = np.isfinite(found) & np.isfinite(expected)
        assert np.array_equal(np.isfinite(found), np.isfinite(expected))
        # Hulls under the engine lean a little: measured across their surface.
        assert np.max(np.abs(found[both] - expected[both]) * cosines[both]) < 0.001


@pytest.mark.parametrize("beams", [HALF_TURN, replace(HALF_TURN, first=-3.0, step=0.011, count=540)])
def test_a_wall_in_front_is_met_where_geometry_has_it(beams: ScanBeams, model: Models, make_world: MakeWorld) -> None:
    world = make_world(WorldSpec("walled", walls=(Block(3.05, 0.0, 0.0, 0.1, 4.0, 2.0, reflector=True),)))
    echoes = world.add_robot("robot", model("p3dx"), Pose2D(0.0, 0.0, 0.0)).scan(beams)
    for index in range(beams.count):
        bearing = beams.first + beams.step * index
        meets = cos(bearing) > 0 and abs(3.0 * sin(bearing) / cos(bearing)) < 2.0
        assert echoes.ranges[index] == pytest.approx(3.0 / cos(bearing) if meets else inf)
        assert echoes.cosines[index] == pytest.approx(cos(bearing) if meets else 0.0)
        assert echoes.reflects[index] == meets


def test_beams_that_go_clockwise_are_the_same_in_reverse(model: Models, make_world: MakeWorld) -> None:
    body = make_world(load_world("office")).add_robot("robot", model("p3dx"))
    forth, back = body.scan(HALF_TURN), body.scan(replace(HALF_TURN, first=pi / 2, step=-pi / 180))
    for one, other in zip(forth, back, strict=True):
        assert np.allclose(one, other[::-1])


def test_the_nearest_of_several_surfaces_is_met(model: Models, make_world: MakeWorld) -> None:
    blocks = tuple(Block(x, 0.0, 0.3 * x, 0.2, 1.0, 2.0) for x in (4.0, 2.0, 3.0))
    body = make_world(WorldSpec("rows", walls=blocks)).add_robot("robot", model("p3dx"), Pose2D(0.0, 0.0, 0.0))
    assert 1.7 < body.scan(HALF_TURN).ranges[90] < 1.95


def test_nothing_beyond_reach_and_nothing_too_low_is_met(model: Models, make_world: MakeWorld) -> None:
    low = Block(1.5, 0.0, 0.0, 0.2, 1.0, 0.15)
    body = make_world(WorldSpec("low", walls=(low, Block(6.0, 0.0, 0.0, 0.2, 1.0, 2.0)))).add_robot(
        "robot", model("p3dx"), Pose2D(0.0, 0.0, 0.0)
    )
    assert body.scan(HALF_TURN).ranges[90] == pytest.approx(5.9)
    assert np.all(np.isinf(body.scan(replace(HALF_TURN, reach=5.8)).ranges))
    assert body.scan(replace(HALF_TURN, height=0.1)).ranges[90] == pytest.approx(1.4)


def test_robots_see_each_other_where_they_are_now_and_never_themselves(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    seer = world.add_robot("seer", model("p3dx"), Pose2D(0.0, 0.0, 0.0))
    other = world.add_robot("other", model("p3dx"), Pose2D(3.0, 0.0, pi))
    front = other.chassis.front
    assert seer.scan(HALF_TURN).ranges[90] == pytest.approx(3.0 - front, abs=0.001)
    world.place("other", Pose2D(2.0, 0.0, pi))
    assert seer.scan(HALF_TURN).ranges[90] == pytest.approx(2.0 - front, abs=0.001)
    world.remove_robot("other")
    assert np.all(np.isinf(seer.scan(HALF_TURN).ranges))


def test_objects_are_seen_and_may_reflect(model: Models, make_world: MakeWorld) -> None:
    mark = Movable("mark", Shape.BOX, Pose2D(2.0, 0.0, 0.0), 0.2, 0.2, 0.5, 1.0, 0.5, "red", reflector=True)
    body = make_world(WorldSpec("marked", objects=(mark,))).add_robot("robot", model("p3dx"), Pose2D(0.0, 0.0, 0.0))
    echoes = body.scan(HALF_TURN)
    assert echoes.ranges[90] == pytest.approx(1.9, abs=0.003)
    assert echoes.reflects[90]


def noisy_scan(make_world: MakeWorld, model: Models, seed: int) -> Echoes:
    world = make_world(load_world("office"), perfect=False, seed=seed)
    return world.add_robot("robot", model("p3dx"), Pose2D(8.2, 6.1, 0.0)).scan(replace(HALF_TURN, noise=0.005))


def test_noise_is_as_wide_as_asked_for_and_comes_from_the_seed(model: Models, make_world: MakeWorld) -> None:
    exact = make_world(load_world("office")).add_robot("robot", model("p3dx"), Pose2D(8.2, 6.1, 0.0)).scan(HALF_TURN)
    first, again, other = (noisy_scan(make_world, model, seed) for seed in (1, 1, 2))
    assert np.array_equal(first.ranges, again.ranges)
    assert not np.array_equal(first.ranges, other.ranges)
    errors = first.ranges - exact.ranges
    assert 0.003 < np.std(errors[np.isfinite(errors)]) < 0.007


def test_a_perfect_world_has_no_noise(model: Models, make_world: MakeWorld) -> None:
    body = make_world(load_world("office")).add_robot("robot", model("p3dx"))
    assert np.array_equal(body.scan(HALF_TURN).ranges, body.scan(replace(HALF_TURN, noise=0.01)).ranges)


def test_corners_hide_nothing_and_let_nothing_through(model: Models, make_world: MakeWorld) -> None:
    """A closed ring of blocks, seen from inside with many beams: not one slips through a corner."""
    turns = [radians(30 * number) for number in range(12)]
    ring = tuple(Block(3.0 * cos(turn), 3.0 * sin(turn), turn, 0.2, 1.8, 2.0) for turn in turns)
    body = make_world(WorldSpec("ring", walls=ring)).add_robot("robot", model("p3dx"), Pose2D(0.0, 0.0, 0.0))
    ranges = body.scan(ScanBeams(0.0, 0.0, 0.2, -3.1, 0.0031, 2000, 30.0)).ranges
    assert np.min(ranges) > 2.89
    assert np.max(ranges) < hypot(2.9, 0.9)
