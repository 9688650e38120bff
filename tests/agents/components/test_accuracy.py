"""How near the base gets to where it was sent, by its own odometry and in truth; and that a wall ends every motion."""

from math import hypot, pi
from pathlib import Path
from typing import Any

import pytest

from agents.platform import Ending
from geometry import Pose2D, wrap_angle
from tests.agents.components.conftest import Lab, MakeLab

BY_ODOMETRY = 0.025, 0.025
"""m and rad."""
IN_TRUTH = 0.05, 0.05
"""The same on a leg of a few metres, wheels and floor being as imperfect as they are."""
BLOCKED = 12.0
"""s after which a robot that cannot go on has said so, the way to the wall included."""

POSES = [
    Pose2D(0.8, 0.6, 0.0),
    Pose2D(0.3, 0.3, pi / 2),
    Pose2D(0.2, -0.7, -2.0),
    Pose2D(0.3, -0.7, -2.0),
    Pose2D(-0.5, 0.0, pi),
    Pose2D(-0.5, 0.0, 0.0),
]
WALL = """
[[walls]]
from_m = [1.0, -2.0]
to_m = [1.0, 2.0]
"""


def odometry(lab: Lab) -> Pose2D:
    now = lab.value("base", "read")
    return Pose2D(now["x"], now["y"], now["heading"])


def check(there: Pose2D, wanted: Pose2D, tolerance: tuple[float, float]) -> None:
    assert hypot(there.x - wanted.x, there.y - wanted.y) < tolerance[0]
    assert abs(wrap_angle(there.heading - wanted.heading)) < tolerance[1]


class TestLegs:
    """A robot whose wheels and sensors are not perfect."""

    @pytest.fixture(params=["p3dx-sh", "powerbot-sh", "amigo-sh"])
    def lab(self, request: pytest.FixtureRequest, make_lab: MakeLab) -> Lab:
        lab = make_lab(model=request.param, perfect=False)
        lab.run(1.0)
        return lab

    def drive(self, lab: Lab, wanted: Pose2D, name: str, **arguments: Any) -> None:
        """Drive a leg, and see whether it ended where it should, in odom."""
        before, was = odometry(lab), lab.lockstep.truth("happy")
        lab.value("base", name, **arguments)
        lab.run(0.5)
        check(odometry(lab), wanted, BY_ODOMETRY)
        check(lab.lockstep.truth("happy").relative_to(was), wanted.relative_to(before), IN_TRUTH)

    def test_poses_are_reached_from_anywhere(self, lab: Lab) -> None:
        for goal in POSES:
            self.drive(lab, goal, "go_to", x=goal.x, y=goal.y, heading=goal.heading)

    def test_ways_and_angles_are_what_was_asked_for(self, lab: Lab) -> None:
        for distance, more in ((1.0, {}), (-0.5, {}), (0.6, {"speed": 0.2}), (-0.6, {"speed": 0.3})):
            self.drive(lab, odometry(lab).compose(Pose2D(distance, 0.0)), "move", distance=distance, **more)
        for angle in (pi / 2, -0.3, 1.5 * pi):
            self.drive(lab, odometry(lab).compose(Pose2D(0.0, 0.0, angle)), "turn", angle=angle)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("go_to", {"x": 2.0, "y": 0.0}),
        ("go_to", {"x": 2.0, "y": 0.3, "heading": 1.0, "speed": 0.2}),
        ("move", {"distance": 2.0}),
        ("move", {"distance": 2.0, "speed": 0.2}),
        ("drive", {"linear": 0.3, "seconds": 60.0}),
    ],
)
def test_a_wall_in_the_way_ends_a_motion_as_stalled(
    make_lab: MakeLab, tmp_path: Path, name: str, arguments: dict[str, Any]
) -> None:
    world = tmp_path / "wall.toml"
    world.write_text(WALL)
    lab = make_lab(world=str(world))
    lab.run(1.0)
    began = lab.loop.time()
    outcome = lab.ask("base", name, **arguments)
    assert lab.loop.time() - began < BLOCKED
    assert outcome.ending is Ending.FAILED
    assert "stalled" in outcome.why
    assert lab.lockstep.truth("happy").x < 1.0
    lab.value("base", "move", distance=-0.3)  # it can go on


def test_the_end_of_a_wall_along_which_it_can_creep_ends_a_motion_too(make_lab: MakeLab, tmp_path: Path) -> None:
    world = tmp_path / "wall.toml"
    world.write_text(WALL)
    lab = make_lab(model="amigo-sh", world=str(world), perfect=False)
    lab.run(1.0)
    began = lab.loop.time()
    outcome = lab.ask("base", "go_to", x=1.5, y=3.0)
    assert "stalled" in outcome.why
    assert lab.loop.time() - began < 2 * BLOCKED  # s; it drives 2 m first
