"""The robots of one run: from `MODEL[:NAME]` to a robot with a name and a port of its own."""

import re
from collections.abc import Container, Mapping
from typing import Any

import configs
from configs import ConfigError
from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.emulator import EmulatedRobot, Emulator
from p2os_emu.microcontroller import Flash
from p2os_emu.ports import Ports

_NAME = re.compile(r"[A-Za-z0-9_.+-]{1,19}")


class TeamError(ValueError):
    """A robot cannot be had as asked; the message says why and what to do."""


class Team:
    """Makes robots.

    Args:
        emulator: Where they live.
        ports: Where their ports come from.
        profile: Name of what their lines do to bytes, for people.
        flash: FLASH parameters that replace the factory's in every robot.
        flash_source: File that they came from, for messages.
    """

    def __init__(
        self, emulator: Emulator, ports: Ports, profile: str, flash: Mapping[str, Any], flash_source: str
    ) -> None:
        self.emulator = emulator
        self._ports = ports
        self._profile = profile
        self._flash = flash
        self._flash_source = flash_source

    def add(self, text: str, pose: Pose2D | None = None) -> EmulatedRobot:
        """Make a robot.

        Args:
            text: MODEL or MODEL:NAME; a model is one of `configs/robots` or a path to a file.
            pose: Where, m, m, rad; None leaves the choice to the world.
        Raises:
            TeamError: The name will not do, or the world has no room there.
            ConfigError: There is no such model, or a file has an error.
            PortError: Its port cannot be opened.
        """
        name, model = read_robot(text, self.emulator.robots)
        flash = self._flash_of(model, name)
        link = self._ports.open(name)
        try:
            return self.emulator.add(name, model, link, pose=pose, flash=flash)
        except ValueError as error:
            link.close()
            raise TeamError(str(error)) from error

    def entry(self, robot: EmulatedRobot) -> dict[str, str | None]:
        """What a program needs to know to use a robot, ready for JSON; null for parts it does not have."""
        return {
            "name": robot.name,
            "model": robot.model.name,
            "port": robot.line.link.port,
            "link": self._profile,
            "laser_port": None,
            "camera_url": None,
        }

    def _flash_of(self, model: RobotModel, name: str) -> Flash:
        try:
            return Flash.of(model, name).changed(self._flash)
        except ValueError as error:
            raise ConfigError(f"{self._flash_source}: {error}") from error


def read_robot(text: str, taken: Container[str]) -> tuple[str, RobotModel]:
    """Find the model and settle the name.

    Args:
        text: MODEL or MODEL:NAME.
        taken: Names that other robots have.
    Returns:
        Name and model. Without a NAME it is the model's, followed by -2, -3 and so on where that is taken.
    Raises:
        TeamError: The name is taken, or is none that the handshake and the bus can carry.
        ConfigError: There is no such model, or its file has an error.
    """
    kind, colon, name = text.partition(":")
    model = configs.load(RobotModel, "robots", kind)
    if not colon:
        name = _free_name(model.name, taken)
    if not _NAME.fullmatch(name):
        raise TeamError(f"robot name {name!r} will not do; use 1 to 19 letters, digits, or any of _ . + -")
    if name in taken:
        raise TeamError(f"there is a robot {name!r} already; choose another name")
    return name, model


def _free_name(name: str, taken: Container[str]) -> str:
    free, number = name, 1
    while free in taken:
        number += 1
        free = f"{name}-{number}"
    return free
