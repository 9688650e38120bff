"""Plan the processes of a team from its file. Starts nothing."""

import difflib
import json
import sys
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import configs
from acromovi.team.gateway_settings import settings_table, settings_text
from acromovi.team.identities import TeamOptions
from bus.keys import robot_name
from configs import ConfigError
from configs.team_file import GatewayProcesses, TeamFile, TeamRobot, read_team
from p2os_emu.links.profile import LinkProfile

if TYPE_CHECKING:
    from apps.indoor_navigation.wiring import Wiring

SERVICES = "services"  # the container of the team's own agents
SHARED_SETTINGS = "emulated.toml"  # of the gateways of emulated robots without settings of their own
EMULATED = "emulated = true\n"
WRITTEN = "# Written by acromovi up"
"""Begin of files that are written for a robot, by which they are told from files of other origin."""


class ProcessKind(IntEnum):
    """What kind of process it is, in the order in which they end."""

    AGENTS = 0  # containers, and what runs on top of them
    GATEWAY = 1  # after those who command it: it stops its robot
    EMULATOR = 2


@dataclass(frozen=True, slots=True)
class PlannedProcess:
    """One process of a team.

    name: for people. robots: whose it is; none where it is everybody's. container: the one that it runs, if any.
    is_extra: it belongs to no robot nor to the team; it is there since one of the team's agents asked for it.
    """

    name: str
    stage: ProcessKind
    command: tuple[str, ...]
    robots: tuple[str, ...] = ()
    container: str = ""
    is_extra: bool = False

    @property
    def robot(self) -> str:
        """The only robot whose it is; empty where it is not one robot's."""
        return self.robots[0] if len(self.robots) == 1 else ""

    @classmethod
    def of_navigation(cls, robot: str, process: str, options: Sequence[str], bus: str) -> Self:
        """One process of a robot's indoor navigation. options: of the wiring, for a command line."""
        words = ("navigate", "process", robot, process, *options, "--bus", bus, "--json")
        command = _python("acromovi", *words)
        return cls(f"{process} of {robot}", ProcessKind.AGENTS, command, (robot,), container=f"{robot}-{process}")


@dataclass(frozen=True, slots=True)
class TeamPlan:
    """A team as its file says.

    name: of the file, and of the platform of the team's own agents. source: what finds the file again.
    """

    name: str
    source: str
    file: TeamFile

    @classmethod
    def load(cls, name: str, only: Sequence[str] = ()) -> Self:
        """Read and check a team's file.

        Args:
            name: One of `configs/teams`, or a file.
            only: The robots that are wanted; none means all.
        Raises:
            ConfigError: There is no such team or robot, the file has an error, or two things have one name.
            KeyNotValid: A name cannot be a robot's.
        """
        path = configs.find("teams", name)
        file = read_team(str(path))
        names = [robot.name for robot in file.robots]
        if not names:
            raise ConfigError(f"{path}: a team needs a robot; write [[robots]] with a name and a model")
        robot_name(path.stem)
        for robot in file.robots:
            _check(robot, path, names)
        for service in file.services:
            _check_service(service, path)
        if any(robot.navigation for robot in file.robots):
            _wiring()
        for wanted in only:
            if wanted not in names:
                raise ConfigError(f"{path}: there is no robot {wanted!r} in this team; {_nearest(wanted, names)}")
        robots = [replace(robot, gateway=settings_table(robot, path)) for robot in file.robots]
        chosen = tuple(robot for robot in robots if robot.name in (only or names))
        return cls(path.stem, str(path), replace(file, robots=chosen))

    @property
    def robots(self) -> tuple[TeamRobot, ...]:
        """Its robots."""
        return self.file.robots

    @property
    def emulated(self) -> tuple[TeamRobot, ...]:
        """Those that are not real."""
        return tuple(robot for robot in self.robots if robot.is_emulated)


