"""People who hear a robot let it pass: they step aside, or walk out of its way where there is no room."""

from collections.abc import Callable
from dataclasses import replace
from math import dist, pi

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from geometry import Pose2D
from p2os.robot_model import RobotModel
from p2os_emu.world import STEP, Block, Person, World, WorldError, WorldSpec
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.people import BODY_RADIUS
from p2os_emu.world.stepping_aside import BERTH, HEARING, WALL_BERTH, Asker, place_aside, place_away
from p2os_emu.world.walk import LONGEST_ASIDE

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]

ANNA = Person("Anna", ((0.0, 0.0), (6.0, 0.0)), patience=(60.0, 60.0))
FACING = Pose2D(4.0, 0.0, pi)


def corridor(width: float, person: Person = ANNA) -> WorldSpec:
    """A corridor along the route."""
    walls = tuple(Block(3.0, side * (width + 0.1) / 2.0, 0.0, 12.0, 0.1, 2.0) for side in (1.0, -1.0))
    return WorldSpec("corridor", walls=walls, people=(person,))


def run(world: World, seconds: float) -> None:
    for _ in range(round(seconds / STEP)):
        world.step()


def here(world: World) -> tuple[float, float]:
    place = world.people()["Anna"]
    return place.x, place.y


def met(world: World, robot: RobotModel, pose: Pose2D = FACING) -> tuple[float, float]:
    """Where Anna stands before a robot."""
    world.add_robot("robot", robot, pose)
    run(world, 5.0)
    return here(world)


def test_who_is_asked_steps_aside_by_as_much_as_the_robot_needs(model: Models, make_world: MakeWorld) -> None:
    world, powerbot = make_world(corridor(3.0)), model("powerbot")
    x, y = met(world, powerbot)
    assert y == 0.0
    world.sound("robot")
    run(world, 2.0)
    assert abs(here(world)[1]) >= powerbot.width / 2.0 + BODY_RADIUS + 0.1
    assert abs(here(world)[0] - x) < 0.6
    assert not world.people()["Anna"].walks


def test_who_is_asked_again_gives_more_room(model: Models, make_world: MakeWorld) -> None:
    world = make_world(corridor(4.0))
    met(world, model("p3dx-sh"))
    aside = []
    for _ in range(2):
        world.sound("robot")
        run(world, 2.0)
        aside.append(here(world)[1])
    assert aside[0] * aside[1] > 0.0, "on the same side"
    assert abs(aside[1]) >= abs(aside[0]) + 0.2


def test_who_stands_beside_the_way_of_the_robot_waits_there_until_it_has_passed(
    model: Models, make_world: MakeWorld
) -> None:
    beside = replace(ANNA, route=((0.0, 1.0), (3.0, 1.0)))
    world = make_world(corridor(4.0, beside))
    world.add_robot("robot", model("p3dx-sh"), Pose2D(4.5, 0.0, pi))
    run(world, 3.0)
    place = here(world)
    world.sound("robot")
    run(world, 3.0)
    assert here(world) == pytest.approx(place, abs=0.02)


def test_they_go_back_to_their_route_when_the_robot_has_passed_and_not_before(
    model: Models, make_world: MakeWorld
) -> None:
    world = make_world(corridor(3.0))
    x, _ = met(world, model("p3dx-sh"))
    world.sound("robot")
    run(world, 2.0)
    aside = here(world)
    world.place("robot", Pose2D(x, 0.0, pi))
    run(world, 3.0)
    assert here(world) == aside
    world.place("robot", Pose2D(x - 1.8, 0.0, pi))
    run(world, 3.0)
    assert here(world)[1] == 0.0
    assert here(world)[0] > x + 0.5, "they walk on"


def test_for_a_robot_that_does_not_come_they_do_not_wait_for_ever(model: Models, make_world: MakeWorld) -> None:
    world = make_world(corridor(3.0))
    x, _ = met(world, model("p3dx-sh"))
    world.sound("robot")
    run(world, LONGEST_ASIDE + 2.0)
    assert here(world) == pytest.approx((x, 0.0), abs=0.02), "they wait on their route again"


def test_who_stands_aside_for_a_robot_that_is_taken_away_goes_back(model: Models, make_world: MakeWorld) -> None:
    world = make_world(corridor(3.0))
    x, _ = met(world, model("p3dx-sh"))
    world.sound("robot")
    run(world, 2.0)
    world.remove_robot("robot")
    run(world, 2.0)
    assert here(world)[1] == 0.0
    assert here(world)[0] > x


def test_where_the_robot_could_not_pass_them_they_walk_back(model: Models, make_world: MakeWorld) -> None:
    world = make_world(corridor(1.2))
    x, _ = met(world, model("powerbot"))
    world.sound("robot")
    run(world, 2.0)
    assert here(world)[0] < x - 1.0
    assert here(world)[1] == 0.0


