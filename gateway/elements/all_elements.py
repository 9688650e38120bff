"""The table of elements, on the robot's line and on cables of their own.

It names the folder of the bus adapters (`gateway.elements.adapter` loads them), since the bus takes longer to load than
the robot to be found. Drivers of elements on cables of their own are loaded when they are needed, for the same reason.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from configs import load
from gateway.cables.cable import ElementDriver
from gateway.cables.cable_thread import CableKind, CameraCable, SerialCable
from gateway.elements.arm.element import ArmElement
from gateway.elements.compass.element import CompassElement
from gateway.elements.element import Element
from gateway.elements.gripper.element import GripperElement
from gateway.elements.gyro.element import Gyro
from gateway.elements.infrared.element import InfraredElement
from gateway.elements.joystick.element import JoystickElement
from gateway.elements.panel.element import ChargerElement, Display, PowerOutputs, Servos
from gateway.elements.ptz.element import PtzElement
from gateway.elements.simulated_laser.element import SimulatedLaserScanner
from gateway.elements.sound.element import SoundElement
from gateway.elements.standard.element import (
    Batteries,
    ControllerConfiguration,
    SonarElement,
    UserPorts,
    WheelEncoders,
)
from gateway.settings import Settings
from p2os.accessories.arm_model import ArmModel


@dataclass(frozen=True, slots=True)
class ElementRow:
    """One element, or a few that belong together.

    folder: in `gateway/elements`; `ADAPTERS` of its module `adapter` are the bus adapters. elements: the driver's side
    on the robot's line. cable: how an element on a cable of its own is opened; such a row has one bus adapter.
    """

    folder: str
    elements: tuple[type[Element[Any]], ...] = ()
    cable: CableKind | None = None


def _laser(has_rate: bool, settings: Settings) -> ElementDriver:
    from gateway.elements.laser.driver import LaserDriver

    return LaserDriver(settings.laser, has_rate=has_rate)


def _arm(has_rate: bool, settings: Settings) -> ElementDriver:
    from gateway.elements.powercube.driver import PowerCubeDriver

    return PowerCubeDriver(load(ArmModel, "accessories", "powercube-arm"), has_rate=has_rate)


ELEMENTS = (
    ElementRow("standard", (ControllerConfiguration, SonarElement, UserPorts, WheelEncoders, Batteries)),
    ElementRow("infrared", (InfraredElement,)),
    ElementRow("gyro", (Gyro,)),
    ElementRow("compass", (CompassElement,)),
    ElementRow("gripper", (GripperElement,)),
    ElementRow("arm", (ArmElement,)),
    ElementRow("joystick", (JoystickElement,)),
    ElementRow("ptz", (PtzElement,)),
    ElementRow("sound", (SoundElement,)),
    ElementRow("panel", (Display, Servos, PowerOutputs, ChargerElement)),
    ElementRow("simulated_laser", (SimulatedLaserScanner,)),
    ElementRow(
        "laser",
        cable=SerialCable(
            "laser",
            "port of a SICK LMS 2xx: a device or a URL",
            fitted={"simulated_laser": False},  # a robot has one laser
            make_driver=_laser,
        ),
    ),
    ElementRow(
        "powercube",
        cable=SerialCable(
            "arm", "port of the PowerBot's arm of PowerCube modules: a device or a URL", make_driver=_arm
        ),
    ),
    ElementRow(
        "camera",
        cable=CameraCable(
            "camera", "the robot's camera: http://HOST/PATH of an MJPEG stream, or a device (OpenCV)", "URL|DEVICE"
        ),
    ),
)
"""In the order of the description, in which the robot is asked for them too."""


def cable_kinds() -> Iterator[CableKind]:
    """Return how the elements on cables of their own are opened."""
    return (row.cable for row in ELEMENTS if row.cable is not None)
