"""Infrared proximity switches, such as the table sensors and gripper beams of a PeopleBot.

Source: client libraries. Their levels come in the fourth digital byte of an IOpac; a PeopleBot of the first generation
has its four on the user inputs instead. A sensor counts as triggered after so many packets in a row as its row in the
robot's model says.
"""

from collections.abc import Sequence

from gateway.elements.element import Element
from gateway.events import InfraredSeen
from p2os import InfraredSensor, IoReport, RobotModel, StandardSip
from p2os.packets import INFRARED_BYTE
from p2os.robot_model import ACTIVE_LOW
from p2os.sip import TABLE_SENSOR_INPUTS

_ON_USER_INPUTS = tuple(InfraredSensor(pin, ACTIVE_LOW, 1, 0.0, 0.0) for pin in sorted(TABLE_SENSOR_INPUTS.values()))
"""Of a PeopleBot of the first generation; the places of these sensors are not known."""


class InfraredElement(Element[IoReport]):
    """is_present: the model has such sensors."""

    takes = (IoReport,)
    _sensors: Sequence[InfraredSensor] = ()

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Take the sensors or outputs of the model."""
        on_inputs = model.table_sensing_ir and not model.new_table_sensing_ir
        self._on_user_inputs = on_inputs and not model.irs
        self._sensors = _ON_USER_INPUTS if self._on_user_inputs else model.irs
        self._triggered_for = [0] * len(self._sensors)
        self.is_present = bool(self._sensors)

    def take(self, packet: IoReport, now: float) -> None:
        """Read the fourth byte, where the robot has one."""
        if self._sensors and not self._on_user_inputs and len(packet.digital_in) > INFRARED_BYTE:
            self._read(packet.digital_in[INFRARED_BYTE])

    def see(self, sip: StandardSip, now: float) -> None:
        """Read the user inputs, where the sensors are there."""
        if self._sensors and self._on_user_inputs:
            self._read(sip.digital_in)

    def _read(self, levels: int) -> None:
        for index, sensor in enumerate(self._sensors):
            level = levels >> sensor.number & 1
            triggered = level == 0 if sensor.kind == ACTIVE_LOW else level == 1
            self._triggered_for[index] = self._triggered_for[index] + 1 if triggered else 0
        near = tuple(
            (sensor.number, count >= sensor.persistence)
            for sensor, count in zip(self._sensors, self._triggered_for, strict=True)
        )
        self._announce(InfraredSeen(near))
