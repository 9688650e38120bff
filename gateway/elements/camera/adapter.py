"""A camera on the bus."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from bus import keys
from bus.keys import Topic, frame
from bus.messages import CompressedImage, header
from gateway.elements.cable_adapter import CableAdapter
from gateway.events import Event, PictureTaken


class CameraAdapter(CableAdapter[Any]):
    """`<robot>/camera/image/compressed`."""

    name = "camera"
    streams = (keys.CAMERA,)

    def messages(self, event: Event, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Every picture, as the camera made it."""
        if isinstance(event, PictureTaken):
            data = np.frombuffer(event.jpeg, np.uint8)
            yield keys.CAMERA, CompressedImage(header(stamp, frame(self._robot, "camera")), format="jpeg", data=data)

    def describe(self) -> Mapping[str, Any]:
        """Size of the pictures, and how wide the camera sees if somebody has said so."""
        return {"size": self._driver.size, "field_of_view": self._settings.camera.field_of_view_rad}

    def halt(self) -> None:
        """A camera does not move."""
