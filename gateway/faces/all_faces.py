"""Every face there is, in the order of the description."""

from collections.abc import Mapping
from typing import Any

from gateway.faces.arm import ArmAdapter
from gateway.faces.cable_face import CableAdapter
from gateway.faces.camera import CameraAdapter
from gateway.faces.compass import CompassAdapter
from gateway.faces.face import BusAdapter
from gateway.faces.gripper import GripperAdapter
from gateway.faces.gyro import GyroAdapter, InnerGyroAdapter
from gateway.faces.infrared import InfraredAdapter
from gateway.faces.joystick import JoystickAdapter
from gateway.faces.laser import LaserAdapter
from gateway.faces.panel import ChargerAdapter, DisplayAdapter, PowerAdapter, ServosAdapter
from gateway.faces.powercube import PowerCubeAdapter
from gateway.faces.ptz import PtzAdapter
from gateway.faces.simulated_laser import SimulatedLaserAdapter
from gateway.faces.sound import SoundAdapter

FACES: tuple[type[BusAdapter], ...] = (
    InfraredAdapter,
    GyroAdapter,
    InnerGyroAdapter,
    CompassAdapter,
    GripperAdapter,
    ArmAdapter,
    JoystickAdapter,
    PtzAdapter,
    SoundAdapter,
    DisplayAdapter,
    ServosAdapter,
    PowerAdapter,
    ChargerAdapter,
    SimulatedLaserAdapter,
)

CABLE_FACES: Mapping[str, type[CableAdapter[Any]]] = {
    face.name: face for face in (LaserAdapter, PowerCubeAdapter, CameraAdapter)
}
"""Those of elements beside the robot's cable, by name. The option of `p2os-gateway` is called the same."""
