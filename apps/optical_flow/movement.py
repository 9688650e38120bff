"""The movement for each situation: which direction, at which speed, on which curve."""

import numpy as np

from apps.optical_flow.settings import FlowSettings
from apps.optical_flow.situation import FlowSituation
from apps.optical_flow.surroundings import FlowSurroundings
from geometry import Twist2D

REST = Twist2D()
_WAYS = 0.6  # m that must be clear in a direction that is chosen
_CURVES = 17  # turn rates that are compared
_AHEAD = {FlowSituation.FREE: np.radians(50.0), FlowSituation.UNKNOWN: np.radians(30.0)}
_SIDEWAYS = np.radians(80.0)


def worth(around: FlowSurroundings, settings: FlowSettings) -> np.ndarray:
    """Return what each direction is worth, m: clear and not visited, less the turn; -inf where it is not clear."""
    coverage = settings.coverage
    value = 0.3 * around.clear + coverage.unvisited * around.fresh - coverage.turn_cost * np.abs(around.bearings)
    value -= coverage.unknown_cost * (1.0 - around.sure)
    return np.where(around.clear >= _WAYS, value, -np.inf)


def direction_ahead(around: FlowSurroundings, situation: FlowSituation, settings: FlowSettings) -> float | None:
    """Return the best bearing to steer to while driving, rad; None where none is clear."""
    value = worth(around, settings)
    value[np.abs(around.bearings) > _AHEAD.get(situation, _SIDEWAYS)] = -np.inf
    if situation is FlowSituation.LEFT:
        value[around.bearings > 0.1] = -np.inf
    if situation is FlowSituation.RIGHT:
        value[around.bearings < -0.1] = -np.inf
    best = int(np.argmax(value))
    return float(around.bearings[best]) if np.isfinite(value[best]) else None


def direction_around(around: FlowSurroundings, settings: FlowSettings, least: float = 0.35) -> float:
    """Return the best bearing to turn to on the spot, rad, at least so many rad away from the heading."""
    value = worth(around, settings)
    value[np.abs(around.bearings) < least] = -np.inf
    best = int(np.argmax(value))
    return float(around.bearings[best if np.isfinite(value[best]) else int(np.argmax(around.clear))])


def steered(
    around: FlowSurroundings, situation: FlowSituation, bearing: float, settings: FlowSettings
) -> Twist2D | None:
    """Return the twist toward a bearing, on the nearest curve that is free; None where there is none.

    Curves over floor that was never seen are slow, and are taken only where there is no other one.
    """
    drive = settings.drive
    wanted = float(np.clip(drive.gain * bearing, -drive.steer_rad_s, drive.steer_rad_s))
    turns = np.linspace(-drive.steer_rad_s, drive.steer_rad_s, _CURVES)
    turns = turns[np.argsort(np.abs(turns - wanted), kind="stable")]
    fast = drive.slow_m_s if situation in (FlowSituation.UNKNOWN, FlowSituation.NEAR) else drive.speed_m_s
    for speed in (fast, drive.slow_m_s) if fast > drive.slow_m_s else (fast,):
        free = turns[around.free_curves(speed, turns, settings) & around.seen_curves(speed, turns, settings)]
        if len(free) and (speed == drive.slow_m_s or abs(free[0] - wanted) < drive.steer_rad_s):
            return Twist2D(speed, float(free[0]))
    costs = np.abs(turns - wanted) + around.risks(turns, settings)
    costs[~around.free_curves(drive.slow_m_s, turns, settings)] = np.inf
    best = int(np.argmin(costs))
    return Twist2D(drive.slow_m_s, float(turns[best])) if np.isfinite(costs[best]) else None


def crept(around: FlowSurroundings, settings: FlowSettings) -> Twist2D | None:
    """Return a slow twist ahead on the straightest free curve over floor that was seen; None where there is none."""
    speed = settings.drive.slow_m_s / 2.0
    turns = np.linspace(-settings.drive.turn_rad_s, settings.drive.turn_rad_s, _CURVES)
    costs = np.abs(turns) + around.risks(turns, settings)
    costs[~around.free_curves(speed, turns, settings)] = np.inf
    best = int(np.argmin(costs))
    return Twist2D(speed, float(turns[best])) if np.isfinite(costs[best]) else None


def turned(bearing: float, settings: FlowSettings) -> Twist2D:
    """Return the twist on the spot toward a bearing, rad."""
    rate = max(0.15, min(settings.drive.turn_rad_s, 1.5 * abs(bearing)))
    return Twist2D(0.0, rate if bearing > 0.0 else -rate)
