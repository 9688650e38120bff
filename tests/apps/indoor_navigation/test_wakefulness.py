"""Components sleep while nobody needs them: they hear and publish nothing, and wake by a subscription or an order."""

from collections.abc import Iterator
from typing import Any

import pytest

from agents.platform import Kinds
from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.component import Component, Role, answers_query, hears, push_key, send_key
from apps.indoor_navigation.components.motion_fuser import MotionFuser
from apps.indoor_navigation.components.robot_base_server import RobotBaseServer
from apps.indoor_navigation.data import (
    Data,
    DLEData,
    GoalPoint,
    LaserRead,
    MotionCmd,
    ObstRead,
    RobotOdometry,
    SonarRead,
    WorldCoord,
)
from apps.indoor_navigation.kinematic.base_server import KinematicBaseServer
from apps.indoor_navigation.parameters import WIRING
from apps.indoor_navigation.wakefulness import LINGER
from apps.indoor_navigation.wiring import load_wiring
from bus import Bus, MemoryBus
from tests.apps.indoor_navigation.site import ROBOT, Robot, Site

KINEMATIC = WIRING.with_name("wiring-kinematic.toml")
ASLEEP = LINGER + 4.0  # s after which all sleep: each does so after those that it gives data to
STREAMS: list[tuple[str, type[Data]]] = [
    ("robot_base_server", RobotOdometry),
    ("robot_base_server", SonarRead),
    ("laser_server", LaserRead),
    ("obstacle_detecting", ObstRead),
    ("dle_detecting", DLEData),
    ("goto", MotionCmd),
    ("orienting", MotionCmd),
    ("obstacle_avoiding", MotionCmd),
    ("motion_fuser", MotionCmd),
]


@pytest.fixture
def site() -> Iterator[Site]:
    loop = VirtualTimeLoop()
    site = Site(loop)
    yield site
    site.close()
    loop.close()


class Middle(Component):
    """Hears odometry, and makes a command of it. heard: how many odometries."""

    role = Role.REACTIVE
    gives = (MotionCmd,)
    heard = 0
    beats = 0

    async def setup(self) -> None:
        self.every(0.1, self._beat)

    @hears(RobotOdometry)
    async def follow(self, odometry: RobotOdometry) -> None:
        self.heard += 1
        self.push(MotionCmd(odometry.stamp, "middle", 0.0, 0.0, 0.0))

    @answers_query("heard")
    def count(self) -> dict[str, Any]:
        return {"heard": self.heard}

    async def _beat(self) -> None:
        self.beats += 1


