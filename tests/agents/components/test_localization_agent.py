import asyncio
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest

from agents.components.localization.localization_agent import LocalizationAgent
from apps.indoor_navigation.algorithms.planning.floor import FloorMap
from benchmarks.localization_drives import map_of_world
from bus import Sample, keys
from bus.messages import decode, heading
from geometry import Cairn, Pose2D, Segment
from maps.building_map import BuildingMap
from maps.map_files import write_building_map
from p2os_emu.world import load_world
from tests.agents.components.conftest import Lab, MakeLab

T = TypeVar("T")
PLACES = (
    Cairn("RobotHome", Pose2D(8.2, 6.1, 0.0), ""),
    Cairn("GoalWithHeading", Pose2D(2.5, 6.1, 1.0), "Lab 2"),
    Cairn("Goal", Pose2D(10.0, 2.5), "Bench"),
    Cairn("Goal", Pose2D(0.1, 6.1), "In the wall"),
    Cairn("Goal", Pose2D(13.7, 9.3), "Kitchen"),
    Cairn("ForbiddenArea", Pose2D(), "", Segment(12.0, 7.3, 15.9, 12.0)),
)


@pytest.fixture(autouse=True)
def _without_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """In virtual time nothing may wait for a thread, so the work is done in the loop."""

    async def now(self: LocalizationAgent, job: Callable[[], T]) -> T:
        return job()

    monkeypatch.setattr(LocalizationAgent, "_in_thread", now)


@pytest.fixture(scope="module")
def office() -> BuildingMap:
    return replace(map_of_world(load_world("office")), places=PLACES)


@pytest.fixture
def file(office: BuildingMap, tmp_path: Path) -> str:
    return str(write_building_map(office, tmp_path / "office.map")[0])


@pytest.fixture
def lab(make_lab: MakeLab) -> Lab:
    lab = make_lab("laser", world="office", perfect=False)
    lab.until(lambda: "localization" in lab.elements)
    return lab


def listened(lab: Lab, topic: keys.Topic) -> list[Any]:
    heard: list[Sample] = []
    lab.bus.subscribe(topic.key("happy"), heard.append)
    return heard


def localized(lab: Lab, file: str, **given: Any) -> None:
    lab.value("localization", "start", map=file, **given)
    lab.until(lambda: lab.value("localization", "state")["state"] == "localized")


def test_a_robot_at_home_is_localized_and_its_pose_is_on_the_bus(lab: Lab, file: str) -> None:
    poses, transforms, maps = (listened(lab, topic) for topic in (keys.POSE, keys.TF, keys.MAP))
    localized(lab, file)
    lab.value("base", "move", distance=1.0)
    lab.until(lambda: maps)
    truth = lab.lockstep.truth("happy")
    pose = decode(keys.POSE.type_name, poses[-1].payload)
    assert pose.header.frame_id == "map"
    at = pose.pose.pose
    assert (at.position.x, at.position.y) == pytest.approx((truth.x, truth.y), abs=0.08)
    assert heading(at.orientation) == pytest.approx(truth.heading, abs=0.03)
    frames = {
        (each.header.frame_id, each.child_frame_id)
        for sample in transforms[-20:]
        for each in decode(keys.TF.type_name, sample.payload).transforms
    }
    assert ("map", "happy/odom") in frames
    grid = decode(keys.MAP.type_name, maps[0].payload)
    assert len(grid.data) == grid.info.width * grid.info.height
    assert set(grid.data.tolist()) == {-1, 0, 100}


