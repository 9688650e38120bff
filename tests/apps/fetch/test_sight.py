"""Objects in drawn images, where and how large they are."""

import numpy as np
import pytest

from apps.fetch.settings import FetchSettings
from apps.fetch.sight import ObjectSight, named_colours
from vision.camera_model import PinholeModel
from vision.image import Floats, Pixels

SETTINGS = FetchSettings.load()
CAMERA = PinholeModel.from_field_of_view(160, 120, 0.83)
TILT = -0.4


def drawn(*things: tuple[str, float, float, float, float], tilt: float = TILT) -> Pixels:
    """An image of upright boards that face the camera: colour, x and y in base_link, width, height, m."""
    image = np.full((120, 160, 3), 150, np.uint8)
    for colour, x, y, width, height in things:
        corners = np.array([[x, y - width / 2, 0.0], [x, y + width / 2, height]])
        rays = corners - np.array([SETTINGS.camera.forward_m, 0.0, SETTINGS.camera.height_m])
        (right, low), (left, high) = np.rint(CAMERA.pixels_of(seen_from(rays, tilt))).astype(int).tolist()
        image[max(0, high) : low + 1, max(0, left) : right + 1] = SETTINGS.shades[colour][::-1]
    return image


def seen_from(rays: Floats, tilt: float) -> Floats:
    """Rays in the axes of a camera with a tilt."""
    c, s = np.cos(tilt), np.sin(tilt)
    turned: Floats = rays @ np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    return turned


@pytest.fixture(scope="module")
def sight() -> ObjectSight:
    return ObjectSight(SETTINGS.camera, CAMERA, named_colours(SETTINGS.shades))


@pytest.mark.parametrize(("x", "y"), [(1.0, 0.0), (1.3, 0.25), (2.0, -0.5)])
def test_an_object_is_where_it_stands_and_as_large_as_it_is(sight: ObjectSight, x: float, y: float) -> None:
    found = sight.look(drawn(("red", x, y, 0.08, 0.14)), tilt=TILT)
    assert [each.colour for each in found] == ["red"]
    depth = found[0].width / 2.0  # behind the face that is seen
    assert np.hypot(found[0].x, found[0].y) == pytest.approx(np.hypot(x, y) + depth, rel=0.04)
    assert np.arctan2(found[0].y, found[0].x) == pytest.approx(np.arctan2(y, x), abs=0.02)
    assert found[0].width == pytest.approx(0.08, abs=0.02)
    assert found[0].height == pytest.approx(0.14, abs=0.03)


def test_a_camera_that_looks_straight_ahead_measures_as_well(sight: ObjectSight) -> None:
    found = sight.look(drawn(("green", 2.0, 0.1, 0.08, 0.14), tilt=0.0))
    assert found[0].x == pytest.approx(2.04, rel=0.04)


def test_objects_that_are_cut_off_are_left_out(sight: ObjectSight) -> None:
    assert sight.look(drawn(("red", 0.58, 0.0, 0.08, 0.14)), tilt=TILT) == []
    assert sight.look(drawn(("red", 1.0, 0.42, 0.2, 0.14)), tilt=TILT) == []


def test_what_has_no_floor_at_its_lower_edge_is_no_object(sight: ObjectSight) -> None:
    image = drawn(tilt=0.0)
    image[20:30, 60:90] = SETTINGS.shades["red"][::-1]  # above the horizon
    assert sight.look(image) == []


def test_several_colours_are_told_apart(sight: ObjectSight) -> None:
    things = [("red", 1.5, 0.3, 0.08, 0.1), ("blue", 1.5, 0.0, 0.08, 0.1), ("yellow", 1.5, -0.3, 0.08, 0.1)]
    assert {each.colour for each in sight.look(drawn(*things), tilt=TILT)} == {"red", "blue", "yellow"}


def test_colours_are_known_in_half_the_light(sight: ObjectSight) -> None:
    dark = (drawn(("red", 1.3, 0.0, 0.08, 0.12)) * 0.5).astype(np.uint8)
    assert [each.colour for each in sight.look(dark, tilt=TILT)] == ["red"]


def test_objects_whose_foot_the_hull_hides_are_left_out() -> None:
    arm = FetchSettings.load_for_arm().camera
    sight = ObjectSight(arm, PinholeModel.from_field_of_view(320, 240, 0.83), named_colours(SETTINGS.shades))
    image = np.full((240, 320, 3), 150, np.uint8)
    image[40:170, 150:170] = SETTINGS.shades["red"][::-1]
    assert [each.colour for each in sight.look(image, tilt=-arm.down_rad)] == ["red"]
    image[40:197, 150:170] = SETTINGS.shades["red"][::-1]  # down to the edge of the hull
    assert sight.look(image, tilt=-arm.down_rad) == []
    assert sight.view(-arm.down_rad).nearest == arm.hidden_m
