"""Which class serves which element."""

from collections.abc import Mapping

from agents.components.arm import Arm
from agents.components.component import Component
from agents.components.generic import Generic
from agents.components.gripper import Gripper
from agents.components.ptz import Ptz

COMPONENTS: Mapping[str, type[Component]] = {
    "gripper": Gripper,
    "arm": Arm,
    "ptz": Ptz,
}
"""By the element's name in the robot's description."""


def component_for(element: str) -> type[Component]:
    """The class for an element; one that nobody has thought of is served all the same."""
    return COMPONENTS.get(element, Generic)
