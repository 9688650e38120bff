"""The robots of one run, from `MODEL[:NAME]` to a robot with a name and a port."""

import re
from collections.abc import Callable, Container, Mapping, Sequence
from contextlib import ExitStack
from typing import Any

import configs
from configs import ConfigError
from configs.team_file import MOST_ROBOTS
from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.emulator import EmulatedRobot, Emulator
from p2os_emu.fit import Fit, FitError, read_fit
from p2os_emu.hints import nearest
from p2os_emu.links.link import Link, PortError
from p2os_emu.links.profile import LinkProfile
from p2os_emu.microcontroller import Flash
from p2os_emu.ports import Ports

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+-]{0,18}")


class EmulatedTeam:
    """Makes robots.

    Args:
        emulator: Where they live.
        ports: Where their ports come from.
        profile: Name of what their lines do to bytes, for people.
        flash: FLASH parameters that replace the factory's in every robot.
        flash_source: File that they came from, for messages.
        fits: Parts of `--fit`, as they are written; those without a robot's name go onto every robot.
        links: Name of a robot to that of its own line profile, where that is another.
    """

    def __init__(
        self,
        emulator: Emulator,
        ports: Ports,
        profile: str,
        flash: Mapping[str, Any],
        flash_source: str,
        fits: Sequence[str] = (),
        links: Mapping[str, str] | None = None,
    ) -> None:
        self.emulator = emulator
        self.whenever_added: list[Callable[[EmulatedRobot], None]] = []
        self.camera_url: Callable[[str], str | None] = lambda name: None
        self._ports = ports
        self._profile = profile
        self._links = links or {}
        self._flash = flash
        self._flash_source = flash_source
        self._fits = [_read_fit_option(text) for text in fits]

    def check_fits(self) -> None:
        """Check that every robot named by a part or a line exists.

        Raises:
            ConfigError: One is not.
        """
        for option, names in (("--fit", [name for name, _ in self._fits if name]), ("--link", self._links)):
            for name in names:
                if name not in self.emulator.robots:
                    hint = nearest(name, self.emulator.robots)
                    raise ConfigError(f"{option} {name}=...: there is no robot {name!r}; {hint}")

    def check_model(self, text: str) -> None:
        """Check that a model exists.

        Raises:
            ConfigError: As `add`.
        """
        name, model = _read_robot(text, ())
        self._fitted(name, model)

    def add(
        self, text: str, pose: Pose2D | None = None, link: Link | None = None, parts: Sequence[str] = ()
    ) -> EmulatedRobot:
        """Make a robot.

        Args:
            text: MODEL or MODEL:NAME; a model is one of `configs/robots` or a path to a file.
            pose: Where, m, m, rad; None leaves the choice to the world.
            link: Its cable; None opens a port for it.
            parts: Of this robot alone, as `--fit` writes them.
        Raises:
            ConfigError: There are too many robots, the name will not do, the world has no room there, or it is to be
                recorded and cannot be.
            ConfigError: There is no such model, or a file has an error.
            PortError: Its port cannot be opened.
        """
        if len(self.emulator.robots) >= MOST_ROBOTS:
            raise ConfigError(f"there are {MOST_ROBOTS} robots already, and no room for more; run a second emulator")
        name, model = _read_robot(text, self.emulator.robots)
        model, fit = self._fitted(name, model, parts)
        flash = self._flash_of(model, name)
        with ExitStack() as opened:
            if link is None:
                link = self._ports.open(name)
                opened.callback(link.close)
            cables = {}
            for part in fit.cables:
                cables[part] = self._ports.open_cable(name, part)
                opened.callback(cables[part].close)
            try:
                robot = self.emulator.add(
                    name, model, link, pose=pose, flash=flash, fit=fit, cables=cables, profile=self._own_profile(name)
                )
            except ValueError as error:
                raise ConfigError(str(error)) from error
            opened.pop_all()
        try:
            for tell in self.whenever_added:
                tell(robot)
        except (ConfigError, PortError):
            self.emulator.remove(name)
            raise
        return robot

    def entry(self, robot: EmulatedRobot) -> dict[str, str | None]:
        """Return the connection data of a robot for JSON; null for parts it does not have."""
        return {
            "name": robot.name,
            "model": robot.model.name,
            "port": robot.line.link.port,
            "link": self._links.get(robot.name, self._profile),
            "laser_port": _cable_port(robot, "laser"),
            "arm_port": _cable_port(robot, "arm"),
            "camera_url": self.camera_url(robot.name),
        }

    def _fitted(self, name: str, model: RobotModel, own: Sequence[str] = ()) -> tuple[RobotModel, Fit]:
        meant = [part for whom, parts in self._fits if whom in ("", name) for part in parts]
        try:
            return read_fit([*meant, *own], model)
        except FitError as error:
            raise ConfigError(f"robot {name}: {error}") from error

    def _own_profile(self, name: str) -> LinkProfile | None:
        return configs.load(LinkProfile, "links", self._links[name]) if name in self._links else None

    def _flash_of(self, model: RobotModel, name: str) -> Flash:
        try:
            return self.emulator.flash(model, name, self._flash)
        except ValueError as error:
            raise ConfigError(f"{self._flash_source}: {error}") from error


def check_name(name: str) -> None:
    """Check the name of an emulated robot.

    Raises:
        ConfigError: The handshake or the bus cannot carry it.
    """
    if not _NAME.fullmatch(name):
        raise ConfigError(f"robot name {name!r} will not do; use 1 to 19 letters, digits, or any of _ . + -")


def _read_robot(text: str, taken: Container[str]) -> tuple[str, RobotModel]:
    """Find the model and choose the name.

    Args:
        text: MODEL or MODEL:NAME.
        taken: Names that other robots have.
    Returns:
        Name and model. Without a NAME it is the model's, followed by -2, -3 and so on where that is taken.
    Raises:
        ConfigError: The name is taken, or is none that the handshake and the bus can carry.
        ConfigError: There is no such model, or its file has an error.
    """
    kind, colon, name = text.partition(":")
    model = configs.load(RobotModel, "robots", kind)
    if not colon:
        name = _free_name(model.name, taken)
    check_name(name)
    if name in taken:
        raise ConfigError(f"there is a robot {name!r} already; choose another name")
    return name, model


def _read_fit_option(text: str) -> tuple[str, list[str]]:
    """Take `[NAME=]part,part` apart; the name is empty where there is none."""
    name, equals, parts = text.rpartition("=")
    return name if equals else "", [part.strip() for part in parts.split(",")]


def _cable_port(robot: EmulatedRobot, part: str) -> str | None:
    return robot.cables[part].line.link.port if part in robot.cables else None


def _free_name(name: str, taken: Container[str]) -> str:
    free, number = name, 1
    while free in taken:
        number += 1
        free = f"{name}-{number}"
    return free
