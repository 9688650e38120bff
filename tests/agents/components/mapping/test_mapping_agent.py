"""mapping@ROBOT: begins, follows, saves and extends a map; the test plays the gateway in drawn rooms."""

import asyncio
import base64
import math
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acromovi.mapping.grids import grid_of_message
from agents.components.mapping import mapping_agent
from agents.components.mapping.mapping_agent import MappingAgent
from agents.platform import Agent, Container, Ending, Outcome, Report, request
from bus import MemoryBus, Sample, keys, messages
from bus.messages import LaserScan, Odometry, Point, Pose, PoseWithCovariance, TwistWithCovariance
from geometry import Pose2D
from maps.map_files import read_building_map
from tests.maps.building.drawn_rooms import BEARINGS, poses_along, ring, scan
from tests.waiting import waiting

START = 1_700_000_000_000_000_000  # ns
PERIOD = 100_000_000  # ns between two scans
LASER = {"name": "laser", "geometry": {"x": 0.0, "y": 0.0, "heading": 0.0}}


class Bench:
    """The agent, `app@team`, which asks it, and a gateway that publishes what a drawn robot sees."""

    def __init__(self, elements: tuple[dict[str, Any], ...] = (LASER,)) -> None:
        self.bus = MemoryBus()
        self.reports: list[Report] = []
        self.agent = MappingAgent("mapping@happy")
        self.container = Container(MemoryBus(self.bus.network), "happy", self.reports.append)
        self.app = Agent("app@team")
        self.laser = self.bus.publisher(keys.SCAN.key("happy"), keys.SCAN.type_name)
        self._number = 0
        self._rng = np.random.default_rng(0)
        self.bus.serve(keys.DESCRIPTION.key("happy"), lambda given: {"name": "happy", "elements": list(elements)})

    async def ask(self, name: str, /, **arguments: Any) -> Outcome:
        return await self.app.request(self.agent.name, name, reply_within=20.0, **arguments)

    async def value(self, name: str, /, **arguments: Any) -> Any:
        return (await self.ask(name, **arguments)).value()

    async def until(self, condition: Callable[[], object]) -> None:
        async with waiting():
            while not condition():
                await asyncio.sleep(0.01)

    async def until_used(self, scans: int) -> dict[str, Any]:
        async with waiting():
            while (state := await self.value("state")).get("scans", 0) < scans:
                await asyncio.sleep(0.05)
        return dict(state)

    def drive(self, *way: tuple[float, float]) -> int:
        """Publish odometry and scans along a way; return the number of scans."""
        poses = list(poses_along(way))
        for pose in poses:
            self._odometry(pose.relative_to(Pose2D(*way[0])))
            self._scan(scan(ring(), pose, self._rng))
            self._number += 1
        self._odometry(poses[-1].relative_to(Pose2D(*way[0])))
        return len(poses)

    def _odometry(self, pose: Pose2D) -> None:
        place = Pose(position=Point(pose.x, pose.y, 0.0), orientation=messages.quaternion(pose.heading))
        twist = TwistWithCovariance(twist=messages.twist(0.0, 0.0), covariance=np.zeros(36))
        head = messages.header(START + self._number * PERIOD, "happy/odom")
        where = PoseWithCovariance(pose=place, covariance=np.zeros(36))
        said = Odometry(header=head, child_frame_id="happy/base_link", pose=where, twist=twist)
        self.bus.put(keys.ODOM.key("happy"), said)

    def _scan(self, ranges: Any) -> None:
        head = messages.header(START + self._number * PERIOD, "happy/laser")
        self.laser.put(
            LaserScan(
                header=head,
                angle_min=float(BEARINGS[0]),
                angle_max=float(BEARINGS[-1]),
                angle_increment=math.radians(1.0),
                time_increment=0.0,
                scan_time=0.1,
                range_min=0.05,
                range_max=30.0,
                ranges=ranges.astype(np.float32),
                intensities=np.zeros(0, np.float32),
            )
        )


@asynccontextmanager
async def bench(*elements: dict[str, Any]) -> AsyncIterator[Bench]:
    made = Bench(elements or (LASER,))
    async with made.container:
        assert await made.container.start(made.app)
        assert await made.container.start(made.agent)
        yield made


def play(story: Callable[[Bench], Any], *elements: dict[str, Any]) -> None:
    async def run() -> None:
        async with bench(*elements) as at:
            await story(at)

    asyncio.run(run())


def test_nothing_is_subscribed_to_before_the_start_and_after_the_stop() -> None:
    async def story(at: Bench) -> None:
        listening = [at.laser.has_listeners]
        assert (await at.value("state"))["building"] is False
        for order in ("start", "stop"):
            await at.value(order)
            listening.append(at.laser.has_listeners)
        assert listening == [False, True, False]

    play(story)


