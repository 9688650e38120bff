"""The description of a robot as JSON: model, elements, geometry, versions. Agents are made from it."""

from collections.abc import Callable, Iterable
from functools import cache
from math import inf
from typing import Any

from bus import keys
from bus.messages import encode_json
from bus.name_holder import BusProgram
from bus.validation import printable
from gateway.elements.adapter import BusAdapter, RobotContext
from gateway.telemetry import SONAR_CONE
from p2os import Configuration, RobotModel

MOST_AGE = 1.0
"""Seconds for which a description serves again; what it is made of changes seldom, and never in silence."""


class RobotDescription:
    """The description of one robot, encoded; made again when elements, link or configuration change, or after a second.

    A description takes a millisecond to make, and every client may request it.

    Lengths are in m, angles in rad, in `<name>/base_link`. The limits of acceleration are there once they are known.
    `emulated` is false unless the settings say that it is true: an unknown robot is treated as real.
    """

    def __init__(
        self,
        robot: RobotContext,
        adapters: Iterable[BusAdapter[Any]],
        process: BusProgram | None,
        clock: Callable[[], float],
    ) -> None:
        """Make none yet.

        Args:
            robot: Which; it has identified itself.
            adapters: Of its elements.
            process: The gateway.
            clock: Steady, s.
        """
        self._robot = robot
        self._adapters = adapters
        self._process = process
        self._clock = clock
        self._state: tuple[object, ...] = ()
        self._made_at = -inf
        self._encoded = b""

    def encoded(self, elements: tuple[str, ...]) -> bytes:
        """Return the description in JSON. elements: those that are present."""
        driver = self._robot.driver
        state = elements, driver.is_connected, driver.configuration
        now = self._clock()
        if state != self._state or now - self._made_at >= MOST_AGE:
            self._encoded = encode_json(self._describe())
            self._state, self._made_at = state, now
        return self._encoded

    def _describe(self) -> dict[str, Any]:
        robot, process = self._robot, self._process
        name, model, driver, identity = robot.name, robot.model, robot.driver, robot.driver.identity
        if identity is None:
            raise ValueError("the robot has not identified itself yet")
        configuration = driver.configuration or Configuration()
        return {
            "name": name,
            "robot_name": printable(identity.name),
            "model": model.name,
            "class": identity.robot_type,
            "emulated": bool(robot.settings.emulated),
            "connected": driver.is_connected,
            "elements": [_describe_element(name, adapter) for adapter in self._adapters if adapter.is_present()],
            "geometry": _geometry(name, model),
            "limits": {"linear": driver.max_linear, "angular": driver.max_angular, **(driver.accelerations or {})},
            "battery": {"nominal": model.battery_nominal, "low": configuration.low_battery or None},
            "serial": configuration.serial,
            "sip_cycle": configuration.sip_cycle or model.flash.sip_cycle,
            "watchdog": configuration.watchdog or model.flash.watchdog,
            "versions": {
                "acromovi": _version(),
                "firmware": f"{model.firmware.value} {configuration.firmware_version}".strip(),
            },
            **(process.told() if process else {}),
        }


@cache
def _version() -> str:
    from importlib.metadata import version  # it is a large module, and not every gateway is asked

    return version("acromovi")  # read from files at each call


def _describe_element(name: str, adapter: BusAdapter[Any]) -> dict[str, Any]:
    """Describe one element, with the keys of its streams and of its commands."""
    commands = (*adapter.subscriptions, *(row.topic for row in adapter.commands))
    return {
        "name": adapter.name,
        "streams": [topic.key(name) for topic in adapter.streams],
        "commands": [topic.key(name) for topic in commands],
        **adapter.describe(),
    }


def _geometry(name: str, model: RobotModel) -> dict[str, Any]:
    return {
        "radius": model.radius,
        "width": model.width,
        "length": model.length,
        "length_front": model.length_front,
        "length_rear": model.length_rear,
        "wheel_track": model.wheel_track,
        "wheel_diameter": model.wheel_diameter,
        "front_bumpers": model.front_bumpers,
        "rear_bumpers": model.rear_bumpers,
        "sonar": [
            {
                "number": disc.number,
                "frame": keys.frame(name, f"sonar_{disc.number}"),
                "x": disc.x,
                "y": disc.y,
                "heading": disc.heading,
                "field_of_view": SONAR_CONE,
            }
            for disc in model.sonar
        ],
    }
