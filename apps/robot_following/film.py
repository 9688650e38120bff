"""The film of robot following: both robots from above, and beside them what the follower sees."""

from pathlib import Path

import cv2
import numpy as np

from apps.film import MOST, RATE, SIDE, TEXT, FilmWriter, Pixels, TopView, moments, write
from apps.robot_following.record import FollowingRecord
from vision.image import Floats, Image

_TARGET = (40, 220, 250)  # blue, green and red of the lines round the target


class FollowingFilm:
    """Collects the pictures of one follower while it drives, and writes the film at the end."""

    def __init__(self, file: Path) -> None:
        """Begin. file: ends in .gif or .mp4."""
        self.file = file
        self._shots: dict[float, tuple[bytes, Floats | None]] = {}  # by time
        self._due, self._period = 0.0, 1.0 / RATE

    def add(self, record: FollowingRecord, shown: tuple[bytes, Floats | None] | None) -> None:
        """Keep the newest picture for the last moment of a record, if one is due."""
        if record.times and record.times[-1] >= self._due and shown is not None:
            self._due = record.times[-1] + self._period
            self._shots[record.times[-1]] = shown
            if len(self._shots) > 2 * MOST:  # more than a film shows
                self._shots = dict(list(self._shots.items())[::2])
                self._period *= 2.0

    def close(self, record: FollowingRecord) -> int:
        """Write the film; returns the number of frames.

        Raises:
            OSError: The file cannot be written.
        """
        view = TopView({record.follower: record.own, "leader": record.leader})
        writer = FilmWriter(self.file)
        kept = [number for number, time in enumerate(record.times) if time in self._shots]
        for number in moments([record.times[each] for each in kept]):
            moment = kept[number]
            gap = record.gaps[moment]
            words = f"{record.times[moment]:.1f} s  " + ("no leader" if np.isnan(gap) else f"gap {gap:.2f} m")
            writer.add(np.hstack((view.draw(moment, words), draw_picture(*self._shots[record.times[moment]]))))
        return writer.close()


def draw_picture(data: bytes, outline: Floats | None) -> Pixels:
    """Return a picture with the target drawn into it: blue, green and red, shape (SIDE + TEXT, SIDE, 3).

    Args:
        data: A JPEG or PNG file.
        outline: Corners of the three rectangles, px of the picture, shape (3, 4, 2); None if it was not found.
    Raises:
        VisionError: It is no picture.
    """
    pixels = Image.decode(data).pixels
    height, width = pixels.shape[:2]
    scale = SIDE / max(width, height)
    size = round(width * scale), round(height * scale)
    frame = np.full((SIDE + TEXT, SIDE, 3), 255, np.uint8)
    small = cv2.resize(pixels if pixels.ndim == 3 else cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR), size)
    frame[: size[1], : size[0]] = small
    if outline is not None and np.isfinite(outline).all():
        lines = np.rint((outline + 0.5) * scale - 0.5).astype(np.int32)
        cv2.polylines(frame[: size[1], : size[0]], list(lines), True, _TARGET, 2, cv2.LINE_AA)
    write(frame, "the follower's camera" + ("" if outline is not None else ": no target"), 6, SIDE + 22)
    return frame
