"""Base and laser on an emulated robot with its driver, under one virtual clock."""

import asyncio
from collections.abc import Coroutine, Iterator
from math import cos, hypot, sin
from typing import Any, TypeVar

import pytest

from acromovi.lockstep import Lockstep
from agents.platform import Agent, AgentName, Container, Report
from agents.platform.virtual_time import VirtualTimeLoop
from agents.services.arbiter import Arbiter
from agents.services.lease_client import leased
from apps.indoor_navigation.component import push_key, query_key
from apps.indoor_navigation.components.laser_server import LaserServer
from apps.indoor_navigation.components.robot_base_server import RobotBaseServer
from apps.indoor_navigation.data import Data, LaserRead, MotionCmd, RobotOdometry, SonarRead
from bus import Sample, keys
from bus.messages import decode_json, twist
from geometry import Pose2D
from p2os_emu.emulator import STEP
from p2os_emu.world import load_world

D = TypeVar("D", bound=Data)

ROBOT = "happy"


class Lab:
    """The robot in the office, and its two components.

    reports: what went wrong, in words. lease: the last that the gateway said of its leases.
    """

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self.loop = loop
        self.lockstep = Lockstep(load_world("office"), {ROBOT: "p2dx"}, fits={ROBOT: "laser"}, perfect=True)
        self.bus = self.lockstep.bus()
        self.reports: list[str] = []
        self.lease: dict[str, object] = {}
        self.start = self.lockstep.truth(ROBOT)
        self._living = loop.create_task(self._live())
        self.bus.subscribe(keys.LEASE_STATE.key(ROBOT), self._note_lease)
        self._containers = [self.container("components")]
        self.run_async(self._begin())

    async def _begin(self) -> None:
        base = {"hears": [["motion_fuser", "MotionCmd"]]}
        laser = {"hears": [["robot_base_server", "Odometry"]]}
        await self._containers[0].start(RobotBaseServer(f"robot_base_server@{ROBOT}", base))
        await self._containers[0].start(LaserServer(f"laser_server@{ROBOT}", laser))

    async def _live(self) -> None:
        while True:
            self.lockstep.run(STEP)
            await asyncio.sleep(STEP)

    def container(self, name: str) -> Container:
        """One more process."""
        return Container(self.lockstep.bus(), name, self._note, lambda: self.lockstep.time, platform=ROBOT)

    def live_with(self, agent: Agent) -> None:
        """Let an agent live in a process of its own."""
        self._containers.append(self.container(f"of-{agent.name.local}"))
        self.run_async(self._containers[-1].start(agent))

    def run_async(self, work: Coroutine[Any, Any, object]) -> None:
        self.loop.run_until_complete(work)

    def run(self, seconds: float) -> None:
        self.loop.run_for(seconds)

    def drive(self, seconds: float, linear: float, angular: float = 0.0) -> None:
        """Let the fuser say so."""
        for _ in range(round(seconds / 0.05)):
            command = MotionCmd(self.lockstep.time, "motion_fuser", linear, angular, 1.0)
            self.bus.put(push_key(ROBOT, "motion_fuser", MotionCmd), command.to_json())
            self.run(0.05)

    def pushed(self, source: str, kind: type[D]) -> list[D]:
        """What a component pushes from now on, in a list that grows."""
        heard: list[D] = []

        def hear(sample: Sample) -> None:
            heard.append(kind.from_json(decode_json(sample.payload)))

        self.bus.subscribe(push_key(ROBOT, source, kind), hear)
        return heard

    def known(self) -> Pose2D:
        """Where the robot is in the frame in which its odometry began."""
        return self.lockstep.truth(ROBOT).relative_to(self.start)

    def close(self) -> None:
        for container in reversed(self._containers):
            self.run_async(container.close())
        self._living.cancel()
        self.run(0.01)
        self.lockstep.close()

    def _note(self, report: Report) -> None:
        self.reports.append(f"{report.agent}: {report.what}: {report.error}")

    def _note_lease(self, sample: Sample) -> None:
        self.lease = decode_json(sample.payload)

    @property
    def holder(self) -> object:
        """Who has the lease on the wheels."""
        elements = self.lease.get("elements")
        return elements.get("base", {}).get("holder") if isinstance(elements, dict) else None


