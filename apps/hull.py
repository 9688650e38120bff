"""Whether an application's settings are of a robot as large as the one that it drives."""

from agents import Robot, RobotError

SAME = 0.03  # m by which a hull may be larger than in the settings


def check_hull(robot: Robot, **told: float) -> None:
    """Refuse a robot that is larger than the settings say.

    Args:
        robot: With a base.
        told: m by the settings, of what the description of the base has: length_front, length_rear, width.
    Raises:
        RobotError: It is larger.
    """
    own = robot.base.properties["geometry"]
    for what, most in told.items():
        if (real := float(own[what])) > most + SAME:
            raise RobotError(
                f"the settings are of a robot whose {what} is {most:.2f} m, and that of {robot.name} is {real:.2f} m; "
                "give settings of its own"
            )