class TeamProcesses:
    """The processes of a team, as they are started."""

    def __init__(self, team: TeamPlan, choices: TeamOptions, folder: Path) -> None:
        """Plan nothing yet.

        Args:
            team: The team.
            choices: Of the command line.
            folder: For ports, control socket and settings.
        """
        self._team = team
        self._choices = choices
        self._folder = folder

    def settings(self) -> dict[Path, str]:
        """Return the files of settings that the gateways read, with their texts."""
        texts = {self._folder / SHARED_SETTINGS: EMULATED} if self._team.emulated else {}
        for robot in self._team.robots:
            if text := settings_text(robot):
                texts[self._settings(robot)] = text if self._shares(robot) else f"{WRITTEN}.\n{text}"
        return texts

    def write_settings(self) -> None:
        """Write the settings of the gateways, before they start."""
        for path, text in self.settings().items():
            path.write_text(text, encoding="utf-8")

    def _settings(self, robot: TeamRobot) -> Path:
        """The file where a gateway reads its settings; that of all emulated robots, or a robot's own."""
        return self._folder / (SHARED_SETTINGS if self._shares(robot) else f"acromovi-gateway-{robot.name}.toml")

    @staticmethod
    def _shares(robot: TeamRobot) -> bool:
        """Whether the settings of a robot's gateway are those of all emulated robots."""
        return robot.is_emulated and robot.gateway is None and robot.camera_calibration is None

    def emulator(self) -> PlannedProcess:
        """The process that emulates the team's emulated robots. Ports and control socket are in the folder."""
        words = ["--team", self._team.source, "--json", "--quiet", "--until-stdin-closes"]
        words += ["--pty", str(self._folder / "port"), "--control", str(self._folder / "control")]
        words += ["--only", ",".join(robot.name for robot in self._team.emulated)]
        if self._choices.seed is not None:
            words += ["--seed", str(self._choices.seed)]
        return PlannedProcess("the emulator", ProcessKind.EMULATOR, _python("p2os_emu", *words))

    def gateways(self, ports: Mapping[str, Mapping[str, Any]]) -> list[PlannedProcess]:
        """The gateways of the emulated robots: a shared one for those with one bus profile, or one for each.

        Args:
            ports: What the emulator says of each robot.
        """
        robots = self._team.emulated
        profiles = Counter(self._choices.bus_of_robot(robot.name) for robot in robots)
        if self._team.file.gateways is GatewayProcesses.SEPARATE or len(profiles) != 1 or len(robots) == 1:
            return [self.gateway(robot, ports[robot.name]) for robot in robots]
        words = [word for robot in robots for word in self._gateway_words(robot, ports[robot.name])]
        command = _python("gateway", *words, "--bus", *profiles, "--json", "--wait")
        names = tuple(robot.name for robot in robots)
        return [PlannedProcess("the gateway of the emulated robots", ProcessKind.GATEWAY, command, names)]

    def gateway(self, robot: TeamRobot, ports: Mapping[str, Any]) -> PlannedProcess:
        """A gateway of one robot.

        Args:
            robot: One of the team, which has the team's link unless it has one of its own. A real one is found where
                the file says.
            ports: What the emulator says of an emulated one; nothing of a real one.
        """
        bus = self._choices.bus_of_robot(robot.name)
        command = _python("gateway", *self._gateway_words(robot, ports), "--bus", bus, "--json", "--wait")
        return PlannedProcess(f"the gateway of {robot.name}", ProcessKind.GATEWAY, command, (robot.name,))

    def _gateway_words(self, robot: TeamRobot, ports: Mapping[str, Any]) -> list[str]:
        """The port of a robot, and the options that are its own."""
        emulated = {part: ports.get(key) for part, key in _PORTS.items()}
        real = {"laser": robot.laser, "arm": robot.arm, "camera": robot.camera}
        words = [ports.get("port") or robot.port, "--name", robot.name]
        for part, place in (emulated if robot.is_emulated else real).items():
            words += [f"--{part}", place] if place else []
        if configs.load(LinkProfile, "links", robot.link or self._team.file.link).modem is not None:
            words.append("--radio")
        if settings_text(robot):
            words += ["--config", str(self._settings(robot))]
        return words

    def container(self, robot: str) -> PlannedProcess:
        """The container of a robot's agents."""
        words = ("container", "--robot", robot, "--bus", self._choices.bus_of_robot(robot), "--json")
        return PlannedProcess(
            f"the container of {robot}", ProcessKind.AGENTS, _python("acromovi", *words), (robot,), container=robot
        )

    def navigation(self, robot: str) -> list[PlannedProcess]:
        """The processes of a robot's indoor navigation, as its wiring has them."""
        bus = self._choices.bus_of_robot(robot)
        return [PlannedProcess.of_navigation(robot, process, [], bus) for process in _wiring().processes]

    def services(self) -> PlannedProcess:
        """The container of the team's own agents."""
        words = [
            "container",
            "--services",
            self._team.name,
            "--bus",
            self._choices.bus_of_team(self._team.name),
            "--json",
            *self._folders,
        ]
        for service, properties in self._team.file.services.items():
            for key, value in properties.items():
                words += ["--property", f"{service}.{key}={json.dumps(value)}"]
        return PlannedProcess(
            "the container of services", ProcessKind.AGENTS, _python("acromovi", *words), container=SERVICES
        )

    def console(self, control: str | None) -> PlannedProcess:
        """The web console.

        Args:
            control: The emulator's control socket; None without an emulator.
        """
        words = ["console", "--json", "--port", str(self._choices.console), "--team", self._team.source]
        words += ["--control", control] if control is not None else []
        command = _python("acromovi", *words, "--bus", self._choices.bus_of_team(self._team.name), *self._folders)
        return PlannedProcess("the console", ProcessKind.AGENTS, command)

    def extra(self, name: str) -> PlannedProcess:
        """An empty container, for an application.

        Raises:
            KeyNotValid: The name cannot be that of a container.
        """
        words = [
            "container",
            robot_name(name),
            "--bus",
            self._choices.bus_of_team(self._team.name),
            "--json",
            *self._folders,
        ]
        command = _python("acromovi", *words)
        return PlannedProcess(f"the container {name}", ProcessKind.AGENTS, command, container=name, is_extra=True)

    @property
    def _folders(self) -> list[str]:
        return [word for folder in self._choices.apps for word in ("--apps", str(folder))]


