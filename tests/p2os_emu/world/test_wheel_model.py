"""The model of the wheels beside the engine, and who computes a robot when."""

from math import hypot, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import configs
from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.world import World, WorldSpec, load_world
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.nearness import PERIOD, Circle, NearnessWatch
from p2os_emu.world.people import Person
from p2os_emu.world.robot_body import RobotBody
from p2os_emu.world.spec import Block, rectangle
from p2os_emu.world.still_outlines import FARTHEST, StillOutlines

RATE = 120  # steps in a second
MODELS = ("p3dx-sh", "powerbot", "amigo", "p2dx", "peoplebot-sh")
WALL = Block(2.0, 0.0, pi / 2.0, 4.0, 0.1, 1.0, "the wall")


def add(world: World, model: str = "p3dx-sh", pose: Pose2D | None = None, name: str = "happy") -> RobotBody:
    return world.add_robot(name, configs.load(RobotModel, "robots", model), pose or Pose2D(0.0, 0.0, 0.3))


def run(world: World, seconds: float) -> None:
    for _ in range(round(seconds * RATE)):
        world.step()


def course(model: str, *, is_spared: bool, acceleration: float) -> list[tuple[float, ...]]:
    """Places, and what the encoders see, in a drive whose speeds change with an acceleration, m/s²."""
    random = np.random.default_rng(7)
    with World(WorldSpec("empty"), seed=3) as world:
        world.engine_use.is_spared = is_spared
        robot = add(world, model)
        rims, wanted = np.zeros(2), np.zeros(2)
        seen: list[tuple[float, ...]] = []
        for step in range(20 * RATE):
            if step % (2 * RATE) == 0:
                wanted = random.choice([-0.3, 0.0, 0.2, 0.4, 0.6], 2)
            rims = rims + np.clip(wanted - rims, -acceleration / RATE, acceleration / RATE)
            robot.drive(*rims.tolist())
            world.step()
            assert robot.is_in_engine is not is_spared
            pose, state = robot.pose, robot.state
            seen.append((pose.x, pose.y, pose.heading, *state[:6]))
        return seen


@pytest.mark.parametrize("model", MODELS)
def test_a_robot_drives_as_the_engine_lets_it_drive(model: str) -> None:
    engine, wheels = (np.array(course(model, is_spared=spared, acceleration=0.3)) for spared in (False, True))
    off = np.abs(engine - wheels)
    off[:, 2] = np.abs((engine[:, 2] - wheels[:, 2] + pi) % (2.0 * pi) - pi)
    assert off[:, :2].max() < 0.005, "m, after 20 s"
    assert off[:, 2].max() < 0.01, "rad"
    assert off[:, 3:5].max() < 0.002, "m, of the encoders"
    assert off[:, 5:7].max() < 0.005, "m/s, of the encoders"
    assert np.percentile(off[:, 7:], 99.0) < 0.03, "loads of the motors; single steps of the engine's are off"


@pytest.mark.parametrize("model", MODELS)
def test_motors_that_give_all_they_can_accelerate_a_robot_as_in_the_engine(model: str) -> None:
    engine, wheels = (np.array(course(model, is_spared=spared, acceleration=50.0)) for spared in (False, True))
    assert np.abs(engine[:, 3:5] - wheels[:, 3:5]).max() < 0.02 * np.abs(engine[:, 3:5]).max(), "of the way"
    assert engine[:, 7:].max() == wheels[:, 7:].max() == 1.0


def test_a_robot_without_power_rolls_out_as_in_the_engine() -> None:
    ends = []
    for is_spared in (False, True):
        with World(WorldSpec("empty"), seed=3) as world:
            world.engine_use.is_spared = is_spared
            robot = add(world)
            robot.drive(0.6, 0.4)
            run(world, 2.0)
            robot.release()
            run(world, 2.0)
            assert robot.velocity == pytest.approx((0.0, 0.0), abs=0.002)
            ends.append(robot.pose)
    assert hypot(ends[0].x - ends[1].x, ends[0].y - ends[1].y) < 0.01


