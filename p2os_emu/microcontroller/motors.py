"""The power stage: whether the wheels get power, and what they are told."""

from p2os.arguments import StallBumpers
from p2os_emu.body import Body, BodyState
from p2os_emu.microcontroller.flash import Flash
from p2os_emu.microcontroller.motion import MotionController


class _StallDetector:
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
        """Look at one step; return whether a wheel is stalled now.

        Args:
            state: The machine.
            forward: Its sign is the direction asked for: a bumper only stalls a robot that moves towards it.
            dt: s.
        """
        left_velocity, right_velocity, left_load, right_load, front, rear = state[2:8]
        if (front or rear) and self._runs_into(front, rear, forward):
            self.left = self.right = True
            return True
        gain = dt / self._window
        below = self._below
        left, right = self._left_average, self._right_average
        left += ((left_load if -below < left_velocity < below else 0.0) - left) * gain
        right += ((right_load if -below < right_velocity < below else 0.0) - right) * gain
        self._left_average, self._right_average = left, right
        threshold = self._threshold
        self.left = left_stalls = left > threshold
        self.right = right_stalls = right > threshold
        return left_stalls or right_stalls

    def _runs_into(self, front: int, rear: int, forward: float) -> bool:
        if forward > 0.0:
            return bool(front and self.bumpers & StallBumpers.FRONT)
        return bool(forward < 0.0 and rear and self.bumpers & StallBumpers.REAR)


AT_REST = 0.005
"""m/s of a wheel rim below which braking has done its work."""


class Motors:
    """Drives the wheels as the motion servers say, while they are enabled and not stalled.

    enabled: as the SIP shows. Motion commands mean nothing while it is false.
    """

    __slots__ = ("_braking", "_driven", "_motion", "_stall_count", "_waiting", "enabled", "stall")

    def __init__(self, motion: MotionController, flash: Flash) -> None:
        self._motion = motion
        self.stall = _StallDetector(flash)
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
        if not (self.enabled or self._braking):
            self._release(body)
            return
        if self._waiting > 0.0:
            self._wait(state, dt)
            if self._waiting > 0.0:
                self._release(body)
                return
        motion = self._motion
        if self.stall.detects(state, motion.left + motion.right, dt):
            self._waiting = self._stall_count
            self._release(body)
            return
        motion.advance(state.left_velocity, state.right_velocity, dt)
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
