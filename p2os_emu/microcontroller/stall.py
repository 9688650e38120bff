"""Stalls: wheels that push without turning, and bumpers that touch on the way."""

from p2os.arguments import StallBumpers
from p2os_emu.body import BodyState
from p2os_emu.microcontroller.flash import Flash


class StallDetector:
    """Watches motor effort and bumpers.

    A wheel is stalled when the running average of its PWM, counted only while the wheel is slow, exceeds STALLVAL. The
    average forgets with the integration time as its time constant. Source: fact sheet section 9.

    left, right: the wheel is stalled. bumpers: which bumpers stall the robot, as the BUMPSTALL command counts.
    """

    __slots__ = ("_below", "_left_average", "_right_average", "_threshold", "_window", "bumpers", "left", "right")

    def __init__(self, flash: Flash) -> None:
        self.restore(flash)

    def restore(self, flash: Flash) -> None:
        """Take the parameters from FLASH and forget the averages."""
        self._threshold = flash.stall_value / flash.pwm_max
        self._window = flash.stall_integration
        self._below = flash.stall_below
        self.bumpers = flash.bump_stall
        self.clear()

    def clear(self) -> None:
        """The motors have no power: nothing pushes."""
        self._left_average = self._right_average = 0.0
        self.left = self.right = False

    def detects(self, state: BodyState, forward: float, dt: float) -> bool:
        """Look at one step; say whether a wheel is stalled now.

        Args:
            state: The machine.
            forward: Speed asked for along the robot, m/s: a bumper only stalls a robot that moves towards it.
            dt: s.
        """
        if (state.front_bumpers or state.rear_bumpers) and self._runs_into(state, forward):
            self.left = self.right = True
            return True
        gain = dt / self._window
        below = self._below
        effort = state.left_load if -below < state.left_velocity < below else 0.0
        self._left_average += (effort - self._left_average) * gain
        effort = state.right_load if -below < state.right_velocity < below else 0.0
        self._right_average += (effort - self._right_average) * gain
        self.left = self._left_average > self._threshold
        self.right = self._right_average > self._threshold
        return self.left or self.right

    def _runs_into(self, state: BodyState, forward: float) -> bool:
        if forward > 0.0:
            return bool(state.front_bumpers and self.bumpers & StallBumpers.FRONT)
        return bool(forward < 0.0 and state.rear_bumpers and self.bumpers & StallBumpers.REAR)
