"""Ranges against distances known from geometry."""

from collections.abc import Callable
from math import cos, inf, pi, radians
from statistics import mean, stdev

import pytest

from geometry import Pose2D, polygon_edges
from p2os.robot_model import RobotModel, SonarDisc
from p2os_emu.world import Block, World, WorldSpec, load_world

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]

WALL_AT_THREE = WorldSpec("walled", walls=(Block(3.05, 0.0, 0.0, 0.1, 20.0, 2.0),))

HALF_BEAM = radians(15)


def nearest_in_cone(world: World, pose: Pose2D, disc: SonarDisc, rays: int) -> float:
    """Distance from a disc's face to the nearest edge of the outline within its cone, by brute force."""
    face = pose.compose(Pose2D(disc.x, disc.y, disc.heading))
    blocks = (*world.spec.walls, *world.spec.furniture)
    edges = [edge for block in blocks for edge in polygon_edges(block.footprint)]
    directions = [face.heading + HALF_BEAM * (2 * i / (rays - 1) - 1) for i in range(rays)]
    return min(edge.hit_by(face.x, face.y, direction) for edge in edges for direction in directions)


@pytest.mark.parametrize("name", ["p3dx", "powerbot", "patrolbot-sh"])
def test_discs_that_face_a_wall_read_its_distance(name: str, model: Models, make_world: MakeWorld) -> None:
    world = make_world(WALL_AT_THREE)
    body = world.add_robot("robot", model(name), Pose2D(0.5, 0.0, 0.0))
    for disc in body.model.sonar:
        if abs(disc.heading) <= radians(15):
            assert body.ping([disc.number]) == [pytest.approx(3.0 - 0.5 - disc.x, rel=0.002)]


def test_a_slanted_disc_reads_the_near_edge_of_its_cone(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WALL_AT_THREE)
    body = world.add_robot("robot", model("p3dx"), Pose2D(0.5, 0.0, 0.0))
    disc = body.model.sonar[2]  # 30 degrees to the left
    assert disc.heading == pytest.approx(radians(30))
    assert body.ping([2]) == [pytest.approx((2.5 - disc.x) / cos(radians(15)), rel=0.001)]


@pytest.mark.parametrize("pose", [Pose2D(8.2, 6.1, 0.3), Pose2D(2.5, 2.5, 2.0), Pose2D(13.7, 9.3, -1.2)])
def test_in_the_office_every_disc_reads_the_nearest_surface_in_its_cone(
    pose: Pose2D, model: Models, make_world: MakeWorld
) -> None:
    world = make_world(load_world("office"))
    body = world.add_robot("robot", model("p3dx"), pose)
    for disc, range_ in zip(body.model.sonar, body.ping([disc.number for disc in body.model.sonar]), strict=True):
        exact = nearest_in_cone(world, pose, disc, rays=301)
        # A fan of rays meets a corner up to 5 degrees late, so it may read more, never less.
        assert exact - 0.002 <= range_ <= exact + 0.6 if exact < 4.9 else range_ > 4.8


def test_nothing_within_five_metres_is_no_echo(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    body = world.add_robot("robot", model("p3dx"))
    assert body.ping(range(16)) == [inf] * 16


def test_a_disc_that_is_not_fitted_hears_nothing(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WALL_AT_THREE, perfect=False)
    body = world.add_robot("robot", model("powerbot"))
    assert 7 not in [disc.number for disc in body.model.sonar]
    assert body.ping([7]) == [inf]


def test_no_discs_give_no_ranges(model: Models, make_world: MakeWorld) -> None:
    assert make_world().add_robot("robot", model("p3dx")).ping([]) == []


def test_a_wall_that_the_robot_touches_is_still_seen(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WALL_AT_THREE)
    body = world.add_robot("robot", model("patrolbot-sh"), Pose2D(2.5, 0.0, 0.0))
    for _ in range(240):
        body.drive(0.3, 0.3)
        world.step()
    assert body.ping([3, 4]) == pytest.approx([0.0, 0.0], abs=0.01)  # its discs stand out of the hull


def test_other_robots_are_seen_and_the_robot_itself_is_not(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    body = world.add_robot("looker", model("p3dx"))
    other = model("amigo")
    world.add_robot("other", other, Pose2D(2.0, 0.0, 0.0))
    ranges = body.ping(range(16))
    face = body.model.sonar[3]
    assert ranges[3] == pytest.approx(2.0 - other.length_rear - face.x, abs=0.01)
    assert ranges[8:] == [inf] * 8


def test_no_model_ever_sees_its_own_hull(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    for i, name in enumerate(["p2dx", "p3at", "peoplebot-sh", "patrolbot-sh", "powerbot", "amigo"]):
        body = world.add_robot(name, model(name), Pose2D(100.0 * i, 0.0, 0.7 * i))
        for turn in range(60):
            world.place(name, Pose2D(100.0 * i, 0.0, turn * pi / 30))
            assert set(body.ping([disc.number for disc in body.model.sonar])) == {inf}


def test_an_imperfect_disc_misses_a_wall_at_a_slant(model: Models, make_world: MakeWorld) -> None:
    pose = Pose2D(2.0, 0.0, radians(75))
    body = make_world(WALL_AT_THREE, perfect=False).add_robot("robot", model("p3dx"), pose)
    perfect = make_world(WALL_AT_THREE).add_robot("robot", model("p3dx"), pose)
    disc = body.model.sonar[3]  # 10 degrees to the left: the edge of its cone meets the wall at 70 degrees
    assert disc.heading == pytest.approx(radians(10))
    assert perfect.ping([3])[0] < inf
    assert body.ping([3]) == [inf]


def test_noise_is_about_one_per_cent(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WALL_AT_THREE, perfect=False)
    body = world.add_robot("robot", model("p3dx"))
    disc = body.model.sonar[3]
    ranges = [body.ping([3])[0] for _ in range(400)]
    assert mean(ranges) == pytest.approx(3.0 - disc.x, abs=0.01)
    assert 0.02 < stdev(ranges) < 0.04


def test_cross_talk_is_rare_and_only_between_discs_that_fire_together(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WALL_AT_THREE, perfect=False)
    body = world.add_robot("robot", model("p3dx"))
    true = 3.0 - body.model.sonar[3].x
    together = [body.ping([3, 11])[0] for _ in range(2000)]
    alone = [body.ping([3])[0] for _ in range(2000)]
    assert 0 < sum(range_ < true - 0.3 for range_ in together) < 20
    assert not any(range_ < true - 0.3 for range_ in alone)


def test_an_imperfect_disc_reads_no_less_than_its_ringing(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WALL_AT_THREE, perfect=False)
    body = world.add_robot("robot", model("p3dx"), Pose2D(2.78, 0.0, 0.0))
    assert body.ping([3, 4]) == [pytest.approx(0.1), pytest.approx(0.1)]
