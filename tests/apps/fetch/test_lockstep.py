"""The whole of it on rendered images in virtual time, as the benchmark drives it."""

import math
from dataclasses import replace

from apps.fetch.settings import FetchSettings
from apps.fetch.states import FetchState
from benchmarks.fetch_course import FIT, FetchCourse, fetch_room
from geometry import Pose2D, Twist2D
from p2os_emu.world import WorldSpec, load_world

SETTINGS = FetchSettings.load()
PLACE = 1.6, 1.9  # m in the world
SLOW_CAMERA = FIT.replace("@10", "@4")
START = Pose2D(1.0, 1.0, 0.0)


def lab() -> WorldSpec:
    """A room with a red box 1.3 m before the robot, and other things."""
    return replace(load_world("gripper-lab"), starts=(START,))


def test_a_box_is_gripped_carried_and_put_down_and_nothing_else_is_touched() -> None:
    with FetchCourse(lab(), SETTINGS, PLACE, seed=1, fit=SLOW_CAMERA) as course:
        assert course.run(90.0)
        assert course.cycle.fetcher.state is FetchState.DELIVERED, course.told
        places = course.lockstep.world.object_places()
        assert math.dist(places["red box"][:2], PLACE) < 0.1
        assert abs(places["red box"].z - 0.06) < 0.01
        assert course.touched() == []
        for each in course.world.objects[1:]:
            assert math.dist(places[each.name][:2], (each.pose.x, each.pose.y)) < 0.005


def test_the_same_seed_gives_the_same_room_and_the_same_drive() -> None:
    world, place = fetch_room(3)
    assert (world, place) == fetch_room(3)
    paths = []
    for seconds in (4.0, 2.0):
        with FetchCourse(world, SETTINGS, place, seed=3) as course:
            course.run(seconds)
            paths.append(course.path)
    assert paths[0][: len(paths[1])] == paths[1]


def test_a_camera_that_falls_silent_stops_the_robot_until_images_return() -> None:
    world, place = fetch_room(1)
    with FetchCourse(world, SETTINGS, place, seed=1) as course:
        course.run(3.0)
        assert course.orders is not None
        assert course.orders.twist != Twist2D()
        course.has_camera = False
        course.run(1.5)
        assert course.orders.twist == Twist2D()
        assert "no usable image has come" in course.told[-1]
        course.has_camera = True
        course.run(0.5)
        assert course.orders.twist != Twist2D()
