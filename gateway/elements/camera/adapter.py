"""A camera on the bus."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from bus import keys
from bus.keys import Topic, frame
from bus.messages import CompressedImage, header
from gateway.cables.cable import ElementCable
from gateway.elements.adapter import BusAdapter, RobotContext
from gateway.events import PictureTaken


class CameraAdapter(BusAdapter[PictureTaken]):
    """`<robot>/camera/image/compressed`."""

    name = "camera"
    streams = (keys.CAMERA,)
    events = (PictureTaken,)

    def __init__(self, robot: RobotContext, cable: ElementCable) -> None:
        super().__init__(robot, cable)
        self._camera = cable.driver
        self._field_of_view = robot.settings.camera.field_of_view_rad

    def messages(self, event: PictureTaken, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Return every picture, as the camera encoded it."""
        data = np.frombuffer(event.jpeg, np.uint8)
        yield keys.CAMERA, CompressedImage(header(stamp, frame(self._robot, "camera")), format="jpeg", data=data)

    def describe(self) -> Mapping[str, Any]:
        """Return the size of the pictures, and the field of view where the settings have it."""
        return {"size": self._camera.size, "field_of_view": self._field_of_view}


ADAPTERS = (CameraAdapter,)
