"""The joystick plugged into the robot. Source: Pioneer 3 operations manual (JOYINFO, JOYDRIVE).

An empty socket may read as a stick at rest. So the robot is asked for a packet now and then, and for all of them once a
hand has moved the stick, or if the settings know that there is one.
"""

from gateway.elements.asked import AskedElement
from gateway.motion_in_progress import is_at_rest
from p2os import Command, JoystickReport, RobotModel, StandardSip, encode_command
from p2os.arguments import PacketRequest

LOOK_PERIOD = 2.0
"""Seconds from one look at a socket that may be empty to the next."""
REST = 0.02
"""How far from its centre a stick at rest may read."""


class JoystickElement(AskedElement[JoystickReport]):
    """is_present: it was moved, or the settings say so. drives: it may drive the robot."""

    takes = (JoystickReport,)
    question = Command.JOYREQUEST, PacketRequest.ONE
    stream = Command.JOYREQUEST, PacketRequest.CONTINUOUS
    drives = False

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask, unless the settings know that there is none."""
        if self._settings.fitted.joystick is not False:
            self.is_present = self.is_present or bool(self._settings.fitted.joystick)
            super().begin_link(model, now)

    def take(self, packet: JoystickReport, now: float) -> None:
        """Announce a packet of a joystick that is there."""
        self.is_present = self.is_present or _is_held(packet)
        if self.is_present:
            super().take(packet, now)
            self._announce(packet)
        else:
            self._asks_left = self.times
            self.deadline = now + LOOK_PERIOD

    def let_drive(self, on: bool) -> None:
        """Let it drive the robot, or not."""
        self.drives = on
        if on:
            self._stop.end()
        self._ask(Command.JOYDRIVE, int(on))

    def halt(self, now: float) -> None:
        """End its driving: a stop holds against a hand on the stick as well."""
        if self.drives:
            self.drives = False
            self._outbox.drop(Command.JOYDRIVE)
            self._put_end()
            self._stop.begin()

    def see(self, sip: StandardSip, now: float) -> None:
        """End its driving again while the wheels still turn."""
        if self._stop.is_due(not is_at_rest(sip), now):
            self._put_end()

    def lose_link(self) -> None:
        """End its driving, as the CLOSE of the next link does."""
        super().lose_link()
        self.drives = False

    def _put_end(self) -> None:
        self._outbox.put(Command.JOYDRIVE, encode_command(Command.JOYDRIVE, 0))


def _is_held(report: JoystickReport) -> bool:
    return report.button1 or report.button2 or max(abs(report.x), abs(report.y)) > REST
