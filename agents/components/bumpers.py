"""The agent of the bumpers."""

from collections.abc import Mapping
from typing import Any, ClassVar

from agents.components.component import ElementAgent
from bus import keys
from bus.messages import Bumpers


class BumpersAgent(ElementAgent):
    """Contacts, and wheels that something blocks."""

    source = keys.BUMPERS
    results: ClassVar[Mapping[str, str]] = {
        "front": "true for each segment that is pressed, from right to left",
        "rear": "the same behind, from right to left with the robot facing up the page",
        "stall_left": "true while the left wheel is blocked",
        "stall_right": "true while the right wheel is blocked",
        "pressed": "true while any segment is",
    }

    def result(self, message: Bumpers) -> dict[str, Any]:
        """What touches the robot."""
        front, rear = [[bool(segment) for segment in side] for side in (message.front, message.rear)]
        return {
            "front": front,
            "rear": rear,
            "stall_left": message.stall_left,
            "stall_right": message.stall_right,
            "pressed": any(front) or any(rear),
        }