_PORTS = {"laser": "laser_port", "arm": "arm_port", "camera": "camera_url"}


def _python(module: str, *words: str) -> tuple[str, ...]:
    return (sys.executable, "-m", module, *words)


def _check(robot: TeamRobot, path: Path, names: Sequence[str]) -> None:
    robot_name(robot.name)
    configs.find("robots", robot.model)
    if not robot.port:
        raise ConfigError(f'{path}: the port of {robot.name} is empty; give a device, a URL or "emu"')
    if robot.link is not None:
        configs.find("links", robot.link)
    if names.count(robot.name) > 1:
        raise ConfigError(f"{path}: two robots are called {robot.name}; give each a name of its own")
    if robot.name in (path.stem, SERVICES):
        taken = "the team" if robot.name == path.stem else "the container of the team's own agents"
        raise ConfigError(f"{path}: a robot is called {robot.name} as {taken} is; give it another name")


def _check_service(name: str, path: Path) -> None:
    from agents.services.all_services import SERVICES as KINDS  # late: few files name one

    if name not in KINDS:
        raise ConfigError(f"{path}: there is no service {name!r}; {_nearest(name, tuple(KINDS), 'the services')}")


def _wiring() -> "Wiring":
    from apps.indoor_navigation.wiring import load_wiring  # late: few teams navigate

    return load_wiring()


def _nearest(name: str, names: Collection[str], whose: str = "its robots") -> str:
    near = difflib.get_close_matches(name, names, 1)
    return f"did you mean {near[0]!r}?" if near else f"{whose} are {', '.join(names)}"
