"""Cameras of robots, drawn in the emulator's own process when a picture is asked for, in step with its world.

They draw with the `Mirror` that a camera's process has, by the software renderer, so the same seed gives the same bytes
on every machine. All cameras of a world share one mirror: what differs between them is the view.
"""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

import configs
from p2os_emu.camera.camera_process import CameraModel
from p2os_emu.camera.cameras import PART
from p2os_emu.camera.image_format import ImageFormat, read_format
from p2os_emu.camera.jpeg import encode_jpeg
from p2os_emu.emulator import Emulator
from p2os_emu.fitting import plugged_head
from p2os_emu.world import World, WorldError
from p2os_emu.world.mirror import Mirror
from p2os_emu.world.view import View


class CamerasInStep:
    """The cameras of all robots in one world. A world of which no picture is asked for costs nothing."""

    def __init__(self, emulator: Emulator, world: World) -> None:
        """Begin.

        Args:
            emulator: Whose robots carry cameras.
            world: What they see.
        """
        self._emulator = emulator
        self._world = world
        self._mirror: Mirror | None = None
        self._known: set[int] = set()

    @cached_property
    def model(self) -> CameraModel:
        """What all these cameras are.

        Raises:
            ConfigError: Its file has an error.
        """
        return configs.load(CameraModel, "accessories", PART)

    def image_format(self, name: str) -> ImageFormat:
        """Return size and rate of a robot's pictures.

        Raises:
            WorldError: There is no such robot, or it has no camera.
        """
        robot = self._emulator.robots.get(name)
        if robot is None or not robot.fit.has(PART):
            able = ", ".join(each.name for each in self._emulator.robots.values() if each.fit.has(PART)) or "none"
            raise WorldError(f"there is no camera on {name!r}; fit it with `camera`. Robots with one: {able}")
        return read_format(robot.fit.parts[PART])

    def view(self, name: str) -> View:
        """Return where a robot's camera truly is and looks now, with its head's pan, tilt and zoom.

        Raises:
            WorldError: As `image_format`.
        """
        self.image_format(name)
        device = plugged_head(self._emulator.robots[name].microcontroller)
        return self.model.view(self._world.truth(name).pose, device.head if device else None)

    def draw(self, name: str) -> NDArray[np.uint8]:
        """Return what a robot's camera sees now: rows of pixels with red, green, blue, shape (height, width, 3).

        Raises:
            WorldError: As `image_format`.
        """
        image, view = self.image_format(name), self.view(name)
        return self._current_mirror().draw(view, image.width, image.height)

    def jpeg(self, name: str) -> bytes:
        """Return what a robot's camera sees now, as the file that a camera's process serves.

        Raises:
            WorldError: As `image_format`.
        """
        return encode_jpeg(self.draw(name), self.model.quality)

    def close(self) -> None:
        """Forget the pictures' world; closing twice does nothing."""
        if self._mirror is not None:
            self._mirror.close()
            self._mirror = None
            self._known.clear()

    def _current_mirror(self) -> Mirror:
        """Return the mirror, with everything where it is now."""
        if self._mirror is None:
            self._mirror = Mirror()
        while True:  # news come in pieces
            news = self._world.sight.news(self._known)
            self._mirror.apply(news)
            self._known |= news.new.keys()
            self._known -= news.gone
            if not news.new:
                return self._mirror
