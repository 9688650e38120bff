"""What a robot is, as JSON: model, elements, geometry, versions. Agents are made from it."""

from collections.abc import Iterator, Sequence
from importlib.metadata import version
from typing import Any

from bus import keys
from bus.keys import Topic
from gateway.driver import Driver
from gateway.faces.all_faces import FACES
from gateway.faces.cable_face import CableFace
from gateway.faces.face import Face
from gateway.settings import Settings
from p2os import Configuration, RobotModel


def describe(
    name: str, driver: Driver, settings: Settings, cable_faces: Sequence[CableFace[Any]] = ()
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
        "robot_name": identity.name,
        "model": model.name,
        "class": identity.robot_type,
        "emulated": bool(settings.emulated),
        "connected": driver.is_connected,
        "elements": [*_elements(name, driver, model, settings), *_cabled(name, cable_faces)],
        "geometry": _geometry(model),
        "limits": {"linear": driver.max_linear, "angular": driver.max_angular, **(driver.accelerations or {})},
        "battery": {"nominal": model.battery_nominal, "low": configuration.low_battery or None},
        "serial": configuration.serial,
        "sip_cycle": configuration.sip_cycle or model.flash.sip_cycle,
        "watchdog": configuration.watchdog or model.flash.watchdog,
        "versions": {
            "acromovi": version("acromovi"),
            "firmware": f"{model.firmware.value} {configuration.firmware_version}".strip(),
        },
    }


def present(
    driver: Driver,
    model: RobotModel,
    settings: Settings,
    faces: Sequence[Face],
    cable_faces: Sequence[CableFace[Any]],
) -> Iterator[str]:
    """The names of the elements that the robot is known to have; one that has two faces comes twice.

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
    yield from (face.name for face in faces if face.is_present(driver))
    yield from (face.name for face in cable_faces if face.driver.is_connected)


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
    for kind in FACES:
        face = kind(name, model)
        if face.is_present(driver):
            commands = tuple(row.topic for row in kind.commands)
            elements.append({**_element(name, kind.name, kind.streams, commands), **face.describe(driver)})
    return elements


def _cabled(name: str, faces: Sequence[CableFace[Any]]) -> list[dict[str, Any]]:
    """Elements on cables of their own, as long as they answer."""
    return [
        {**_element(name, face.name, face.streams, tuple(row.topic for row in face.commands)), **face.describe()}
        for face in faces
        if face.driver.is_connected
    ]


def _element(name: str, kind: str, streams: tuple[Topic, ...], commands: tuple[Topic, ...] = ()) -> dict[str, Any]:
    return {
        "name": kind,
        "streams": [topic.key(name) for topic in streams],
        "commands": [topic.key(name) for topic in commands],
    }


def _geometry(model: RobotModel) -> dict[str, Any]:
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
        "sonar": [{"number": disc.number, "x": disc.x, "y": disc.y, "heading": disc.heading} for disc in model.sonar],
    }
