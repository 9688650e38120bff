"""Every face there is, in the order of the description."""

from collections.abc import Mapping
from typing import Any

from gateway.faces.arm import ArmFace
from gateway.faces.cable_face import CableFace
from gateway.faces.camera import CameraFace
from gateway.faces.compass import CompassFace
from gateway.faces.face import Face
from gateway.faces.gripper import GripperFace
from gateway.faces.gyro import GyroFace, InnerGyroFace
from gateway.faces.infrared import InfraredFace
from gateway.faces.joystick import JoystickFace
from gateway.faces.laser import LaserFace
from gateway.faces.panel import ChargerFace, DisplayFace, PowerFace, ServosFace
from gateway.faces.powercube import PowerCubeFace
from gateway.faces.ptz import PtzFace
from gateway.faces.simulated_laser import SimulatedLaserFace
from gateway.faces.sound import SoundFace

FACES: tuple[type[Face], ...] = (
    InfraredFace,
    GyroFace,
    InnerGyroFace,
    CompassFace,
    GripperFace,
    ArmFace,
    JoystickFace,
    PtzFace,
    SoundFace,
    DisplayFace,
    ServosFace,
    PowerFace,
    ChargerFace,
    SimulatedLaserFace,
)

CABLE_FACES: Mapping[str, type[CableFace[Any]]] = {face.name: face for face in (LaserFace, PowerCubeFace, CameraFace)}
"""Those of elements beside the robot's cable, by name. The option of `p2os-gateway` is called the same."""
