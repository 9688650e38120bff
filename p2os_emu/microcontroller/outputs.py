"""Outputs of the board: power outputs, servos, the display, a lamp.

Source: fact sheet section 4. Assumed: every power output is on after the power switch. SETPBIOPORT is taken as clients
send it, an output's number and its state, with 11 for the laser; the fact sheet's reading, a mask and levels, would
leave a laser without power that they switch on.
"""

from dataclasses import dataclass, field

from p2os.arguments import LASER_POWER_PORT, POWER_PORTS, PULSE_UNIT, SERVO_PORTS, read_display_data

POWER_OUTPUTS = ("pc", "lrf", "5v", "12v", "aux_pc", "touchscreen", "ptz", "audio", "lrf2")
"""By name: each has a POWER command of its own."""
_OUTPUT_OF_PORT = {number: f"port{number}" for number in POWER_PORTS} | {LASER_POWER_PORT: "lrf"}


def _all_on() -> dict[str, bool]:
    return dict.fromkeys((*POWER_OUTPUTS, *_OUTPUT_OF_PORT.values()), True)


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

    def set_power_port(self, number: int, state: int) -> None:
        """SETPBIOPORT; a number that is no output's is ignored."""
        if number in _OUTPUT_OF_PORT:
            self.power[_OUTPUT_OF_PORT[number]] = state != 0

    def set_servo(self, port: int, count: int) -> None:
        """PTUPOS; a pulse of no width ends the pulses."""
        if port not in SERVO_PORTS:
            return
        self.servos.pop(port, None)
        if count:
            self.servos[port] = count * PULSE_UNIT

    def show(self, text: bytes) -> None:
        """LCDWRITE."""
        self.lcd = read_display_data(text)
