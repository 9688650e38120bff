"""Odometry without the roll-over: X and Y on the wire are 15-bit counters."""

from p2os.fields import POSITION_UNITS, Quantity, Ring
from p2os.robot_model import RobotModel

JUMP_COUNTS = 0x1000
"""Counts between two SIPs that no robot rolls in a cycle. Source: the limit that a client library unwraps by."""

_SHORTEST = Ring(-POSITION_UNITS // 2, POSITION_UNITS)


class OdometryUnwrapper:
    """Follows the wire's position counters to a continuous position, m in `odom`.

    A step of more than `JUMP_COUNTS`, the shortest way round, is no movement: the counters were set anew (SETO, a
    reset), or a damaged packet passed as sound. The position stays, and later steps count from the new counters.

    jumps: steps taken for jumps so far.
    """

    def __init__(self, model: RobotModel) -> None:
        self._scale = model.scales[Quantity.DISTANCE]
        self._last: tuple[int, int] | None = None
        self._total = (0, 0)
        self.jumps = 0

    def update(self, x: float, y: float) -> tuple[float, float]:
        """Take the position of one SIP.

        Args:
            x, y: m, as `StandardSip` has them.
        Returns:
            Position since the first SIP, m, without roll-over.
        """
        now = round(x / self._scale), round(y / self._scale)
        last = self._last or now
        self._last = now
        dx, dy = _SHORTEST.fit(now[0] - last[0]), _SHORTEST.fit(now[1] - last[1])
        if max(abs(dx), abs(dy)) > JUMP_COUNTS:
            self.jumps += 1
        else:
            self._total = self._total[0] + dx, self._total[1] + dy
        return self._total[0] * self._scale, self._total[1] * self._scale

    def rebase(self) -> None:
        """Take the position of the next SIP as the new reference, after SETO or a new connection."""
        self._last = None
