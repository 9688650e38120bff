"""The elements that tell what a robot senses."""

import base64
import math
from collections.abc import Sequence

from agents.face.element import Element
from agents.face.picture import Picture
from agents.face.readings import (
    BatteryReading,
    BumpersReading,
    CameraReading,
    IoReading,
    JoystickReading,
    LaserReading,
    OtherReading,
    RangesReading,
    SonarReading,
)


class Sonar(Element[SonarReading]):
    """The ring of sonar discs."""

    reading = SonarReading

    def nearest(self) -> float:
        """The nearest echo, m; infinite when there is none."""
        return self.read().nearest

    def power(self, on: bool = True) -> None:
        """Switch the discs."""
        self.ask("power", on=on)


class Laser(Element[LaserReading]):
    """The laser scanner."""

    reading = LaserReading

    def nearest(self) -> float:
        """The nearest obstacle, m; infinite when there is none."""
        return self.read().nearest


class Bumpers(Element[BumpersReading]):
    """What feels contact."""

    reading = BumpersReading

    def pressed(self) -> bool:
        """Whether anything touches the robot."""
        return self.read().pressed


class Infrared(Element[RangesReading]):
    """Infrared range sensors."""

    reading = RangesReading

    def nearest(self) -> float:
        """The nearest thing, m; infinite when there is none."""
        return self.read().nearest


class Battery(Element[BatteryReading]):
    """The battery."""

    reading = BatteryReading

    def voltage(self) -> float:
        """V."""
        return self.read().voltage


class Io(Element[IoReading]):
    """The user's inputs and outputs."""

    reading = IoReading

    def output(self, mask: int, value: int) -> None:
        """Set the digital outputs whose bits are in the mask, each to its bit in the value."""
        self.ask("output", mask=mask, value=value)


class Camera(Element[CameraReading]):
    """The camera."""

    reading = CameraReading

    def picture(self) -> Picture:
        """The newest picture: `robot.camera.picture().save("here.jpg")`."""
        taken = self.ask("picture")
        return Picture(
            format=taken["format"],
            width=taken["width"],
            height=taken["height"],
            data=base64.b64decode(taken["data"]),
        )


class Sound(Element[OtherReading]):
    """Buzzer or loudspeaker."""

    def play(self, notes: Sequence[tuple[int, float]] | int) -> None:
        """Play notes, each a MIDI number and its length in s, or a tune that the robot knows by its number."""
        if isinstance(notes, int):
            self.ask("play", number=notes)
        else:
            self.ask("play", notes=[list(note) for note in notes])

    def mute(self, on: bool = True) -> None:
        """Be silent, or no longer."""
        self.ask("mute", on=on)


class Joystick(Element[JoystickReading]):
    """The joystick on the robot."""

    reading = JoystickReading

    def drive(self, on: bool = True) -> None:
        """Let it drive the robot, or no longer."""
        self.ask("drive", on=on)


class Compass(Element[OtherReading]):
    """The compass."""

    def heading(self) -> float:
        """From magnetic north, counter-clockwise, rad; NaN where it cannot be told."""
        heading = self.read()["heading"]
        return math.nan if heading is None else float(heading)
