"""The target at the back of a robot: whether it is fitted, and where it is."""

from configs.target_file import PART, TargetFile, target_file
from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.fit import Fit


def target_of(fit: Fit) -> TargetFile | None:
    """Return the target of a fit, None where there is none.

    Raises:
        ConfigError: Its file has an error.
    """
    return target_file() if fit.has(PART) else None


def target_on(model: RobotModel, target: TargetFile) -> Pose2D:
    """Return the middle between the flanks on a robot, seen from the middle of its axle."""
    return Pose2D(target.inset_m - model.length_rear, 0.0, 0.0)
