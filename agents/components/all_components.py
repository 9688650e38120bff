"""The agent classes by element."""

from collections.abc import Mapping

from agents.components.arm import ArmAgent
from agents.components.base import BaseAgent
from agents.components.camera import CameraAgent
from agents.components.component import ElementAgent
from agents.components.generic import Generic
from agents.components.gripper import GripperAgent
from agents.components.ptz import PtzAgent
from agents.components.sensors import (
    BatteryAgent,
    BumpersAgent,
    EncodersAgent,
    InfraredAgent,
    InputOutput,
    JoystickAgent,
    LaserAgent,
    SonarAgent,
    SoundAgent,
)

COMPONENTS: Mapping[str, type[ElementAgent]] = {
    "base": BaseAgent,
    "sonar": SonarAgent,
    "laser": LaserAgent,
    "bumpers": BumpersAgent,
    "ir": InfraredAgent,
    "encoders": EncodersAgent,
    "battery": BatteryAgent,
    "io": InputOutput,
    "sound": SoundAgent,
    "joystick": JoystickAgent,
    "gripper": GripperAgent,
    "arm": ArmAgent,
    "ptz": PtzAgent,
    "camera": CameraAgent,
}
"""By the element's name in the robot's description."""


def component_for(element: str) -> type[ElementAgent]:
    """Return the class for an element; an unknown one gets the generic class."""
    return COMPONENTS.get(element, Generic)
