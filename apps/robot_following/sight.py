"""The leader in an image: its target is found by colours, and its pose follows from the edges."""

from collections.abc import Sequence
from math import hypot

import numpy as np

from apps.robot_following.leader import Sighting, leader_pose
from apps.robot_following.settings import LeaderSettings
from configs.target_file import target_file
from geometry import Pose2D
from vision.camera_model import PinholeModel
from vision.colours import ColourTable
from vision.image import Floats, Pixels
from vision.target import TargetFinder, TargetPose, TargetShape
from vision.target_fit import placed

_SHADES = np.linspace(0.45, 1.0, 12)  # of a colour, from shadow to full light
_PATCH = 12  # px, of the drawn patch that a colour is trained from


class LeaderSight:
    """Finds the leader in the images of one camera.

    words: what was seen last, for a person. outline: where the corners of the leader's target are in that image, px,
    shape (3, 4, 2); None if it was not found.
    """

    def __init__(self, settings: LeaderSettings, camera: PinholeModel, table: ColourTable) -> None:
        """Make ready.

        Args:
            settings: Of the leader.
            camera: Model of the camera, at the size of its images.
            table: Trained on the target's colours in channels 1 to 3: left flank, centre, right flank.
        Raises:
            VisionError: A channel is not trained.
        """
        self._settings = settings
        self._finder = TargetFinder(TargetShape(), table, camera)
        self._camera = camera
        self.words = "no image has come"
        self.outline: Floats | None = None

    def look(
        self, pixels: Pixels, robot: Pose2D, camera: Pose2D, tilt: float = 0.0, expected: Pose2D | None = None
    ) -> Sighting | None:
        """Return the leader in an image, None where it is not found.

        Args:
            pixels: In the order of OpenCV.
            robot: The follower, in odom, when the image was exposed.
            camera: On the follower, in its frame, with the pan as heading.
            tilt: Of the camera, rad, up.
            expected: Where the leader should be, in odom; tells which of several targets is its own. Without it, the
                leader is the nearest if the others are clearly farther.
        Raises:
            VisionError: The image does not fit the camera's model.
        """
        found = self._finder.find(pixels, tilt)
        self.words = found.words
        pose = found.pose or self._chosen(found.others, robot, camera, expected)
        if pose is None:
            self.outline = None
            return None
        at = np.array([pose.x, pose.y, pose.z, pose.orientation, 0.0, 0.0])
        corners = placed(TargetShape().corners().reshape(-1, 3), at, tilt)
        self.outline = self._camera.pixels_of(corners).reshape(3, 4, 2)
        return self._sighting(pose, robot, camera)

    def _chosen(
        self, several: Sequence[TargetPose], robot: Pose2D, camera: Pose2D, expected: Pose2D | None
    ) -> TargetPose | None:
        """Return the leader's of several targets in view; None if that is not clear."""
        if len(several) < 2:
            return None
        if expected is None:
            first, second = sorted(several, key=lambda each: each.distance)[:2]
            return first if second.distance - first.distance > self._settings.apart else None
        leaders = [self._sighting(each, robot, camera).pose for each in several]
        offs = [hypot(each.x - expected.x, each.y - expected.y) for each in leaders]
        nearest, second_off = sorted(offs)[:2]
        return several[offs.index(nearest)] if second_off - nearest > self._settings.apart / 2.0 else None

    def _sighting(self, pose: TargetPose, robot: Pose2D, camera: Pose2D) -> Sighting:
        """Return the sighting of the leader that carries a target."""
        known = self._settings
        return Sighting(
            leader_pose(robot, camera, (pose.x, pose.y, pose.orientation), known.carried),
            max(known.position_deviation, known.distance_deviation * pose.distance, pose.distance_deviation),
            max(known.heading_deviation, pose.orientation_deviation),
        )


def shipped_colours() -> ColourTable:
    """Return a table of the colours of the target that emulated robots carry, from shadow to full light."""
    target, table = target_file(), ColourTable()
    for channel, (red, green, blue) in enumerate((target.left, target.centre, target.right), 1):
        shades = _SHADES[:, None] * np.array([blue, green, red])
        patch = np.repeat(np.repeat(np.rint(255.0 * shades).astype(np.uint8)[:, None], _PATCH, axis=1), 2, axis=0)
        table.train(channel, patch, (0, 0, _PATCH, len(patch)))
    return table
