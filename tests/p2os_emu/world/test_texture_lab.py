"""The world texture-lab serves optical flow: time to contact can be measured in it."""

import io
from math import cos, pi, radians

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from geometry import Pose2D
from p2os_emu.body import ScanBeams
from p2os_emu.camera.jpeg import encode_jpeg
from p2os_emu.world import World, load_world
from p2os_emu.world.mirror import Mirror
from p2os_emu.world.planar import PlanarScene
from p2os_emu.world.view import View
from vision.camera_model import PinholeModel
from vision.contact import ContactEstimator

WIDTH, HEIGHT, FIELD, EYE = 160, 120, radians(60.0), 0.45
PERIOD = 0.1
IMAGES, SETTLED = 14, 5
FAN = radians(0.5)
AROUND = ScanBeams(0.0, 0.0, EYE, -pi, FAN, 720, 20.0)
"""Truth comes from outlines, not from the renderer."""


def relative_errors(seed: int) -> list[float]:
    """Errors of the times between 1 s and 8 s of a straight drive from a place with room ahead."""
    spec, rng = load_world("texture-lab"), np.random.default_rng(seed)
    scene = PlanarScene((*spec.walls, *spec.furniture), lambda: ())
    ahead = AROUND.count // 2

    def seen_from(pose: Pose2D) -> NDArray[np.float64]:
        return scene.cast(AROUND, pose, "").ranges

    while True:
        start = Pose2D(rng.uniform(0.5, 9.5), rng.uniform(0.5, 7.5), rng.uniform(-pi, pi))
        inside = any(block.contains(start.x, start.y) for block in (*spec.walls, *spec.furniture))
        ranges = seen_from(start)
        if not inside and ranges.min() > 0.4 and 1.2 < ranges[ahead] < 4.0:
            break
    speed = rng.uniform(0.2, 0.4)
    estimator = ContactEstimator(PinholeModel.from_field_of_view(WIDTH, HEIGHT, FIELD))
    mirror, errors = Mirror(), []
    with World(spec, seed=seed, perfect=True) as world:
        mirror.apply(world.sight.news(set()))
    for number in range(IMAGES):
        pose = Pose2D(*start.transform(speed * PERIOD * number, 0.0), start.heading)
        drawn = mirror.draw(View.on(pose, 0.0, EYE, 0.0, 0.0, FIELD), WIDTH, HEIGHT)
        pixels = np.asarray(Image.open(io.BytesIO(encode_jpeg(drawn, 80))))[:, :, ::-1]
        result = estimator.update(np.ascontiguousarray(pixels), PERIOD, yaw=0.0)
        if result is not None and number >= SETTLED:
            ranges = seen_from(pose)
            for bearing, time in zip(result.bearings, result.times, strict=True):
                true = ranges[ahead + round(bearing / FAN)] * cos(bearing) / speed
                if 1.0 <= true <= 8.0 and np.isfinite(time):
                    errors.append(abs(time / true - 1.0))
    mirror.close()
    return errors


def test_time_to_contact_is_measured_in_the_texture_lab() -> None:
    """From places that nothing was tuned on, under the light of the world, through the camera's JPEG."""
    errors = [error for seed in range(7300, 7308) for error in relative_errors(seed)]
    assert len(errors) > 300
    assert np.median(errors) < 0.2
