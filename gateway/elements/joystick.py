"""The joystick plugged into the robot. Source: Pioneer 3 operations manual (JOYINFO, JOYDRIVE)."""

from gateway.elements.asked import AskedElement
from gateway.events import JoystickSeen
from p2os import Command, JoystickReport, RobotModel

ONE_PACKET, CONTINUOUS = 1, 2
"""Arguments of JOYINFO."""


class Joystick(AskedElement):
    """Asks for one packet, and if it comes for all of them."""

    takes = (JoystickReport,)
    question = Command.JOYREQUEST, ONE_PACKET
    stream = Command.JOYREQUEST, CONTINUOUS

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask, unless the settings know that there is none."""
        if self._settings.fitted.joystick:
            super().begin_link(model, now)

    def take(self, packet: object, now: float) -> None:
        """Pass it on."""
        super().take(packet, now)
        assert isinstance(packet, JoystickReport)
        self.is_present = True
        self._announce(JoystickSeen(packet))

    def let_drive(self, on: bool) -> None:
        """Let it drive the robot, or not."""
        self._ask(Command.JOYDRIVE, int(on))
