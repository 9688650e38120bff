"""The cycle of one robot: images, odometry, sonar and hand in, orders out. No bus, no clock."""

from collections.abc import Mapping, Sequence
from math import hypot, inf
from typing import Any

from apps.fetch.fetcher import Fetcher
from apps.fetch.hands import Hand
from apps.fetch.settings import FetchSettings
from apps.fetch.sight import ObjectSight, named_colours
from apps.fetch.states import FetchOrders, FetchReadings
from apps.robot_following.history import StampedPoses
from geometry import Point, Pose2D, Twist2D
from vision.camera_model import camera_model
from vision.colours import ColourTable
from vision.image import Image, VisionError

_BEYOND = 0.5  # s after the newest odometry, for which its velocity holds


class FetchCycle:
    """Makes one step of the application from readings. Times are s on the clock of the robot's gateway.

    seen: what was in the last image, in words.
    """

    def __init__(
        self,
        settings: FetchSettings,
        colour: str,
        place: Point,
        camera: Mapping[str, Any],
        hand: Hand,
        table: ColourTable | None = None,
    ) -> None:
        """Begin without readings.

        Args:
            settings: Of the application.
            colour: Of the object; name of a channel.
            place: Where it is to stand, m in odom.
            camera: Properties of the camera's agent: its model or field of view.
            hand: What grips the object.
            table: Trained channels; None for the colours of the settings.
        """
        self.fetcher = Fetcher(settings, colour, place, hand)
        self.seen = "no image has come"
        self._settings, self._camera = settings, camera
        self._table = table or named_colours(settings.shades)
        self._poses = StampedPoses(_BEYOND)
        self._pan = self._tilt = 0.0
        self._head_moves = False
        self._images, self._image_at, self._heard_at = 0, -inf, -inf
        self._has_stalled = False
        self._sight: ObjectSight | None = None

    def take_odometry(self, stamp: float, pose: Pose2D, velocity: Twist2D) -> None:
        """Take a reading of the base; the same one again is ignored."""
        if self._poses.is_jump(stamp, pose):
            self._poses.clear()
            self.fetcher.lose_place()
        self._poses.add(stamp, pose, velocity)

    def take_head(self, pan: float, tilt: float, is_moving: bool) -> None:
        """Take where the head looks, rad to the left and up; images are not used while it moves."""
        self._pan, self._tilt, self._head_moves = pan, tilt, is_moving

    def take_hand(self, reading: Mapping[str, Any]) -> None:
        """Take a reading of the gripper or the arm."""
        self.fetcher.hand.take(reading)

    def take_contact(self) -> None:
        """Take that the wheels stall or a bumper is pressed."""
        self._has_stalled = True

    def take_sonar(self, stamp: float, discs: Sequence[Pose2D], ranges: Sequence[float]) -> None:
        """Take the ranges of all discs, m, infinite without an echo, with their poses on the robot."""
        robot = self._poses.at(stamp)
        if robot is not None and stamp >= self._heard_at:
            self._heard_at = stamp
            self.fetcher.floor.hear(stamp, robot, discs, ranges, self.fetcher.ignored(robot))

    def take_image(self, stamp: float, data: bytes) -> None:
        """Take a JPEG or PNG file exposed at `stamp`; the same one again is ignored."""
        robot, earlier = self._poses.at(stamp), self._poses.at(stamp - self._settings.camera.late_s)
        if robot is None or earlier is None or stamp <= self._image_at or self._head_moves:
            return
        try:
            pixels = Image.decode(data).pixels
            sight = self._sight_for(pixels.shape[1], pixels.shape[0])
            found = sight.look(pixels, self._pan, self._tilt)
        except VisionError as err:
            self.seen = f"an image cannot be used: {err}"
            return
        self._image_at, self._images = stamp, self._images + 1
        words = ", ".join(f"{each.colour} {hypot(each.x, each.y):.2f} m" for each in found)
        self.seen = words or "nothing of the known colours"
        found = [each for each in found if not self.fetcher.is_held(each.x, each.y)]
        self.fetcher.objects.take(
            stamp, robot, found, sight.view(self._tilt), earlier=earlier, covered=self.fetcher.hand.covers
        )

    def pose(self, now: float) -> Pose2D | None:
        """Return where the robot is in odom; None without a recent reading."""
        return self._poses.at(now)

    def step(self, now: float) -> FetchOrders | None:
        """Return what to do; None where the odometry is silent and nothing can be done but to stand."""
        pose = self._poses.at(now)
        if pose is None:
            return None
        silence, blind = now - self._image_at, ""
        if silence > self._settings.camera.silent_s:
            blind = "no usable image has come" + (f" for {silence:.0f} s" if silence < inf else "")
            if self.seen.startswith("an image cannot"):
                blind = self.seen
        stalled, self._has_stalled = self._has_stalled, False
        return self.fetcher.step(FetchReadings(now, pose, self.fetcher.hand.state, self._images, blind, stalled))

    def _sight_for(self, width: int, height: int) -> ObjectSight:
        """Return what finds objects in images of a size, px.

        Raises:
            VisionError: The camera's properties describe no camera.
        """
        if self._sight is None or (self._sight.camera.width, self._sight.camera.height) != (width, height):
            model = camera_model(self._camera, width, height)
            if model is None:
                raise VisionError("the field of view of the camera is not known")
            self._sight = ObjectSight(self._settings.camera, model, self._table)
        return self._sight
