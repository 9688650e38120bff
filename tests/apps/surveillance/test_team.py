"""A team on patrol in virtual time: the agents of the application, and robots that are played."""

import base64
import shutil
from collections.abc import Callable, Iterator
from math import dist
from pathlib import Path
from typing import Any

import pytest

from agents.components.camera import MOST
from apps.surveillance.algorithms.neglect import RoomVisit
from apps.surveillance.settings import SurveillanceSettings
from benchmarks.surveillance_course import SurveillanceCourse
from benchmarks.surveillance_robots import ORIGIN, PICTURE, PlayedIntruder
from bus import keys
from geometry import Pose2D
from tests.apps.surveillance.building import DOC, HAPPY, ROOMS, floor, map_file, world

SETTINGS = SurveillanceSettings.load()
NEVER = 1e6  # s between two scans
Make = Callable[..., SurveillanceCourse]


@pytest.fixture
def make(tmp_path: Path) -> Iterator[Make]:
    made = []

    def begin(
        *intruders: PlayedIntruder, starts: dict[str, Pose2D] | None = None, scan_s: float = NEVER, **options: Any
    ) -> SurveillanceCourse:
        given = {"happy": HAPPY, "doc": DOC} if starts is None else starts
        course = SurveillanceCourse(
            world(), map_file(tmp_path), floor(), ROOMS, given, SETTINGS, intruders=intruders, scan_s=scan_s, **options
        )
        made.append(course)
        assert course.run_until(lambda: len(course.manager.market.assigned) == len(ROOMS), 10.0)
        return course

    yield begin
    for course in made:
        course.close()
        assert course.errors == []


def told(course: SurveillanceCourse) -> list[str]:
    return [str(event["text"]) for event in course.manager.events]


def moves(course: SurveillanceCourse, robot: str) -> bool:
    before = course.robots[robot].driven
    course.run(2.0)
    return course.robots[robot].driven > before


def begin_driving(course: SurveillanceCourse, robot: str) -> None:
    """Let time pass until a robot is well on its way."""
    assert course.run_until(lambda: len(course.robots[robot].way) > 0, 30.0)
    course.run(0.5)


def test_all_rooms_are_taken_by_bids_and_visited_again_and_again(make: Make) -> None:
    course = make()
    assert set(course.manager.market.assigned.values()) == {"happy", "doc"}
    course.run(80.0)
    status = course.manager.state_of_patrol()
    assert all(room["visits"] >= 2 for room in status["rooms"].values())
    periods = [robot["period"] for robot in status["robots"].values()]
    assert status["longest"] <= 1.5 * max(periods)


def test_maps_show_to_which_room_a_robot_drives(make: Make) -> None:
    course = make()
    shown: list[dict[str, Any]] = []
    course.listen(keys.OVERLAY.key("happy", "surveillance"), shown.append)
    begin_driving(course, "happy")
    assert course.run_until(lambda: bool(shown and shown[-1]["lines"]), 5.0)
    room = course.manager.state_of_patrol()["robots"]["happy"]["next"]
    assert shown[-1]["words"] == f"drives to {room}"
    assert shown[-1]["frame"] == "odom"
    assert shown[-1]["lines"][0][2:] == pytest.approx(ORIGIN.locate(*ROOMS[room]), abs=0.01)


def test_the_rooms_of_a_robot_that_dies_are_auctioned_again(make: Make) -> None:
    course = make()
    course.run(20.0)
    course.kill("doc")
    assert course.run_until(lambda: list(course.manager.market.assigned.values()) == ["happy"] * 4, 5.0)
    assert any("doc leaves the patrol" in text for text in told(course))


def test_a_robot_that_falls_silent_is_stopped_and_its_rooms_are_auctioned_again(make: Make) -> None:
    course = make()
    begin_driving(course, "doc")
    course.freeze("doc")
    assert course.run_until(lambda: list(course.manager.market.assigned.values()) == ["happy"] * 4, 8.0)
    assert not moves(course, "doc")
    assert any("doc leaves the patrol: has been silent" in text for text in told(course))


def test_a_robot_that_joins_gets_rooms(make: Make) -> None:
    course = make(starts={"happy": HAPPY})
    assert set(course.manager.market.assigned.values()) == {"happy"}
    course.add("doc", DOC)
    assert course.run_until(lambda: list(course.manager.market.assigned.values()).count("doc") == 2, 15.0)


