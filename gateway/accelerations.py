"""Speeds and accelerations of the robot: those that the user asks for, those that are known, duration of a motion."""

from collections.abc import Iterator
from math import inf, sqrt
from typing import NamedTuple

from gateway.settings import DriveLimits
from p2os import Command, Configuration, RobotModel, encode_command

LEAST_ACCELERATION = 1e-3
"""m/s² or rad/s²; a robot that reports zero does not know its own."""


class _Acceleration(NamedTuple):
    """One acceleration, m/s² or rad/s², by its name in each place; `sign` is that on the wire."""

    name: str
    setting: str
    of_robot: str
    command: Command
    sign: float


_ROWS = (
    _Acceleration("acceleration", "acceleration_m_s2", "acceleration", Command.SETA, 1.0),
    _Acceleration("deceleration", "deceleration_m_s2", "deceleration", Command.SETA, -1.0),
    _Acceleration("angular_acceleration", "angular_acceleration_rad_s2", "rotational_acceleration", Command.SETRA, 1.0),
    _Acceleration(
        "angular_deceleration", "angular_deceleration_rad_s2", "rotational_deceleration", Command.SETRA, -1.0
    ),
)


def acceleration_frames(limits: DriveLimits) -> Iterator[tuple[str, bytes]]:
    """Return the frames that set the accelerations of the settings, each with its name; others stay as they are."""
    for row in _ROWS:
        wanted: float | None = getattr(limits, row.setting)
        if wanted is not None:
            yield row.name, encode_command(row.command, row.sign * wanted)


def speed_frames(limits: DriveLimits, linear: float, angular: float) -> Iterator[tuple[str, bytes]]:
    """Return the frames that have the robot keep the speeds of the settings in moves and turns, each with its name.

    Args:
        limits: Of the settings; what they leave out stays as it is.
        linear, angular: The lowest limits of model, robot and settings, m/s and rad/s, so that none is raised.
    """
    if limits.linear_m_s is not None:
        yield "speed", encode_command(Command.SETV, linear)
    if limits.angular_rad_s is not None:
        yield "angular_speed", encode_command(Command.SETRV, angular)


def known_accelerations(
    limits: DriveLimits, model: RobotModel, configuration: Configuration | None
) -> dict[str, float]:
    """Return the accelerations that can be counted on, by name.

    A frame that sets one may have been lost, so what the robot reports holds. Without a report it is the lesser of the
    setting and the model's.
    """
    found = {}
    for row in _ROWS:
        reported: float = getattr(configuration, row.of_robot) if configuration is not None else 0.0
        wanted: float | None = getattr(limits, row.setting)
        found[row.name] = reported or min(getattr(model.flash, row.of_robot), wanted or inf)
    return found


def travel_time(way: float, speed: float, acceleration: float, deceleration: float) -> float:
    """Return the time for a way with a trapezoidal speed profile, s.

    Args:
        way: m or rad; its sign does not matter.
        speed: The highest, m/s or rad/s, above 0.
        acceleration, deceleration: m/s² or rad/s², above 0.
    """
    ramps = 1.0 / max(acceleration, LEAST_ACCELERATION) + 1.0 / max(deceleration, LEAST_ACCELERATION)
    reached = min(speed, sqrt(2.0 * abs(way) / ramps))
    if reached <= 0.0:
        return 0.0
    return abs(way) / reached + reached * ramps / 2.0
