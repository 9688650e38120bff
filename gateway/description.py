"""What a robot is, as JSON: model, elements, geometry, versions. Agents are made from it."""

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from importlib.metadata import version
from math import inf
from typing import Any

from bus import keys
from bus.keys import Topic
from bus.messages import encode_json
from bus.name_holder import BusProgram
from bus.validation import printable
from gateway.driver import Driver
from gateway.elements.adapter import BusAdapter
from gateway.elements.all_adapters import ADAPTERS
from gateway.elements.cable_adapter import CableAdapter
from gateway.settings import Settings
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


def describe(
    name: str,
    driver: Driver,
    settings: Settings,
    cable_adapters: Sequence[CableAdapter[Any]] = (),
    process: BusProgram | None = None,
) -> dict[str, Any]:
    """Describe one robot.

    Lengths in m, angles in rad, in `<name>/base_link`. The limits of acceleration are there once they are known.
    `emulated` is false unless the settings say that it is true: what is not known is treated as real.
    """
    model, identity = driver.model, driver.identity
    if model is None or identity is None:
        raise ValueError("the robot has not said who it is yet")
    configuration = driver.configuration or Configuration()
    return {
        "name": name,
        "robot_name": printable(identity.name),
        "model": model.name,
        "class": identity.robot_type,
        "emulated": bool(settings.emulated),
        "connected": driver.is_connected,
        "elements": [*_elements(name, driver, model, settings), *_cabled(name, cable_adapters)],
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


def present(
    driver: Driver,
    model: RobotModel,
    settings: Settings,
    adapters: Sequence[BusAdapter],
    cable_adapters: Sequence[CableAdapter[Any]],
) -> Iterator[str]:
    """The names of the elements that the robot is known to have; one that has two adapters comes twice.

    A robot that is out of touch keeps its elements, since it comes back with them. What is on a cable of its own is
    there as long as it answers.
    """
    yield from ("base", "battery", "io")
    if model.sonar:
        yield "sonar"
    if model.front_bumpers or model.rear_bumpers:
        yield "bumpers"
    if settings.encoders:
        yield "encoders"
    yield from (adapter.name for adapter in adapters if adapter.is_present(driver))
    yield from (adapter.name for adapter in cable_adapters if adapter.driver.is_connected)


def _elements(name: str, driver: Driver, model: RobotModel, settings: Settings) -> list[dict[str, Any]]:
    """Every element that the robot has, with the keys of its streams and of its commands."""
    elements = [
        _element(
            name,
            "base",
            (keys.ODOM, keys.TF, keys.STATE),
            (
                keys.CMD_VEL,
                keys.CMD_VEL_STAMPED,
                keys.DRIVE,
                keys.ENABLE,
                keys.STOP,
                keys.ESTOP,
                keys.MOVE,
                keys.TURN,
                keys.HEADING,
            ),
        ),
        _element(name, "battery", (keys.BATTERY,)),
        _element(name, "io", (keys.IO,), (keys.OUTPUT,)),
    ]
    if model.sonar:
        elements.append(_element(name, "sonar", (keys.SONAR, keys.SONAR_POINTS), (keys.SONAR_POWER,)))
    if model.front_bumpers or model.rear_bumpers:
        elements.append(_element(name, "bumpers", (keys.BUMPERS,)))
    if settings.encoders:
        elements.append(_element(name, "encoders", (keys.JOINT_STATES,)))
    for kind in ADAPTERS:
        adapter = kind(name, model)
        if adapter.is_present(driver):
            commands = tuple(row.topic for row in kind.commands)
            elements.append({**_element(name, kind.name, kind.streams, commands), **adapter.describe(driver)})
    return elements


def _cabled(name: str, adapters: Sequence[CableAdapter[Any]]) -> list[dict[str, Any]]:
    """Elements on cables of their own, as long as they answer."""
    return [
        {
            **_element(name, adapter.name, adapter.streams, tuple(row.topic for row in adapter.commands)),
            **adapter.describe(),
        }
        for adapter in adapters
        if adapter.driver.is_connected
    ]


def _element(name: str, kind: str, streams: tuple[Topic, ...], commands: tuple[Topic, ...] = ()) -> dict[str, Any]:
    return {
        "name": kind,
        "streams": [topic.key(name) for topic in streams],
        "commands": [topic.key(name) for topic in commands],
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
