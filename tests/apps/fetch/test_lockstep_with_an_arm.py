"""The whole of it with the arm of a PowerBot, on rendered images in virtual time, as the benchmark drives it."""

import math
from collections.abc import Iterator

import pytest

from apps.fetch.settings import FetchSettings
from apps.fetch.states import FetchState
from benchmarks.fetch_course import ARM_FIT, ARM_ROOMS, ARMED, ROBOT, FetchCourse, fetch_room
from p2os_emu.world import load_world

SETTINGS = FetchSettings.load_for_arm()
PLACE = 2.6, 3.4  # m in the world
RAISED = SETTINGS.robot.lift_m - 0.02  # m


@pytest.fixture
def course() -> Iterator[FetchCourse]:
    with FetchCourse(load_world("post-lab"), SETTINGS, PLACE, seed=1, model=ARMED, fit=ARM_FIT) as course:
        yield course


def test_a_post_is_gripped_carried_upright_and_put_down_and_nothing_else_is_touched(course: FetchCourse) -> None:
    world, post = course.lockstep.world, course.world.objects[0]
    heights: list[float] = []

    def look() -> bool:
        if course.cycle.fetcher.state is FetchState.CARRY:
            heights.append(world.object_places()[post.name].z - post.height / 2.0)
            assert world.held(ROBOT) == post.name
        return False

    assert course.run(150.0, look)
    assert course.cycle.fetcher.state is FetchState.DELIVERED, course.told
    assert min(heights) > RAISED
    places = world.object_places()
    assert math.dist(places[post.name][:2], PLACE) < 0.15
    assert abs(places[post.name].z - post.height / 2.0) < 0.01
    assert course.touched() == []
    for each in course.world.objects[1:]:
        assert math.dist(places[each.name][:2], (each.pose.x, each.pose.y)) < 0.005


def test_rooms_for_an_arm_have_tall_objects_that_pass_between_its_fingers() -> None:
    for seed in range(20):
        world, place = fetch_room(seed, ARM_ROOMS)
        thing = world.objects[0]
        assert SETTINGS.object.lowest_m < thing.height < SETTINGS.object.highest_m
        assert math.hypot(thing.length, thing.width) < SETTINGS.robot.opening_m or thing.length < 0.055
        assert math.dist((thing.pose.x, thing.pose.y), place) > ARM_ROOMS.apart