def test_goals_are_converted_to_odom_and_refused_with_a_reason(lab: Lab, file: str) -> None:
    assert "no localization" in lab.ask("localization", "goal", place="Lab 2").why
    localized(lab, file)
    goal = lab.value("localization", "goal", place="Lab 2")  # odom began at RobotHome
    assert (goal["x"], goal["y"], goal["heading"]) == pytest.approx((-5.7, 0.0, 1.0), abs=0.1)
    assert lab.value("localization", "goal", x=8.2, y=5.9)["heading"] is None
    assert lab.value("localization", "goal", place="Bench", heading=2.0)["heading"] == pytest.approx(2.0, abs=0.05)
    for given, why in (
        ({"place": "Lab 3"}, "did you mean Lab 2?"),
        ({"place": "In the wall"}, "from a wall"),
        ({"place": "Kitchen"}, "in a forbidden area"),
        ({"x": 90.0, "y": 1.0}, "outside the map"),
        ({"x": "left", "y": 1.0}, "x must be a number"),
        ({}, "a name, or x and y"),
    ):
        assert why in lab.ask("localization", "goal", **given).why
    assert {each["name"] for each in lab.value("localization", "goals")} >= {"Lab 2", "Kitchen"}
    floor = FloorMap.of_json(lab.value("localization", "floor"))
    points = np.array([(13.7, 9.3), (10.0, 2.5)])  # in the forbidden area, at the bench
    assert floor.grid.values_at(points).tolist() == [0, 0]
    assert floor.grid.is_occupied().any()
    forbidden = replace(floor.grid, cells=floor.forbidden.astype(np.int8))
    assert forbidden.values_at(points).tolist() == [1, 0]


def test_what_cannot_be_started_is_refused_with_a_reason(lab: Lab, office: BuildingMap, tmp_path: Path) -> None:
    homeless = str(write_building_map(replace(office, places=()), tmp_path / "homeless.map")[0])
    half = tmp_path / "half.map"
    half.write_text(Path(homeless).read_text()[:300])
    for given, why in (
        ({"map": homeless}, "no RobotHome"),
        ({"map": str(half)}, "half.map:"),
        ({"map": str(tmp_path / "none.map")}, "cannot be read"),
        ({"map": homeless, "pose": "there"}, "pose must be"),
        ({"map": homeless, "pose": [99.0, 0.0, 0.0]}, "outside the map"),
        ({"map": homeless, "pose": [8.2, 6.1, 0.0], "settings": str(tmp_path / "none.toml")}, "cannot be read"),
    ):
        assert why in lab.ask("localization", "start", **given).why
    assert lab.value("localization", "state")["state"] == "stopped"


def test_a_localization_costs_nothing_before_and_after_and_takes_a_new_pose(lab: Lab, file: str) -> None:
    def hears() -> int:
        (agent,) = (each for each in lab.container.agents if each.name.local == "localization")
        assert isinstance(agent, LocalizationAgent)
        return len(agent.behaviours)

    before = hears()
    localized(lab, file, pose=[8.2, 6.1, 0.0])
    lab.value("localization", "set_pose", x=8.3, y=6.0, heading=0.1)
    lab.until(lambda: lab.value("localization", "state")["state"] == "localized")
    assert lab.value("localization", "stop")["state"] == "stopped"
    lab.run(0.1)
    assert hears() == before


@pytest.fixture
def _slow_reading(_without_thread: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let reading a map take 2 s."""

    async def slow(self: LocalizationAgent, job: Callable[[], T]) -> T:
        if self._tools is None:
            await asyncio.sleep(2.0)
        return job()

    monkeypatch.setattr(LocalizationAgent, "_in_thread", slow)


@pytest.mark.usefixtures("_slow_reading")
def test_a_stop_while_the_map_is_read_ends_the_start(lab: Lab, file: str) -> None:
    results = lab.results("localization")
    starting = lab.begin("localization", "start", map=file)
    lab.run(0.5)
    assert lab.value("localization", "stop") == {"state": "stopped"}
    assert "was stopped" in lab.do(starting).why
    lab.run(1.0)
    assert lab.value("localization", "state")["state"] == "stopped"
    assert results == []


@pytest.mark.usefixtures("_slow_reading")
def test_of_two_starts_the_later_one_localizes_the_robot(lab: Lab, file: str) -> None:
    first = lab.begin("localization", "start", map=file, pose=[2.5, 6.1, 0.0])
    lab.run(0.5)
    lab.value("localization", "start", map=file)
    assert "started again" in lab.do(first).why
    lab.until(lambda: lab.value("localization", "state")["state"] == "localized")
    assert lab.value("localization", "state")["pose"][:2] == pytest.approx([8.2, 6.1], abs=0.1)
    assert lab.value("localization", "stop")["state"] == "stopped"
    lab.run(1.0)
    assert lab.value("localization", "state")["state"] == "stopped"