def test_the_engine_takes_over_before_a_robot_meets_a_wall_and_stops_it_there() -> None:
    ends = []
    for is_spared in (False, True):
        with World(WorldSpec("wall", walls=(WALL,)), seed=3) as world:
            world.engine_use.is_spared = is_spared
            robot = add(world, pose=Pose2D(0.0, 0.0, 0.0))
            robot.drive(0.5, 0.5)
            run(world, 1.0)
            assert robot.is_in_engine is not is_spared
            run(world, 5.0)
            assert robot.is_in_engine
            assert world.touches("happy").count == 1
            ends.append(robot.pose)
    assert ends[0].x == pytest.approx(ends[1].x, abs=0.005)
    assert ends[0].x < 1.95 - 0.2


def test_a_robot_that_leaves_a_wall_is_spared_again_and_goes_on_at_its_speed() -> None:
    with World(WorldSpec("wall", walls=(WALL,)), seed=3) as world:
        robot = add(world, pose=Pose2D(0.0, 0.0, 0.0))
        robot.drive(0.5, 0.5)
        run(world, 6.0)
        robot.drive(-0.3, -0.3)
        speeds = []
        for _ in range(3 * RATE):
            world.step()
            speeds.append(robot.velocity[0])
        assert not robot.is_in_engine
        assert speeds[RATE:] == pytest.approx([speeds[-1]] * (2 * RATE), abs=0.005)


def test_two_robots_that_drive_at_each_other_touch() -> None:
    with World(WorldSpec("empty"), seed=3) as world:
        left = add(world, pose=Pose2D(0.0, 0.0, 0.0), name="left")
        right = add(world, pose=Pose2D(3.0, 0.0, pi), name="right")
        for robot in (left, right):
            robot.drive(0.7, 0.7)
        run(world, 4.0)
        assert left.is_in_engine
        assert right.is_in_engine
        assert world.touches("left").count == world.touches("right").count == 1
        assert right.pose.x - left.pose.x > 0.4


def test_nobody_runs_into_a_robot_where_it_was() -> None:
    beside = Block(0.0, 0.5, 0.0, 12.0, 0.1, 1.0, "the wall")  # so near that the engine computes who drives along it
    with World(WorldSpec("wall", walls=(beside,)), seed=3) as world:
        first = add(world, pose=Pose2D(0.0, 0.0, -pi / 2.0), name="first")
        first.drive(0.6, 0.6)
        run(world, 4.0)
        assert not first.is_in_engine
        second = add(world, pose=Pose2D(-2.0, 0.12, 0.0), name="second")
        second.drive(0.5, 0.5)
        for _ in range(8 * RATE):
            world.step()
            assert second.is_in_engine
        assert second.pose.x > 1.5
        assert world.touches("second").count == 0


def test_somebody_who_walks_into_a_parked_robot_is_noticed() -> None:
    person = Person("Ada", ((2.0, 0.0), (-2.0, 0.0)), speed=0.8, gives_way=False)
    with World(WorldSpec("walk", people=(person,)), seed=3) as world:
        world.stop_people(True)
        add(world, pose=Pose2D(0.0, 0.0, 0.0))
        run(world, 4.0)
        world.stop_people(False)
        run(world, 4.0)
        assert world.touches("happy").count >= 1


def test_a_box_that_is_pushed_is_pushed_and_comes_to_rest_when_the_robot_has_left() -> None:
    box = Movable("box", Shape.BOX, Pose2D(0.8, 0.0, 0.0), 0.2, 0.2, 0.2, 0.5, 0.5, "red")
    with World(WorldSpec("box", objects=(box,)), seed=3) as world:
        robot = add(world, pose=Pose2D(0.0, 0.0, 0.0))
        robot.drive(0.6, 0.6)
        run(world, 3.0)
        robot.drive(-0.6, -0.6)
        run(world, 3.0)
        assert not robot.is_in_engine
        lies = world.object_places()["box"]
        assert lies.x > 1.2
        run(world, 2.0)
        assert world.object_places()["box"] == lies


