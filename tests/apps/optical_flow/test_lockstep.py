"""The whole of it on rendered images in virtual time, as the benchmark drives it."""

from dataclasses import replace

import numpy as np

from apps.optical_flow.settings import FlowSettings
from apps.optical_flow.situation import FlowSituation
from benchmarks.flow_course import FloorCover, FlowCourse
from benchmarks.textured_rooms import textured_room
from bus.messages import CompressedImage
from p2os_emu.world import load_world

SETTINGS = FlowSettings.load()


def test_the_same_seed_gives_the_same_drive_and_nothing_is_touched() -> None:
    world = textured_room(2)
    assert world == textured_room(2)
    assert world != textured_room(3)
    paths = []
    for seconds in (5.0, 2.0):
        with FlowCourse(world, SETTINGS, seed=2) as course:
            course.run(seconds)
            assert course.touched() == []
            paths.append(course.path)
    assert paths[0][: len(paths[1])] == paths[1]
    assert FloorCover(world).share(paths[0]) > 0.005


def test_a_torn_image_and_a_camera_that_falls_silent_stop_the_robot_until_images_return() -> None:
    with FlowCourse(load_world("texture-lab"), SETTINGS, seed=1) as course:
        course.run(2.0)
        assert course.orders is not None
        assert course.orders.twist.linear > 0.0
        course.spoil = torn
        course.run(0.3)
        assert course.orders.situation is FlowSituation.BLIND
        assert course.orders.twist.linear == 0.0
        course.spoil = lambda message: None
        course.run(0.5)
        assert course.orders.twist.linear == 0.0
        course.spoil = lambda message: message
        course.run(1.0)
        assert course.orders.twist.linear > 0.0


def torn(message: CompressedImage) -> CompressedImage:
    return replace(message, data=np.asarray(message.data[:200]))
