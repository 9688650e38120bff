"""Level rays of sonar by arithmetic, against the rays of the physics engine."""

from collections.abc import Callable
from dataclasses import replace
from math import cos, inf, pi, radians, sin
from random import Random

import pytest

from geometry import Pose2D
from p2os.robot_model import RobotModel
from p2os_emu.fit import read_fit
from p2os_emu.world import Block, RobotBody, World, WorldError, WorldSpec
from p2os_emu.world.engine import engine
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.moving_doors import MovingDoor
from p2os_emu.world.people import Person
from p2os_emu.world.rays import cast
from p2os_emu.world.sonar import SETBACK

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]

SHIFT = 0.002
"""m; the engine meets surfaces up to a millimetre early, so near corners it may meet what geometry does not."""
CLOSE = 0.002
"""m; a millimetre before a surface, along a ray that meets it at the greatest angle that reflects."""
TIE = 0.02
"""m; where a robot that is `SHIFT` to the side has a range so different, a ray is at a corner."""
MODELS = ("p3dx", "amigo", "powerbot", "p3at", "peoplebot-sh")
HALF_ROOM = 4.0


def engine_ranges(world: World, body: RobotBody, pose: Pose2D) -> list[float]:
    """Ranges of all discs, without noise, by the rays of the physics engine."""
    numbers = [disc.number for disc in body.model.sonar]
    world.engine_use.put_robots()
    starts, ends = body._sonar.rays(numbers, pose)
    return body._sonar.measure(numbers, ends, cast(world._client, starts, ends, body.body_id))


def plane_ranges(body: RobotBody) -> list[float] | None:
    """Ranges of all discs, without noise, by arithmetic; None where it does not suffice."""
    return body._sonar.in_plane([disc.number for disc in body.model.sonar], body.pose, body.body_id)


def room(random: Random) -> WorldSpec:
    """Walls, boxes, glass, cylinders, people and a door at any place and angle."""

    def place() -> tuple[float, float]:
        return random.uniform(-HALF_ROOM, HALF_ROOM), random.uniform(-HALF_ROOM, HALF_ROOM)

    def block(length: float, width: float) -> Block:
        height = random.choice([0.15, 0.25, 2.0])
        return Block(*place(), random.uniform(-pi, pi), length, width, height, glass=random.random() < 0.3)

    def movable(number: int) -> Movable:
        pose, width = Pose2D(*place(), random.uniform(-pi, pi)), random.uniform(0.1, 0.5)
        size = width, width, random.choice([0.15, 0.3, 0.6])
        return Movable(f"thing {number}", random.choice(list(Shape)), pose, *size, 5.0, 0.5, "red")

    def person(number: int) -> Person:
        (x, y), turn = place(), random.uniform(-pi, pi)
        return Person(f"person {number}", ((x, y), (x + 0.5 * cos(turn), y + 0.5 * sin(turn))), gives_way=False)

    walls = [block(random.uniform(0.5, 5.0), 0.1) for _ in range(random.randint(0, 5))]
    furniture = [block(random.uniform(0.1, 1.0), random.uniform(0.1, 1.0)) for _ in range(random.randint(0, 4))]
    (x, y), turn = place(), random.uniform(-pi, pi)
    door = MovingDoor("door", (x, y), (x + cos(turn), y + sin(turn)), is_open=False)
    return WorldSpec(
        "room",
        walls=tuple(walls),
        furniture=tuple(furniture),
        objects=tuple(movable(number) for number in range(random.randint(0, 4))),
        people=tuple(person(number) for number in range(random.randint(0, 2))),
        moving_doors=(door,),
    )


def fill(world: World, random: Random, model: Models) -> list[RobotBody]:
    """Put robots where there is room for them."""
    bodies = []
    for number in range(8):
        x, y = random.uniform(-HALF_ROOM, HALF_ROOM), random.uniform(-HALF_ROOM, HALF_ROOM)
        pose = Pose2D(x, y, random.uniform(-pi, pi))
        try:
            bodies.append(world.add_robot(f"robot {number}", model(random.choice(MODELS)), pose))
        except WorldError:  # something stands there; a room with fewer robots serves as well
            continue
    return bodies


