"""The joystick in the robot's socket: how it drives.

It drives while its fire button (button 1) is held: always without a client, with one only after JOYDRIVE 1. The speeds
are FLASH's JOYVEL and JOYRVEL at full deflection, times the throttle. Source: fact sheet section 4 and section 7 of the
accessories. Assumed: without a client the fire button enables the motors, and letting go brakes and disables them; with
one, motors stay as the client has them and letting go stops the robot; what the client commands meanwhile is
overridden; the watchdog holds nothing that a hand drives.
"""

from p2os_emu.microcontroller.flash import Flash
from p2os_emu.microcontroller.motion import MotionController
from p2os_emu.microcontroller.motors import Motors
from p2os_emu.microcontroller.panel import Stick


class JoystickServer:
    """Drives.

    allowed: JOYDRIVE. driving: the joystick has the wheels now.
    """

    __slots__ = ("_rotation", "_velocity", "allowed", "driving")

    def __init__(self, flash: Flash) -> None:
        self._velocity = flash.joystick_velocity
        self._rotation = flash.joystick_rotation
        self.driving = False
        self.restore()

    def restore(self) -> None:
        """Handle the end of the connection: JOYDRIVE ends."""
        self.allowed = False

    def advance(
        self, stick: Stick, motors: Motors, motion: MotionController, has_client: bool, may_enable: bool
    ) -> None:
        """Take one step.

        Args:
            stick: As a hand holds it.
            motors: Enabled and disabled, as long as there is no client.
            motion: Told where to go.
            has_client: A connection is open.
            may_enable: No STOP button forbids it.
        """
        wants = stick.button1 and (self.allowed or not has_client)
        if wants and not has_client and may_enable:
            motors.enable()
        if wants and motors.enabled:
            self.driving = True
            motion.translate(stick.y * stick.throttle * self._velocity)
            motion.rotate(-stick.x * stick.throttle * self._rotation)
        elif self.driving:
            self.driving = False
            if has_client:
                motion.stop()
            else:
                motors.brake_and_disable()