def test_who_rests_in_the_way_walks_on_where_they_cannot_step_aside(model: Models, make_world: MakeWorld) -> None:
    resting = replace(ANNA, route=((2.0, 0.0), (6.0, 0.0)), begin=4.0, pause=(60.0, 60.0))
    world = make_world(corridor(1.2, resting))
    world.add_robot("robot", model("powerbot"), Pose2D(7.5, 0.0, pi))
    run(world, 1.0)
    assert here(world) == (6.0, 0.0)
    world.sound("robot")
    run(world, 2.0)
    assert here(world)[0] < 5.0


def test_who_can_do_neither_goes_back_from_the_robot(model: Models, make_world: MakeWorld) -> None:
    at_the_end = replace(ANNA, route=((0.0, 0.0), (2.0, 0.0)), begin=2.0, pause=(60.0, 60.0))
    world = make_world(corridor(1.2, at_the_end))
    world.add_robot("robot", model("powerbot"), Pose2D(0.8, 0.0, 0.0))
    run(world, 1.0)
    world.sound("robot")
    run(world, 3.0)
    assert here(world) == pytest.approx((3.6, 0.0), abs=0.2)
    run(world, LONGEST_ASIDE)
    assert here(world) == (2.0, 0.0)


def test_nobody_steps_to_where_a_wall_is_between_them_and_their_route() -> None:
    wall = Block(1.0, 0.6, 0.0, 1.4, 0.1, 2.0)
    walking = FreeSpace(WorldSpec("wall", walls=(wall,)), BODY_RADIUS)
    asker = Asker(Pose2D(-1.5, 0.0, 0.0), 0.4, 0.3)
    behind = place_away((1.9, 1.0), (1.0, 0.0), asker, walking)
    assert walking.has_way(((1.9, 1.0), behind, (1.0, 0.0)))


@pytest.mark.parametrize(
    ("pose", "gives_way"),
    [(Pose2D(4.0, 0.0, pi), False), (Pose2D(4.0, 0.0, 0.0), True), (Pose2D(6.0, 1.5, pi), True)],
    ids=["who gives no way", "who is behind the robot", "who is far from it"],
)
def test_a_sound_does_not_move(pose: Pose2D, gives_way: bool, model: Models, make_world: MakeWorld) -> None:
    resting = replace(ANNA, gives_way=gives_way, route=((0.0, 0.0), (2.5, 0.0)), begin=2.5, pause=(60.0, 60.0))
    world = make_world(corridor(4.0, resting))
    world.add_robot("robot", model("p3dx-sh"), pose)
    run(world, 1.0)
    world.sound("robot")
    run(world, 2.0)
    assert here(world) == (2.5, 0.0)


def test_a_robot_that_is_not_there_makes_no_sound(make_world: MakeWorld) -> None:
    with pytest.raises(WorldError, match="there is no robot 'robot'"):
        make_world(corridor(2.0)).sound("robot")


def test_nobody_has_to_be_there_to_hear(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    world.add_robot("robot", model("p3dx-sh"), Pose2D())
    world.sound("robot")
    run(world, 0.1)


coordinates = st.floats(-2.5, 2.5)
boxes = st.lists(
    st.builds(
        Block, coordinates, coordinates, st.floats(-pi, pi), st.floats(0.1, 1.5), st.floats(0.1, 1.5), st.just(2.0)
    ),
    max_size=8,
)


@given(boxes, st.floats(-pi, pi), st.floats(1.0, HEARING), st.sampled_from([0.4, 0.63]))
def test_whoever_steps_aside_can_go_there_and_the_robot_can_pass(
    walls: list[Block], bearing: float, away: float, width: float
) -> None:
    spec = WorldSpec("random", walls=tuple(walls))
    walking, passing = FreeSpace(spec, BODY_RADIUS), FreeSpace(spec, width / 2.0 + WALL_BERTH)
    assume(walking.is_free((0.0, 0.0)))
    way = Pose2D(0.0, 0.0, bearing)  # that of the robot, from where somebody stands
    robot = way.compose(Pose2D(-away, 0.0, 0.0))
    place = place_aside((0.0, 0.0), (0.0, 0.0), Asker(robot, width, 0.5), walking, passing)
    if place is None:
        return
    if place != (0.0, 0.0):
        assert walking.has_way(((0.0, 0.0), place))
        assert dist(place, (robot.x, robot.y)) >= 0.5 + BODY_RADIUS
    ahead, beside = way.locate(*place)
    assert any(
        passing.is_free(way.transform(ahead, across))
        and abs(across - beside) >= width / 2.0 + BODY_RADIUS + BERTH - 1e-6
        for across in (step / 10.0 for step in range(-18, 19))
    )
