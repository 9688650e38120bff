"""Images for the calibration of a camera: from files, a video, a robot's camera on the bus, or a URL or device."""

import re
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from glob import glob
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from configs.loader import ConfigError

if TYPE_CHECKING:  # it loads OpenCV
    from vision.image import Pixels

VIDEOS = (".mp4", ".avi", ".mov", ".mkv", ".webm")
_GLANCE = 0.2  # s of a video from one image that is looked at to the next
_CAMERA = "camera"
_AGAIN = 0.2  # s after which a camera that has failed is asked again
_PAUSE = 30.0  # s without an image after which a camera that gave some counts as lost
_ROBOT = re.compile(rf"([\w-]+)(/{_CAMERA})?")


class Shot(NamedTuple):
    """An image, and what it is called. is_live: the one before was taken a moment ago."""

    name: str
    pixels: "Pixels"
    is_live: bool


def robot_of(text: str) -> str:
    """Return the robot that ROBOT or ROBOT/camera means.

    Raises:
        ConfigError: It is neither.
    """
    match = _ROBOT.fullmatch(text)
    if match is None:
        raise ConfigError(f"{text} is not ROBOT or ROBOT/{_CAMERA}; a robot has one camera, called {_CAMERA}")
    return match[1]


def files_of(sources: Sequence[str]) -> list[Path]:
    """Return the files that sources mean, in their order; none if the only source is a live camera.

    Raises:
        ConfigError: A source is a pattern that no file matches, or looks like a file and is none.
    """
    files: list[Path] = []
    for source in sources:
        named = [source] if Path(source).is_file() else sorted(glob(source))  # noqa: PTH207  # absolute ones as well
        found = [Path(each) for each in named]
        if len(sources) == 1 and not found and (_is_address(source) or _ROBOT.fullmatch(source)):
            return []
        if any(each.is_dir() for each in found):
            raise ConfigError(f"{source} is a folder; give its images, as {source.rstrip('/')}/*.png")
        if not found:
            raise ConfigError(f"there is no file {source}; give images or a video of a chessboard, or a live camera")
        files += found
    return files


def shots_of_files(files: Sequence[Path]) -> Iterator[Shot]:
    """Yield the images of files, and of videos some for each second.

    Raises:
        ConfigError: A file cannot be read.
        VisionError: A file is no image.
    """
    from vision.image import Image, VisionError

    for file in files:
        if file.suffix.lower() in VIDEOS:
            yield from _shots_of_video(file)
            continue
        try:
            yield Shot(str(file), Image.decode(file.read_bytes()).pixels, is_live=False)
        except OSError as err:
            raise ConfigError(f"{file} cannot be read: {err.strerror}") from err
        except VisionError as err:
            raise VisionError(f"{file}: {err}") from err


def live_shots(source: str, bus: str, tell: Callable[[str], None]) -> Generator[Shot, None, None]:
    """Yield new images of a live camera, without end.

    Args:
        source: ROBOT, ROBOT/camera, a URL or a device.
        bus: Profile of the bus that the robot is on.
        tell: Called with what a person should know while no images come.
    Raises:
        RobotError: There is no such robot, it has no camera, or this gives no images.
        CameraError: The camera cannot be opened, or gives no images any more.
    """
    from vision.image import Image

    for number, data in enumerate(_from_camera(source) if _is_address(source) else _from_robot(source, bus, tell), 1):
        yield Shot(f"image {number}", Image.decode(data).pixels, is_live=True)


def _is_address(source: str) -> bool:
    return "://" in source or source.startswith("/dev/")


def _shots_of_video(file: Path) -> Iterator[Shot]:
    import cv2  # it takes long to load

    capture = cv2.VideoCapture(str(file))
    try:
        if not capture.isOpened():
            raise ConfigError(f"{file} is no video that can be read here")
        rate = capture.get(cv2.CAP_PROP_FPS) or 25.0
        each = max(1, round(rate * _GLANCE))
        number = 0
        while capture.grab():
            if number % each == 0:
                has_come, pixels = capture.retrieve()
                if has_come:
                    yield Shot(f"{file} at {number / rate:.1f} s", np.asarray(pixels, np.uint8), is_live=True)
            number += 1
    finally:
        capture.release()


def _from_robot(source: str, bus: str, tell: Callable[[str], None]) -> Iterator[bytes]:
    from agents import Failed, Team, TimedOut

    with Team(bus) as team:
        camera = team.robot(robot_of(source), having=_CAMERA).camera
        before, came, is_told = None, -inf, False
        while True:
            try:
                picture = camera.picture()
            except (Failed, TimedOut) as error:
                # A busy machine gives up images for a while; what was collected must not be lost by that.
                if time.monotonic() - came > _PAUSE:
                    raise
                if not is_told:
                    tell(f"no image comes: {error}")
                    is_told = True
                team.sleep(_AGAIN)
                continue
            if picture.stamp != before:
                before, came, is_told = picture.stamp, time.monotonic(), False
                yield picture.data
            else:
                team.sleep(0.02)


def _from_camera(where: str) -> Iterator[bytes]:
    from cameras import check_source, open_source

    check_source(where)
    with closing(open_source(where)) as camera:
        while True:
            yield camera.read().jpeg
