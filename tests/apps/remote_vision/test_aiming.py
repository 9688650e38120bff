"""Where the head is to look, by steps, points and drags, with the camera model."""

from math import radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from apps.remote_vision.aiming import HeadPlace, centred, dragged, horizontal_view, stepped, view_of, zoomed
from vision.camera_model import PinholeModel

VIEW = 0.83  # rad
MODEL = PinholeModel.from_field_of_view(320, 240, VIEW)
LIMITS = {"pan": [-1.7, 1.7], "tilt": [-0.5, 1.5], "zoom": [1.0, 16.0]}
CENTRE = (159.5, 119.5)
places = st.builds(HeadPlace, st.floats(-1.5, 1.5), st.floats(-0.5, 0.8), st.just(1.0))
pixels = st.tuples(st.floats(0, 319), st.floats(0, 239))


def test_the_centre_of_the_image_is_centred_already() -> None:
    place = centred(HeadPlace(0.3, 0.1), MODEL, CENTRE)
    assert (place.pan, place.tilt) == pytest.approx((0.3, 0.1))


def test_a_point_at_the_right_edge_is_half_a_field_of_view_to_the_right() -> None:
    place = centred(HeadPlace(), MODEL, (319.5, 119.5))
    assert place.pan == pytest.approx(-VIEW / 2, abs=1e-6)
    assert place.tilt == pytest.approx(0.0, abs=1e-9)


def test_a_point_above_is_up_and_with_zoom_it_is_less() -> None:
    wide = centred(HeadPlace(), MODEL, (159.5, 20.0))
    near = centred(HeadPlace(zoom=4.0), zoomed(MODEL, 4.0), (159.5, 20.0))
    assert wide.tilt > 3 * near.tilt > 0.0
    assert near.zoom == 4.0


@given(places, pixels)
def test_what_was_centred_is_dragged_back_to_where_it_was(place: HeadPlace, pixel: tuple[float, float]) -> None:
    there = centred(place, MODEL, pixel)
    back = dragged(there, MODEL, CENTRE, pixel)
    assert (back.pan, back.tilt) == pytest.approx((place.pan, place.tilt), abs=1e-6)


@given(places, pixels)
def test_a_drag_that_ends_where_it_began_moves_nothing(place: HeadPlace, pixel: tuple[float, float]) -> None:
    still = dragged(place, MODEL, pixel, pixel)
    assert (still.pan, still.tilt) == pytest.approx((place.pan, place.tilt), abs=1e-6)


def test_a_drag_to_the_right_turns_the_head_to_the_left() -> None:
    place = dragged(HeadPlace(), MODEL, CENTRE, (219.5, 119.5))
    assert place.pan > 0.1
    assert place.tilt == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("key", "expected"),
    [
        ("ArrowLeft", (0.2 * VIEW, 0.0, 2.0)),
        ("ArrowRight", (-0.2 * VIEW, 0.0, 2.0)),
        ("ArrowUp", (0.0, 0.2 * VIEW, 2.0)),
        ("ArrowDown", (0.0, -0.2 * VIEW, 2.0)),
        ("+", (0.0, 0.0, 2.5)),
        ("-", (0.0, 0.0, 1.6)),
    ],
)
def test_a_step_is_a_part_of_the_field_of_view(key: str, expected: tuple[float, float, float]) -> None:
    place = stepped(HeadPlace(zoom=2.0), key, VIEW, 0.2, 1.25)
    assert (place.pan, place.tilt, place.zoom) == pytest.approx(expected)


def test_a_place_is_kept_within_the_limits_of_the_head() -> None:
    assert HeadPlace(3.0, -1.0, 40.0).limited(LIMITS) == HeadPlace(1.7, -0.5, 16.0)
    assert HeadPlace(0.1, 0.2, 3.0).limited(LIMITS) == HeadPlace(0.1, 0.2, 3.0)
    assert HeadPlace(3.0, 0.0, 1.0).limited({"pan": "much"}) == HeadPlace(3.0, 0.0, 1.0)


def test_zoom_narrows_the_view() -> None:
    assert horizontal_view(MODEL) == pytest.approx(VIEW)
    assert horizontal_view(zoomed(MODEL, 4.0)) < VIEW / 3
    assert zoomed(MODEL, 0.0) == MODEL


def test_a_calibrated_lens_counts_more_than_that_of_the_head() -> None:
    assert view_of({"field_of_view": None}, {"field_of_view": VIEW}) == {"field_of_view": VIEW}
    assert view_of({"model": {"fx": 1.0}, "field_of_view": 1.0}, {"field_of_view": VIEW}) == {"model": {"fx": 1.0}}
    assert view_of({}, {}) == {}


def test_a_report_without_a_direction_is_no_place() -> None:
    assert HeadPlace.from_result({"pan": 0.5, "tilt": 0, "zoom": 1.0}) == HeadPlace(0.5, 0.0, 1.0)
    assert HeadPlace.from_result({"pan": None, "tilt": 0.0, "zoom": 1.0}) is None
    assert str(HeadPlace(radians(10), radians(-5), 2.0)) == "pan 10°, tilt -5°, zoom 2.0"
