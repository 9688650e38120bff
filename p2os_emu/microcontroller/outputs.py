"""What the board switches and shows: power outputs, servos, the display, a lamp.

Source: fact sheet section 4. Assumed: every power output is on after the power switch; bit 0 of the power port is the
first of its outputs.
"""

from dataclasses import dataclass, field

POWER_OUTPUTS = ("pc", "lrf", "5v", "12v", "aux_pc", "touchscreen", "ptz", "audio", "lrf2")
"""By name: each has a POWER command of its own."""
POWER_PORT = tuple(f"port{bit + 1}" for bit in range(8))
"""The eight outputs that SETPBIOPORT switches, bit 0 first."""
SERVO_PORTS = range(1, 5)
PULSE_UNIT = 1e-5
"""s of a servo pulse that one count of PTUPOS stands for, since P2OS."""
LCD_SIZE = 20
"""Characters that the display takes at once."""


def _all_on() -> dict[str, bool]:
    return dict.fromkeys((*POWER_OUTPUTS, *POWER_PORT), True)


@dataclass(slots=True)
class Outputs:
    """The board's outputs beside the user's digital ones.

    power: name to whether it is on. servos: port to width of its pulses, s; a port without pulses is not there.
    lcd: the text on the display. lamp: PatrolBot's lamp blinks while it drives.
    """

    power: dict[str, bool] = field(default_factory=_all_on)
    servos: dict[int, float] = field(default_factory=dict)
    lcd: str = ""
    lamp: bool = True

    def set_power_port(self, mask: int, levels: int) -> None:
        """SETPBIOPORT: switch what the mask names."""
        for bit, name in enumerate(POWER_PORT):
            if mask >> bit & 1:
                self.power[name] = bool(levels >> bit & 1)

    def set_servo(self, port: int, count: int) -> None:
        """PTUPOS; a pulse of no width ends the pulses."""
        if port not in SERVO_PORTS:
            return
        self.servos.pop(port, None)
        if count:
            self.servos[port] = count * PULSE_UNIT

    def show(self, text: bytes) -> None:
        """LCDWRITE."""
        self.lcd = text.split(b"\0", 1)[0][:LCD_SIZE].decode("latin-1")
