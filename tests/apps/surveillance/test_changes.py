"""What is not explained: people are found; walls, the team, furniture and a doubtful pose raise no alarm."""

from collections.abc import Sequence
from math import cos, pi, sin

import numpy as np
import pytest

from apps.surveillance.algorithms.changes import MapComparison, NearRobot, SeenFloor, UnexplainedThing
from apps.surveillance.algorithms.intruders import AlarmSensor, IntruderWatch, TeamAlarms
from apps.surveillance.settings import SurveillanceSettings
from geometry import Point, Pose2D
from p2os_emu.body import ScanBeams
from p2os_emu.world.objects import MovingObject
from p2os_emu.world.planar import PlanarScene
from tests.apps.surveillance.building import building_map, floor, world

SETTINGS = SurveillanceSettings.load()
HERE = Pose2D(1.0, 1.2, 0.0)
BEAMS, STEP = 181, pi / 180
COMPARISON = MapComparison(building_map(), floor(), SETTINGS.scan, SETTINGS.sonar, SETTINGS.member)
RNG = np.random.default_rng(0)


def disc(place: Point, radius: float) -> MovingObject:
    turns = np.linspace(0.0, 2 * pi, 12, endpoint=False).tolist()
    return MovingObject(
        "thing", tuple((place[0] + radius * cos(t), place[1] + radius * sin(t)) for t in turns), 0.0, 1.7
    )


def person(x: float, y: float) -> list[MovingObject]:
    return [disc((x, y - 0.08), 0.07), disc((x + 0.1, y + 0.08), 0.07)]


def chair(x: float, y: float) -> list[MovingObject]:
    return [disc((x + dx, y + dy), 0.015) for dx in (-0.17, 0.17) for dy in (-0.17, 0.17)]


def found(
    things: Sequence[MovingObject],
    pose: Pose2D = HERE,
    believed: Pose2D | None = None,
    robots: Sequence[NearRobot] = (),
    seen: SeenFloor | None = None,
    turn_rate: float = 0.0,
) -> list[UnexplainedThing]:
    """What a scan shows, made at a pose and compared at the one that is believed."""
    scene = PlanarScene(world().walls, lambda: tuple(things))
    echoes = scene.cast(ScanBeams(0.0, 0.0, 0.3, -pi / 2, STEP, BEAMS, 10.0), pose, "me")
    ranges = echoes.ranges + RNG.normal(0.0, 0.01, BEAMS)
    bearings = -pi / 2 + STEP * np.arange(BEAMS)
    ends = np.stack((ranges * np.cos(bearings), ranges * np.sin(bearings)), axis=1)[np.isfinite(ranges)]
    return COMPARISON.in_scan(believed or pose, ends, (0.0, 0.0), STEP, turn_rate, robots, seen)


def test_a_person_is_found_at_the_right_place() -> None:
    (thing,) = found(person(3.0, 1.6))
    assert (thing.x, thing.y) == pytest.approx((3.0, 1.6), abs=0.2)


@pytest.mark.parametrize("heading", np.linspace(-3.0, 3.0, 9).tolist())
def test_walls_are_nothing_unexplained_even_with_an_error_of_the_pose(heading: float) -> None:
    pose = Pose2D(2.0, 1.5, heading)
    assert found((), pose, Pose2D(2.05, 1.45, heading + 0.02)) == []


def test_a_robot_of_the_team_is_no_intruder_but_a_person_beside_it_is() -> None:
    robot = disc((2.6, 1.0), 0.22)
    assert len(found([robot])) == 1
    known = [NearRobot(2.6, 1.0, 0.1)]
    assert found([robot], robots=known) == []
    assert len(found([robot, *person(3.2, 2.2)], robots=known)) == 1


def test_a_robot_that_has_been_silent_may_be_farther_from_its_last_place() -> None:
    robot = disc((2.6, 1.0), 0.22)
    assert found([robot], robots=[NearRobot(2.0, 2.0, 0.0)])
    assert found([robot], robots=[NearRobot(2.0, 2.0, 2.0)]) == []


def test_the_legs_of_a_chair_are_no_person() -> None:
    for away in (1.8, 2.0, 2.2, 2.6, 3.0, 3.4):
        assert not any(thing.is_solid for thing in found(chair(away, 1.3)))


def test_a_leg_is_something_but_is_not_solid_as_a_person_is() -> None:
    (leg,) = found(person(2.2, 1.6)[:1])
    (whole,) = found(person(2.2, 1.6))
    assert (leg.is_solid, whole.is_solid) == (False, True)


def test_nothing_is_told_where_the_pose_is_in_doubt() -> None:
    assert found((), HERE, Pose2D(2.2, 2.2, 1.2)) == []


def test_what_stands_where_the_floor_was_never_free_is_furniture_and_what_comes_later_is_not() -> None:
    seen = SeenFloor(floor())
    box = [disc((3.0, 1.0), 0.2)]
    for _ in range(8):
        assert found(box, seen=seen) == []
    (thing,) = found([*box, *person(2.4, 2.0)], seen=seen)
    assert thing.y == pytest.approx(2.0, abs=0.2)
    # From another side furniture is still furniture.
    assert found(box, Pose2D(2.2, 2.2, -0.6), seen=seen) == []


