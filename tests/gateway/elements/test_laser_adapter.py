"""The laser as the bus sees it: angles, order, times, what is no distance."""

from dataclasses import replace
from math import inf, isinf, isnan, nan, pi, radians
from typing import Any, cast

import numpy as np
import pytest

import configs
from bus import keys, messages
from gateway.cables.cable import IsWanted, PublishEvents
from gateway.driver import Driver
from gateway.elements.adapter import RobotContext
from gateway.elements.laser.adapter import LaserAdapter
from gateway.elements.laser.driver import LaserDriver
from gateway.events import ElementFound, LaserScanned
from gateway.settings import LaserSettings, Settings
from p2os import LaserMount, RobotModel
from p2os.accessories.lms import LmsConfiguration, Scan, Unit, Variant

STAMP = 1_000_000_000_000
UPRIGHT = LaserMount("lms2xx", 0.2, 0.1, radians(10))


class Cable:
    """A laser's cable, on which nobody commands anything."""

    name = "laser"
    bridge = None

    def __init__(self) -> None:
        self.driver = LaserDriver(LaserSettings())

    def join(self, publish: PublishEvents, is_wanted: IsWanted) -> None:
        raise AssertionError("an adapter does not join")

    def halt(self) -> None:
        raise AssertionError("an adapter halts only when it is told to")


def adapter(mount: LaserMount = UPRIGHT, settings: LaserSettings | None = None) -> LaserAdapter:
    model = replace(configs.load(RobotModel, "robots", "p3dx-sh"), lasers=(mount,))
    robot = RobotContext("happy", model, Settings(laser=settings or LaserSettings()), cast(Driver, None))
    return LaserAdapter(robot, Cable())


def scanned(ranges: list[float], first: int = 0, flags: list[int] | None = None) -> LaserScanned:
    configuration = LmsConfiguration()
    given = np.array(flags or [0] * len(ranges), np.uint16)
    words = np.frombuffer(configuration.pack_values(np.array(ranges), given), "<u2")
    return LaserScanned(Scan(first, words, Unit.MILLIMETRE), Variant(180, 100), configuration, 0.11, 0.1)


def published(laser: LaserAdapter, event: LaserScanned) -> Any:
    ((topic, message),) = laser.messages(event, STAMP)
    assert topic is keys.SCAN
    return messages.decode(keys.SCAN.type_name, messages.encode(message))


def test_the_first_value_is_the_rightmost_beam() -> None:
    scan = published(adapter(), scanned([1.0 + 0.01 * index for index in range(181)]))
    assert scan.header.frame_id == "happy/laser"
    assert scan.angle_min == pytest.approx(-pi / 2)
    assert scan.angle_max == pytest.approx(pi / 2)
    assert scan.angle_increment == pytest.approx(pi / 180)
    assert scan.ranges[[0, 180]] == pytest.approx([1.0, 2.8])


def test_a_flipped_laser_is_turned_round() -> None:
    scan = published(adapter(replace(UPRIGHT, flipped=True)), scanned([1.0 + 0.01 * index for index in range(181)]))
    assert scan.angle_min == pytest.approx(-pi / 2)
    assert scan.angle_increment > 0
    assert scan.ranges[[0, 180]] == pytest.approx([2.8, 1.0])


def test_a_part_of_the_beams_keeps_its_angles() -> None:
    part = scanned([1.0, 2.0, 3.0], first=100)
    upright, flipped = published(adapter(), part), published(adapter(replace(UPRIGHT, flipped=True)), part)
    assert [upright.angle_min, upright.angle_max] == pytest.approx([radians(10), radians(12)])
    assert [flipped.angle_min, flipped.angle_max] == pytest.approx([radians(-12), radians(-10)])


def test_nothing_there_is_infinite_and_no_measurement_not_a_number() -> None:
    scan = published(adapter(), scanned([1.0, inf, nan]))
    assert isinf(scan.ranges[1])
    assert isnan(scan.ranges[2])
    assert scan.range_max == pytest.approx(32.758)


def test_reflectors_show_in_the_intensities() -> None:
    assert list(published(adapter(), scanned([1.0, 1.0], flags=[0, 1])).intensities) == [0.0, 1.0]


def test_the_stamp_is_that_of_the_first_beam_and_times_are_the_mirrors() -> None:
    scan = published(adapter(), scanned([1.0] * 181))
    assert messages.stamp_ns(scan.header) == STAMP - 110_000_000
    assert scan.time_increment == pytest.approx(1 / 75 / 360)
    assert scan.scan_time == pytest.approx(0.1)


def test_its_frame_is_where_the_model_has_it_unless_the_settings_know_better() -> None:
    (transform,) = adapter().transforms(STAMP)
    assert (transform.header.frame_id, transform.child_frame_id) == ("happy/base_link", "happy/laser")
    assert (transform.transform.translation.x, transform.transform.translation.y) == (0.2, 0.1)
    assert messages.heading(transform.transform.rotation) == pytest.approx(radians(10))
    moved = adapter(settings=LaserSettings(x_m=-0.1, y_m=0.0, z_m=0.4, heading_deg=180.0, flipped=True))
    (transform,) = moved.transforms(STAMP)
    place = transform.transform.translation
    assert (place.x, place.y, place.z) == (-0.1, 0.0, 0.4)
    assert abs(messages.heading(transform.transform.rotation)) == pytest.approx(pi)
    assert moved.describe()["geometry"]["flipped"] is True


def test_other_events_are_none_of_its_business() -> None:
    assert not isinstance(ElementFound("laser", 9600), LaserAdapter.events)
