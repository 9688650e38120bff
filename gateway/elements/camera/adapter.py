"""A camera on the bus."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from bus import keys
from bus.keys import Topic, frame
from bus.messages import CameraInfo, CompressedImage, Header, RegionOfInterest, header
from configs.camera_calibration import CameraCalibration
from gateway.cables.cable import ElementCable
from gateway.elements.adapter import BusAdapter, RobotContext
from gateway.events import PictureTaken


class CameraAdapter(BusAdapter[PictureTaken]):
    """`<robot>/camera/image/compressed`, and `<robot>/camera/camera_info` of a calibrated camera."""

    name = "camera"
    streams = (keys.CAMERA, keys.CAMERA_INFO)
    events = (PictureTaken,)

    def __init__(self, robot: RobotContext, cable: ElementCable) -> None:
        super().__init__(robot, cable)
        self._camera = cable.driver
        self._field_of_view = robot.settings.camera.field_of_view_rad
        self._calibration = robot.settings.camera.calibration

    def messages(self, event: PictureTaken, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Return every picture, as the camera encoded it, and before it the model of a calibrated camera."""
        head = header(stamp, frame(self._robot, "camera"))
        known = self._calibration
        if known is not None and (event.width, event.height) == (known.width, known.height):
            yield keys.CAMERA_INFO, _camera_info(head, known)
        yield keys.CAMERA, CompressedImage(head, format="jpeg", data=np.frombuffer(event.jpeg, np.uint8))

    def describe(self) -> Mapping[str, Any]:
        """Return the size of the pictures, and field of view and model where the settings have them."""
        told = {"size": self._camera.size, "field_of_view": self._field_of_view}
        return told if self._calibration is None else {**told, "model": self._calibration.model}


def _camera_info(head: Header, known: CameraCalibration) -> CameraInfo:
    """Return the model of a camera; the image is not rectified, so that the projection is the camera matrix."""
    matrix = np.array([[known.fx, 0.0, known.cx], [0.0, known.fy, known.cy], [0.0, 0.0, 1.0]])
    return CameraInfo(
        header=head,
        height=known.height,
        width=known.width,
        distortion_model="plumb_bob",
        d=np.array(known.distortion),
        k=matrix.ravel(),
        r=np.eye(3).ravel(),
        p=np.hstack((matrix, np.zeros((3, 1)))).ravel(),
        binning_x=0,
        binning_y=0,
        roi=RegionOfInterest(0, 0, 0, 0, do_rectify=False),
    )


ADAPTERS = (CameraAdapter,)
