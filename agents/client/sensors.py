"""The clients of sensors, user ports and sound."""

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from agents.client.element import ElementClient
from agents.client.errors import RobotError
from agents.client.loop_thread import LoopThread
from agents.client.readings import (
    BatteryReading,
    BumpersReading,
    CameraReading,
    IoReading,
    JoystickReading,
    LaserReading,
    OtherReading,
    RangesReading,
    SonarDiscPose,
    SonarReading,
)
from agents.platform import AgentName
from agents.platform.errors import in_words
from bus.keys import frame
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
        """Return its size and stamp: `<Picture jpeg, 320 x 240 pixels, 10.4 kB, stamp 1793404800.512>`."""
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
        """Return its pixels: rows from the top, columns from the left, and blue, green and red, 0 to 255.

        Raises:
            RobotError: It is no picture, or OpenCV is missing.
        """
        if missing("vision"):
            raise RobotError(needs("Picture.pixels", "vision"))
        import cv2  # late: only this needs the large module

        found = cv2.imdecode(np.frombuffer(self.data, np.uint8), cv2.IMREAD_COLOR)
        if found is None:
            raise RobotError(f"what the camera gave is no {self.format} that can be read")
        return np.asarray(found, np.uint8)


class SonarClient(ElementClient[SonarReading]):
    """The ring of sonar discs."""

    reading = SonarReading

    def __init__(self, thread: LoopThread, agent: AgentName) -> None:
        super().__init__(thread, agent)
        self._discs: dict[int, SonarDiscPose] | None = None

    @property
    def discs(self) -> dict[int, SonarDiscPose]:
        """Return the discs by number with pose and frame; empty if the robot's description has none.

        Raises:
            RobotError: The agent does not answer.
        """
        if self._discs is None:
            rows = self.properties.get("discs") or []
            self._discs = {disc.number: disc for disc in (_disc(row, self.agent) for row in rows)}
        return dict(self._discs)

    def within(self, angle: float, width: float) -> float:
        """Return the nearest echo now, m, in a sector of `width` rad around `angle`; see `SonarReading.within`."""
        return self.read().within(angle, width)

    def nearest(self) -> float:
        """Return the nearest echo, m; infinite if there is none."""
        return self.read().nearest

    def power(self, on: bool = True) -> None:
        """Switch the discs on or off."""
        self.ask("power", on=on)

    def _read(self, result: Any) -> SonarReading:
        return replace(super()._read(result), discs=self.discs)


def _disc(row: Mapping[str, Any], said_by: AgentName) -> SonarDiscPose:
    """Return a disc of the agent's description.

    Raises:
        RobotError: It cannot be read.
    """
    try:
        number = int(row["number"])
        return SonarDiscPose(
            number=number,
            frame=str(row.get("frame") or frame(said_by.platform, f"sonar_{number}")),
            x=float(row["x"]),
            y=float(row["y"]),
            heading=float(row["heading"]),
            field_of_view=float(row.get("field_of_view", 0.0)),
        )
    except (KeyError, TypeError, ValueError) as err:
        raise RobotError(f"the discs of {said_by} cannot be read: {in_words(err)}") from err


class LaserClient(ElementClient[LaserReading]):
    """The laser scanner."""

    reading = LaserReading

    def nearest(self) -> float:
        """Return the nearest obstacle, m; infinite if there is none."""
        return self.read().nearest


class BumpersClient(ElementClient[BumpersReading]):
    """The bumpers."""

    reading = BumpersReading

    def pressed(self) -> bool:
        """Return whether anything touches the robot."""
        return self.read().pressed


class InfraredClient(ElementClient[RangesReading]):
    """Infrared range sensors."""

    reading = RangesReading

    def nearest(self) -> float:
        """Return the nearest obstacle, m; infinite if there is none."""
        return self.read().nearest


class BatteryClient(ElementClient[BatteryReading]):
    """The battery."""

    reading = BatteryReading

    def voltage(self) -> float:
        """V."""
        return self.read().voltage


class Io(ElementClient[IoReading]):
    """The user's inputs and outputs."""

    reading = IoReading

    def output(self, mask: int, value: int) -> None:
        """Set the digital outputs whose bits are in the mask, each to its bit in the value."""
        self.ask("output", mask=mask, value=value)


class CameraClient(ElementClient[CameraReading]):
    """The camera."""

    reading = CameraReading

    def picture(self) -> Picture:
        """Return the newest picture: `robot.camera.picture().save("here.jpg")`."""
        taken = self.ask("picture")
        return Picture(
            format=taken["format"],
            width=taken["width"],
            height=taken["height"],
            data=base64.b64decode(taken["data"]),
            stamp=taken.get("stamp", math.nan),
        )


class SoundClient(ElementClient[OtherReading]):
    """The buzzer or loudspeaker."""

    def play(self, notes: Sequence[tuple[int, float]] | int) -> None:
        """Play notes, each a MIDI number and its length in s, or a tune of the robot by its number."""
        if isinstance(notes, int):
            self.ask("play", number=notes)
        else:
            self.ask("play", notes=[list(note) for note in notes])

    def mute(self, on: bool = True) -> None:
        """Switch the sound off or on."""
        self.ask("mute", on=on)


class JoystickClient(ElementClient[JoystickReading]):
    """The joystick on the robot."""

    reading = JoystickReading

    def drive(self, on: bool = True) -> None:
        """Permit or forbid that it drives the robot."""
        self.ask("drive", on=on)


class CompassClient(ElementClient[OtherReading]):
    """The compass."""

    def heading(self) -> float:
        """Return the heading from magnetic north, counter-clockwise, rad; NaN if it is not known."""
        heading = self.read()["heading"]
        return math.nan if heading is None else float(heading)