def test_a_robot_that_is_lost_stands_at_once_and_its_rooms_are_auctioned_again(make: Make) -> None:
    course = make()
    begin_driving(course, "doc")
    course.robots["doc"].is_lost = True
    course.run(1.5)
    assert not moves(course, "doc")
    assert course.run_until(lambda: list(course.manager.market.assigned.values()) == ["happy"] * 4, 8.0)
    course.robots["doc"].is_lost = False
    assert course.run_until(lambda: "doc" in course.manager.market.assigned.values(), 15.0)


def test_a_robot_stands_as_soon_as_its_localization_tells_that_it_is_lost_and_drives_on_afterwards(make: Make) -> None:
    course = make()
    begin_driving(course, "doc")
    course.robots["doc"].is_lost = True
    course.run(0.5)
    assert not moves(course, "doc")
    course.robots["doc"].is_lost = False
    course.run(1.0)
    assert moves(course, "doc")
    assert not any("doc leaves the patrol" in text for text in told(course))


@pytest.mark.parametrize("is_same_map", [True, False])
def test_a_robot_that_is_localized_anew_ends_its_patrol_and_joins_again_only_on_the_same_map(
    make: Make, tmp_path: Path, is_same_map: bool
) -> None:
    course = make()
    begin_driving(course, "doc")
    doc = course.robots["doc"]
    if not is_same_map:
        doc.map = str(shutil.copy(map_file(tmp_path), tmp_path / "another.map"))
    doc.started += 1
    course.run(0.5)
    assert course.run_until(lambda: "doc" not in course.manager.market.assigned.values(), 1.0)
    assert not moves(course, "doc")
    assert any("its localization was started again" in text for text in told(course))
    assert course.run_until(lambda: "doc" in course.manager.market.assigned.values(), 20.0) is is_same_map
    if not is_same_map:
        assert course.run_until(lambda: "another.map" in course.manager.members["doc"].trouble, 6.0)


def test_robots_stand_when_the_manager_has_gone(make: Make) -> None:
    course = make()
    begin_driving(course, "doc")
    course.kill_manager()
    course.run(1.0)
    assert not moves(course, "doc")
    assert not moves(course, "happy")


def test_robots_stand_when_the_heartbeat_of_the_manager_stops(make: Make) -> None:
    course = make()
    begin_driving(course, "doc")
    course.freeze_manager()
    course.run(1.0)
    assert not moves(course, "doc")
    assert not moves(course, "happy")


def test_nobody_patrols_when_the_program_does_not_ask_any_more(make: Make) -> None:
    course = make()
    begin_driving(course, "doc")
    course.manager.properties["attention"] = 2.0
    course.run(5.0)
    assert course.manager.serving == []
    assert not moves(course, "doc")


def test_a_robot_that_another_program_drives_leaves_its_rooms_to_others_and_is_left_alone(make: Make) -> None:
    course = make()
    begin_driving(course, "doc")
    robot = course.robots["doc"]
    robot.mission, robot.way = "another", [(6.0, 5.5)]
    assert course.run_until(lambda: list(course.manager.market.assigned.values()) == ["happy"] * 4, 10.0)
    assert any("another program drives it" in text for text in told(course))


def test_a_room_that_one_robot_cannot_reach_is_taken_by_another(make: Make) -> None:
    course = make()
    owner = course.manager.market.assigned["Far"]
    course.block(owner, ROOMS["Far"])
    other = "happy" if owner == "doc" else "doc"
    assert course.run_until(lambda: course.manager.market.assigned.get("Far") == other, 200.0)
    assert any(f"{owner} cannot reach Far: no way" in text for text in told(course))


def test_an_intruder_raises_one_alarm_and_the_nearest_robot_follows_it(make: Make) -> None:
    walk = ((3.4, 0.6), (3.4, 2.4), (1.8, 2.2), (1.8, 3.4), (1.2, 5.0))
    course = make(PlayedIntruder(walk, 30.0, 0.5, 40.0), scan_s=0.2)
    assert course.run_until(lambda: 0 in course.reported, 80.0)
    assert course.reported[0] - course.visible[0] <= 3.0
    (alarm,) = course.manager.state_of_patrol()["alarms"]
    follower = str(alarm["follower"])
    places = {name: (each.pose.x, each.pose.y) for name, each in course.robots.items()}
    here = alarm["x"], alarm["y"]
    assert follower == min(places, key=lambda name: floor().length(places[name], here))
    assert course.run_until(lambda: course.time >= 62.0, 60.0)
    pose, place = course.robots[follower].pose, course.intruders[0].place(course.time)
    assert place is not None
    assert dist((pose.x, pose.y), place) < 3.5
    assert course.run_until(lambda: course.manager.state_of_patrol()["alarms"][0]["follower"] is None, 60.0)
    assert len(course.manager.alarms.alarms) == 1
    count = len(visits(course))
    assert course.run_until(lambda: follower in {each.robot for each in visits(course)[count:]}, 60.0)


