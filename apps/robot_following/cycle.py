"""The cycle of one follower: pictures, odometry, head and ranges in, velocity and direction of the camera out."""

from collections import deque
from collections.abc import Mapping, Sequence
from math import hypot, inf
from typing import Any

from apps.robot_following.follower import FollowingStep, SightFollower
from apps.robot_following.gaze import HeadCommands, pan_to
from apps.robot_following.history import StampedPoses
from apps.robot_following.settings import FollowingSettings
from apps.robot_following.sight import LeaderSight, shipped_colours
from geometry import Point, Pose2D, Twist2D, wrap_angle
from vision.camera_model import camera_model
from vision.colours import ColourTable
from vision.image import Floats, Image, VisionError

_WAITING = 3  # pictures for which it is not yet known where the head looked


class FollowingCycle:
    """Makes one step of the application from readings; it has no clock and no bus.

    All times are s on the clock of the follower's gateway, which stamps its readings.

    words: what the camera saw last, for a person. shown: the newest picture that was looked at, as a file, and the
    corners of the target in it, px, shape (3, 4, 2), None where it was not found. found_at: when the picture was
    exposed, s, in which the last step found the leader; None if in none.
    """

    def __init__(
        self,
        settings: FollowingSettings,
        lens: Mapping[str, Any],
        pan_reach: float = 0.0,
        colours: ColourTable | None = None,
    ) -> None:
        """Begin without readings.

        Args:
            settings: Of the application.
            lens: Of the camera: its `model`, or its horizontal `field_of_view` in rad, as `camera_model` takes them.
            pan_reach: How far the camera's head goes to either side, rad; 0 without one.
            colours: Of the target in channels 1 to 3; None for those of the targets that emulated robots carry.
        Raises:
            VisionError: A channel is not trained.
        """
        self.settings = settings
        self.follower = SightFollower(settings, pan_reach)
        self.words = "no picture has come"
        self.shown: tuple[bytes, Floats | None] | None = None
        self.found_at: float | None = None
        self._lens = lens
        self._colours = colours or shipped_colours()
        self._robot, self._camera = StampedPoses(settings.silent), StampedPoses(settings.camera.head_silent)
        self._pan_reach = pan_reach
        self._head = HeadCommands(settings.search) if pan_reach > 0.0 else None
        self._head_moves = False
        self._pan = self._tilt = 0.0
        self._pictures: deque[tuple[float, bytes]] = deque(maxlen=_WAITING)
        self._sight: LeaderSight | None = None
        self._size = (0, 0)
        self._picture: bytes | None = None
        self._picture_from: Pose2D | None = None  # where the robot was when it first gave this picture
        self._picture_at = self._looked_at = -inf

    def take_odometry(self, stamp: float, pose: Pose2D, velocity: Twist2D) -> None:
        """Take a reading of the base; the same one again is ignored."""
        if self._robot.is_jump(stamp, pose):
            self._robot.clear()
            self.follower.forget()
        self._robot.add(stamp, pose, velocity)

    def take_head(self, stamp: float, pan: float, tilt: float, is_moving: bool) -> None:
        """Take a reading of the head, rad to the left and up."""
        if self._camera.add(stamp, Pose2D(self.settings.camera.forward, 0.0, pan)):
            self._tilt, self._head_moves = tilt, is_moving

    def take_picture(self, stamp: float, data: bytes) -> None:
        """Take a JPEG or PNG file exposed at `stamp`; the same one again is ignored."""
        if stamp > self._picture_at:
            self._picture_at = stamp
            self._pictures.append((stamp, data))

    def step(self, now: float, obstacles: Sequence[Point]) -> FollowingStep | None:
        """Return what to do; None where the odometry is silent and nothing can be done but to stand.

        Args:
            now: s.
            obstacles: Where range sensors have an echo, in the robot's frame, m.
        """
        self.found_at = None
        while self._pictures and self._is_ready(self._pictures[0][0]):
            self._look(*self._pictures.popleft())
        pose = self._robot.at(now)
        if pose is None:
            return None
        is_blind = now - self._looked_at > self.settings.search.coast
        step = self.follower.step(now, pose, obstacles, is_blind=is_blind)
        self._pan = step.pan
        return step

    def pose(self, now: float) -> Pose2D | None:
        """Return where the robot is in odom; None without a recent reading."""
        return self._robot.at(now)

    def head_command(self, now: float, gaze: float | None = None) -> float | None:
        """Return the pan that the head is to be told now, rad; None if there is nothing to tell.

        Args:
            now: s.
            gaze: Bearing to look at, rad; None for that of the last step.
        """
        pan = self._pan if gaze is None else pan_to(gaze, self._pan_reach)
        return self._head.next(pan, now) if self._head else None

    def _is_ready(self, stamp: float) -> bool:
        """Return whether it is known where the head looked at a time: it stands, or a later reading has come."""
        newest = self._camera.newest
        if self._head is None or newest is None or newest >= stamp:
            return True
        return not self._head_moves and not newest < self._head.told_at <= stamp

    def _look(self, stamp: float, data: bytes) -> None:
        """Look for the leader in a picture."""
        camera = self.settings.camera
        robot = self._robot.at(stamp)
        eye = Pose2D(camera.forward, 0.0, 0.0) if self._head is None else self._camera.at(stamp)
        if robot is None or eye is None:
            silent = "base" if robot is None else "head of the camera"
            self.words = f"a picture is not used, since the {silent} has not reported where it was then"
        elif self._is_frozen(data, robot):
            self.words = "the camera repeats one picture although the robot moves"
        else:
            try:
                pixels = Image.decode(data).pixels
                sight = self._sight_for(pixels.shape[1], pixels.shape[0])
                sighting = sight.look(pixels, robot, eye, self._tilt, self.follower.expected(stamp))
            except VisionError as err:
                self.words = f"a picture cannot be used: {err}"
                return
            self._looked_at, self.words, self.shown = stamp, sight.words, (data, sight.outline)
            if sighting is not None:
                self.found_at = stamp
                self.follower.see(sighting, stamp)

    def _is_frozen(self, data: bytes, robot: Pose2D) -> bool:
        """Return whether a picture is the one before although the robot has moved since it came first."""
        if data != self._picture or self._picture_from is None:
            self._picture, self._picture_from = data, robot
            return False
        first, moved = self._picture_from, self.settings.camera.moved
        return (
            hypot(robot.x - first.x, robot.y - first.y) > moved
            or abs(wrap_angle(robot.heading - first.heading)) > moved
        )

    def _sight_for(self, width: int, height: int) -> LeaderSight:
        """Return what finds the leader in pictures of a size, px."""
        if self._sight is None or self._size != (width, height):
            camera = camera_model(self._lens, width, height)
            assert camera is not None, "a lens has a model or a field of view"
            self._sight, self._size = LeaderSight(self.settings.leader, camera, self._colours), (width, height)
        return self._sight
