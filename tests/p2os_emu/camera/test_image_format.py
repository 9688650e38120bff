import pytest

import configs
from p2os import RobotModel
from p2os_emu.camera.image_format import ImageFormat, read_format
from p2os_emu.fit import FitError, read_fit


@pytest.mark.parametrize(
    ("text", "image"),
    [
        ("160x120@10", ImageFormat(160, 120, 10.0)),
        ("320x240", ImageFormat(320, 240, 10.0)),
        ("640x480@0.5", ImageFormat(640, 480, 0.5)),
    ],
)
def test_format_is_read(text: str, image: ImageFormat) -> None:
    assert read_format(text) == image
    assert read_format(str(image)) == image


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("big", "write WIDTHxHEIGHT@RATE"),
        ("320*240", "write WIDTHxHEIGHT@RATE"),
        ("320x240@", "write WIDTHxHEIGHT@RATE"),
        ("10000x240", "width 10000 .* is not within 32 to 1280"),
        ("320x8", "height 8 .* is not within 24 to 960"),
        ("320x240@100", "rate 100 .* is not within 0.5 to 30"),
    ],
)
def test_what_no_camera_gives_is_refused_with_what_it_gives(text: str, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        read_format(text)


def test_camera_is_fitted_in_any_format_and_in_no_other_words() -> None:
    model = configs.load(RobotModel, "robots", "p3dx")
    _, fit = read_fit(["camera"], model)
    assert fit.parts["camera"] == "320x240@10"
    _, fit = read_fit(["camera:200x100@7"], model)
    assert read_format(fit.parts["camera"]) == ImageFormat(200, 100, 7.0)
    with pytest.raises(FitError, match="camera: 'large' is no picture format"):
        read_fit(["camera:large"], model)
