"""Where a dock is: a pose in odom, or the name of a dock on the map on which the robot is localized."""

import math
from collections.abc import Sequence

from agents import NotThere, RobotError, Team
from geometry import Pose2D, wrap_angle


class DockPlace:
    """A dock of one robot.

    The pose of a dock that is given by its name follows from the localization, and so changes while the robot drives.
    """

    def __init__(self, team: Team, robot: str, given: str | Sequence[float]) -> None:
        """Take what a person has given.

        Args:
            team: The robots on the bus.
            robot: Its name.
            given: x, y (m) and heading (rad) in odom, as numbers or as a text; any other text is a name on the map.
        Raises:
            RobotError: It is neither a pose nor a name.
        """
        self._team, self._localization = team, f"localization@{robot}"
        self._fixed = _numbers(given)
        self._name = given if isinstance(given, str) else ""
        is_list = self._name.strip().startswith("[")
        if self._fixed is None and (not self._name or is_list):
            raise RobotError(
                "a dock is x, y and heading in m and rad, as dock=[1,0.5,3.14], or the name of a dock on the map, "
                f"not {str(given)[:40]!r}"
            )

    def pose(self) -> Pose2D:
        """Return the pose of the robot on the dock, in odom.

        Raises:
            RobotError: It is given by a name, and the robot is not localized, or the map has no dock of this name.
        """
        if self._fixed is not None:
            return self._fixed
        try:
            goal = self._team.ask(self._localization, "goal", place=self._name)
        except NotThere as err:
            raise RobotError(f"the dock {self._name!r} is looked for on a map, but {err}") from err
        if goal["heading"] is None:
            raise RobotError(f"{self._name!r} has no heading on the map, so it is no dock")
        return Pose2D(float(goal["x"]), float(goal["y"]), float(goal["heading"]))


def _numbers(given: str | Sequence[float]) -> Pose2D | None:
    """Return a pose that is given by three numbers; None for anything else."""
    parts = given.strip("[] ").split(",") if isinstance(given, str) else given
    try:
        x, y, heading = map(float, parts)
    except (TypeError, ValueError):  # None says that it is no pose
        return None
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(heading)):
        return None
    return Pose2D(x, y, wrap_angle(heading))
