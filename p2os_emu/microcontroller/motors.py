"""The power stage: whether the wheels get power, and what they are told."""

from p2os_emu.body import Body, BodyState
from p2os_emu.microcontroller.flash import Flash
from p2os_emu.microcontroller.motion import MotionController
from p2os_emu.microcontroller.stall import StallDetector

AT_REST = 0.005
"""m/s of a wheel rim below which braking has done its work."""


class Motors:
    """Drives the wheels as the motion servers say, while they are enabled and not stalled.

    enabled: as the SIP shows. Motion commands mean nothing while it is false.
    """

    __slots__ = ("_braking", "_driven", "_motion", "_stall_count", "_waiting", "enabled", "stall")

    def __init__(self, motion: MotionController, flash: Flash) -> None:
        self._motion = motion
        self.stall = StallDetector(flash)
        self._driven: tuple[float, float] | None = None
        self.enabled = False
        self.restore(flash)

    def restore(self, flash: Flash) -> None:
        """Take the parameters from FLASH and the power off the wheels."""
        self.stall.restore(flash)
        self._stall_count = flash.stall_count
        self.disable()
        self._driven = (0.0, 0.0)  # whatever the wheels were told before, release them

    def enable(self) -> None:
        """Give the wheels power; the robot stands until a command comes."""
        if not self.enabled:
            self.disable()
            self.enabled = True

    def disable(self) -> None:
        """Take the power off the wheels and forget every command."""
        self.enabled = False
        self._braking = False
        self._waiting = 0.0
        self.stall.clear()
        self._motion.rest()

    def brake_and_disable(self) -> None:
        """Brake as hard as the motors can, then take the power off: the STOP button."""
        if self.enabled:
            self.enabled = False
            self._braking = True
            self._motion.stop(emergency=True)

    def advance(self, body: Body, state: BodyState, dt: float) -> None:
        """Advance by one step; send the wheel speeds to the body if they changed."""
        if self._waiting > 0.0:
            self._wait(state, dt)
        if self._waiting > 0.0 or not (self.enabled or self._braking):
            self._release(body)
            return
        motion = self._motion
        if self.stall.detects(state, motion.forward, dt):
            self._waiting = self._stall_count
            self._release(body)
            return
        motion.advance(state, dt)
        if self._braking and self._stands(state):
            self.disable()
            self._release(body)
            return
        wanted = (motion.left, motion.right)
        if wanted != self._driven:
            self._driven = wanted
            body.drive(*wanted)

    def _wait(self, state: BodyState, dt: float) -> None:
        """Keep a stalled robot without power for a while, then continue from its present speed."""
        self._waiting -= dt
        if self._waiting <= 0.0:
            self.stall.clear()
            self._motion.restart(state.left_velocity, state.right_velocity)

    def _release(self, body: Body) -> None:
        if self._driven is not None:
            self._driven = None
            body.release()

    def _stands(self, state: BodyState) -> bool:
        motion = self._motion
        return motion.left == motion.right == 0.0 and max(abs(state.left_velocity), abs(state.right_velocity)) < AT_REST
