"""The agent of motion tracking: what moves in front of a standing camera."""

from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, ClassVar

from agents.components.vision.image_agent import ImageAgent
from agents.platform import AgentName
from bus import MessageError, keys
from bus.messages import NS_PER_S, CompressedImage, decode, stamp_ns

if TYPE_CHECKING:  # these load OpenCV
    from agents.components.vision.image_tools import MotionTools

_STILL = 0.005
"""m/s and rad/s, below which the robot stands."""


class MotionAgent(ImageAgent["MotionTools"]):
    """`motion@happy`: blobs of what moves. While the robot or the head moves, everything does, and there are none."""

    services = ("images", "motion")
    moved_by = (keys.ODOM, keys.PTZ)
    results: ClassVar[Mapping[str, str]] = {
        "age": "s since the exposure of the image",
        "trouble": "why there are no blobs, null if nothing is wrong",
        "width, height": "px of the image",
        "settled": "whether there is a background to compare with",
        "blobs": "of what moves, the largest first",
    }

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._is_moving = {keys.ODOM.type_name: False, keys.PTZ.type_name: False}  # the agent's thread only

    def load_tools(self) -> "MotionTools":
        """Return what compares images."""
        from agents.components.vision.image_tools import MotionTools

        return MotionTools(has_noise=self.has_noise)

    def look(self, tools: "MotionTools", image: CompressedImage) -> Mapping[str, Any]:
        """Return the blobs."""
        decoded = tools.decoded(image)
        was_moving = self._has_moved()
        return {**self.head(image), **tools.result(decoded, stamp_ns(image.header) / NS_PER_S, was_moving)}

    def _has_moved(self) -> bool:
        """Return whether the camera has moved since the image before."""
        has_moved = any(self._is_moving.values())
        while self._moved:
            sample = self._moved.popleft()
            with suppress(MessageError, AttributeError):  # what cannot be read is missing only
                message = decode(sample.type_name, sample.payload)
                if sample.type_name == keys.PTZ.type_name:
                    is_moving = bool(message.moving)
                else:
                    twist = message.twist.twist
                    is_moving = max(abs(twist.linear.x), abs(twist.angular.z)) > _STILL
                self._is_moving[sample.type_name] = is_moving
                has_moved = has_moved or is_moving
        return has_moved
