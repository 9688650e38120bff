"""Agents of the elements that only measure, and of user ports and sound, whose commands end at once."""

from collections.abc import Mapping, Sequence
from math import atan2, cos, inf, sin
from typing import Any, ClassVar

import numpy as np

from agents.components.component import ElementAgent, known
from agents.components.generic import Generic
from agents.platform import AgentName, request
from bus import Refused, Sample, keys
from bus.keys import frame
from bus.messages import NS_PER_S, BatteryState, Bumpers, InputsOutputs, Joy, LaserScan, RangeArray, stamp_ns

MEMORY = 1.0
"""Seconds for which a disc's range stands; each packet brings those of a few discs only."""


class SonarAgent(ElementAgent):
    """The sonar: the latest ranges of all discs. `bearing` is the direction of the nearest echo from the robot."""

    source = keys.SONAR
    memory = MEMORY
    results: ClassVar[Mapping[str, str]] = {
        "ranges": "m by the number of the disc, null where no echo came",
        "nearest": "m, null where none came at all",
        "bearing": "rad in base_link, of the nearest",
    }

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._ranges: dict[int, tuple[float, float | None]] = {}  # stamp in s, and m

    @classmethod
    def properties_of(cls, robot: Mapping[str, Any], element: Mapping[str, Any]) -> dict[str, Any]:
        """Return the properties, with the poses of the discs."""
        return {**super().properties_of(robot, element), "discs": robot["geometry"]["sonar"]}

    @request("power", agrees_itself=True)
    async def power(self, on: bool) -> dict[str, Any]:
        """Switch the sonar on or off."""
        return await self.command(keys.SONAR_POWER, on=on)

    def result(self, message: RangeArray) -> dict[str, Any]:
        """Return the ranges of the last second."""
        now = stamp_ns(message.header) / NS_PER_S
        self._ranges |= {_number(each.header.frame_id): (now, known(each.range)) for each in message.ranges}
        self._ranges = {disc: seen for disc, seen in self._ranges.items() if abs(now - seen[0]) <= MEMORY}
        echoes = [(distance, disc) for disc, (_, distance) in self._ranges.items() if distance is not None]
        nearest, disc = min(echoes, default=(None, None))
        return {
            "ranges": {str(disc): self._ranges[disc][1] for disc in sorted(self._ranges)},
            "nearest": nearest,
            "bearing": None if nearest is None or disc is None else self._bearing(disc, nearest),
        }

    def _bearing(self, number: int, distance: float) -> float | None:
        """Return the bearing of an echo on the axis of a disc."""
        for disc in self.properties.get("discs", []):
            if disc["number"] == number:
                x, y, heading = disc["x"], disc["y"], disc["heading"]
                return known(atan2(y + distance * sin(heading), x + distance * cos(heading)))
        return None


def _number(frame_id: str) -> int:
    """Return the number of the disc with this frame, `happy/sonar_3`."""
    return int(frame_id.rpartition("_")[2])


class LaserAgent(ElementAgent):
    """The laser: scans from right to left. `bearing` is the direction of the nearest echo from the robot."""

    source = keys.SCAN
    results: ClassVar[Mapping[str, str]] = {
        "angle_min": "rad of the first beam, in the laser's frame",
        "angle_increment": "rad from beam to beam",
        "ranges": "m of each beam, null where nothing was measured",
        "nearest": "m, null where there is nothing",
        "bearing": "rad in base_link, of the nearest",
    }

    def result(self, message: LaserScan) -> dict[str, Any]:
        """Return the scan."""
        ranges = np.asarray(message.ranges, np.float64)
        missing = np.flatnonzero(~np.isfinite(ranges))
        listed = np.round(ranges, 3).tolist()
        for beam in missing:
            listed[beam] = None
        nearest = bearing = None
        if len(missing) < len(ranges):
            first = int(np.argmin(np.where(np.isfinite(ranges), ranges, np.inf)))
            nearest = known(ranges[first], 3)
            bearing = self._bearing(message.angle_min + first * message.angle_increment, ranges[first])
        return {
            "angle_min": known(message.angle_min, 6),
            "angle_increment": known(message.angle_increment, 6),
            "ranges": listed,
            "nearest": nearest,
            "bearing": bearing,
        }

    def _bearing(self, angle: float, distance: float) -> float | None:
        place = self.properties.get("geometry", {})
        angle += place.get("heading", 0.0)
        x, y = place.get("x", 0.0) + distance * cos(angle), place.get("y", 0.0) + distance * sin(angle)
        return known(atan2(y, x))


