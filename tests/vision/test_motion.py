"""Motion in drawn images of a standing camera: what moves is found, light and noise are not."""

import numpy as np
import pytest

from benchmarks.vision_drawing import Flaws, background, spoilt
from vision.image import Pixels, VisionError
from vision.motion import MotionDetector, MotionParameters, MotionResult

DT = 0.1


class Scene:
    """A background, and a square before it."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.room = background(self.rng, 160, 120).astype(np.float64)

    def image(self, left: int | None = None, gain: float = 1.0) -> Pixels:
        scene = self.room.copy()
        if left is not None:
            behind = self.room[40:70, left : left + 20]
            scene[40:70, left : left + 20] = np.where(behind < 128, behind + 70, behind - 70)
        return spoilt(scene, self.rng, Flaws(noise=4.0, gain=gain, quality=90))


def settled(scene: Scene, detector: MotionDetector) -> MotionResult:
    for _ in range(20):
        result = detector.update(scene.image(), DT)
    return result


@pytest.mark.parametrize("seed", range(4))
def test_a_moving_square_is_found_where_it_is(seed: int) -> None:
    scene, detector = Scene(seed), MotionDetector()
    settled(scene, detector)
    for left in range(10, 130, 8):
        blobs = detector.update(scene.image(left), DT).blobs
        assert any(abs(blob.x - (left + 9.5)) < 3 and abs(blob.y - 54.5) < 3 for blob in blobs), left


@pytest.mark.parametrize("seed", range(4))
def test_noise_and_light_are_no_motion(seed: int) -> None:
    scene, detector = Scene(seed), MotionDetector()
    assert not settled(scene, detector).blobs
    for gain in (1.0, 0.9, 0.75, 0.6, 0.8, 1.0):
        assert not detector.update(scene.image(gain=gain), DT).blobs


def test_what_stops_is_found_for_a_while_and_then_is_background() -> None:
    scene, detector = Scene(1), MotionDetector(MotionParameters(absorb=3.0))
    settled(scene, detector)
    found = [bool(detector.update(scene.image(60), DT).blobs) for _ in range(120)]
    assert all(found[:10])
    assert not any(found[-10:])


def test_a_turned_camera_begins_a_new_background() -> None:
    scene, detector = Scene(1), MotionDetector()
    settled(scene, detector)
    turned = scene.image()[:, ::-1].copy()
    turned[:, ::2] = 255 - turned[:, ::2]
    result = detector.update(turned, DT)
    assert not result.settled
    assert not result.blobs
    assert detector.update(turned, DT).settled


def test_another_size_or_a_reset_begins_a_new_background() -> None:
    detector = MotionDetector()
    assert not detector.update(Scene(1).image(), DT).settled
    assert not detector.update(np.zeros((50, 60), np.uint8), DT).settled
    detector.reset()
    assert not detector.update(np.zeros((50, 60), np.uint8), DT).settled


def test_black_images_hold_no_motion() -> None:
    detector = MotionDetector()
    for _ in range(3):
        assert not detector.update(np.zeros((50, 60), np.uint8), DT).blobs


def test_misuse_is_refused() -> None:
    with pytest.raises(VisionError, match="must be positive, not 0 s"):
        MotionDetector().update(np.zeros((50, 60), np.uint8), 0.0)
    with pytest.raises(VisionError, match="must be positive"):
        MotionParameters(adapt=-1.0)