def fill_and_settle(random: Random, make_world: MakeWorld, model: Models) -> tuple[World, list[RobotBody]]:
    """Make a room in which robots accelerate, so that their hulls lean, and whatever may fall has fallen."""
    while True:
        try:
            world = make_world(room(random))
        except WorldError:  # a route leads through a wall
            continue
        bodies = fill(world, random, model)
        for body in bodies:
            body.drive(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0))
        for _ in range(random.randint(5, 60)):
            world.step()
        return world, bodies


@pytest.mark.parametrize("perfect", [True, False])
@pytest.mark.parametrize("seed", range(25))
def test_rooms_sound_as_the_physics_engine_has_them(
    seed: int, perfect: bool, model: Models, make_world: MakeWorld
) -> None:
    world, bodies = fill_and_settle(Random(seed), lambda spec: make_world(spec, perfect=perfect), model)
    clear = compared = 0
    for body in bodies:
        pose = body.pose
        shifted = [(0.0, 0.0), (SHIFT, 0.0), (-SHIFT, 0.0), (0.0, SHIFT), (0.0, -SHIFT)]
        rows = [engine_ranges(world, body, replace(pose, x=pose.x + x, y=pose.y + y)) for x, y in shifted]
        found = plane_ranges(body)
        assert found is not None
        for range_, expected in zip(found, zip(*rows, strict=True), strict=True):
            compared += 1
            assert min(expected) - CLOSE <= range_ <= max(expected) + CLOSE
            if min(expected) == inf or max(expected) - min(expected) < TIE:
                clear += 1
                assert range_ == pytest.approx(expected[0], abs=TIE / 4)
    assert compared > 30
    assert clear > 0.9 * compared, "most rays meet no corner"


def test_glass_is_heard(model: Models, make_world: MakeWorld) -> None:
    pane = Block(2.05, 0.0, 0.0, 0.1, 4.0, 2.0, glass=True)
    body = make_world(WorldSpec("glass", walls=(pane,))).add_robot("robot", model("p3dx"), Pose2D(0.0, 0.0, 0.0))
    assert body.ping([3]) == [pytest.approx(2.0 - body.model.sonar[3].x, rel=0.002)]


def test_what_ends_below_the_discs_is_not_heard(model: Models, make_world: MakeWorld) -> None:
    low = Block(1.0, 0.0, 0.0, 0.1, 4.0, 0.19)
    high = Block(2.05, 0.0, 0.0, 0.1, 4.0, 0.21)
    body = make_world(WorldSpec("low", walls=(low, high))).add_robot("robot", model("p3dx"), Pose2D(0.0, 0.0, 0.0))
    assert body.ping([3]) == [pytest.approx(2.0 - body.model.sonar[3].x, rel=0.002)]


def test_a_person_is_round(model: Models, make_world: MakeWorld) -> None:
    person = Person("ann", ((2.0, 0.0), (3.0, 0.0)), pause=(10.0, 10.0))
    body = make_world(WorldSpec("crowd", people=(person,))).add_robot("robot", model("p3dx"), Pose2D(0.0, 0.0, 0.0))
    disc = body.model.sonar[3]  # 10 degrees to the left; its nearest ray runs straight at the person, 10 degrees right
    assert disc.heading == pytest.approx(radians(10))
    expected = 2.0 - disc.x - (0.25**2 - disc.y**2) ** 0.5
    assert body.ping([3]) == [pytest.approx(expected, abs=0.01)]