def test_others_see_and_hear_a_robot_where_it_is() -> None:
    with World(WorldSpec("empty"), seed=3, perfect=True) as world:
        still = add(world, pose=Pose2D(0.0, 0.0, 0.0), name="still")
        driving = add(world, pose=Pose2D(4.0, 0.0, 0.0), name="driving")
        driving.drive(-0.4, -0.4)
        run(world, 5.0)
        assert not driving.is_in_engine
        gap = driving.pose.x - driving.chassis.rear
        assert min(still.ping(range(8))) == pytest.approx(gap - 0.21, abs=0.05)
        hulls = [each.place[0] for _, each in world.sight.news(set()).new.values() if each.place[0] > 1.0]
        assert min(abs(x - driving.pose.x) for x in hulls) < 0.001


def test_a_robot_put_next_to_another_one_is_computed_with_it_at_once() -> None:
    with World(WorldSpec("empty"), seed=3) as world:
        first, second = add(world, name="first"), add(world, pose=Pose2D(5.0, 0.0, 0.0), name="second")
        run(world, 1.0)
        assert not first.is_in_engine
        world.place("second", Pose2D(0.6, 0.0, 0.0))
        world.step()
        assert (first.is_in_engine, second.is_in_engine) == (True, True)


def test_the_same_seed_and_commands_give_the_same_states() -> None:
    ends = []
    for _ in range(2):
        with World(load_world("office"), seed=5) as world:
            robots = [world.add_robot(f"r{n}", configs.load(RobotModel, "robots", "p3dx-sh")) for n in range(4)]
            for robot in robots:
                robot.drive(0.3, 0.25)
            run(world, 10.0)
            ends.append([(robot.pose, robot.state) for robot in robots])
    assert ends[0] == ends[1]


@given(
    boxes=st.lists(
        st.tuples(*[st.floats(-5.0, 5.0)] * 2, st.floats(-pi, pi), *[st.floats(0.05, 4.0)] * 2), min_size=1, max_size=6
    ),
    x=st.floats(-5.0, 5.0),
    y=st.floats(-5.0, 5.0),
)
def test_the_distance_of_outlines_is_that_of_the_nearest_point_of_an_outline(
    boxes: list[tuple[float, float, float, float, float]], x: float, y: float
) -> None:
    outlines = [rectangle(Pose2D(bx, by, turned), ahead, ahead, width) for bx, by, turned, ahead, width in boxes]
    parts = np.linspace(0.0, 1.0, 400)[:, None]
    edges = [(np.array(a), np.array(b)) for each in outlines for a, b in zip(each, (*each[1:], each[0]), strict=True)]
    nearest = min(np.hypot(*(a + parts * (b - a) - (x, y)).T).min() for a, b in edges)
    assert StillOutlines(outlines).distance(x, y) == pytest.approx(min(FARTHEST, nearest), abs=0.02)


def test_where_nothing_stands_everything_is_clear() -> None:
    assert StillOutlines([]).distance(1e5, -3.0) == FARTHEST


@given(
    gap=st.floats(0.0, 1.5),
    speed=st.floats(0.0, 2.0),
    other_speed=st.floats(0.0, 2.0),
    has_room_already=st.booleans(),
)
def test_a_robot_with_room_cannot_be_touched_before_the_next_look(
    gap: float, speed: float, other_speed: float, has_room_already: bool
) -> None:
    watch = NearnessWatch(StillOutlines([]))
    if has_room_already:
        assert watch.look({"happy": Circle(0.0, 0.0, 0.4, 0.0)}, []) == {"happy"}
    found = watch.look({"happy": Circle(0.0, 0.0, 0.4, speed)}, [Circle(0.7 + gap, 0.0, 0.3, other_speed)])
    if found:
        assert gap > (speed + other_speed) * PERIOD