def test_an_intruder_behind_a_wall_is_not_visible_where_beams_end_at_the_wall(make: Make) -> None:
    outside = 8.1, 4.8
    course = make(PlayedIntruder((outside, outside), 0.0), scan_s=0.5, starts={"doc": Pose2D(6.0, 4.5, 0.0)})
    course.run(5.0)
    assert course.visible == {}


def test_while_a_robot_is_lost_an_alarm_says_that_it_may_be_that_robot_and_nobody_follows(make: Make) -> None:
    course = make(PlayedIntruder(((1.2, 4.8), (2.6, 4.2)), 80.0, 0.05), scan_s=0.2)
    course.robots["doc"].is_lost = True
    assert course.run_until(lambda: bool(course.manager.alarms.alarms), 200.0)
    course.run(1.0)
    (alarm,) = course.manager.state_of_patrol()["alarms"]
    assert (alarm["may_be"], alarm["follower"]) == (["doc"], None)
    assert any("it may be doc, which is not localized" in text for text in told(course))
    course.robots["doc"].is_lost = False
    assert course.run_until(lambda: bool(course.manager.state_of_patrol()["alarms"][0]["follower"]), 40.0)
    assert course.manager.state_of_patrol()["alarms"][0]["may_be"] == []


def test_robots_that_meet_raise_no_alarm(make: Make) -> None:
    course = make(scan_s=0.5, starts={"happy": HAPPY, "doc": Pose2D(2.6, 1.2, 3.1)})
    course.run(40.0)
    assert course.manager.alarms.alarms == []
    assert course.false_sightings == 0


def look(course: SurveillanceCourse, robot: str, blob: dict[str, float]) -> None:
    """Wait until a robot has stood for a while and looks, and have something move in a few of its images."""
    looks = f"looks in {course.manager.state_of_patrol()['robots'][robot]['next']}"
    assert course.run_until(lambda: str(course.manager.members[robot].state["does"]).startswith("looks in"), 60.0), (
        looks
    )
    course.run(1.4)
    for _ in range(5):
        course.show_motion(robot, [blob])
        course.run(0.2)


def test_what_moves_before_the_camera_of_a_standing_robot_raises_an_alarm_with_a_picture(make: Make) -> None:
    course = make(view=1.0, starts={"happy": HAPPY})
    look(course, "happy", {"area": 10.0, "x": 50.0})
    assert course.manager.alarms.alarms == []  # too small
    course.run(4.0)
    look(course, "happy", {"area": 400.0, "x": 50.0})
    (alarm,) = course.manager.alarms.alarms
    assert (alarm.robot, alarm.sensor) == ("happy", "camera")
    pictures = [event["picture"] for event in course.manager.events if "picture" in event]
    assert [base64.b64decode(each["data"]) for each in pictures] == [PICTURE]


def ask(course: SurveillanceCourse, request: str, **arguments: Any) -> Any:
    """The result of a request to the manager, which must be done."""
    manager = course.manager
    return course.loop.run_until_complete(manager.request(manager.name, request, **arguments)).value()


def test_events_with_the_largest_pictures_are_told_in_several_replies(make: Make) -> None:
    course = make()
    picture = {"stamp": 1.0, "format": "jpeg", "data": base64.b64encode(bytes(MOST)).decode()}
    for alarm in range(1, 31):
        event = {"number": len(course.manager.events), "time": 1.0, "text": f"alarm {alarm}", "alarm": alarm}
        course.manager.events.append(event | ({"picture": picture} if alarm < 4 else {}))
    replies: list[list[dict[str, Any]]] = []
    while events := ask(course, "events", number=sum(map(len, replies))):
        replies.append(events)
    assert [event for events in replies for event in events] == list(course.manager.events)
    assert max(map(len, replies)) <= 20


def test_the_status_has_the_newest_alarms(make: Make) -> None:
    course = make()
    for number in range(2000):
        course.manager.alarms.take(course.time, "happy", "laser", (100.0 * number, 0.0))
    assert [alarm["number"] for alarm in ask(course, "status")["alarms"]] == list(range(1801, 2001))


