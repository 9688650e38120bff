"""How hard the robot speeds up and brakes: what the user has it told, and what is known of it."""

from collections.abc import Iterator
from math import inf
from typing import NamedTuple

from gateway.settings import DriveLimits
from p2os import Command, Configuration, RobotModel, encode_command


class _Acceleration(NamedTuple):
    """One acceleration, m/s² or rad/s², by the name that it has in each place; `sign` is that on the wire."""

    name: str
    setting: str
    of_robot: str
    command: Command
    sign: float


ROWS = (
    _Acceleration("acceleration", "acceleration_m_s2", "acceleration", Command.SETA, 1.0),
    _Acceleration("deceleration", "deceleration_m_s2", "deceleration", Command.SETA, -1.0),
    _Acceleration("angular_acceleration", "angular_acceleration_rad_s2", "rotational_acceleration", Command.SETRA, 1.0),
    _Acceleration(
        "angular_deceleration", "angular_deceleration_rad_s2", "rotational_deceleration", Command.SETRA, -1.0
    ),
)


def told(limits: DriveLimits) -> Iterator[tuple[str, bytes]]:
    """What the robot has to be told, each with its name: what the user left out stays as it is."""
    for row in ROWS:
        wanted: float | None = getattr(limits, row.setting)
        if wanted is not None:
            yield row.name, encode_command(row.command, row.sign * wanted)


def known(limits: DriveLimits, model: RobotModel, configuration: Configuration | None) -> dict[str, float]:
    """Those that can be counted on.

    Whatever the robot was told may have been lost on the way: what it says itself holds. Of one that says nothing no
    more is believed than what was wanted and what its model has.
    """
    found = {}
    for row in ROWS:
        said: float = getattr(configuration, row.of_robot) if configuration is not None else 0.0
        wanted: float | None = getattr(limits, row.setting)
        found[row.name] = said or min(getattr(model.flash, row.of_robot), wanted or inf)
    return found
