"""Robots come, stand, go; worlds repeat themselves bit by bit."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from math import hypot, inf, nan

import pytest

from geometry import Pose2D, polygons_overlap
from p2os.robot_model import RobotModel
from p2os_emu.world import STEP, Block, Truth, World, WorldError, WorldSpec, load_world
from p2os_emu.world.chassis import Chassis
from p2os_emu.world.engine import engine

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]


def wander(world: World, model: Models, others: Sequence[World] = ()) -> tuple[list[object], list[Truth]]:
    """A few robots drive about, one leaves, another comes; returns all they felt and heard, and where they ended."""
    bodies = [world.add_robot(f"r{i}", model(name)) for i, name in enumerate(["p3dx", "powerbot", "amigo"])]
    felt: list[object] = []
    for step in range(240):
        for i, body in enumerate(bodies):
            body.drive(0.4 - 0.1 * i, 0.2 + 0.002 * step)
            if step % 5 == i:
                felt.append(body.ping([step % 8, 8 + step % 7]))
        if step == 120:
            world.remove_robot("r1")
            bodies[1] = world.add_robot("r3", model("p3at"))
        for each in (world, *others):
            each.step()
        felt.extend(body.state for body in bodies)
    return felt, [world.truth(name) for name in world.robots]


def test_the_same_seed_and_calls_give_the_same_bits(model: Models, make_world: MakeWorld) -> None:
    office = load_world("office")
    first = wander(make_world(office, perfect=False, seed=7), model)
    assert wander(make_world(office, perfect=False, seed=7), model) == first
    assert wander(make_world(office, perfect=False, seed=8), model) != first


def test_worlds_in_one_process_do_not_touch_each_other(model: Models, make_world: MakeWorld) -> None:
    office = load_world("office")
    alone = wander(make_world(office, perfect=False), model)
    beside = make_world(office, perfect=False)
    beside.add_robot("r0", model("p3dx")).drive(1.0, -1.0)
    assert wander(make_world(office, perfect=False), model, [beside]) == alone


def test_a_robot_draws_its_imperfections_from_seed_and_name(model: Models, make_world: MakeWorld) -> None:
    def chassis(name: str, **options: int) -> Chassis:
        return make_world(perfect=False, **options).add_robot(name, model("p3dx")).chassis

    assert chassis("a") == chassis("a")
    assert chassis("a") != chassis("b")
    assert chassis("a", seed=1) != chassis("a", seed=2)


def test_time_is_counted_in_steps(make_world: MakeWorld) -> None:
    world = make_world()
    for _ in range(12):
        world.step()
    assert world.steps == 12
    assert world.time == pytest.approx(12 * STEP)


def test_a_robot_stands_where_it_is_put(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    world.add_robot("robot", model("p3dx"), Pose2D(1.0, -2.0, 3.0))
    truth = world.truth("robot")
    assert (truth.pose.x, truth.pose.y, truth.pose.heading) == pytest.approx((1.0, -2.0, 3.0))
    assert (truth.linear, truth.angular) == (0.0, 0.0)


@pytest.mark.parametrize("name", ["powerbot", "p3dx", "amigo"])
@pytest.mark.parametrize("place", ["office", "empty"])
def test_twenty_robots_find_room_to_turn(place: str, name: str, model: Models, make_world: MakeWorld) -> None:
    world = make_world(load_world(place))
    for i in range(20):
        world.add_robot(f"r{i}", model(name))
    poses = [world.truth(robot).pose for robot in world.robots]
    shape = model(name)
    turning = hypot(max(shape.length_front, shape.length_rear), shape.width / 2)
    assert all(hypot(a.x - b.x, a.y - b.y) > 2 * turning for i, a in enumerate(poses) for b in poses[i + 1 :])
    blocks = [block.footprint for block in (*world.spec.walls, *world.spec.furniture)]
    square = [((p.x - turning, p.y), (p.x, p.y - turning), (p.x + turning, p.y), (p.x, p.y + turning)) for p in poses]
    assert not any(polygons_overlap(diamond, block) for diamond in square for block in blocks)


def test_a_full_world_says_so(model: Models, make_world: MakeWorld) -> None:
    walls = tuple(
        Block(x, y, 0.0, *size, 2.0)
        for x, y, size in [
            (1.0, 0.0, (0.1, 2.1)),
            (-1.0, 0.0, (0.1, 2.1)),
            (0.0, 1.0, (2.1, 0.1)),
            (0.0, -1.0, (2.1, 0.1)),
        ]
    )
    world = make_world(WorldSpec("cell", walls=walls))
    world.add_robot("first", model("p3dx"))
    with pytest.raises(WorldError, match="'cell' has no free place left for robot 'second'"):
        world.add_robot("second", model("p3dx"))


def test_no_robot_stands_in_a_wall_or_in_another(model: Models, make_world: MakeWorld) -> None:
    world = make_world(load_world("office"))
    with pytest.raises(WorldError, match=r"cannot stand at \(8\.20, 5\.10\) m: corridor, south side is in the way"):
        world.add_robot("robot", model("powerbot"), Pose2D(8.2, 5.1, 0.0))
    world.add_robot("first", model("powerbot"), Pose2D(8.2, 6.1, 0.0))
    with pytest.raises(WorldError, match="robot 'first' is in the way"):
        world.add_robot("second", model("powerbot"), Pose2D(8.9, 6.1, 0.0))
    assert world.robots == ("first",)


@pytest.mark.parametrize("pose", [Pose2D(nan, 0.0, 0.0), Pose2D(0.0, inf, 0.0), Pose2D(0.0, 0.0, nan)])
def test_no_robot_stands_at_what_is_no_number(pose: Pose2D, model: Models, make_world: MakeWorld) -> None:
    with pytest.raises(WorldError, match="give finite numbers"):
        make_world().add_robot("robot", model("p3dx"), pose)


def test_a_robot_is_not_placed_in_a_wall(model: Models, make_world: MakeWorld) -> None:
    world = make_world(load_world("office"))
    world.add_robot("robot", model("p3dx"))
    before = world.truth("robot")
    with pytest.raises(WorldError, match="in the way"):
        world.place("robot", Pose2D(0.0, 0.0, 0.0))
    assert world.truth("robot") == before


def test_a_robot_may_be_placed_where_it_stands(model: Models, make_world: MakeWorld) -> None:
    world = make_world(load_world("office"))
    world.add_robot("robot", model("p3dx"))
    world.place("robot", Pose2D(8.3, 6.1, 1.0))
    assert world.truth("robot").pose.heading == pytest.approx(1.0)


def test_how_often_a_robot_was_put_elsewhere_is_counted(model: Models, make_world: MakeWorld) -> None:
    world = make_world(load_world("office"))
    world.add_robot("robot", model("p3dx"))
    counts = [world.placed("robot")]
    for place in (Pose2D(8.3, 6.1), Pose2D(8.3, 6.1, 1.0), Pose2D()):
        with suppress(WorldError):  # the last one is refused, and must not be counted
            world.place("robot", place)
        counts.append(world.placed("robot"))
    assert counts == [0, 1, 2, 2]


def test_names_are_unique(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    world.add_robot("happy", model("p3dx"))
    with pytest.raises(WorldError, match="'happy' already"):
        world.add_robot("happy", model("p3dx"))


@pytest.mark.parametrize("ask", ["truth", "remove_robot"])
def test_an_unknown_robot_is_an_error_that_names_those_there(ask: str, model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    world.add_robot("happy", model("p3dx"))
    with pytest.raises(WorldError, match="no robot 'grumpy' in this world; there are: happy"):
        getattr(world, ask)("grumpy")


def test_a_removed_robot_leaves_its_place(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    world.add_robot("first", model("p3dx"), Pose2D())
    world.remove_robot("first")
    world.add_robot("first", model("p3dx"), Pose2D())
    world.step()
    assert world.robots == ("first",)


def test_a_window_needs_a_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    with pytest.raises(WorldError, match="no display"):
        World(WorldSpec("floor"), gui=True)


def test_closing_twice_does_nothing() -> None:
    with World(WorldSpec("floor")) as world:
        world.close()


def test_world_whose_window_is_closed_ends_without_an_error() -> None:
    with World(load_world("empty")) as world:
        reached_the_end = False
        with world.until_window_closes():
            world.step()
            world._client.disconnect()  # what closing the window does to the engine
            world.step()
            reached_the_end = True
        assert not reached_the_end


def test_other_errors_of_the_engine_are_not_taken_for_a_closed_window() -> None:
    with World(load_world("empty")) as world, pytest.raises(engine.error), world.until_window_closes():
        world._client.getBasePositionAndOrientation(1234)
