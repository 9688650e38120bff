"""Saving computing time: what is parked, and what nothing can touch, is not computed, and people can be stopped."""

from collections.abc import Iterator

import pytest

import configs
from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.fit import Fit
from p2os_emu.world import World, WorldSpec, load_world
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.robot_body import RobotBody
from p2os_emu.world.spec import Block

PARKED = 3.0
"""s for which a robot stands until it is no more computed."""


@pytest.fixture
def world() -> Iterator[World]:
    with World(WorldSpec("empty"), seed=3) as world:
        yield world


def is_resting(robot: RobotBody) -> bool:
    return robot.is_resting


def add(world: World, name: str, x: float, fit: Fit | None = None) -> RobotBody:
    model = configs.load(RobotModel, "robots", "p3dx-sh")
    return world.add_robot(name, model, Pose2D(x, 0.0, 0.0), fit or Fit())


def run(world: World, seconds: float) -> None:
    for _ in range(round(seconds * 120)):
        world.step()


def test_parked_robots_rest_and_robots_that_drive_do_not(world: World) -> None:
    parked, driving = add(world, "parked", 0.0), add(world, "driving", 3.0)
    driving.drive(0.01, 0.01)
    run(world, 6.0)
    assert (is_resting(parked), is_resting(driving)) == (True, False)
    assert driving.pose.x == pytest.approx(3.0 + 6.0 * 0.01, rel=0.1), "however slowly it drives"


def test_a_robot_that_rests_is_woken_by_its_motors_and_drives_as_ever(world: World) -> None:
    robot = add(world, "happy", 0.0)
    run(world, PARKED + 0.5)
    assert is_resting(robot)
    robot.drive(0.3, 0.3)
    run(world, 2.0)
    assert robot.pose.x == pytest.approx(0.6, abs=0.05)
    assert robot.state.left_travel == pytest.approx(robot.pose.x, rel=0.03)


def test_a_robot_that_rests_is_pushed_like_any_other(world: World) -> None:
    pusher, parked = add(world, "pusher", 0.0), add(world, "parked", 0.8)
    run(world, PARKED + 0.5)
    assert is_resting(parked)
    pusher.drive(0.5, 0.5)
    run(world, 3.0)
    assert not is_resting(parked)
    assert parked.pose.x > 1.2
    assert parked.state.left_travel > 0.3
    assert pusher.state.left_load > 0.0


def test_a_robot_that_stands_for_a_short_time_does_not_rest(world: World) -> None:
    robot = add(world, "happy", 0.0)
    for _ in range(3):
        run(world, PARKED - 0.5)
        assert not is_resting(robot)
        robot.drive(0.1, 0.1)
        run(world, 0.5)
        robot.drive(0.0, 0.0)


def test_a_robot_that_rests_feels_a_touch_in_the_same_step(world: World) -> None:
    pusher, parked = add(world, "pusher", 0.0), add(world, "parked", 0.8)
    run(world, PARKED + 0.5)
    assert is_resting(parked)
    pusher.drive(0.5, 0.5)
    while not pusher.touched:
        world.step()
    assert parked.body_id in pusher.touched
    assert pusher.body_id in parked.touched
    assert not parked.is_resting


def test_a_robot_that_leans_on_a_wall_goes_on_feeling_it() -> None:
    wall = Block(1.0, 0.0, 0.0, 0.1, 2.0, 1.0)
    with World(WorldSpec("wall", walls=(wall,)), seed=3) as world:
        robot = add(world, "happy", 0.0)
        robot.drive(0.3, 0.3)
        while not robot.touched:
            world.step()
        robot.drive(0.0, 0.0)
        run(world, PARKED + 0.5)
        assert robot.is_resting != bool(robot.touched)
        robot.drive(0.02, 0.02)
        run(world, 1.0)
        robot.drive(0.0, 0.0)
        run(world, PARKED + 0.5)
        assert robot.is_resting != bool(robot.touched)


def test_a_robot_that_rests_can_be_put_elsewhere(world: World) -> None:
    robot = add(world, "happy", 0.0)
    run(world, PARKED + 0.5)
    world.place("happy", Pose2D(2.0, 1.0, 0.5))
    run(world, 1.0)
    assert (robot.pose.x, robot.pose.y, robot.pose.heading) == pytest.approx((2.0, 1.0, 0.5), abs=0.01)


def test_an_arm_of_a_robot_that_rests_moves_when_it_is_told_to(world: World) -> None:
    robot = add(world, "happy", 0.0, Fit({"arm": "pioneer"}))
    assert robot.arm is not None
    run(world, PARKED + 0.5)
    was_resting = is_resting(robot)
    robot.arm.move(0, 0.5, 0.2)
    run(world, 4.0)
    assert was_resting
    assert robot.arm.positions[0] == pytest.approx(0.5, abs=0.02)


