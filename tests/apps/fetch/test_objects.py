"""Objects kept from sightings."""

import pytest

from apps.fetch.objects import FloorObjects
from apps.fetch.settings import FetchSettings
from apps.fetch.sight import CameraView, ObjectSighting
from geometry import Pose2D, Twist2D, integrate

VIEW = CameraView(0.44, 0.6)


def objects() -> FloorObjects:
    return FloorObjects(FetchSettings.load())


def seen(x: float, y: float, colour: str = "red", width: float = 0.06) -> ObjectSighting:
    return ObjectSighting(colour, x, y, width, 0.12)


def test_an_object_is_known_after_some_images_and_near_sightings_count_most() -> None:
    known = objects()
    known.take(0.0, Pose2D(), [seen(3.0, 0.2)], VIEW)
    assert list(known.known()) == []
    for number in range(1, 4):
        known.take(number / 10.0, Pose2D(2.0, 0.0, 0.0), [seen(1.2, 0.0)], VIEW)
    (one,) = known.known()
    assert (round(one.x, 2), round(one.y, 2)) == (3.2, 0.0)


@pytest.mark.parametrize(
    ("linear", "angular"), [(0.125, 0.0), (0.0, 0.4)], ids=["of a robot that drives", "of one that turns"]
)
def test_images_with_late_stamps_move_no_object_that_was_seen_from_standstill(linear: float, angular: float) -> None:
    known, late, motion = objects(), 0.2, Twist2D(linear, angular)
    for number in range(15):
        known.take(number / 10.0, Pose2D(), [seen(1.3, 0.0)], VIEW)
    for number in range(12):
        stamp = 0.4 + number / 5.0
        exposed, taken, earliest = (integrate(Pose2D(), motion, stamp - ago) for ago in (late, 0.0, 0.3))
        sighting = seen(*exposed.locate(1.3, 0.0))
        known.take(1.5 + stamp, taken, [sighting], VIEW, earlier=earliest)
    (one,) = known.known()
    assert (one.x, one.y) == pytest.approx((1.3, 0.0), abs=0.005)


def test_parts_of_one_object_in_an_image_make_one_object() -> None:
    known = objects()
    for number in range(5):
        known.take(number / 10.0, Pose2D(), [seen(1.2, 0.0), seen(1.3, 0.0, width=0.03)], VIEW)
    assert len(known.objects) == 1


def test_an_object_that_is_not_there_any_more_is_forgotten_only_where_it_should_be_seen() -> None:
    known = objects()
    for number in range(5):
        known.take(number / 10.0, Pose2D(), [seen(1.5, 0.0)], VIEW)
    for number in range(20):
        known.take(1.0 + number / 10.0, Pose2D(0.0, 0.0, 3.0), [], VIEW)
    assert len(known.objects) == 1
    for number in range(10):
        known.take(4.0 + number / 10.0, Pose2D(), [], VIEW)
    assert known.objects == []


def test_objects_of_different_colours_in_one_place_are_two() -> None:
    known = objects()
    known.take(0.0, Pose2D(), [seen(1.5, 0.0), seen(1.5, 0.05, "green")], VIEW)
    assert {each.colour for each in known.objects} == {"red", "green"}


def test_size_of_an_object_that_the_hand_covers_is_kept() -> None:
    known = objects()
    for number in range(10):
        known.take(number / 10.0, Pose2D(), [seen(1.3, 0.0, width=0.045)], VIEW)
    for number in range(10):
        known.take(2.0 + number / 10.0, Pose2D(), [ObjectSighting("red", 1.28, 0.0, 0.09, 0.05)], VIEW, covered=True)
    (one,) = known.known()
    assert (one.width, one.height) == pytest.approx((0.045, 0.12))
    assert one.x < 1.295, "where it is, is taken"


def test_an_object_whose_size_is_not_known_well_from_far_is_judged_again_from_near() -> None:
    known = FloorObjects(FetchSettings.load_for_arm())
    for number in range(20):
        known.take(number / 10.0, Pose2D(), [ObjectSighting("red", 3.5, 0.0, 0.05, 0.26)], VIEW)
    far = known.to_fetch(2.0, "red", (0.0, 0.0), (0.0, 0.0))
    assert far is not None
    for number in range(20):
        known.take(3.0 + number / 10.0, Pose2D(2.2, 0.0, 0.0), [ObjectSighting("red", 1.3, 0.0, 0.05, 0.26)], VIEW)
    assert known.misfit(far) == "is 0.05 m wide and 0.26 m high"
    for number in range(30):
        known.take(6.0 + number / 10.0, Pose2D(2.2, 0.0, 0.0), [ObjectSighting("red", 1.3, 0.0, 0.05, 0.4)], VIEW)
    assert known.misfit(far) == ""
