"""Encoders and dead reckoning: wheel travel to ticks, ticks to a pose."""

from math import cos, floor, sin

from p2os.robot_model import RobotModel

DRIFT_UNIT = 1 / 8192
"""DRIFTFACTOR counts this much of the left encoder."""


class OdometryIntegrator:
    """Counts encoder ticks and integrates them, as the microcontroller does: all it knows of its motion is ticks.

    left_ticks, right_ticks: since power-on. x, y: m since the last reset. heading: rad since the last reset, unwrapped.
    travelled, left_travelled, right_travelled: m forward since power-on. turned: rad counter-clockwise since power-on.
    """

    __slots__ = (
        "_left_metres",
        "_left_seen",
        "_right_metres",
        "_right_seen",
        "_started",
        "_ticks_per_metre",
        "_track",
        "_turned_at_reset",
        "_wheel_track",
        "left_ticks",
        "left_travelled",
        "right_ticks",
        "right_travelled",
        "travelled",
        "turned",
        "x",
        "y",
    )

    def __init__(self, model: RobotModel) -> None:
        self._ticks_per_metre = model.ticks_per_metre
        self._wheel_track = model.wheel_track
        self.calibrate(1.0, 1.0, 0)
        self.power_on()

    @property
    def heading(self) -> float:
        """Rad counter-clockwise since the last reset, not wrapped."""
        return self.turned - self._turned_at_reset

    def power_on(self) -> None:
        """Forget everything; the next update sets the wheel positions."""
        self._started = False
        self._left_seen = self._right_seen = 0
        self.left_ticks = self.right_ticks = 0
        self.travelled = self.left_travelled = self.right_travelled = self.turned = 0.0
        self.reset()

    def reset(self) -> None:
        """Call the present pose the origin (SETO)."""
        self.x = self.y = 0.0
        self._turned_at_reset = self.turned

    def calibrate(self, ticks: float, revolution: float, drift: int) -> None:
        """Set working calibration, from now on.

        Args:
            ticks: TICKSMM in parts of the FLASH value: more ticks make a millimetre.
            revolution: REVCOUNT in parts of the FLASH value: more differential ticks make a turn. Relative, because the
                manuals count them per full turn (AROS) and per half turn (ARCOS).
            drift: DRIFTFACTOR.
        """
        self._right_metres = 1.0 / (self._ticks_per_metre * ticks)
        self._left_metres = self._right_metres * (1.0 + drift * DRIFT_UNIT)
        self._track = self._wheel_track * revolution / ticks

    def update(self, left_travel: float, right_travel: float, turned: float | None = None) -> None:
        """Read the encoders.

        Args:
            left_travel: m rolled by the left rim since some fixed time.
            right_travel: m, likewise.
            turned: rad counter-clockwise since the update before, where something knows better than the wheels.
        """
        ticks_per_metre = self._ticks_per_metre
        left_count = floor(left_travel * ticks_per_metre)
        right_count = floor(right_travel * ticks_per_metre)
        left_step = left_count - self._left_seen
        right_step = right_count - self._right_seen
        if not (left_step or right_step or turned) and self._started:
            return
        self._left_seen = left_count
        self._right_seen = right_count
        if not self._started:
            self._started = True
            return
        self.left_ticks += left_step
        self.right_ticks += right_step
        left = left_step * self._left_metres
        right = right_step * self._right_metres
        # The pose moves along the chord of the arc that the wheels rolled.
        forward = (left + right) / 2
        turn = (right - left) / self._track if turned is None else turned
        before = self.turned
        bearing = before - self._turned_at_reset + turn / 2
        self.x += forward * cos(bearing)
        self.y += forward * sin(bearing)
        self.turned = before + turn
        self.travelled += forward
        self.left_travelled += left
        self.right_travelled += right
