"""Options of a team on the command line, and the keys of its processes on a secure bus.

What is a robot's comes with the robot's own key; the host and the team's services, which look after all, with the key
of an admin who is called as the team is.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from bus.secure import CERTIFICATE, Permit, Profile
from configs import ConfigError


@dataclass(frozen=True, slots=True)
class TeamOptions:
    """Options of the command line for a team.

    apps: folders of applications that the team's agents may start.
    keys: the folder where each process has a key of its own for the bus; None where all come as the bus says.
    console: TCP port of the web console; None where none is started.
    """

    bus: str = "local"
    seed: int | None = None
    apps: tuple[Path, ...] = ()
    keys: Path | None = None
    console: int | None = None

    def bus_of_robot(self, robot: str) -> str:
        """Return the bus options of a robot's gateway and agents, with the robot's key."""
        return self._bus_of(_robots_key(robot))

    def bus_of_team(self, team: str) -> str:
        """Return the bus options of a team's host and services, with the team's key."""
        return self._bus_of(_teams_key(team))

    def _bus_of(self, owner: str) -> str:
        return self.bus if self.keys is None else f"{Profile.find(self.bus).path}:{self.keys / owner}"


def folder_of_keys(profile: str, team: str, robots: Iterable[str]) -> Path | None:
    """Return the folder with the keys of a team's processes.

    Args:
        profile: The bus, as of `--bus`.
        team: The team's name.
        robots: Its robots.
    Returns:
        The folder, as `acromovi keys` fills it; None where all share what the profile says.
    Raises:
        ConfigError: Keys are missing, or the only one that is given is not an admin's.
        BusUnavailable: The only one that is given is not valid now.
    """
    found = Profile.find(profile)
    if found.folder is None:
        return None
    owners = [*map(_robots_key, robots), _teams_key(team)]
    if (found.folder / CERTIFICATE).is_file():
        permit = Permit.of(found)
        if permit is not None and permit.own_name is not None:
            raise ConfigError(
                f"{found.folder} is the key of {permit.common_name}, which may not speak for a whole team; give the "
                f"folder in which the keys {', '.join(owners)} are: --bus secure:FOLDER"
            )
        return None
    missing = [owner for owner in owners if not (found.folder / owner / CERTIFICATE).is_file()]
    if missing:
        first = "; ".join(_making(owner, found.folder) for owner in missing)
        lacks = f"{found.folder} lacks the keys of {', '.join(missing)}"
        raise ConfigError(f"{lacks}; make them, and start the router again: {first}")
    return found.folder.absolute()


def _making(owner: str, folder: Path) -> str:
    """The command that makes a key."""
    role, _, name = owner.partition(".")
    return f"acromovi keys make --role {role} --name {name} --out {folder}"


def _robots_key(robot: str) -> str:
    return f"robot.{robot}"


def _teams_key(team: str) -> str:
    return f"admin.{team}"
