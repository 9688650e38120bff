"""The leader in an image: its target is found by colours, and its pose follows from the edges."""

from math import hypot

import numpy as np

from apps.robot_following.leader import Sighting, leader_pose
from apps.robot_following.settings import LeaderSettings
from configs.target_file import target_file
from geometry import Pose2D
from vision.camera_model import PinholeModel
from vision.colours import ColourTable
from vision.image import Pixels
from vision.target import TargetFinder, TargetPose, TargetShape

_SHADES = np.linspace(0.45, 1.0, 12)  # of a colour, from shadow to full light
_PATCH = 12  # px, of the drawn patch that a colour is trained from


class LeaderSight:
    """Finds the leader in the images of one camera.

    words: what was seen last, for a person.
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
        self.words = "no image has come"

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
        seen = [(self._sighting(pose, robot, camera), pose.distance) for pose in found.others]
        if found.pose is not None:
            return self._sighting(found.pose, robot, camera)
        if len(seen) < 2:
            return None
        if expected is None:
            seen.sort(key=lambda each: each[1])
            return seen[0][0] if seen[1][1] - seen[0][1] > self._settings.apart else None
        offs = [hypot(each.pose.x - expected.x, each.pose.y - expected.y) for each, _ in seen]
        nearest, second = sorted(offs)[:2]
        return seen[offs.index(nearest)][0] if second - nearest > self._settings.apart / 2.0 else None

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
