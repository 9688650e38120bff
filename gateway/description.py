"""What a robot is, as JSON: model, elements, geometry, versions. Agents are made from it."""

from collections.abc import Callable, Iterable
from functools import cache
from importlib.metadata import version
from math import inf
from typing import Any

from bus import keys
from bus.messages import encode_json
from bus.name_holder import BusProgram
from bus.validation import printable
from gateway.driver import Driver
from gateway.elements.adapter import BusAdapter, RobotContext
from gateway.telemetry import SONAR_CONE
from p2os import Configuration, RobotModel

MOST_AGE = 1.0
"""Seconds for which a description serves again; what it is made of changes seldom, and never in silence."""


class CachedDescription:
    """The description of one robot, encoded; made anew when elements, link or configuration have changed, or with time.

    A description takes a millisecond to make, and anybody who may look may ask for it.
    """

    def __init__(self, make: Callable[[], dict[str, Any]], driver: Driver, clock: Callable[[], float]) -> None:
        """Make none yet.

        Args:
            make: The description as it is now.
            driver: Of the robot.
            clock: Steady, s.
        """
        self._make = make
        self._driver = driver
        self._clock = clock
        self._state: tuple[object, ...] = ()
        self._made_at = -inf
        self._encoded = b""

    def encoded(self, elements: tuple[str, ...]) -> bytes:
        """The description in JSON. elements: those that are present."""
        state = elements, self._driver.is_connected, self._driver.configuration
        now = self._clock()
        if state != self._state or now - self._made_at >= MOST_AGE:
            self._encoded = encode_json(self._make())
            self._state, self._made_at = state, now
        return self._encoded


@cache
def _version() -> str:
    return version("acromovi")  # read from files at each call


def describe(robot: RobotContext, adapters: Iterable[BusAdapter], process: BusProgram | None = None) -> dict[str, Any]:
    """Describe one robot.

    Lengths in m, angles in rad, in `<name>/base_link`. The limits of acceleration are there once they are known.
    `emulated` is false unless the settings say that it is true: what is not known is treated as real.
    """
    name, model, driver, identity = robot.name, robot.model, robot.driver, robot.driver.identity
    if identity is None:
        raise ValueError("the robot has not said who it is yet")
    configuration = driver.configuration or Configuration()
    return {
        "name": name,
        "robot_name": printable(identity.name),
        "model": model.name,
        "class": identity.robot_type,
        "emulated": bool(robot.settings.emulated),
        "connected": driver.is_connected,
        "elements": [_describe_element(name, adapter) for adapter in adapters if adapter.is_present()],
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


def _describe_element(name: str, adapter: BusAdapter) -> dict[str, Any]:
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
