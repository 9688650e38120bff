"""Teams as data: which robots there are, what they have, and where they are plugged in."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from configs.camera_calibration import CameraCalibration
from configs.defaults import LINK, WORLD
from configs.loader import ConfigError, find, load

MOST_ROBOTS = 100
"""Robots in one team: an emulator's core has room for about as many, firmware and physics included."""
EMULATED = "emu"
"""The port of a robot that is emulated."""


class GatewayProcesses(StrEnum):
    """In which processes the gateways of a team run: emulated robots share one, or each robot has its own."""

    SHARED = "shared"
    SEPARATE = "separate"


@dataclass(frozen=True, slots=True)
class TeamRobot:
    """One robot of a team.

    name: on the bus. model: one of `configs/robots`, or a file. port: a device or a URL, or `EMULATED`.
    fit: its accessories, as `--fit` writes them; of a real robot, what is bolted onto it.
    laser, arm, camera: where those of a real robot are plugged in.
    camera_calibration: of its camera, as `acromovi camera calibrate` writes it.
    gateway: settings of its gateway, a table or the name of a file beside the team's.
    link: of an emulated one, where it differs from the team's.
    navigation: whether its indoor navigation is started with the team, as `acromovi navigate up` does.
    at_m, heading_deg: where it begins in an emulated world; left to the world without them.
    """

    name: str
    model: str
    port: str = EMULATED
    fit: tuple[str, ...] = ()
    laser: str | None = None
    arm: str | None = None
    camera: str | None = None
    camera_calibration: CameraCalibration | None = None
    gateway: str | Mapping[str, Any] | None = None
    link: str | None = None
    navigation: bool = False
    at_m: tuple[float, float] | None = None
    heading_deg: float = 0.0

    @property
    def is_emulated(self) -> bool:
        """It has no port of its own."""
        return self.port == EMULATED


@dataclass(frozen=True, slots=True)
class TeamFile:
    """A file of `configs/teams`.

    world, link: of the emulated robots. gateways: processes of their gateways; real robots always have their own.
    services: properties of the team's services, by their names.
    """

    robots: tuple[TeamRobot, ...]
    about: str = ""
    world: str = WORLD
    link: str = LINK
    gateways: GatewayProcesses = GatewayProcesses.SHARED
    services: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def read_team(name: str) -> TeamFile:
    """Find and read a team.

    Args:
        name: One of `configs/teams`, or a file.
    Raises:
        ConfigError: There is no such team, its file has an error, or it has more than `MOST_ROBOTS`.
    """
    team = load(TeamFile, "teams", name)
    if len(team.robots) > MOST_ROBOTS:
        raise ConfigError(
            f"{find('teams', name)}: a team of {len(team.robots)} robots is too large; use at most {MOST_ROBOTS}"
        )
    return team
