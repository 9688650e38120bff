"""Whether the robot does as it is told: a cable may carry everything one way and nothing the other."""

from math import inf

from gateway.motion_in_progress import is_at_rest
from p2os import StandardSip

PATIENCE = 1.0
"""Seconds for which a robot may stand that was told to drive."""
SLOWEST = 0.02, 0.05
"""m/s and rad/s: what is slower may be less than the wire can say, or than the gears turn by."""


class Obedience:
    """Compares what was asked for with what the SIPs show.

    is_ignored: the robot stands although it is told to drive, has power, and says of no wheel that it is stalled.
    """

    def __init__(self) -> None:
        self.is_ignored = False
        self._stands_since = inf

    def judge(self, linear: float, angular: float, sip: StandardSip, now: float) -> None:
        """Take a SIP.

        Args:
            linear, angular: Velocity that is in force, m/s and rad/s.
            sip: A plausible one.
            now: Steady time, s.
        """
        is_asked = abs(linear) >= SLOWEST[0] or abs(angular) >= SLOWEST[1]
        is_able = sip.motors_enabled and not (sip.left_stalled or sip.right_stalled)
        self._stands_since = min(self._stands_since, now) if is_asked and is_able and is_at_rest(sip) else inf
        self.is_ignored = now - self._stands_since >= PATIENCE