@pytest.mark.parametrize("shape", [Shape.BOX, Shape.CYLINDER])
def test_a_body_in_which_a_ray_starts_is_not_heard(shape: Shape, model: Models, make_world: MakeWorld) -> None:
    things = tuple(
        Movable(name, shape, Pose2D(x, 0.0, 0.0), 1.0, 1.0, 0.5, 100.0, 0.5, "red")
        for name, x in (("near", 2.0), ("far", 4.0))
    )
    world = make_world(WorldSpec("inside", objects=things))
    body = world.add_robot("robot", model("p3dx"), Pose2D(0.0, 0.0, 0.0))
    body.move_to(Pose2D(2.0, 0.0, 0.0))
    world._heard.forget_places()
    expected = engine_ranges(world, body, body.pose)
    assert plane_ranges(body) == pytest.approx(expected, abs=CLOSE)
    assert expected[3] == pytest.approx(4.0 - 0.5 - 2.0 - body.model.sonar[3].x, abs=0.02)


def test_a_wall_between_the_disc_and_the_start_of_its_rays_is_heard_behind_the_disc(
    model: Models, make_world: MakeWorld
) -> None:
    world = make_world(WorldSpec("walled", walls=(Block(1.05, 0.0, 0.0, 0.1, 4.0, 2.0),)))
    body = world.add_robot("robot", model("p3dx"), Pose2D(0.0, 0.0, 0.0))
    front = body.model.sonar[3]
    body.move_to(Pose2D(1.0 - front.x + 0.03, 0.0, -front.heading))
    found, expected = plane_ranges(body), engine_ranges(world, body, body.pose)
    assert found == pytest.approx(expected, abs=CLOSE)
    assert found is not None
    assert -SETBACK < found[3] < 0.0


def test_a_robot_is_heard_where_it_was_put_and_no_longer_when_it_is_gone(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    body = world.add_robot("looker", model("p3dx"), Pose2D(0.0, 0.0, 0.0))
    world.add_robot("other", model("amigo"), Pose2D(40.0, 0.0, 0.0))
    assert body.ping([3]) == [inf]
    world.place("other", Pose2D(2.0, 0.0, 0.0))
    assert 1.0 < body.ping([3])[0] < 2.0
    world.remove_robot("other")
    assert body.ping([3]) == [inf]


def test_what_the_plane_does_not_show_is_left_to_the_physics_engine(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    body = world.add_robot("plain", model("p3dx"), Pose2D(0.0, 0.0, 0.0))
    assert plane_ranges(body) is not None
    gripper_model, fit = read_fit(["gripper"], model("p3dx"))
    world.add_robot("gripper", gripper_model, Pose2D(3.0, 0.0, 0.0), fit)
    assert plane_ranges(body) is None, "paddles and lift are not boxes in the plane"
    assert body.ping([3])[0] < 3.0
    world.remove_robot("gripper")
    assert plane_ranges(body) is not None
    world.sonar_in_plane = False
    assert plane_ranges(body) is None
    shelf = Block(3.0, 0.0, 0.0, 0.1, 4.0, 0.1, bottom=0.7)
    under = make_world(WorldSpec("shelf", furniture=(shelf,))).add_robot("robot", model("p3dx"), Pose2D(0.0, 0.0, 0.0))
    assert plane_ranges(under) is None, "rays rise"


def test_what_has_fallen_over_is_left_to_the_physics_engine(model: Models, make_world: MakeWorld) -> None:
    post = Movable("post", Shape.CYLINDER, Pose2D(2.0, 0.0, 0.0), 0.1, 0.1, 1.0, 1.0, 0.5, "red")
    world = make_world(WorldSpec("post", objects=(post,)))
    body = world.add_robot("robot", model("p3dx"), Pose2D(0.0, 0.0, 0.0))
    assert plane_ranges(body) is not None
    (number,) = world.objects.bodies
    fallen = engine.getQuaternionFromEuler([0.0, radians(60.0), 0.0])
    world._client.resetBasePositionAndOrientation(number, [2.0, 0.0, 0.3], fallen)
    world._heard.forget_places()
    assert plane_ranges(body) is None
    assert body.ping([3])[0] < 2.0
