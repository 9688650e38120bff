"""Every camera of an emulator: a process for each robot that has one fitted."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import configs
from p2os_emu.camera.camera_process import CameraModel, CameraProcess
from p2os_emu.camera.image_format import read_format
from p2os_emu.camera.news import SceneMoment
from p2os_emu.fitting import plugged_head
from p2os_emu.links.link import PortError

if TYPE_CHECKING:
    from p2os_emu.emulator import EmulatedRobot, Emulator
    from p2os_emu.world import World

PART = "camera"
RATE = 30.0
"""Hz; how often a camera hears what is new. Its pictures are not older than this lets them be."""


class Cameras:
    """The camera processes of an emulator; call `add` for each robot and `tend` between steps.

    has_stopped: no news are sent, and so no pictures drawn, beyond the few that keep viewers waiting.
    """

    def __init__(self, emulator: "Emulator", world: "World", complain: Callable[[str], None]) -> None:
        """Begin without any.

        Args:
            emulator: Whose robots carry them.
            world: What they see.
            complain: Says a sentence to people.
        """
        self.has_stopped = False
        self._emulator = emulator
        self._world = world
        self._complain = complain
        self._model: CameraModel | None = None
        self._processes: dict[str, CameraProcess] = {}
        self._leaving: list[CameraProcess] = []
        self._due = 0.0

    def add(self, robot: "EmulatedRobot") -> None:
        """Start the camera of a robot, if one is fitted.

        Raises:
            PortError: There is no port or no process for it.
        """
        if robot.fit.has(PART):
            self._model = self._model or configs.load(CameraModel, "accessories", PART)
            image = read_format(robot.fit.parts[PART])
            try:
                self._processes[robot.name] = CameraProcess(robot.name, image, self._model)
            except OSError as error:
                raise PortError(f"there is no camera to be had for {robot.name}: {error}") from error

    def url(self, name: str) -> str | None:
        """Return the URL of a robot's camera; None where it has none."""
        process = self._processes.get(name)
        return None if process is None else process.url

    def tend(self) -> None:
        """Send the changes that are due to every watched camera; never blocks."""
        now = self._emulator.time
        is_due = now >= self._due
        if is_due:
            self._leaving = [process for process in self._leaving if not process.has_ended]
            self._due = now + 1 / RATE
        for name, process in list(self._processes.items()):
            robot = self._emulator.robots.get(name)
            if robot is None:
                self._drop(name)
            elif not self._feed(robot, process, is_due):
                self._drop(name)
                self._complain(f"the camera of {name} has ended; the robot goes on without it")

    @property
    def are_watched(self) -> bool:
        """Whether any camera is watched."""
        return any(process.wants_news for process in self._processes.values())

    def close(self) -> None:
        """End every process."""
        for name in list(self._processes):
            self._drop(name)
        while self._leaving:
            self._leaving.pop().close()

    def _feed(self, robot: "EmulatedRobot", process: CameraProcess, is_due: bool) -> bool:
        """Send the changes to a camera if they are due or it has a new viewer; return whether it lives."""
        if not process.listen():
            return False
        if process.is_newly_watched or (is_due and process.wants_news and not self.has_stopped):
            return process.tell(self._moment(robot, process))
        return True

    def _drop(self, name: str) -> None:
        process = self._processes.pop(name)
        process.leave()
        self._leaving.append(process)

    def _moment(self, robot: "EmulatedRobot", process: CameraProcess) -> SceneMoment:
        """Return the changes for a camera and its present view, along its head if it is on one."""
        model = self._model
        assert model is not None  # there is a camera
        device = plugged_head(robot.microcontroller)
        view = model.view(self._world.truth(robot.name).pose, device.head if device else None)
        return SceneMoment(self._world.sight.news(process.known), view, time.time())