def test_a_map_is_built_published_and_saved(tmp_path: Path) -> None:
    async def story(at: Bench) -> None:
        grids: list[Sample] = []
        at.bus.subscribe(keys.MAP.key("happy"), grids.append)
        assert (await at.value("start"))["building"] is True
        scans = at.drive((2.0, 2.0), (4.0, 2.0), (3.0, 3.0))
        state = await at.until_used(scans)
        assert state["key_scans"] > 3
        assert state["pose"][:2] == pytest.approx([1.0, 1.0], abs=0.35)
        assert state["odom"] == pytest.approx([0.0, 0.0, 0.0], abs=0.05)
        await at.until(lambda: grids)
        grid = grid_of_message(grids[-1].decoded())
        assert grid.values_at(np.array([[0.5, 0.0], [-2.0, 0.0]])).tolist() == [0, 100]
        await at.value("stop")
        saved = await at.value("save", path=str(tmp_path / "lab"), formats=["map", "yaml"])
        assert {Path(each).name for each in saved["files"]} == {"lab.map", "lab.yaml", "lab.pgm"}
        made = read_building_map(tmp_path / "lab.map")
        assert len(made.lines) > 8
        assert made.home == Pose2D(0.0, 0.0, 0.0)
        content = await at.value("content", kind="map")
        assert base64.b64decode(content["files"]["map.map"]) == (tmp_path / "lab.map").read_bytes()

    play(story)


def test_a_saved_map_is_extended_from_where_the_robot_is(tmp_path: Path) -> None:
    async def story(at: Bench) -> None:
        await at.value("start")
        await at.until_used(at.drive((2.0, 2.0), (4.0, 2.0)))
        await at.value("stop", refine=False)
        await at.value("save", path=str(tmp_path / "lab.map"))
        before = read_building_map(tmp_path / "lab.map")
        await at.value("start", extend=str(tmp_path / "lab.map"), x=1.3, y=0.2)
        state = await at.until_used(at.drive((3.5, 2.0), (7.0, 2.0)))
        assert state["pose"][:2] == pytest.approx([5.0, 0.0], abs=0.35)
        await at.value("stop", refine=False)
        await at.value("save", path=str(tmp_path / "more.map"))
        more = read_building_map(tmp_path / "more.map")
        assert more.bounds.x2 > before.bounds.x2 - 0.1
        assert more.bounds.x1 == pytest.approx(before.bounds.x1, abs=0.15)

    play(story)


def test_a_start_that_does_not_fit_the_map_is_told_and_ends_the_building(tmp_path: Path) -> None:
    async def story(at: Bench) -> None:
        await at.value("start")
        await at.until_used(at.drive((2.0, 2.0), (2.5, 2.0)))
        await at.value("save", path=str(tmp_path / "lab.map"))
        await at.value("stop", refine=False)
        await at.value("start", extend=str(tmp_path / "lab.map"), x=30.0, y=30.0)
        at.drive((2.0, 2.0), (2.5, 2.0))
        async with waiting():
            while (state := await at.value("state"))["building"]:
                await asyncio.sleep(0.05)
        assert "give the pose" in state["trouble"]
        assert not at.laser.has_listeners

    play(story)


class PlayedLocalization(Agent):
    """`localization@happy`, which tells a state."""

    told = "searching"

    @request("state")
    async def tell_state(self) -> dict[str, Any]:
        return {"state": self.told}


def test_no_map_is_begun_while_the_robot_is_localized_on_another_one() -> None:
    async def story(at: Bench) -> None:
        localization = PlayedLocalization("localization@happy")
        assert await at.container.start(localization)
        outcome = await at.ask("start")
        assert outcome.ending is not Ending.DONE
        assert "acromovi localize happy --stop" in outcome.why
        assert not at.laser.has_listeners
        localization.told = "stopped"
        assert (await at.value("start"))["building"] is True

    play(story)


def test_a_stop_while_a_map_is_begun_ends_the_start(monkeypatch: pytest.MonkeyPatch) -> None:
    reached, may_go_on = threading.Event(), threading.Event()
    begun = mapping_agent._begun

    def slow(*given: Any) -> Any:
        reached.set()
        may_go_on.wait(20.0)
        return begun(*given)

    monkeypatch.setattr(mapping_agent, "_begun", slow)

    async def story(at: Bench) -> None:
        try:
            starting = asyncio.ensure_future(at.ask("start"))
            await at.until(reached.is_set)
            assert "ask it to stop first" in (await at.ask("start")).why
            assert (await at.value("stop"))["building"] is False
        finally:
            may_go_on.set()
        assert "was stopped" in (await starting).why
        assert not at.laser.has_listeners
        assert (await at.value("start"))["building"] is True

    play(story)


@pytest.mark.parametrize(
    ("request_", "arguments", "why"),
    [
        ("save", {"path": "/tmp/x.map"}, "has no map"),
        ("stop", {}, "has no map"),
        ("content", {}, "has no map"),
        ("start", {"extend": "/nowhere/lab.map"}, "/nowhere/lab.map"),
        ("start", {"x": 1.0}, "needs x and y"),
    ],
)
def test_what_cannot_be_done_is_refused_with_the_reason(request_: str, arguments: dict[str, Any], why: str) -> None:
    async def story(at: Bench) -> None:
        outcome = await at.ask(request_, **arguments)
        assert outcome.ending in (Ending.REFUSED, Ending.FAILED)
        assert why in outcome.why

    play(story)


def test_a_robot_without_laser_and_sonar_is_refused() -> None:
    async def story(at: Bench) -> None:
        outcome = await at.ask("start")
        assert outcome.ending is not Ending.DONE
        assert "neither a laser nor sonar" in outcome.why

    play(story, {"name": "base"})
