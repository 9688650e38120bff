"""Which class serves which element."""

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
    """The class for an element; one that nobody has thought of is served all the same."""
    return COMPONENTS.get(element, Generic)
