"""Planning on the bus: what it hears, whom it tells what, and what becomes of it when others die."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.component import query_key, send_key
from apps.indoor_navigation.components.path_planning import PathPlanning
from apps.indoor_navigation.data import Data, DLEData, Door, GoalPoint, LogMessage, ObstRead, PlannedWay, WorldCoord
from bus import MemoryBus, Sample
from bus.messages import decode_json
from tests.apps.indoor_navigation.planning.house import House
from tests.apps.indoor_navigation.planning.on_a_map import Localization, floor_of
from tests.apps.indoor_navigation.site import ROBOT, Site

PROPERTIES = {
    "hears": [["obstacle_detecting", "ObstRead"], ["dle_detecting", "DLEData"]],
    "tells": {"WorldCoord": ["goto", "orienting"], "LogMessage": ["user_interface"]},
    "asks": {"load": "motion_fuser", "robot": "robot_base_server"},
    "numbers": {},
}
DOOR = Door(2.0, 0.0, 0.9, 0.0, 0.9)


BODY = {"width": 0.6, "front": 0.3, "rear": 0.5}  # m


class Others:
    """All components around planning, spoken for by the test.

    orders: what goto was told. log: what the person was told. busy: of the fuser.
    """

    def __init__(self, site: Site) -> None:
        self.site = site
        self.orders: list[WorldCoord] = []
        self.log: list[LogMessage] = []
        self.busy = 0.1
        self.x = 0.0
        site.bus.subscribe(send_key(ROBOT, "goto", WorldCoord), self._order)
        site.bus.subscribe(send_key(ROBOT, "user_interface", LogMessage), self._log)
        self.fuser = MemoryBus(site.network)
        self.fuser.serve(query_key(ROBOT, "motion_fuser", "load"), lambda arguments: {"busy": self.busy})
        self.base = MemoryBus(site.network)
        self.base.serve(query_key(ROBOT, "robot_base_server", "robot"), lambda arguments: BODY)

    def tell(self, goal: GoalPoint) -> None:
        self.site.bus.send(send_key(ROBOT, "path_planning", GoalPoint), goal.to_json())

    def see(self, seconds: float = 0.1, data: Data | None = None) -> None:
        """Open floor all around the robot."""
        for _ in range(round(seconds / 0.1)):
            angles, here = np.linspace(-3.1, 3.1, 90), np.ones(90)
            ends = self.x + 3.0 * np.cos(angles), 3.0 * np.sin(angles)
            pose = (self.x, 0.0, 0.0)
            free = ObstRead(self.site.time, pose, None, 0.0, self.x * here, 0.0 * here, *ends, 0.0 * here, False)
            self.site.push("obstacle_detecting", free)
            if data is not None:
                self.site.push("dle_detecting", data)
            self.site.run(0.1)

    def said(self) -> str:
        return "\n".join(f"{message.level} {message.what}" for message in self.log)

    def _order(self, sample: Sample) -> None:
        self.orders.append(WorldCoord.from_json(decode_json(sample.payload)))

    def _log(self, sample: Sample) -> None:
        self.log.append(LogMessage.from_json(decode_json(sample.payload)))


@pytest.fixture
def site() -> Iterator[Site]:
    loop = VirtualTimeLoop()
    site = Site(loop)
    yield site
    site.close()
    loop.close()


@pytest.fixture
def others(site: Site) -> Others:
    return Others(site)


def start(site: Site, **parameters: Any) -> None:
    site.start(PathPlanning(f"path_planning@{ROBOT}", {**PROPERTIES, "numbers": parameters}))


def test_a_goal_becomes_an_order_and_an_end(site: Site, others: Others) -> None:
    start(site)
    others.see(0.5)
    others.tell(GoalPoint("m1", 2.0, 0.0))
    others.see(0.3)
    assert (others.orders[-1].aim, others.orders[-1].is_last) == ("go", True)
    assert others.orders[-1].x == pytest.approx(2.0, abs=0.15)
    assert site.ask("path_planning", "state")["state"] == "going"
    while others.x < 1.9:
        others.x += 0.05
        others.see()
    others.see(0.4)
    state = site.ask("path_planning", "state")
    assert (state["state"], state["messages"]) == ("done", len(others.log))
    assert others.orders[-1].aim == "rest"
    assert "info done: there, after 1.8 m" in others.said()
    assert {message.mission for message in others.log} == {"m1"}


def test_an_order_is_told_again_and_keeps_its_number_while_it_is_the_same(site: Site, others: Others) -> None:
    start(site)
    others.see(0.5)
    others.tell(GoalPoint("m1", 2.0, 0.0))
    others.see(2.0)
    goes = [order for order in others.orders if order.aim == "go"]
    assert len(goes) == 4
    assert len({order.order for order in goes}) == 1


def test_a_planner_begun_anew_gives_higher_numbers(site: Site, others: Others) -> None:
    start(site)
    others.see(0.5)
    others.tell(GoalPoint("m1", 2.0, 0.0))
    others.see(1.0)
    site.kill("path_planning")
    start(site)
    others.see(0.5)
    others.tell(GoalPoint("m1", 2.0, 0.0))
    others.see(0.5)
    numbers = [order.order for order in others.orders]
    assert numbers == sorted(numbers)
    assert numbers[-1] > numbers[0]


def test_cancelled_the_robot_rests_at_once(site: Site, others: Others) -> None:
    start(site)
    others.see(0.5)
    others.tell(GoalPoint("m1", 2.0, 0.0))
    others.see(0.5)
    others.tell(GoalPoint("m1", None, None))
    site.run(0.01)
    assert others.orders[-1].aim == "rest"
    assert site.ask("path_planning", "state")["state"] == "cancelled"


def test_a_planner_that_is_stopped_leaves_nobody_on_the_way(site: Site, others: Others) -> None:
    start(site)
    others.see(0.5)
    others.tell(GoalPoint("m1", 2.0, 0.0))
    others.see(0.5)
    site.close()
    site.run(0.01)
    assert others.orders[-1].aim == "rest"


def test_without_obstacle_detecting_the_robot_rests_and_goes_on_when_it_is_back(site: Site, others: Others) -> None:
    start(site)
    others.see(0.5)
    others.tell(GoalPoint("m1", 2.0, 0.0))
    others.see(0.5)
    site.run(1.5)
    assert others.orders[-1].aim == "rest"
    assert "warning waiting: nothing is seen" in others.said()
    others.see(0.5)
    assert others.orders[-1].aim == "go"


def test_the_fuser_s_silence_is_said_once_and_stops_nobody(site: Site, others: Others) -> None:
    start(site)
    others.fuser.close()
    others.see(0.5)
    others.tell(GoalPoint("m1", 2.0, 0.0))
    others.see(2.0)
    assert others.orders[-1].aim == "go"
    assert others.said().count("the fuser does not say how it is") == 1


def test_a_fuser_that_is_busy_is_spared(site: Site, others: Others) -> None:
    start(site)
    others.busy = 0.95
    others.see(0.5)
    others.tell(GoalPoint("m1", 2.0, 0.0))
    others.see(0.5)
    assert others.orders[-1].speed == 0.25
    assert "the fuser is busy 95% of its time" in others.said()


def test_the_robot_says_how_large_it_is(site: Site, others: Others) -> None:
    component = PathPlanning(f"path_planning@{ROBOT}", PROPERTIES)
    site.start(component)
    site.run(0.1)
    assert component._navigator.memory.outline == Outline(0.3, 0.5, 0.6)


def test_doors_are_kept_in_a_file_and_known_again(site: Site, others: Others, tmp_path: Path) -> None:
    path = tmp_path / "doors.json"
    start(site, doors_file=str(path))
    others.see(0.5, DLEData(site.time, (0.0, 0.0, 0.0), (DOOR,)))
    others.tell(GoalPoint("m1", 0.1, 0.0))
    others.see(0.5)
    assert path.exists()
    site.kill("path_planning")
    start(site, doors_file=str(path))
    (door,) = site.ask("path_planning", "picture")["doors"]
    assert door["x"] == pytest.approx(2.0)


def test_a_file_that_cannot_be_used_is_told_and_left_alone(site: Site, others: Others, tmp_path: Path) -> None:
    path = tmp_path / "doors.json"
    path.write_text("dear to somebody")
    start(site, doors_file=str(path))
    assert "remove it to begin a new one" in site.reports[0]
    others.see(0.5)
    others.tell(GoalPoint("m1", 0.1, 0.0))
    others.see(0.5)
    assert path.read_text() == "dear to somebody"


def test_a_picture_can_be_asked_for_at_any_time(site: Site, others: Others) -> None:
    start(site)
    assert site.ask("path_planning", "picture")["grid"]["runs"] == []
    others.see(0.5)
    assert site.ask("path_planning", "picture")["pose"] == [0.0, 0.0, 0.0]


def test_whoever_watches_gets_the_whole_plan_with_the_doors_until_the_mission_has_ended(
    site: Site, others: Others
) -> None:
    start(site)
    others.see(1.5, DLEData(0.0, (0.0, 0.0, 0.0), (DOOR,)))
    others.tell(GoalPoint("m1", 8.0, 0.0))
    others.see(0.5)
    plans = site.pushed("path_planning", PlannedWay)
    others.see(2.0)
    assert 3 <= len(plans) <= 5  # two a second
    plan = plans[-1]
    assert (plan.mission, plan.route[:2]) == ("m1", (0.0, 0.0))
    assert plan.route[-2:] == pytest.approx((8.0, 0.0), abs=0.3)  # the goal, though the next piece ends at the door
    assert [door.x for door in plan.doors] == pytest.approx([DOOR.x])
    others.tell(GoalPoint("m1", None, None))
    others.see(2.0)
    assert plans[-1].route == ()
    count = len(plans)
    others.see(2.0)
    assert len(plans) == count, "without a mission there is no plan to tell"


def test_a_goal_that_is_none_is_refused_in_words(site: Site, others: Others) -> None:
    start(site)
    others.see(0.5)
    site.bus.send(
        send_key(ROBOT, "path_planning", GoalPoint), {"mission": "m1", "x": "far", "y": 0.0, "tolerance": 0.2}
    )
    others.see(0.3)
    assert "error failed: x 'far', y 0.0, heading None, tolerance 0.2 is not a valid goal" in others.said()


@pytest.fixture
def localization(site: Site) -> Localization:
    agent = Localization(site, floor_of(House([]).box(-6.0, -6.0, 12.0, 12.0)))
    site.start(agent)
    return agent


def drive(others: Others, localization: Localization, seconds: float) -> None:
    for _ in range(round(seconds / 0.1)):
        localization.say()
        others.see()


def test_a_mission_on_the_map_follows_the_localization_and_stops_when_it_is_lost(
    site: Site, others: Others, localization: Localization
) -> None:
    start(site)
    drive(others, localization, 0.5)
    others.tell(GoalPoint("m1", 2.8, 3.0, frame="map"))  # 2 m ahead, and 0.1 m to the right
    drive(others, localization, 1.0)
    assert localization.asked == 1
    assert (others.orders[-1].aim, others.orders[-1].is_last) == ("go", True)
    assert (others.orders[-1].x, others.orders[-1].y) == pytest.approx((2.06, 0.01), abs=0.25)
    assert site.ask("path_planning", "state")["frame"] == "map"
    localization.place = [1.0, 1.5, 0.5]  # odometry has drifted
    drive(others, localization, 0.5)
    assert (others.orders[-1].x, others.orders[-1].y) == pytest.approx((2.30, 0.45), abs=0.25)
    localization.place = None
    drive(others, localization, 0.5)
    assert others.orders[-1].aim == "rest"
    assert "warning lost: the robot has lost its place on the map: it fits no place" in others.said()
    assert site.ask("path_planning", "state")["state"] == "lost"
    localization.place = [1.0, 1.5, 0.5]
    drive(others, localization, 0.5)
    assert others.orders[-1].aim == "go"
    assert "the robot knows its place on the map again" in others.said()


def test_a_localization_that_dies_on_the_way_is_said_and_the_robot_goes_on_by_odometry(
    site: Site, others: Others, localization: Localization
) -> None:
    start(site)
    drive(others, localization, 0.5)
    others.tell(GoalPoint("m1", 2.8, 3.0, frame="map"))
    drive(others, localization, 0.5)
    site.kill("localization")
    others.see(5.0)
    assert others.orders[-1].aim != "rest"
    assert others.said().count("the localization is silent; the robot continues by its odometry") == 1


def test_without_the_map_of_the_localization_the_robot_drives_by_its_sensors(
    site: Site, others: Others, localization: Localization
) -> None:
    localization.refuses = "there is no map"
    start(site)
    drive(others, localization, 0.5)
    others.tell(GoalPoint("m1", 2.0, 0.0))
    drive(others, localization, 5.0)
    assert others.orders[-1].x == pytest.approx(2.0, abs=0.2)
    assert others.said().count("the map does not come: refused: there is no map") == 1
    assert 2 <= localization.asked <= 5


def test_the_map_of_another_localization_is_requested_anew(
    site: Site, others: Others, localization: Localization
) -> None:
    start(site)
    drive(others, localization, 1.0)
    site.kill("localization")
    other = Localization(site, floor_of(House([]).box(-9.0, -9.0, 18.0, 18.0)), number=2)
    site.start(other)
    drive(others, other, 3.0)
    assert (localization.asked, other.asked) == (1, 1)
    assert site.ask("path_planning", "picture")["grid"]["columns"] > 300
