"""People who walk: read from files, walking by the seed, seen by every sensor, waiting for robots."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import hypot, inf, pi
from pathlib import Path
from random import Random

import numpy as np
import pytest

from geometry import Pose2D
from p2os.robot_model import RobotModel
from p2os_emu.body import ScanBeams
from p2os_emu.world import STEP, Block, Person, World, WorldError, WorldSpec, load_world
from p2os_emu.world.people import BODY_RADIUS, HIP, LEG_RADIUS, STEP_LENGTH, PersonRoute
from p2os_emu.world.walk import Walk
from p2os_emu.world.walkers import LOOK_AHEAD

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]

ANNA = Person("Anna", ((0.0, 0.0), (4.0, 0.0)), speed=1.0)
ROUND = Person("Bert", ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0)), loops=True, speed=0.5)
BEAMS = ScanBeams(x=0.0, y=0.0, height=0.3, first=-pi / 4, step=pi / 720, count=361, reach=8.0)
FILE = """
about = "somebody"

[[people]]
name = "Anna"
route_m = [[0.0, 0.0], [4.0, 0.0]]
loop = true
begin_m = 1.0
speed_m_s = 1.2
pause_s = [1.0, 2.0]
gives_way = false
patience_s = [3.0, 5.0]
colour = "green"
"""


def run(world: World, seconds: float) -> None:
    for _ in range(round(seconds / STEP)):
        world.step()


def walk(person: Person, seconds: float, seed: int = 0) -> list[Pose2D]:
    way = Walk(person, Random(seed))
    places = []
    for _ in range(round(seconds / STEP)):
        way.advance(STEP, is_blocked=False)
        places.append(way.place)
    return places


def test_people_are_read_from_a_world_file(tmp_path: Path) -> None:
    path = tmp_path / "street.toml"
    path.write_text(FILE)
    route = ((0.0, 0.0), (4.0, 0.0))
    assert load_world(path).people == (Person("Anna", route, True, 1.0, 1.2, (1.0, 2.0), False, (3.0, 5.0), "green"),)


@pytest.mark.parametrize(
    ("before", "after", "reason"),
    [
        ("[[0.0, 0.0], [4.0, 0.0]]", "[[0.0, 0.0]]", r"people\[0\] Anna: route_m needs two waypoints"),
        ("[[0.0, 0.0], [4.0, 0.0]]", "[[1.0, 0.0], [1.0, 0.0]]", "no two neighbours alike"),
        ("speed_m_s = 1.2", "speed_m_s = 12", "speed_m_s must be from 0.1 to 2.0, not 12"),
        ("pause_s = [1.0, 2.0]", "pause_s = [2.0, 1.0]", "pause_s must be a shortest and a longest time"),
        ("patience_s = [3.0, 5.0]", "patience_s = [-3.0, 5.0]", "patience_s must be"),
        ("begin_m = 1.0", "begin_m = 9.0", "begin_m must be from 0 to 8.00"),
        ('"green"', '"gren"', "did you mean green"),
        ("route_m", "rout_m", "rout_m.*route_m"),
    ],
)
def test_people_that_make_no_sense_are_refused_with_a_reason(
    before: str, after: str, reason: str, tmp_path: Path
) -> None:
    path = tmp_path / "street.toml"
    path.write_text(FILE.replace(before, after))
    with pytest.raises(WorldError, match=reason):
        load_world(path)


def test_nobody_walks_through_a_wall(make_world: MakeWorld) -> None:
    wall = Block(2.0, 0.0, pi / 2, 2.0, 0.1, 2.0)
    with pytest.raises(WorldError, match=r"Anna cannot walk from \[0.0, 0.0\] to \[4.0, 0.0\]"):
        make_world(WorldSpec("walled", walls=(wall,), people=(ANNA,)))


def test_somebody_walks_there_and_back_at_their_speed() -> None:
    places = walk(ANNA, 8.0)
    assert places[round(2.0 / STEP) - 1].x == pytest.approx(2.0, abs=0.01)
    assert places[round(5.0 / STEP) - 1].x == pytest.approx(3.0, abs=0.02)
    assert places[round(1.0 / STEP)].heading == 0.0
    assert abs(places[round(5.0 / STEP)].heading) == pytest.approx(pi)


def test_a_loop_is_walked_round_and_round() -> None:
    length = PersonRoute(ROUND.route, loops=True).length
    assert length == pytest.approx(4.0 + hypot(2.0, 2.0))
    places = walk(ROUND, 2 * length / 0.5)
    for lap in (1, 2):
        here = places[round(lap * length / 0.5 / STEP) - 1]
        assert hypot(here.x, here.y) < 0.05
    assert max(place.y for place in places) == pytest.approx(2.0, abs=0.01)


def test_pauses_are_drawn_between_the_shortest_and_the_longest() -> None:
    person = replace(ANNA, pause=(1.0, 3.0))
    rests = {}
    for seed in range(10):
        standing = [a for a, b in zip(*[iter(walk(person, 8.0, seed))] * 2, strict=False) if a == b]
        rests[seed] = len(standing) * 2 * STEP
    assert all(0.95 <= rest <= 3.05 for rest in rests.values())
    assert len({round(rest, 2) for rest in rests.values()}) > 5


def test_who_is_blocked_waits_and_then_turns_back() -> None:
    way = Walk(replace(ANNA, patience=(2.0, 2.0)), Random(0))
    for _ in range(round(1.0 / STEP)):
        way.advance(STEP, is_blocked=False)
    for _ in range(round(1.9 / STEP)):
        way.advance(STEP, is_blocked=True)
    assert (way.place.x, way.place.heading) == pytest.approx((1.0, 0.0))
    for _ in range(round(0.2 / STEP)):
        way.advance(STEP, is_blocked=True)
    assert way.place.x == pytest.approx(1.0)
    assert abs(way.place.heading) == pytest.approx(pi)


def test_the_foot_that_bears_stands_still_while_the_body_moves_over_it() -> None:
    way = Walk(ANNA, Random(0))
    left = []
    for _ in range(round(2.0 / STEP)):
        way.advance(STEP, is_blocked=False)
        left.append(way.place.x + way.stride)
    moves = [b - a for a, b in pairwise(left)]
    stands = sum(abs(move) < 1e-9 for move in moves) / len(moves)
    assert stands == pytest.approx(0.5, abs=0.1)
    assert max(moves) == pytest.approx(2 * STEP, abs=1e-6), "the other foot swings at twice the speed"


def test_legs_stay_within_the_body() -> None:
    assert hypot(STEP_LENGTH / 2, HIP) + LEG_RADIUS <= BODY_RADIUS


def test_a_scanner_sees_two_legs_that_move(model: Models, make_world: MakeWorld) -> None:
    standing = Person("Anna", ((2.0, -2.0), (2.0, 2.0)), begin=2.0, speed=0.5)
    world = make_world(WorldSpec("street", people=(standing,)))
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D())

    def legs() -> list[float]:
        """Bearings of the middles of what is seen."""
        seen = np.flatnonzero(body.scan(BEAMS).ranges < 3.0)
        runs = np.split(seen, np.flatnonzero(np.diff(seen) > 1) + 1)
        return [float(BEAMS.first + BEAMS.step * run.mean()) for run in runs]

    counts = set()
    for _ in range(40):
        run(world, 0.05)
        counts.add(len(legs()))
    assert counts == {1, 2}, "one leg hides the other now and then"
    assert float(np.mean(legs())) == pytest.approx(0.45, abs=0.15), "they have walked on to the left"


def test_sonar_hears_a_body(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WorldSpec("street", people=(Person("Anna", ((2.0, 0.0), (2.0, 4.0)), speed=1.0),)))
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D())
    run(world, STEP)
    assert min(body.ping([3, 4])) == pytest.approx(2.0 - BODY_RADIUS - body.model.sonar[3].x, abs=0.05)
    run(world, 3.0)
    assert min(body.ping([3, 4])) == inf


def test_a_polite_person_stops_short_of_a_robot_and_turns_back(model: Models, make_world: MakeWorld) -> None:
    polite = replace(ANNA, patience=(2.0, 2.0))
    world = make_world(WorldSpec("street", people=(polite,)))
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D(3.0, 0.0, pi))
    run(world, 3.5)
    place = world.people()["Anna"]
    assert not place.walks
    gap = 3.0 - body.chassis.front - BODY_RADIUS - place.x
    assert LOOK_AHEAD - 0.05 <= gap <= LOOK_AHEAD
    run(world, 1.5)
    assert world.people()["Anna"].x < place.x
    assert world.touches("robot").count == 0


def test_a_polite_person_walks_on_when_the_robot_has_gone(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WorldSpec("street", people=(replace(ANNA, patience=(60.0, 60.0)),)))
    world.add_robot("robot", model("p3dx-sh"), Pose2D(3.0, 0.0, pi))
    run(world, 5.0)
    stood = world.people()["Anna"].x
    world.place("robot", Pose2D(3.0, 3.0, 0.0))
    run(world, 1.0)
    assert world.people()["Anna"].x > stood + 0.8


def test_who_does_not_give_way_bumps_into_the_robot_and_stops(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WorldSpec("street", people=(replace(ANNA, gives_way=False, patience=(60.0, 60.0)),)))
    world.add_robot("robot", model("p3dx-sh"), Pose2D(3.0, 0.0, pi))
    run(world, 6.0)
    touches = world.touches("robot")
    assert [touch.what for touch in touches.last] == ["Anna"]
    assert world.truth("robot").pose.x == pytest.approx(3.0, abs=0.1), "it is bumped into, not carried along"


def test_a_bumper_feels_a_person(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WorldSpec("street", people=(replace(ANNA, gives_way=False),)))
    body = world.add_robot("robot", model("powerbot-sh"), Pose2D(2.0, 0.0, pi))
    pressed = 0
    for _ in range(round(3.0 / STEP)):
        world.step()
        pressed |= body.state.front_bumpers
    assert pressed == 1 << 3, "the middle one of seven"


def test_no_robot_is_put_onto_a_person(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WorldSpec("street", people=(ANNA,)))
    with pytest.raises(WorldError, match="Anna is in the way"):
        world.add_robot("robot", model("p3dx-sh"), Pose2D(0.3, 0.0, 0.0))
    world.add_robot("robot", model("p3dx-sh"))
    pose = world.truth("robot").pose
    assert hypot(pose.x, pose.y) > 0.5


def test_the_same_seed_walks_the_same_way(model: Models, make_world: MakeWorld) -> None:
    def places(seed: int) -> object:
        world = make_world(load_world("people-lab"), perfect=False, seed=seed)
        world.add_robot("robot", model("p3dx-sh"))
        run(world, 20.0)
        return world.people(), world.doors(), world.truth("robot")

    assert places(1) == places(1)
    assert places(1) != places(2)
