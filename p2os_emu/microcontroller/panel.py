"""What the world outside the cable does to a robot: buttons, the charger, the user's input pins."""

from dataclasses import dataclass, field

ANALOG_PORTS = 8
OPEN_PINS = 0xFF
"""Digital inputs are pulled high; infrared sensors are active low."""


@dataclass(slots=True)
class Panel:
    """Inputs that a person, a fault or an accessory may change at any time.

    stop_button: the red button is pressed. charger_plugged: the charger gives power. digital_in: level of each user
    input, bit 0 to 7. infrared: level of each infrared sensor, a bit is clear while it sees something. analog: V of
    each user A/D port, 0 to 5. battery: V that takes the place of the battery's own, None for none.
    """

    stop_button: bool = False
    charger_plugged: bool = False
    digital_in: int = OPEN_PINS
    infrared: int = OPEN_PINS
    analog: list[float] = field(default_factory=lambda: [0.0] * ANALOG_PORTS)
    battery: float | None = None
