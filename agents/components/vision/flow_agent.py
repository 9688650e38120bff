"""The agent of optical flow: by columns of the image, with and without the robot's rotation, and time to contact."""

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, ClassVar

from agents.components.camera import LINGER
from agents.components.component import failure
from agents.components.vision.flow_inputs import GAP, CameraMotion, FlowOptions, HeadingHistory
from agents.components.vision.image_agent import ImageAgent
from agents.platform import AgentName, request
from bus import MessageError, Refused, Sample, keys
from bus.messages import NS_PER_S, CompressedImage, decode, heading, stamp_ns

if TYPE_CHECKING:  # these load OpenCV
    from agents.components.vision.flow_tools import FlowTools

METHODS = ("dense", "sparse")
MOST_COLUMNS = 80
MOST_AHEAD = 2.0  # m


class FlowAgent(ImageAgent["FlowTools"]):
    """`flow@happy`: flow and time to contact from images alone; neither speed nor distances are needed.

    The rotation of the camera between two exposures comes from odometry and the pan-tilt head, or from the flow itself
    where odometry is missing.
    """

    services = ("images", "optical-flow")
    moved_by = (keys.ODOM, keys.PTZ)
    results: ClassVar[Mapping[str, str]] = {
        "age": "s since the exposure of the image",
        "trouble": "why there is no result, or not all of it; null if nothing is wrong",
        "method": "dense or sparse",
        "interval": "s between the two images that were compared; null for the first image",
        "ahead": "m, of the camera before the axle, as configured",
        "yaw": "rad by which the camera turned meanwhile, left positive",
        "rotation": "odometry or flow: where the yaw comes from; null without one",
        "bearings": "rad of the columns from left to right, left positive; null for an unknown camera",
        "flow": "px/s right and down, median of each column",
        "translation": "the same without the rotation",
        "rates": "1/s, 1 / time to contact of each column; 0 where nothing comes nearer, null where it is not known",
        "times": "s to contact; null where nothing comes nearer or it is not known",
        "deviations": "1/s, standard deviations of the rates",
        "focus": "px, the focus of expansion, null where there is none",
    }

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._options = FlowOptions()
        self._compared: tuple[Mapping[str, Any], float] | None = None  # the latest result, and the loop's time of it
        self._has_compared = asyncio.Event()
        self._exposure: float | None = None  # of the latest image, s; None before the first one of a subscription
        # The agent's thread only:
        self._headings = HeadingHistory()
        self._head = self._head_before = (0.0, 0.0)  # pan and tilt, rad, now and with the image before

    def load_tools(self) -> "FlowTools":
        """Return what compares images."""
        from agents.components.vision.flow_tools import FlowTools

        return FlowTools(has_noise=self.has_noise)

    def pack(self) -> dict[str, Any]:
        """Return the options."""
        return asdict(self._options)

    def unpack(self, state: Mapping[str, Any]) -> None:
        """Take them."""
        self._options = FlowOptions(**state)

    @property
    def is_wanted(self) -> bool:
        """Whether a program listens, or has just asked: each result needs the images before."""
        assert self._loop is not None  # it lives
        return self.is_heard or self._loop.time() < self._wanted_until

    @request("configure")
    async def configure(
        self, method: str = "dense", columns: int = 16, vectors: bool = False, ahead: float = 0.0
    ) -> dict[str, Any]:
        """Set the method, `dense` or `sparse`, and the number of columns; `vectors` adds single vectors.

        method: dense, for all pixels, or sparse, for corners. columns: of the result, 1 to 80. vectors: whether results
        have a list `vectors` of [x, y, right, down] in px and px/s. ahead: of the camera before the axle, m, -2 to 2;
        in turns it moves sideways. Without it, times are too long at the inner side of a curve.
        """
        if method not in METHODS:
            raise Refused(f"the method is dense or sparse, not {method[:40]!r}")
        if not 1 <= columns <= MOST_COLUMNS:
            raise Refused(f"there are 1 to {MOST_COLUMNS} columns, not {columns}")
        if not -MOST_AHEAD <= ahead <= MOST_AHEAD:
            raise Refused(f"the camera is up to {MOST_AHEAD:g} m before or behind the axle, not {ahead:g} m")
        self._options = FlowOptions(method, columns, vectors, ahead)
        self._compared = None
        return asdict(self._options)

    @request("read")
    async def read(self) -> dict[str, Any]:
        """The latest result; it waits until two images have come."""
        loop = asyncio.get_running_loop()
        self._wanted_until = loop.time() + self.first_within + LINGER
        self._hear_images()
        if self._compared is None or loop.time() - self._compared[1] > self.fresh:
            self._compared = None
            self._has_compared.clear()
            with suppress(TimeoutError):  # what is missing is told below
                async with asyncio.timeout(self.first_within):
                    await self._has_compared.wait()
        self._wanted_until = loop.time() + LINGER
        if self._compared is None:
            why = self._trouble or f"is the camera of {self.robot} there?"
            raise failure(f"{self.name} has not received two images that can be compared: {why}")
        return dict(self._compared[0])

    def look(self, tools: "FlowTools", image: CompressedImage) -> Mapping[str, Any]:
        """Return flow and times."""
        decoded = tools.decoded(image)
        stamp = stamp_ns(image.header) / NS_PER_S
        result = tools.result(decoded, stamp, self._motion(tools.stamp, stamp), self.properties, self._options)
        return {**self.head(image), **result}

    def _motion(self, before: float | None, stamp: float) -> CameraMotion:
        """Return the motion of the camera between two exposures, s."""
        while self._moved:
            self._take_motion(self._moved.popleft())
        turned = None if before is None else self._headings.turned(before, stamp)
        (pan, tilt), (pan_before, _) = self._head, self._head_before
        self._head_before = self._head
        yaw = None if turned is None else turned + pan - pan_before
        return CameraMotion(yaw, pan, tilt, self._headings.speed, self._headings.rate)

    def _take_motion(self, sample: Sample) -> None:
        with suppress(MessageError, AttributeError):  # what cannot be read is missing only
            message = decode(sample.type_name, sample.payload)
            if sample.type_name == keys.PTZ.type_name:
                self._head = message.pan, message.tilt
            else:
                at = stamp_ns(message.header) / NS_PER_S
                moving = message.twist.twist
                self._headings.add(at, heading(message.pose.pose.orientation), moving.angular.z, moving.linear.x)

    def _show(self, result: Mapping[str, Any]) -> None:
        before, self._exposure = self._exposure, result.get("stamp")
        if result.get("interval") is not None:
            self._compared = result, asyncio.get_running_loop().time()
            self._has_compared.set()
        elif before and self._exposure and self._exposure - before > GAP and result.get("trouble") is None:
            apart = f"they are {self._exposure - before:.1f} s apart, and flow needs more than {1.0 / GAP:g} a second"
            result = {**result, "trouble": apart}
        super()._show(result)

    def _give_up_images(self) -> None:
        super()._give_up_images()
        self._exposure = None