def test_a_robot_of_the_team_that_drives_before_the_camera_raises_no_alarm(make: Make) -> None:
    course = make(view=1.0)
    assert course.run_until(lambda: str(course.manager.members["doc"].state["does"]).startswith("looks in"), 60.0)
    doc = course.robots["doc"].pose
    course.share_pose("stranger", doc.compose(Pose2D(1.5, 0.0, 0.0)))
    course.run(1.4)
    for _ in range(5):
        course.show_motion("doc", [{"area": 400.0, "x": 50.0}])
        course.run(0.2)
    assert course.manager.alarms.alarms == []


def test_a_robot_that_is_charged_leaves_its_rooms_to_others_and_joins_again_afterwards(make: Make) -> None:
    course = make()
    course.run(5.0)
    course.share_battery("doc", 0.5, charging=True)
    assert course.run_until(lambda: list(course.manager.market.assigned.values()) == ["happy"] * 4, 3.0)
    assert "doc leaves the patrol: doc is being charged" in told(course)
    course.share_battery("doc", 0.5, charging=False)
    assert course.run_until(lambda: "doc" in course.manager.market.assigned.values(), 15.0)
    course.share_battery("doc", 0.1, charging=False)
    assert course.run_until(lambda: list(course.manager.market.assigned.values()) == ["happy"] * 4, 3.0)
    assert "doc leaves the patrol: doc has to be charged: its battery is at 10%" in told(course)


def test_without_a_navigation_robots_drive_along_the_map_and_stand_when_the_manager_has_gone(make: Make) -> None:
    course = make(starts={"happy": HAPPY}, scan_s=0.4, navigates=False)
    assert course.run_until(lambda: len({visit.room for visit in visits(course)}) == 4, 90.0)
    begin_driving(course, "happy")
    course.kill_manager()
    course.run(1.0)
    assert not moves(course, "happy")


def test_without_a_navigation_a_robot_makes_way_for_another_one_and_drives_on_afterwards(make: Make) -> None:
    course = make(starts={"happy": HAPPY}, scan_s=0.4, navigates=False)
    course.add_stander("stranger", Pose2D(4.0, 2.6, 3.1))  # in the door between South and East
    assert course.run_until(
        lambda: course.manager.members["happy"].state["does"] == "makes way for another robot", 60.0
    )
    came_from = ROOMS[visits(course)[-1].room]
    robot = course.robots["happy"]
    assert course.run_until(lambda: dist((robot.pose.x, robot.pose.y), came_from) < 0.6, 20.0)
    assert course.run_until(lambda: len(robot.way) > 0, 15.0)
    assert course.manager.serving == ["happy"]


def test_a_robot_that_stands_where_it_came_from_makes_way_into_another_room(make: Make) -> None:
    course = make(starts={"happy": Pose2D(6.0, 1.6, 1.57)}, scan_s=0.4, navigates=False)
    course.add_stander("stranger", Pose2D(6.3, 2.4, -1.57))  # on the way to the next room, and wants to come here
    assert course.run_until(
        lambda: course.manager.members["happy"].state["does"] == "makes way for another robot", 60.0
    )
    robot = course.robots["happy"]
    assert course.run_until(lambda: robot.pose.x < 3.0, 30.0)
    assert course.manager.members["happy"].state["does"] == "makes way for another robot"
    assert course.manager.serving == ["happy"]


def test_ways_aside_do_not_lead_past_the_other_robot() -> None:
    robot, other = (6.0, 1.8), (5.3, 1.9)
    assert [room for room, place in ROOMS.items() if floor().leads_away(robot, place, other)] == ["East", "Far"]
    assert floor().leads_away(robot, ROOMS["South"], (6.0, 4.0))


def test_without_a_navigation_a_robot_backs_off_from_what_stalls_it_and_drives_on(make: Make) -> None:
    course = make(starts={"happy": HAPPY}, scan_s=0.4, navigates=False)
    robot = course.robots["happy"]
    course.run(5.0)
    robot.stalls, seen = 2, len(visits(course))
    assert course.run_until(lambda: robot.stalls == 0, 30.0)
    assert course.run_until(lambda: len(visits(course)) > seen, 40.0)
    assert robot.backed == pytest.approx(0.4, abs=0.01)
    assert course.manager.serving == ["happy"]


def visits(course: SurveillanceCourse) -> list[RoomVisit]:
    return [] if course.manager.ledger is None else course.manager.ledger.visits
