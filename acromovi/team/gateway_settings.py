"""Settings of the gateways of a team: what the team's file says of a robot, as the file that its gateway reads."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import configs
from configs import ConfigError
from configs.team_file import TeamRobot
from gateway.settings import Settings


def settings_table(robot: TeamRobot, team: Path) -> Mapping[str, Any] | None:
    """Return the settings that a team's file names for a robot's gateway, checked; None if it names none.

    Args:
        robot: As the file has it. A file of settings is looked for beside the team's file.
        team: The team's file.
    Raises:
        ConfigError: There is no such file, or a setting is unknown or not valid.
    """
    if robot.gateway is None:
        return None
    table, source = robot.gateway, f"{team}: the gateway of {robot.name}"
    if isinstance(table, str):
        path = team.parent / table
        if not path.is_file():
            raise ConfigError(f"{source}: there is no file {path}")
        table, source = configs.read(path), str(path)
    try:
        settings = configs.build(Settings, table, source)
    except ConfigError:
        raise
    except ValueError as err:
        raise ConfigError(f"{source}: {err}") from err
    if robot.camera_calibration is not None and settings.camera.calibration is not None:
        raise ConfigError(f"{source}: the camera has a calibration here and in camera_calibration; remove one")
    return table


def settings_text(robot: TeamRobot) -> str:
    """Return the settings of a robot's gateway as TOML; empty if it needs none.

    Args:
        robot: Its `gateway` is a table, or None.
    """
    table = {} if robot.gateway is None else robot.gateway
    assert not isinstance(table, str), "files are read when the team is loaded"
    if robot.is_emulated:
        table = {**table, "emulated": True}
    lines = list(_lines(table))
    if robot.camera_calibration is not None:
        lines.append(f"camera.calibration = {robot.camera_calibration.toml}")
    return "".join(f"{line}\n" for line in lines)


def _lines(table: Mapping[str, Any], above: str = "") -> Iterator[str]:
    for key, value in table.items():
        name = f"{above}{key}"
        if isinstance(value, Mapping):
            yield from _lines(value, f"{name}.")
        else:
            yield f"{name} = {json.dumps(value)}"  # plain values and lists of JSON are TOML as well
