"""Inputs of the robot beside its line: buttons, the charger, the user's input pins."""

from dataclasses import dataclass, field
from typing import NamedTuple

from p2os.sip import OPEN_INPUTS
from p2os_emu.microcontroller.flash import Flash
from p2os_emu.microcontroller.motion import MotionController
from p2os_emu.microcontroller.motors import Motors

ANALOG_PORTS = 8


class Stick(NamedTuple):
    """Position of a joystick.

    x: -1 left to 1 right. y: -1 back to 1 forward. throttle: 0 to 1. button1: the fire button.
    """

    x: float = 0.0
    y: float = 0.0
    throttle: float = 1.0
    button1: bool = False
    button2: bool = False


CENTRED = Stick()


@dataclass(slots=True)
class Panel:
    """Inputs that a person, a fault or an accessory may change at any time.

    stop_button: the red button is pressed. charger_plugged: the charger gives power. digital_in: level of each user
    input, bit 0 to 7. infrared: level of each infrared sensor, a bit is clear while it sees something. analog: V of
    each user A/D port, 0 to 5. battery: V that takes the place of the battery's own, None for none.
    docked: the robot stands at a dock, whose power lowered contacts find. joystick: None while none is plugged in.
    gyro_failed: the gyro gives nothing any more.
    """

    stop_button: bool = False
    charger_plugged: bool = False
    digital_in: int = OPEN_INPUTS
    infrared: int = OPEN_INPUTS
    analog: list[float] = field(default_factory=lambda: [0.0] * ANALOG_PORTS)
    battery: float | None = None
    docked: bool = False
    joystick: Stick | None = None
    gyro_failed: bool = False


class JoystickServer:
    """Lets the joystick drive while its fire button (button 1) is held; with a client only after JOYDRIVE 1.

    The speeds are FLASH's JOYVEL and JOYRVEL at full deflection, times the throttle.
    Source: fact sheet section 4, and section 7 of the accessories.

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
