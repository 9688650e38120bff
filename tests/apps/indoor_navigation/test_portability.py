"""The whole navigation on the kinematic robot, in one process and virtual time."""

from collections.abc import Iterator

import pytest

from agents.platform import Kinds
from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.component import Component, send_key
from apps.indoor_navigation.data import RobotOdometry, WorldCoord
from apps.indoor_navigation.kinematic.base_server import KinematicBaseServer
from apps.indoor_navigation.parameters import WIRING
from apps.indoor_navigation.wiring import load_wiring
from geometry import Pose2D
from tests.apps.indoor_navigation.site import ROBOT, Site

KINEMATIC = WIRING.with_name("wiring-kinematic.toml")
REACTIVE = ("motion_fuser", "goto", "orienting", "obstacle_avoiding", "obstacle_detecting")
HARDWARE = ("robot_base_server", "laser_server")


class Run(Site):
    """The kinematic pair and the reactive components."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        super().__init__(loop)
        for part in load_wiring(KINEMATIC).parts:
            if part.local in REACTIVE + HARDWARE:
                component = Kinds().make(part.kind, part.agent(ROBOT), part.properties)
                assert isinstance(component, Component)
                self.start(component)
                if isinstance(component, KinematicBaseServer):
                    self.base = component
        self.order = 0

    def tell(self, aim: str, x: float = 0.0, y: float = 0.0, heading: float = 0.0) -> None:
        """What path planning would say."""
        self.order += 1
        for receiver in ("goto", "orienting"):
            coord = WorldCoord(self.time, self.order, aim, x, y, heading, 0.5)
            self.bus.send(send_key(ROBOT, receiver, WorldCoord), coord.to_json())

    @property
    def pose(self) -> Pose2D:
        """Where the robot is."""
        return self.base.kinematic.odometry


@pytest.fixture
def run() -> Iterator[Run]:
    loop = VirtualTimeLoop()
    run = Run(loop)
    run.run(1.0)
    yield run
    run.close()
    loop.close()


def test_the_reactive_components_bring_a_robot_that_is_no_pioneer_through_a_gap(run: Run) -> None:
    run.tell("go", 6.5, -1.0)
    run.run(25.0)
    assert abs(run.pose.x - 6.5) < 0.3
    assert abs(run.pose.y + 1.0) < 0.3
    assert run.base.kinematic.touched == 0


def test_it_turns_where_it_stands(run: Run) -> None:
    run.tell("turn", heading=2.0)
    run.run(8.0)
    assert run.pose.heading == pytest.approx(2.0, abs=0.1)
    assert abs(run.pose.x) < 0.05


@pytest.mark.parametrize("dead", [*REACTIVE[1:2], "obstacle_avoiding", "motion_fuser"])
def test_when_a_component_dies_on_the_way_the_robot_stands_and_touches_nothing(run: Run, dead: str) -> None:
    run.tell("go", 6.5, -1.0)
    run.run(4.0)
    heard = run.pushed("robot_base_server", RobotOdometry)
    run.kill(dead)
    run.run(2.0)
    assert heard[-1].linear == pytest.approx(0.0, abs=0.02)
    run.run(5.0)
    assert run.base.kinematic.touched == 0
