"""Every camera of an emulator: a process for each robot that has one fitted."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import configs
from p2os_emu.camera.camera_model import CameraModel
from p2os_emu.camera.camera_process import CameraProcess
from p2os_emu.camera.image_format import read_format
from p2os_emu.camera.news import SceneMoment
from p2os_emu.fitting import plugged_head
from p2os_emu.links.link import PortError
from p2os_emu.world.view import View

if TYPE_CHECKING:
    from p2os_emu.emulator import EmulatedRobot, Emulator
    from p2os_emu.world import World

PART = "camera"
RATE = 30.0
"""Hz; how often a camera hears what is new. Its pictures are not older than this lets them be."""


class Cameras:
    """Made beside an emulator, and told whenever a robot is added and between steps.

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
        """A robot has come, with a camera or without.

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
        """Where a robot's camera is; None where it has none."""
        process = self._processes.get(name)
        return None if process is None else process.url

    def tend(self) -> None:
        """Tell every camera at which somebody looks what is new, if that is due; never waits."""
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
        """Whether somebody looks at a picture of one of them."""
        return any(process.wants_news for process in self._processes.values())

    def close(self) -> None:
        """End every process."""
        for name in list(self._processes):
            self._drop(name)
        while self._leaving:
            self._leaving.pop().close()

    def _feed(self, robot: "EmulatedRobot", process: CameraProcess, is_due: bool) -> bool:
        """Tell a camera what is new, if that is due or somebody has just begun to look; returns whether it lives."""
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
        """What is new to a camera, and where it looks now: along its head, if it is on one."""
        model = self._model
        assert model is not None  # there is a camera
        device = plugged_head(robot.microcontroller)
        head = None if device is None else device.head
        view = View.on(
            self._world.truth(robot.name).pose,
            model.forward_m,
            model.height_m,
            head.pan.position if head else 0.0,
            head.tilt.position if head else 0.0,
            head.field_of_view if head else model.field_of_view,
        )
        return SceneMoment(self._world.sight.news(process.known), view)
