"""Which class serves which element."""

from collections.abc import Mapping

from agents.components.arm import Arm
from agents.components.base import Base
from agents.components.battery import Battery
from agents.components.bumpers import Bumpers
from agents.components.camera import Camera
from agents.components.component import Component
from agents.components.encoders import Encoders
from agents.components.generic import Generic
from agents.components.gripper import Gripper
from agents.components.infrared import Infrared
from agents.components.io import InputOutput
from agents.components.joystick import Joystick
from agents.components.laser import Laser
from agents.components.ptz import Ptz
from agents.components.sonar import Sonar
from agents.components.sound import Sound

COMPONENTS: Mapping[str, type[Component]] = {
    "base": Base,
    "sonar": Sonar,
    "laser": Laser,
    "bumpers": Bumpers,
    "ir": Infrared,
    "encoders": Encoders,
    "battery": Battery,
    "io": InputOutput,
    "sound": Sound,
    "joystick": Joystick,
    "gripper": Gripper,
    "arm": Arm,
    "ptz": Ptz,
    "camera": Camera,
}
"""By the element's name in the robot's description."""


def component_for(element: str) -> type[Component]:
    """The class for an element; one that nobody has thought of is served all the same."""
    return COMPONENTS.get(element, Generic)