def test_people_stand_still_and_walk_on_from_there() -> None:
    with World(load_world("people-lab"), seed=1) as lab:
        run(lab, 1.0)
        assert lab.people()["Anna"].walks
        lab.stop_people(True)
        stood = lab.people()["Anna"]
        assert not stood.walks
        run(lab, 2.0)
        assert lab.people()["Anna"] == stood
        lab.stop_people(False)
        run(lab, 0.5)
        assert lab.people()["Anna"][:2] != stood[:2]


def test_a_gripper_of_a_robot_that_rests_closes_when_it_is_told_to(world: World) -> None:
    robot = add(world, "happy", 0.0, Fit({"gripper": "pioneer"}))
    assert robot.gripper is not None
    run(world, PARKED + 0.5)
    was_resting = is_resting(robot)
    robot.gripper.drive(-1.0, 1.0)
    run(world, 4.0)
    assert was_resting
    assert (robot.gripper.state.opening, robot.gripper.state.lift) == pytest.approx((0.0, 1.0), abs=0.05)


class EngineSteps:
    """Counts what the engine computes of a world."""

    def __init__(self, world: World, monkeypatch: pytest.MonkeyPatch) -> None:
        self.count = 0
        step = world._client.stepSimulation

        def counted() -> None:
            self.count += 1
            step()

        monkeypatch.setattr(world._client, "stepSimulation", counted, raising=False)

    def during(self, world: World, seconds: float) -> int:
        before = self.count
        run(world, seconds)
        return self.count - before


def test_where_nothing_moves_the_engine_computes_nothing_and_time_goes_on(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    engine = EngineSteps(world, monkeypatch)
    first = add(world, "first", 0.0)
    add(world, "second", 3.0)
    run(world, PARKED + 0.5)
    began = world.time
    assert engine.during(world, 2.0) == 0
    assert world.time - began == pytest.approx(2.0)
    first.drive(0.3, 0.3)
    assert engine.during(world, 1.0) == 0, "nothing can touch it"
    assert first.pose.x > 0.2
    assert engine.during(world, 8.0) > 120, "it has come to the second one"


def test_people_walk_on_where_the_engine_computes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    with World(load_world("people-lab"), seed=1) as lab:
        engine = EngineSteps(lab, monkeypatch)
        run(lab, 1.0)
        before = dict(lab.people())
        assert engine.during(lab, 1.0) == 0
        assert dict(lab.people()) != before


def test_a_robot_among_people_is_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    with World(load_world("people-lab"), seed=1) as lab:
        engine = EngineSteps(lab, monkeypatch)
        lab.stop_people(True)
        someone = next(iter(lab.people().values()))
        model = configs.load(RobotModel, "robots", "p3dx-sh")
        lab.add_robot("happy", model, Pose2D(someone.x, someone.y - 0.75, 0.0))
        run(lab, PARKED + 0.5)
        assert engine.during(lab, 1.0) == 120, "although it is parked: who touches it must be noticed"


def test_a_box_that_was_pushed_stays_where_it_came_to_rest_and_is_pushed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    box = Movable("box", Shape.BOX, Pose2D(0.6, 0.0, 0.0), 0.2, 0.2, 0.2, 0.5, 0.5, "red")
    with World(WorldSpec("box", objects=(box,)), seed=3) as world:
        engine = EngineSteps(world, monkeypatch)
        robot = add(world, "happy", 0.0)
        run(world, PARKED + 0.5)
        robot.drive(0.4, 0.4)
        run(world, 2.0)
        robot.drive(0.0, 0.0)
        assert engine.during(world, 1.0) == 120
        run(world, PARKED + 3.0)
        lies = world.object_places()["box"]
        assert lies.x > 0.8
        assert engine.during(world, 2.0) == 0
        robot.drive(0.4, 0.4)
        run(world, 1.0)
        assert world.object_places()["box"].x > lies.x


def test_sonar_of_robots_that_rest_hears_at_once_what_is_put_before_it(world: World) -> None:
    robot, other = add(world, "happy", 0.0), add(world, "other", 3.0)
    ahead = list(range(8))
    run(world, PARKED + 0.5)
    before = min(robot.ping(ahead))
    assert min(robot.ping(ahead)) == pytest.approx(before, abs=0.3), "with noise of its own each time"
    world.place("other", Pose2D(1.2, 0.0, 0.0))
    assert min(robot.ping(ahead)) < before - 1.0
    assert not other.is_resting
    run(world, PARKED + 0.5)
    world.remove_robot("other")
    assert min(robot.ping(ahead)) > before
