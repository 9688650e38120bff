"""Where the camera looks: at the leader, or about in search of it."""

from math import asin, copysign, inf, pi, sin

from apps.robot_following.settings import SearchSettings
from geometry import wrap_angle


def pan_to(bearing: float, reach: float) -> float:
    """Return the pan for a bearing in the robot's frame, rad, as far as the head goes to either side."""
    return max(-reach, min(reach, wrap_angle(bearing)))


def sweep(since: float, first: float, side: float, settings: SearchSettings, reach: float) -> float:
    """Return the pan of a search, rad.

    The head swings to and fro at an even pace, first to the side to which the leader was headed.

    Args:
        since: s since the search began.
        first: Bearing of the leader then, rad.
        side: Positive for the left one.
        settings: Of the search.
        reach: Of the head to either side, rad; 0 without one.
    """
    wide = min(settings.pan, reach)
    if wide <= 0.0:
        return 0.0
    out = copysign(1.0, side)
    start = max(-1.0, min(1.0, out * first / wide))  # on the first swing out
    phase = start + since * settings.pan_speed / wide
    return out * wide * 2.0 / pi * asin(sin(pi / 2.0 * phase))


def swing_time(settings: SearchSettings, reach: float) -> float:
    """Return how long the head needs to look to both sides and back, s; 0 without a head."""
    return 4.0 * min(settings.pan, reach) / settings.pan_speed


class HeadCommands:
    """Decides when the head is told to move: its line is slow, and pictures are best while it stands.

    told_at: s of the latest command; -inf before the first.
    """

    def __init__(self, settings: SearchSettings) -> None:
        self._settings = settings
        self._told = 0.0
        self.told_at = -inf

    def next(self, pan: float, now: float) -> float | None:
        """Return the pan to command, rad; None if the head looks nearly there, or was told only just.

        Args:
            pan: Where it should look, rad.
            now: s.
        """
        settings, since = self._settings, now - self.told_at
        if since < settings.pan_period or (abs(pan - self._told) < settings.pan_step and since < settings.pan_repeat):
            return None
        self._told, self.told_at = pan, now
        return pan
