"""Films that applications write: a view of robots from above, and the file. OpenCV is loaded where it is used."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents import RobotError
from configs.extras import ExtraMissing, require
from geometry import Point, Pose2D

Pixels = NDArray[np.uint8]
ENDINGS = (".gif", ".mp4")
PLAY = 10  # frames a second of the film
RATE = 5.0  # frames of a second of the drive: the film is twice as fast
MOST = 600  # frames; of a longer drive, every second, third and so on is shown
SIDE, TEXT = 480, 34  # px of the view from above, and of the line of words below it
_EDGE = 0.6  # m round the trajectories
_SMALLEST = 4.0  # m that the view shows at least
_RADIUS = 0.22  # m of a robot
_COLOURS = ((72, 66, 61), (180, 119, 31), (13, 115, 217), (74, 157, 42), (189, 103, 148), (154, 64, 194))


def check_film(film: str) -> None:
    """Check the name of a file for a film and the extras that it needs, before anything moves; none is right as well.

    Raises:
        RobotError: It is of another kind, its folder does not exist, or an extra is missing.
    """
    if not film:
        return
    file = Path(film)
    if file.suffix not in ENDINGS or not file.parent.is_dir():
        raise RobotError(f"the film {film} cannot be written; name a .gif or .mp4 file in a folder that exists")
    try:
        require("the film", "vision", "plots")
    except ExtraMissing as err:
        raise RobotError(f"{err}; film= does without") from err


def moments(times: Sequence[float]) -> list[int]:
    """Return the indices of the moments that a film shows: some each second, and not more than `MOST`."""
    if not times:
        return []
    count = min(MOST, math.floor((times[-1] - times[0]) * RATE + 1e-6) + 1)
    wanted = np.linspace(times[0], times[-1], count) - 1e-6
    return sorted(set(np.searchsorted(times, wanted).tolist()))


class TopView:
    """Draws robots and their trajectories so far as seen from above, at one scale for the whole film."""

    def __init__(self, tracks: Mapping[str, Sequence[Pose2D | None]]) -> None:
        """Fit the view to trajectories; name to poses, one for each moment, None where it is not known."""
        self._tracks = tracks
        known = [(pose.x, pose.y) for track in tracks.values() for pose in track if pose is not None] or [(0.0, 0.0)]
        low, high = np.min(known, axis=0), np.max(known, axis=0)
        self._middle = (low + high) / 2.0
        self.scale = SIDE / max(_SMALLEST, float((high - low).max()) + 2.0 * _EDGE)

    def pixel(self, x: float, y: float) -> tuple[int, int]:
        """Return where a point is drawn, px to the right and down; x leads to the right, y up."""
        right, up = (np.array([x, y]) - self._middle) * self.scale
        return round(SIDE / 2.0 + right), round(SIDE / 2.0 - up)

    def draw(self, moment: int, words: str, points: Sequence[Point] = ()) -> Pixels:
        """Return a frame: blue, green and red, shape (SIDE + TEXT, SIDE, 3).

        Args:
            moment: Index of the poses; earlier ones are the trajectory.
            words: Below the view.
            points: Places to mark, such as virtual points.
        """
        import cv2  # it takes long to load

        frame = np.full((SIDE + TEXT, SIDE, 3), 255, np.uint8)
        for x, y in points:
            cv2.drawMarker(frame, self.pixel(x, y), (150, 150, 150), cv2.MARKER_CROSS, 12, 1, cv2.LINE_AA)
        for number, (name, track) in enumerate(self._tracks.items()):
            colour = _COLOURS[number % len(_COLOURS)]
            way = [self.pixel(pose.x, pose.y) for pose in track[: moment + 1] if pose is not None]
            cv2.polylines(frame, [np.array(way, np.int32).reshape(-1, 1, 2)], False, colour, 1, cv2.LINE_AA)
            pose = track[moment]
            if pose is not None:
                radius, place = max(4, round(_RADIUS * self.scale)), self.pixel(pose.x, pose.y)
                cv2.circle(frame, place, radius, colour, -1, cv2.LINE_AA)
                cv2.line(frame, place, self.pixel(*pose.transform(_RADIUS, 0.0)), (255, 255, 255), 2, cv2.LINE_AA)
            cv2.rectangle(frame, (8, 9 + 16 * number), (18, 15 + 16 * number), colour, -1)
            write(frame, name, 24, 16 + 16 * number)
        frame[SIDE:] = 255
        write(frame, words, 6, SIDE + 22)
        return frame


def write(frame: Pixels, words: str, left: int, down: int) -> None:
    """Write words of ASCII into a frame; left, down: px of their lower left corner."""
    import cv2

    cv2.putText(frame, words, (left, down), cv2.FONT_HERSHEY_SIMPLEX, 0.38, (30, 30, 30), 1, cv2.LINE_AA)


class FilmWriter:
    """Collects frames, and writes them at the end: a GIF with Pillow, or an MP4 with OpenCV."""

    def __init__(self, file: Path, most: int = MOST) -> None:
        """Begin. file: ends in .gif or .mp4. most: frames; further ones are dropped."""
        self.file = file
        self._most = most
        self._frames: list[Any] = []  # JPEGs, which need a tenth of the memory

    def add(self, frame: Pixels) -> None:
        """Add a frame: blue, green and red, all of one size."""
        import cv2

        if len(self._frames) < self._most:
            self._frames.append(cv2.imencode(".jpg", frame, [cv2.IMWRITE_JPEG_QUALITY, 90])[1])

    def close(self) -> int:
        """Write the film; returns the number of frames. Without frames there is no file.

        Raises:
            OSError: The file cannot be written.
        """
        import cv2

        frames = (np.asarray(cv2.imdecode(each, cv2.IMREAD_COLOR), np.uint8) for each in self._frames)
        if not self._frames:
            return 0
        if self.file.suffix == ".gif":
            from PIL import Image

            first, *others = (
                Image.fromarray(frame[:, :, ::-1]).quantize(64, Image.Quantize.FASTOCTREE) for frame in frames
            )
            first.save(self.file, save_all=True, append_images=others, duration=1000 // PLAY, loop=0, optimize=False)
            return len(self._frames)
        writer = None
        for frame in frames:
            if writer is None:
                height, width = frame.shape[:2]
                writer = cv2.VideoWriter(str(self.file), cv2.VideoWriter.fourcc(*"mp4v"), PLAY, (width, height))
                if not writer.isOpened():
                    raise OSError(f"{self.file} cannot be written")
            writer.write(frame)
        assert writer is not None  # there are frames
        writer.release()
        return len(self._frames)
