"""Inputs of the robot beside its line: buttons, the charger, the user's input pins."""

from dataclasses import dataclass, field
from typing import NamedTuple

from p2os.sip import OPEN_INPUTS

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
