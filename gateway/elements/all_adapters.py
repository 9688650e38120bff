"""Every bus adapter, in the order of the description."""

from collections.abc import Mapping
from typing import Any

from gateway.elements.adapter import BusAdapter
from gateway.elements.arm.adapter import ArmAdapter
from gateway.elements.cable_adapter import CableAdapter
from gateway.elements.camera.adapter import CameraAdapter
from gateway.elements.compass.adapter import CompassAdapter
from gateway.elements.gripper.adapter import GripperAdapter
from gateway.elements.gyro.adapter import GyroAdapter, InnerGyroAdapter
from gateway.elements.infrared.adapter import InfraredAdapter
from gateway.elements.joystick.adapter import JoystickAdapter
from gateway.elements.laser.adapter import LaserAdapter
from gateway.elements.panel.adapter import ChargerAdapter, DisplayAdapter, PowerAdapter, ServosAdapter
from gateway.elements.powercube.adapter import PowerCubeAdapter
from gateway.elements.ptz.adapter import PtzAdapter
from gateway.elements.simulated_laser.adapter import SimulatedLaserAdapter
from gateway.elements.sound.adapter import SoundAdapter

ADAPTERS: tuple[type[BusAdapter], ...] = (
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

CABLE_ADAPTERS: Mapping[str, type[CableAdapter[Any]]] = {
    adapter.name: adapter for adapter in (LaserAdapter, PowerCubeAdapter, CameraAdapter)
}
"""Those of elements beside the robot's cable, by name. The option of `p2os-gateway` is called the same."""
