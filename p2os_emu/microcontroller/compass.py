"""The compass server: the TCM2 command, the compass byte of the SIP and TCM2pac.

Source: fact sheet section 7 of the accessories. Assumed: with a module fitted the byte is in the SIP from power-on;
CALCOMP 1 and 0 begin and end a calibration as modes 4 and 6 do.
"""

from p2os.accessory_packets import CompassReport
from p2os.arguments import CompassMode, PacketRequest
from p2os.sip import compass_byte
from p2os_emu.accessories.tcm2 import Tcm2
from p2os_emu.body import BodyState
from p2os_emu.microcontroller.timers import Cadence


class CompassServer:
    """Reads the module five times a second.

    byte: what the SIP carries, 2 degrees a count clockwise from north; north is 180, since one well-known driver takes
    0 for no compass; 0 while it is off.
    """

    def __init__(self, module: Tcm2) -> None:
        self._module = module
        self._cadence = Cadence(module.spec.period_s)
        self.power_on()

    def power_on(self) -> None:
        """Begin as after the power switch; the module remembers its calibration."""
        self.byte = 0
        self.restore()

    def restore(self) -> None:
        """The client has gone."""
        self._module.end_calibration()
        self._reads = True
        self._packets = PacketRequest.STOP

    def command(self, mode: int) -> None:
        """TCM2; other numbers are ignored."""
        match mode:
            case CompassMode.OFF | CompassMode.BYTE:
                self._packets = PacketRequest.STOP
            case CompassMode.ONE_PACKET:
                self._packets = PacketRequest.ONE
            case CompassMode.CONTINUOUS:
                self._packets = PacketRequest.CONTINUOUS
            case CompassMode.USER_CALIBRATION | CompassMode.AUTO_CALIBRATION:
                self._module.begin_calibration()
            case CompassMode.END_CALIBRATION:
                self._module.end_calibration()
                self._packets = PacketRequest.ONE
            case CompassMode.SOFT_RESET:
                self._module.reset()
                self._packets = PacketRequest.STOP
            case _:
                return
        self._reads = mode != CompassMode.OFF
        if not self._reads:
            self.byte = 0

    def calibrate(self, on: bool) -> None:
        """CALCOMP."""
        if on:
            self._module.begin_calibration()
        else:
            self._module.end_calibration()

    def advance(self, state: BodyState, dt: float) -> CompassReport | None:
        """Let time pass, s; give the packet that is due, if a client has asked for it."""
        if not self._cadence.advance(dt) or not self._reads:
            return None
        report = self._module.measure(state.heading, state.magnetic)
        self.byte = compass_byte(report.heading)
        if not self._packets:
            return None
        if self._packets == PacketRequest.ONE:
            self._packets = PacketRequest.STOP
        return report
