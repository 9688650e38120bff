"""One picture, in a program's hands."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from agents.client.errors import RobotError
from configs.extras import missing, needs


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """One picture.

    format: `jpeg` or `png`. data: such a file. width, height: pixels, None where they are not known.
    stamp: when it was taken, s since 1970 on the clock of the robot's gateway; NaN where that is not known.
    """

    format: str
    width: int | None
    height: int | None
    data: bytes
    stamp: float = math.nan

    def __repr__(self) -> str:
        """Its size and stamp: `<Picture jpeg, 320 x 240 pixels, 10.4 kB, stamp 1793404800.512>`."""
        size = "unknown size" if self.width is None or self.height is None else f"{self.width} x {self.height} pixels"
        stamp = "" if math.isnan(self.stamp) else f", stamp {self.stamp:.3f}"
        return f"<Picture {self.format}, {size}, {len(self.data) / 1000:.1f} kB{stamp}>"

    def save(self, file: str | Path) -> None:
        """Write it into a file.

        Raises:
            RobotError: It cannot be written there.
        """
        try:
            Path(file).write_bytes(self.data)
        except OSError as err:
            raise RobotError(f"the picture cannot be written to {file}: {err.strerror}") from err

    def pixels(self) -> npt.NDArray[np.uint8]:
        """The colours of its pixels: rows from the top, columns from the left, and blue, green and red, 0 to 255.

        Raises:
            RobotError: It is no picture, or OpenCV is missing, which takes it apart.
        """
        if missing("vision"):
            raise RobotError(needs("Picture.pixels", "vision"))
        import cv2  # here and not at the top: it is a large part that only this needs

        found = cv2.imdecode(np.frombuffer(self.data, np.uint8), cv2.IMREAD_COLOR)
        if found is None:
            raise RobotError(f"what the camera gave is no {self.format} that can be read")
        return np.asarray(found, np.uint8)