def test_furniture_that_was_moved_is_an_intruder_until_it_is_expected() -> None:
    seen = SeenFloor(floor())
    for _ in range(8):
        found((), seen=seen)
    box = [disc((2.4, 1.5), 0.2)]
    (thing,) = found(box, seen=seen)
    seen.expect(np.array([[thing.x, thing.y]]))
    assert found(box, seen=seen) == []


def arcs(distance: float, bearing: float) -> np.ndarray:
    spread = bearing + np.linspace(-0.2, 0.2, 5)
    return np.stack((distance * np.cos(spread), distance * np.sin(spread)), axis=1)[np.newaxis]


def test_an_echo_of_the_sonar_before_the_walls_is_unexplained_and_one_from_them_is_not() -> None:
    assert COMPARISON.in_sonar(HERE, arcs(3.0, 0.0), ()) == []  # the wall between South and East
    (thing,) = COMPARISON.in_sonar(HERE, arcs(1.5, 0.0), ())
    assert (thing.x, thing.y) == pytest.approx((2.5, 1.2), abs=0.01)
    assert COMPARISON.in_sonar(HERE, arcs(1.5, 0.0), [NearRobot(2.5, 1.2, 0.0)]) == []


def test_what_the_sonar_hears_from_the_first_is_furniture() -> None:
    seen = SeenFloor(floor())
    for _ in range(8):
        assert COMPARISON.in_sonar(HERE, arcs(1.5, 0.0), (), seen) == []
        assert COMPARISON.in_sonar(HERE, arcs(2.4, 0.6), (), seen) == []
    assert len(COMPARISON.in_sonar(HERE, arcs(1.2, 0.6), (), seen)) == 1


def test_an_intruder_raises_one_alarm_once_it_was_seen_for_long_enough() -> None:
    watch = IntruderWatch(SETTINGS.alarm)
    told = [
        watch.take(0.2 * number, AlarmSensor.LASER, [UnexplainedThing(1.0 + 0.15 * number, 2.0)]) for number in range(9)
    ]
    assert [len(each) for each in told] == [0, 0, 0, 1, 0, 0, 0, 0, 0]
    assert watch.take(9.0, AlarmSensor.LASER, []) == []
    assert watch.intruders == []


def alarms_of(*sightings: UnexplainedThing) -> int:
    """How many alarms sightings raise, in one scan after the other."""
    watch = IntruderWatch(SETTINGS.alarm)
    return sum(len(watch.take(0.2 * number, AlarmSensor.LASER, [each])) for number, each in enumerate(sightings))


def test_of_somebody_who_walks_a_leg_is_enough_but_for_once() -> None:
    walking = [UnexplainedThing(1.0 + 0.15 * number, 2.0, is_solid=False) for number in range(12)]
    assert alarms_of(*walking) == 0
    assert alarms_of(*walking[:3], UnexplainedThing(1.45, 2.0), *walking[4:]) == 1


def test_two_legs_that_are_seen_apart_for_a_moment_are_one_person() -> None:
    watch = IntruderWatch(SETTINGS.alarm)
    alarms = 0
    for number in range(6):
        x = 1.0 + 0.15 * number
        legs = [UnexplainedThing(x - 0.2, 2.0, is_solid=False), UnexplainedThing(x + 0.2, 2.0, is_solid=False)]
        things = legs if number == 2 else [UnexplainedThing(x, 2.0)]
        alarms += len(watch.take(0.2 * number, AlarmSensor.LASER, things))
    assert alarms == 1


def test_a_chair_that_once_seemed_solid_raises_no_alarm_where_it_stands() -> None:
    standing = [UnexplainedThing(1.0 + 0.2 * (number % 2), 2.0, is_solid=number == 3) for number in range(40)]
    assert alarms_of(*standing) == 0


def test_flicker_raises_no_alarm() -> None:
    watch = IntruderWatch(SETTINGS.alarm)
    for number in range(20):
        place = UnexplainedThing(1.0 + 2.0 * (number % 3), 2.0)
        assert watch.take(2.0 * number, AlarmSensor.LASER, [place]) == []


def test_an_intruder_that_stands_still_for_minutes_becomes_furniture() -> None:
    watch, lasts = IntruderWatch(SETTINGS.alarm), SETTINGS.alarm.furniture_s
    for number in range(int(lasts) + 2):
        watch.take(float(number), AlarmSensor.LASER, [UnexplainedThing(1.0, 2.0)])
        if number < lasts:
            assert watch.settled(float(number)) == []
    assert len(watch.settled(lasts + 1.0)) == 1


def test_what_two_robots_see_at_one_place_is_one_intruder() -> None:
    alarms = TeamAlarms(SETTINGS.alarm)
    first, is_new = alarms.take(0.0, "happy", "laser", (1.0, 1.0))
    assert is_new
    again, is_new = alarms.take(2.0, "doc", "laser", (2.0, 1.5))
    assert (again, is_new) == (first, False)
    _, is_new = alarms.take(3.0, "doc", "laser", (7.0, 5.0))
    assert is_new
    _, is_new = alarms.take(3.0 + 2 * SETTINGS.alarm.same_s, "doc", "laser", (2.0, 1.5))
    assert is_new
