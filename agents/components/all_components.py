"""The agent classes by element."""

from collections import ChainMap
from collections.abc import Mapping

from agents.components.arm import ArmAgent
from agents.components.base import BaseAgent
from agents.components.camera import CameraAgent
from agents.components.component import ElementAgent
from agents.components.generic import Generic
from agents.components.gripper import GripperAgent
from agents.components.localization.localization_agent import LocalizationAgent
from agents.components.mapping.mapping_agent import MappingAgent
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
from agents.components.vision.colours_agent import ColoursAgent
from agents.components.vision.flow_agent import FlowAgent
from agents.components.vision.motion_agent import MotionAgent
from agents.components.vision.vision_agent import VisionAgent

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
_OF_RANGES: Mapping[str, type[ElementAgent]] = {"localization": LocalizationAgent, "mapping": MappingAgent}
DERIVED: Mapping[str, Mapping[str, type[ElementAgent]]] = {
    "camera": {"vision": VisionAgent, "colours": ColoursAgent, "flow": FlowAgent, "motion": MotionAgent},
    "laser": _OF_RANGES,
    "sonar": _OF_RANGES,
}
"""By the element's name: further agents by their names, which live as long as it is there."""
NEEDED: Mapping[str, str] = {"camera": "vision"}
"""By the element's name: the extra without which its further agents cannot run."""
_CLASSES = ChainMap(dict(COMPONENTS), *map(dict, DERIVED.values()))


def component_for(name: str) -> type[ElementAgent]:
    """Return the class of an agent by its name; an unknown one is for an element, and gets the generic class."""
    return _CLASSES.get(name, Generic)