class AllTen(Site):
    """The ten components of the kinematic robot. bases: the base, and those before that were killed."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        super().__init__(loop)
        self.bases: list[KinematicBaseServer] = []
        self._parts = {part.local: part for part in load_wiring(KINEMATIC).parts}
        for local in self._parts:
            self.begin(local)

    def begin(self, local: str) -> None:
        """Start a component."""
        part = self._parts[local]
        component = Kinds().make(part.kind, part.agent(ROBOT), part.properties)
        if isinstance(component, KinematicBaseServer):
            self.bases.append(component)
        self.start(component)

    def has_subscribers(self, source: str, kind: type[Data]) -> bool:
        return self.network.has_subscribers(push_key(ROBOT, source, kind))

    def go(self, mission: str, x: float, y: float) -> None:
        self.bus.send(send_key(ROBOT, "path_planning", GoalPoint), GoalPoint(mission, x, y).to_json())

    def ends(self, limit: float = 60.0) -> str:
        """Wait for the end of the mission."""
        deadline = self.loop.time() + limit
        while self.loop.time() < deadline:
            self.run(0.5)
            state = str(self.ask("path_planning", "state")["state"])
            if state in ("done", "failed", "cancelled"):
                return state
        return "late"


@pytest.fixture
def ten() -> Iterator[AllTen]:
    loop = VirtualTimeLoop()
    ten = AllTen(loop)
    yield ten
    ten.close()
    loop.close()


def middle(site: Site) -> Middle:
    component = Middle(f"middle@{ROBOT}", {"hears": [["base", "Odometry"]]})
    site.start(component)
    return component


def move(site: Site, seconds: float) -> None:
    """Push odometry ten times a second, whether anybody hears it or not."""
    for _ in range(round(seconds / 0.1)):
        site.push("base", RobotOdometry(site.time, 0.0, 0.0, 0.0, 0.0, 0.0))
        site.run(0.1)


def known_cells(picture: dict[str, Any]) -> int:
    """Number of cells of the grid that are not unknown."""
    return sum(length for kind, length in picture["grid"]["runs"] if kind != 0)


def subscribed(site: Site) -> bool:
    return site.network.has_subscribers(push_key(ROBOT, "base", RobotOdometry))


def test_a_component_that_nobody_hears_closes_its_inputs_and_stops_its_clock(site: Site) -> None:
    component = middle(site)
    move(site, 1.0)
    assert component.heard == 10
    move(site, LINGER)
    assert not subscribed(site)
    heard, beats = component.heard, component.beats
    move(site, 10.0)
    assert (component.heard, component.beats) == (heard, beats)


def test_a_subscription_wakes_a_component_and_keeps_it_awake(site: Site) -> None:
    component = middle(site)
    site.run(ASLEEP)
    heard = site.pushed("middle", MotionCmd)
    site.run(0.01)
    assert subscribed(site)
    move(site, 3.0 * LINGER)
    assert component.is_awake
    assert len(heard) == component.heard >= 10.0 * 3.0 * LINGER - 1


def test_a_component_sleeps_when_its_last_listener_has_gone(site: Site) -> None:
    middle(site)
    site.run(ASLEEP)
    listener = MemoryBus(site.network)
    listener.subscribe(push_key(ROBOT, "middle", MotionCmd), lambda sample: None)
    site.run(ASLEEP)
    assert subscribed(site)
    listener.close()
    site.run(1.0)
    assert not subscribed(site)


def test_a_query_wakes_a_component_for_some_time(site: Site) -> None:
    component = middle(site)
    site.run(ASLEEP)
    site.ask("middle", "heard")
    site.run(0.01)
    assert component.is_awake
    site.run(ASLEEP)
    assert not component.is_awake


def test_what_nobody_hears_is_not_encoded(site: Site) -> None:
    sent: list[Data] = []

    class Counted(MotionCmd):
        def to_json(self) -> dict[str, Any]:
            sent.append(self)
            return super().to_json()

    component = middle(site)
    component.push(Counted(site.time, "middle", 0.0, 0.0, 0.0))
    assert not sent


def test_the_fuser_hears_its_guard_only_while_another_source_wants_to_move(site: Site) -> None:
    sources = ("goto", "obstacle_avoiding")
    numbers = {"fusion": {"sources": {"goto": {"max_age": 0.4}, "obstacle_avoiding": {"required": True}}}}
    properties = {"hears": [[source, "MotionCmd"] for source in sources], "numbers": numbers}
    site.start(MotionFuser(f"motion_fuser@{ROBOT}", properties))
    fused = site.pushed("motion_fuser", MotionCmd)
    site.run(ASLEEP)
    assert not site.network.has_subscribers(push_key(ROBOT, "obstacle_avoiding", MotionCmd))
    before = len(fused)
    site.run(10.0)
    assert len(fused) == before
    site.push("goto", MotionCmd(site.time, "goto", 0.3, 0.0, 1.0))
    site.run(0.01)
    assert site.network.has_subscribers(push_key(ROBOT, "obstacle_avoiding", MotionCmd))
    assert [command.linear for command in fused[before:]] == [0.0], "its guard has said nothing yet"


def test_a_fuser_whose_sources_are_all_guards_stays_awake(site: Site) -> None:
    numbers = {"fusion": {"sources": {"obstacle_avoiding": {"required": True}}}}
    properties = {"hears": [["obstacle_avoiding", "MotionCmd"]], "numbers": numbers}
    site.start(MotionFuser(f"motion_fuser@{ROBOT}", properties))
    site.run(ASLEEP)
    assert site.network.has_subscribers(push_key(ROBOT, "obstacle_avoiding", MotionCmd))


def test_a_base_that_sleeps_asks_the_gateway_for_nothing_and_obeys_a_command_all_the_same(site: Site) -> None:
    site.start(RobotBaseServer(f"robot_base_server@{ROBOT}", {"hears": [["motion_fuser", "MotionCmd"]]}))
    site.run(ASLEEP)
    assert site.network.has_subscribers(f"{ROBOT}/odom"), "the robot is unknown"
    robot = Robot(site)
    robot.odometry()
    site.run(ASLEEP)
    assert not site.network.has_subscribers(f"{ROBOT}/odom")
    site.run(10.0)
    assert site.reports == []
    site.push("motion_fuser", MotionCmd(site.time, "motion_fuser", 0.2, 0.0, 1.0))
    site.run(0.1)
    assert robot.told[-1][1] == 0.2
    site.run(1.0)
    assert robot.told[-1][1] == 0.0, "the fuser is silent"


def test_a_gateway_that_was_lost_during_a_sleep_is_reported_after_it(site: Site) -> None:
    site.start(RobotBaseServer(f"robot_base_server@{ROBOT}", {"hears": [["motion_fuser", "MotionCmd"]]}))
    robot = Robot(site)
    for _ in range(round(ASLEEP / 0.1)):
        robot.odometry()
        site.run(0.1)
    robot.go()
    site.run(10.0)
    assert site.reports == []
    site.pushed("robot_base_server", RobotOdometry)
    site.run(3.0)
    assert len([report for report in site.reports if "has published no odometry" in report]) == 1


def test_without_a_mission_no_component_publishes_or_subscribes(ten: AllTen) -> None:
    ten.run(ASLEEP)
    assert not any(ten.has_subscribers(*stream) for stream in STREAMS[:5])
    watcher: Bus = MemoryBus(ten.network)
    heard: list[str] = []
    for source in ("goto", "orienting", "motion_fuser"):  # they work for orders, not for whoever listens
        watcher.subscribe(push_key(ROBOT, source, MotionCmd), lambda sample: heard.append(sample.key))
    ten.run(10.0)
    assert heard == []
    assert ten.reports == []


def test_a_mission_after_a_sleep_is_carried_out_and_all_sleep_again(ten: AllTen) -> None:
    for mission, x in (("m1", 2.0), ("m2", 0.5)):
        ten.run(60.0)
        ten.go(mission, x, 0.0)
        assert ten.ends() == "done"
        assert abs(ten.bases[-1].kinematic.odometry.x - x) < 0.3
    ten.run(ASLEEP + 2.0)
    assert not any(ten.has_subscribers(*stream) for stream in STREAMS[:5])
    assert ten.bases[-1].kinematic.touched == 0
    assert ten.reports == []


def test_what_planning_has_learned_remains_during_a_sleep(ten: AllTen) -> None:
    ten.go("m1", 2.0, 0.0)
    assert ten.ends() == "done"
    before = known_cells(ten.ask("path_planning", "picture"))
    ten.run(120.0)
    assert known_cells(ten.ask("path_planning", "picture")) > 0.9 * before > 0.0


@pytest.mark.parametrize("local", [*dict(STREAMS), "path_planning"])
def test_a_component_that_was_restarted_during_a_sleep_takes_part_in_the_next_mission(ten: AllTen, local: str) -> None:
    ten.run(ASLEEP)
    ten.kill(local)
    ten.run(1.0)
    ten.begin(local)
    ten.run(ASLEEP)
    assert not any(ten.has_subscribers(*stream) for stream in STREAMS[:5])
    ten.go("m1", 1.0, 0.0)
    assert ten.ends() == "done"
    assert ten.bases[-1].kinematic.touched == 0


def test_without_avoiding_a_robot_that_was_woken_does_not_move(ten: AllTen) -> None:
    ten.run(ASLEEP)
    ten.kill("obstacle_avoiding")
    ten.go("m1", 2.0, 0.0)
    ten.run(5.0)
    assert ten.bases[-1].kinematic.odometry.x == 0.0
    ten.begin("obstacle_avoiding")
    assert ten.ends() == "done"


def test_a_person_who_asks_for_the_state_during_a_sleep_is_told_where_the_robot_is_now(ten: AllTen) -> None:
    ten.run(ASLEEP)
    assert not ten.ask("path_planning", "state")["is_current"]
    ten.run(0.8)
    told = ten.ask("path_planning", "state")
    assert told["is_current"]
    assert told["pose"] == [0.0, 0.0, 0.0]


def test_orders_of_a_planner_that_has_died_do_not_keep_a_robot_awake_that_stands(ten: AllTen) -> None:
    ten.run(1.0)
    for receiver in ("goto", "orienting"):
        order = WorldCoord(ten.time, 1, "go", 1.0, 0.0, 0.0, 0.5, True)
        ten.bus.send(send_key(ROBOT, receiver, WorldCoord), order.to_json())
    ten.kill("path_planning")
    ten.run(30.0)
    assert abs(ten.bases[-1].kinematic.odometry.x - 1.0) < 0.3
    assert not any(ten.has_subscribers(*stream) for stream in STREAMS[:5])
