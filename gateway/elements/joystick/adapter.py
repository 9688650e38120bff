"""The joystick on the bus."""

from collections.abc import Iterable

import numpy as np

from bus import keys
from bus.keys import Topic, frame
from bus.messages import Joy, header
from gateway.commands import BASE, Arguments, CommandRow
from gateway.elements.adapter import BusAdapter
from gateway.elements.joystick.element import JoystickElement
from p2os import JoystickReport


class _JoystickAdapter(BusAdapter[JoystickReport]):
    """`<robot>/joystick` and `command/joystick`.

    Axes as ROS has them: to the left, forward, throttle. Buttons: 1 and 2.
    """

    name = "joystick"
    element = JoystickElement
    streams = (keys.JOYSTICK,)
    events = (JoystickReport,)

    def messages(self, event: JoystickReport, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Return one message for each packet."""
        message = Joy(
            header=header(stamp, frame(self._robot, "base_link")),
            axes=np.array([-event.x, event.y, event.throttle], np.float32),
            buttons=np.array([event.button1, event.button2], np.int32),
        )
        yield keys.JOYSTICK, message

    def _let_drive(self, arguments: Arguments, now: float) -> None:
        joystick = self._driver.element(JoystickElement, now)
        if arguments["on"]:
            self._driver.release_wheels(now)
        joystick.let_drive(arguments["on"])

    commands = (CommandRow(keys.JOYDRIVE, {"on": bool}, _let_drive, BASE),)


ADAPTERS = (_JoystickAdapter,)
