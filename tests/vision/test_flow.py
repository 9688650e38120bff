"""Optical flow and time to contact in a drawn room."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from math import degrees, radians

import cv2
import numpy as np
import pytest

from benchmarks.vision_drawing import Camera, Flaws, Floats, Room
from vision.camera_model import PinholeModel
from vision.contact import ContactEstimator, ContactParameters, ContactResult
from vision.flow import FlowGeometry, dense_flow, sparse_flow, yaw_vector
from vision.image import Pixels, VisionError

CAMERA = Camera(160, 120)
MODEL = PinholeModel.from_field_of_view(160, 120, CAMERA.view)
DT = 1 / 15
ROOM = Room(1)


@pytest.fixture(scope="module")
def still() -> Pixels:
    return ROOM.image(CAMERA, 0, 0, 0)


def shifted(image: Pixels, x: float, y: float) -> Pixels:
    matrix = np.array([[1.0, 0, x], [0, 1.0, y]])
    return np.asarray(cv2.warpAffine(image, matrix, (160, 120), borderMode=cv2.BORDER_REFLECT), np.uint8)


@pytest.mark.parametrize("by", [(1.5, 0.0), (-3.0, 2.0), (0.3, -0.4)])
def test_flow_of_a_shift_is_the_shift(still: Pixels, by: tuple[float, float]) -> None:
    dense = dense_flow(still, shifted(still, *by))[20:-20, 20:-20]
    assert np.allclose(np.median(dense, axis=(0, 1)), by, atol=0.1)
    points, sparse = sparse_flow(still, shifted(still, *by))
    assert len(points) > 20
    assert np.allclose(np.median(sparse, axis=0), by, atol=0.1)


def test_flow_of_two_surfaces_changes_at_their_edge() -> None:
    rng = np.random.default_rng(1)
    noise = (cv2.GaussianBlur(rng.integers(0, 256, (120, 160), np.uint8), (0, 0), 1.5) for _ in range(2))
    near, far = (np.asarray(cv2.equalizeHist(each), np.uint8) for each in noise)
    before, after = far.copy(), far.copy()
    before[:, :80], after[:, :77] = near[:, 10:90], near[:, 13:90]  # the left half moves by 3 px
    flow = np.asarray(dense_flow(before, after)[20:100, :, 0])
    assert np.abs(flow[:, 40:74] + 3.0).mean() < 0.1
    assert np.abs(flow[:, 86:120]).mean() < 0.05


def test_sparse_flow_follows_given_points_and_an_empty_image_has_none(still: Pixels) -> None:
    points, moved = sparse_flow(still, shifted(still, 2, 0), np.array([[80.0, 60.0]]))
    assert np.allclose(points + moved, [[82.0, 60.0]], atol=0.2)
    assert len(sparse_flow(np.zeros((60, 60), np.uint8), np.zeros((60, 60), np.uint8))[0]) == 0


@pytest.mark.parametrize("yaw", [0.02, -0.03])
def test_flow_of_a_turn_is_that_of_the_camera_model(yaw: float) -> None:
    flow = dense_flow(ROOM.image(CAMERA, 0, 0, 0), ROOM.image(CAMERA, 0, 0, yaw))
    geometry = FlowGeometry(MODEL)
    rest = (flow - geometry.of_rotation(yaw_vector(yaw)))[15:-15, 15:-15]
    assert np.median(np.linalg.norm(rest, axis=2)) < 0.15
    estimated = geometry.rotation_in(flow, (0.0, 0.0), np.ones(flow.shape[:2]))
    assert np.abs(estimated - [0, 0, yaw]).max() < radians(0.1)


def test_the_focus_of_expansion_is_where_the_robot_goes() -> None:
    aside = 0.2  # m to the left for each m ahead
    flow = dense_flow(ROOM.image(CAMERA, 0, 0, 0), ROOM.image(CAMERA, 0.15, 0.15 * aside, 0))
    focus = FlowGeometry(MODEL).focus_in(flow, np.ones(flow.shape[:2]))
    assert focus is not None
    assert abs(focus[0] - aside) < 0.05
    assert abs(focus[1]) < 0.05
    assert FlowGeometry(MODEL).focus_in(flow * 0.0, np.ones(flow.shape[:2])) is None


def test_rotation_by_slopes_agrees_with_rotation_by_geometry() -> None:
    geometry = FlowGeometry(PinholeModel(160, 120, 140, 140, 80, 60, -0.1, 0.02))
    for small in np.eye(3) * 1e-3:
        flow = geometry.of_rotation(small)
        assert np.allclose(geometry.rotation_in(flow, (0.1, 0.05), np.ones((120, 160))), small, atol=2e-5)


@dataclass(frozen=True)
class Course:
    """A drive through a room; the yaw rate is steady, rad/s, or swings by `swing`."""

    seed: int
    speed: float
    yaw: float = 0.0
    swing: float = 0.0
    count: int = 30

    def poses(self) -> Iterator[tuple[float, float, float, float]]:
        """Place and heading at each image, and the turn since the one before."""
        x, y, heading, turned = 1.0, 0.0, 0.0, 0.0
        for number in range(self.count):
            yield x, y, heading, turned
            turned = (self.yaw + self.swing * float(np.sin(number / 5))) * DT
            x += self.speed * DT * float(np.cos(heading + turned / 2))
            y += self.speed * DT * float(np.sin(heading + turned / 2))
            heading += turned


@cache  # drawing takes longer than all that is done with the images
def images(course: Course) -> list[Pixels]:
    room = Room(course.seed)
    return [room.image(CAMERA, x, y, heading) for x, y, heading, _ in course.poses()]


def drive(course: Course, is_known: bool) -> tuple[list[float], list[ContactResult]]:
    """Relative errors of all columns whose time is between 1 and 8 s, and the results."""
    room, estimator = Room(course.seed), ContactEstimator(MODEL)
    errors, results = [], []
    for number, ((x, y, heading, turned), image) in enumerate(zip(course.poses(), images(course), strict=True)):
        result = estimator.update(image, DT, turned if is_known else None)
        if result and number > 6:
            results.append(result)
            for bearing, time in zip(result.bearings, result.times, strict=True):
                true = room.depth(x, y, heading, bearing) / course.speed
                if 1 <= true <= 8 and not np.isnan(time):
                    errors.append(abs(min(time, 100.0) - true) / true)
    return errors, results


@pytest.mark.parametrize("seed", [100, 101])
@pytest.mark.parametrize("is_known", [True, False])
def test_time_to_contact_of_a_straight_drive(seed: int, is_known: bool) -> None:
    errors, results = drive(Course(seed, 0.6), is_known)
    assert np.median(errors) < 0.15
    assert np.median([abs(result.yaw) / result.interval for result in results]) < radians(0.5)


@pytest.mark.parametrize("is_known", [True, False])
def test_time_to_contact_while_turning(is_known: bool) -> None:
    errors, results = drive(Course(102, 0.5, swing=0.4), is_known)
    assert np.median(errors) < 0.15
    assert all(result.interval < 0.6 for result in results)
    # What came into view since the image that is compared is not known.
    assert all(np.isnan(result.times[2:-2]).sum() == 0 for result in results)


def shares_in_curve(rooms: Sequence[Room], rate: float, ahead: float) -> dict[int, list[float]]:
    """1 / time by column, as a share of the true one, in curves at 0.3 m/s; ahead: of the camera before the axle, m."""
    speed, shares = 0.3, defaultdict[int, list[float]](list)
    for room in rooms:
        estimator = ContactEstimator(MODEL)
        for number, (x, y, heading, turned) in enumerate(Course(0, speed, yaw=rate, count=20).poses()):
            eye = x + ahead * float(np.cos(heading)), y + ahead * float(np.sin(heading)), heading
            result = estimator.update(room.image(CAMERA, *eye), DT, turned, way=(speed * DT, ahead * rate * DT))
            if result and number > 7:
                for column, (bearing, time) in enumerate(zip(result.bearings, result.times, strict=True)):
                    shares[column].append(room.depth(*eye, bearing) / speed / time)
    return shares


@pytest.mark.parametrize("ahead", [0.0, 0.2])
def test_times_are_right_at_both_sides_of_a_curve_also_if_the_camera_is_before_the_axle(ahead: float) -> None:
    shares = shares_in_curve([Room(104, ahead=4.5), Room(105, ahead=4.5)], 0.3, ahead)
    for side in ((1, 2, 3), (12, 13, 14)):
        assert np.nanmedian([share for column in side for share in shares[column]]) == pytest.approx(1.0, abs=0.12)


def test_times_are_told_by_the_columns_in_which_things_are_now() -> None:
    shares = shares_in_curve([Room(seed, 8.0, 0.9, 0.9) for seed in (204, 205)], 0.15, 0.1)
    outer = [share for column in (11, 12, 13, 14) for share in shares[column]]  # the wall goes out of the view
    assert np.nanmedian(outer) == pytest.approx(1.0, abs=0.1)


def test_a_robot_that_stands_and_turns_has_nothing_ahead() -> None:
    _, results = drive(Course(103, 1e-9, yaw=0.3, count=15), True)
    assert np.isnan(results[-1].times[1:]).sum() == 0, "only the left column came into view"
    assert np.nanmedian(results[-1].times) > 15.0


def test_frozen_and_black_images_say_that_nothing_is_known(still: Pixels) -> None:
    for image in (still, np.zeros_like(still)):
        estimator = ContactEstimator(MODEL)
        assert estimator.update(image, DT) is None
        result = estimator.update(image, DT)
        assert result is not None
        assert np.isnan(result.times).all()
    rng = np.random.default_rng(0)
    estimator = ContactEstimator(MODEL)
    for _ in range(5):
        result = estimator.update((rng.random((120, 160)) * 3).astype(np.uint8), DT)
    assert result is not None
    assert np.isnan(result.times).all()


def test_larger_images_are_made_smaller() -> None:
    estimator = ContactEstimator(PinholeModel.from_field_of_view(320, 240, CAMERA.view), ContactParameters(columns=8))
    for x in (0.0, 0.05):
        result = estimator.update(ROOM.image(Camera(320, 240), x, 0, 0, Flaws(noise=1.0)), DT)
    assert result is not None
    assert result.flow.shape == (120, 160, 2)
    assert len(result.times) == len(result.bearings) == 8
    assert degrees(result.bearings[0]) > 20
    assert result.focus is not None


def test_misuse_is_refused(still: Pixels) -> None:
    estimator = ContactEstimator(MODEL)
    with pytest.raises(VisionError, match="scale the model"):
        estimator.update(np.zeros((50, 50), np.uint8), DT)
    with pytest.raises(VisionError, match="must be positive, not 0 s"):
        estimator.update(still, 0.0)
    with pytest.raises(VisionError, match="two images of one size"):
        dense_flow(still, still[:50])
    with pytest.raises(VisionError, match="at least 16 x 16"):
        sparse_flow(still[:8], still[:8])
    with pytest.raises(VisionError, match="1 to 80 columns"):
        ContactParameters(columns=0)


def test_equal_images_give_equal_results() -> None:
    def times() -> Floats:
        return drive(Course(104, 0.6, yaw=0.1, count=12), False)[1][-1].times

    assert np.array_equal(times(), times(), equal_nan=True)
