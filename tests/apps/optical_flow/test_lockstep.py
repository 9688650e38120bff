"""The whole of it on rendered images in virtual time, as the benchmark drives it."""

from dataclasses import replace

import numpy as np

from apps.optical_flow.settings import FlowSettings
from apps.optical_flow.situation import FlowSituation
from benchmarks.flow_course import FloorCover, FlowCourse
from benchmarks.textured_rooms import textured_room
from bus.messages import CompressedImage
from geometry import Twist2D
from p2os_emu.world import load_world

SETTINGS = FlowSettings.load()


def test_the_same_seed_gives_the_same_drive_and_nothing_is_touched() -> None:
    world = textured_room(2)
    assert world == textured_room(2)
    paths = []
    for seconds in (4.0, 1.0):
        with FlowCourse(world, SETTINGS, seed=2) as course:
            course.run(seconds)
            assert course.touched() == []
            paths.append(course.path)
    assert paths[0][: len(paths[1])] == paths[1]
    assert FloorCover(world).share(paths[0]) > 0.005


def test_a_torn_image_and_a_camera_that_falls_silent_stop_the_robot_until_images_return() -> None:
    with FlowCourse(load_world("texture-lab"), SETTINGS, seed=1) as course:
        assert moves(course)
        course.spoil = torn
        course.run(0.3)
        assert course.orders is not None
        assert course.orders.situation is FlowSituation.BLIND
        assert course.orders.twist == Twist2D()
        course.spoil = lambda message: None
        course.run(0.5)
        assert course.orders.twist == Twist2D()
        course.spoil = lambda message: message
        assert moves(course)


def moves(course: FlowCourse) -> bool:
    """Whether it moves within two seconds."""
    return any(course.step().twist != Twist2D() for _ in range(20))


def torn(message: CompressedImage) -> CompressedImage:
    return replace(message, data=np.asarray(message.data[:200]))