@pytest.fixture
def lab() -> Iterator[Lab]:
    loop = VirtualTimeLoop()
    lab = Lab(loop)
    lab.run(4.0)  # the driver connects, and switches the motors and the laser on
    yield lab
    lab.close()
    loop.close()


def test_a_robot_of_the_team_is_read_and_driven(lab: Lab) -> None:
    odometries = lab.pushed("robot_base_server", RobotOdometry)
    sonars = lab.pushed("robot_base_server", SonarRead)
    lab.drive(2.0, 0.3)
    lab.run(1.5)
    (answer,) = lab.bus.query(query_key(ROBOT, "robot_base_server", "robot"))
    assert answer.value["model"] == "p2dx"
    assert answer.value["limits"]["linear"] > 0.0
    assert odometries[-1].linear == 0.0
    assert odometries[-1].jumps == 0
    assert 0.4 < odometries[-1].x == pytest.approx(lab.known().x, abs=0.02)
    assert len(sonars[-1].ranges) == 16
    assert sonars[-1].stamp == pytest.approx(lab.lockstep.time, abs=0.15)
    assert lab.reports == []


def test_a_scan_knows_where_the_robot_was(lab: Lab) -> None:
    truths: list[tuple[float, Pose2D]] = []
    scans = lab.pushed("laser_server", LaserRead)

    async def watch() -> None:
        while True:
            truths.append((lab.lockstep.time, lab.known()))
            await asyncio.sleep(STEP)

    watching = lab.loop.create_task(watch())
    lab.drive(4.0, 0.2, 0.5)
    watching.cancel()
    assert len(scans) >= 10
    for scan in scans:
        truth = min(truths, key=lambda each: abs(each[0] - scan.stamp - 0.013))[1]
        x, y, heading = scan.pose
        assert hypot(x - truth.x, y - truth.y) < 0.05
        assert abs(sin(heading - truth.heading)) < 0.06
        assert cos(heading - truth.heading) > 0.0


def test_with_an_arbiter_the_wheels_are_leased_as_long_as_they_move(lab: Lab) -> None:
    lab.live_with(Arbiter(AgentName("arbiter", "team")))
    lab.drive(3.0, 0.2)
    assert lab.holder == f"robot_base_server@{ROBOT}"
    assert lab.known().x > 0.3
    before = lab.known().x
    for _ in range(10):  # somebody else, with no token
        lab.bus.put(keys.CMD_VEL.key(ROBOT), twist(-0.5, 0.0))
        lab.drive(0.1, 0.2)
    assert lab.known().x > before + 0.1
    lab.drive(2.0, 0.0)
    lab.run(1.0)
    assert lab.holder is None


def test_a_lease_that_was_lost_is_said_and_taken_again(lab: Lab) -> None:
    lab.live_with(Arbiter(AgentName("arbiter", "team")))
    person = Agent(AgentName("person", "lab"))
    lab.live_with(person)
    lab.drive(3.0, 0.2)

    async def hold() -> None:
        async with leased(person, f"base@{ROBOT}", priority=9):
            await asyncio.sleep(3.0)

    holding = lab.loop.create_task(hold())
    lab.drive(2.5, 0.2)
    assert lab.holder == "person@lab"
    stood = lab.known().x
    lab.drive(0.5, 0.2)
    assert lab.known().x == pytest.approx(stood, abs=0.01)
    assert any("the lease on the wheels was lost" in report for report in lab.reports)
    lab.drive(4.0, 0.2)
    assert holding.done()
    assert lab.holder == f"robot_base_server@{ROBOT}"
    assert lab.known().x > stood + 0.2


def test_a_cable_that_was_cut_is_said_and_the_robot_is_driven_again(lab: Lab) -> None:
    lab.drive(1.0, 0.2)
    cut = lab.lockstep.fault("line-cut")
    lab.drive(3.0, 0.2)
    assert any("happy has published no odometry" in report for report in lab.reports)
    lab.lockstep.clear(cut)
    lab.drive(6.0, 0.2)
    before = lab.known().x
    lab.drive(1.0, 0.2)
    assert lab.known().x > before + 0.1