class BumpersAgent(ElementAgent):
    """The bumpers, and the stall flags of the wheels."""

    source = keys.BUMPERS
    results: ClassVar[Mapping[str, str]] = {
        "front": "true for each segment that is pressed, from right to left",
        "rear": "the same behind, from right to left with the robot facing up the page",
        "stall_left": "true while the left wheel is blocked",
        "stall_right": "true while the right wheel is blocked",
        "pressed": "true while any segment is",
    }

    def result(self, message: Bumpers) -> dict[str, Any]:
        """Return contacts and stall flags."""
        front, rear = [[bool(segment) for segment in side] for side in (message.front, message.rear)]
        return {
            "front": front,
            "rear": rear,
            "stall_left": message.stall_left,
            "stall_right": message.stall_right,
            "pressed": any(front) or any(rear),
        }


class InfraredAgent(ElementAgent):
    """Infrared sensors, which are switches: each frame lies where its sensor detects an object."""

    source = keys.IR
    results: ClassVar[Mapping[str, str]] = {
        "ranges": "m by the number of the sensor: 0 where it sees something, null where not",
        "nearest": "m, null where none sees anything",
    }

    def result(self, message: RangeArray) -> dict[str, Any]:
        """Return the ranges of the sensors."""
        ranges = {
            each.header.frame_id.rpartition("_")[2]: known(each.min_range if each.range == -inf else each.range)
            for each in message.ranges
        }
        return {"ranges": ranges, "nearest": min((near for near in ranges.values() if near is not None), default=None)}


class EncodersAgent(Generic):
    """Angles of the driven wheels, rad from the first packet on. They share `joint_states` with arm and gripper."""

    def _take_reading(self, sample: Sample) -> None:
        if frame(self.robot, "left_wheel").encode() in sample.payload:
            super()._take_reading(sample)


class BatteryAgent(ElementAgent):
    """The battery."""

    source = keys.BATTERY
    results: ClassVar[Mapping[str, str]] = {
        "voltage": "V",
        "fraction": "0 to 1 of a full charge, null where the robot does not say",
        "charging": "true while it is being charged",
    }

    def result(self, message: BatteryState) -> dict[str, Any]:
        """Return voltage and charge."""
        return {
            "voltage": known(message.voltage, 2),
            "fraction": known(message.percentage),
            "charging": message.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_CHARGING,
        }


class JoystickAgent(ElementAgent):
    """The joystick."""

    source = keys.JOYSTICK
    results: ClassVar[Mapping[str, str]] = {
        "axes": "to the left, forward, throttle; -1 to 1",
        "buttons": "1 while pressed",
    }

    @request("drive", agrees_itself=True)
    async def drive(self, on: bool, token: str = "") -> dict[str, Any]:
        """Permit or forbid that the joystick drives the robot."""
        return await self.command(keys.JOYDRIVE, on=on, token=token)

    def result(self, message: Joy) -> dict[str, Any]:
        """Return axes and buttons."""
        return {
            "axes": _every_known([float(axis) for axis in message.axes]),
            "buttons": [int(button) for button in message.buttons],
        }


class SoundAgent(ElementAgent):
    """The buzzer or loudspeaker."""

    @request("play", agrees_itself=True)
    async def play(self, notes: list[Any] | None = None, number: int | None = None) -> dict[str, Any]:
        """Play notes, each a MIDI number and s as in [[60, 0.2]]; or a sound of the robot by its number."""
        if (notes is None) == (number is None):
            raise Refused("say either notes or a number")
        return await self.command(keys.SOUND, notes=notes, number=number)

    @request("mute", agrees_itself=True)
    async def mute(self, on: bool = True) -> dict[str, Any]:
        """Switch the sound off or on."""
        return await self.command(keys.SOUND, on=not on)


class InputOutput(ElementAgent):
    """The digital and analogue user ports."""

    source = keys.IO
    results: ClassVar[Mapping[str, str]] = {
        "digital_in": "true or false of each pin, the lowest bit first",
        "digital_out": "likewise",
        "analog_in": "V of each",
    }

    @request("output", agrees_itself=True)
    async def output(self, mask: int, value: int) -> dict[str, Any]:
        """Set the digital outputs whose bits are in the mask, to the bits of the value."""
        return await self.command(keys.OUTPUT, mask=mask, value=value)

    def result(self, message: InputsOutputs) -> dict[str, Any]:
        """Return the state of all ports."""
        return {
            "digital_in": [bool(pin) for pin in message.digital_in],
            "digital_out": [bool(pin) for pin in message.digital_out],
            "analog_in": _every_known([float(pin) for pin in message.analog_in], 3),
        }


def _every_known(values: Sequence[float], digits: int = 4) -> list[float | None]:
    """Return measured numbers for a result, as `known` does."""
    return [known(value, digits) for value in values]
