"""Plans made up by a seed, and worlds made harder: always passable, always the same for the same seed."""

from dataclasses import replace

import numpy as np
import pytest

from p2os_emu.world import World, WorldError, WorldSpec, load_world
from p2os_emu.world.conditions import RADIUS, with_obstacles, with_people
from p2os_emu.world.floors.plan import MOST_ROOMS, TURNING_ROOM, floor_plan
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.people import BODY_RADIUS
from p2os_emu.world.shortest_path import are_connected
from p2os_emu.world.spec import WallEntry

SEEDS = range(5)


@pytest.mark.parametrize("seed", SEEDS)
def test_in_every_plan_a_robot_gets_everywhere_and_can_turn_there(seed: int) -> None:
    plan = floor_plan(seed)
    places = list(plan.places.values())
    assert list(plan.places) == [f"room-{number}" for number in range(1, 7)] + ["corridor"]
    assert are_connected(FreeSpace(plan, RADIUS), places)
    assert FreeSpace(plan, TURNING_ROOM - 0.01).are_free(_table(places)).all()
    assert len(plan.furniture) >= 6


@pytest.mark.parametrize("seed", SEEDS)
def test_a_plan_has_a_way_round_for_some_door(seed: int) -> None:
    plan = floor_plan(seed)
    places = list(plan.places.values())
    doors = [door.name for door in plan.moving_doors]
    assert any(name.startswith("door between") for name in doors)
    assert any(are_connected(FreeSpace(plan, RADIUS, [name]), places) for name in doors if name.startswith("door of"))
    assert not are_connected(FreeSpace(plan, RADIUS, doors), places)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_leaf_that_stands_open_is_out_of_the_way(seed: int) -> None:
    plan = floor_plan(seed)
    with World(plan) as world:
        leaves = [each.footprint for each in world.moving if each.name in world.doors()]
    assert len(leaves) == len(plan.moving_doors)
    beside_walls = FreeSpace(replace(plan, furniture=()), 0.001)
    assert not any(beside_walls.is_free(corner) for leaf in leaves for corner in leaf)


def test_the_same_seed_makes_the_same_plan() -> None:
    assert floor_plan(3) == floor_plan(3)
    assert floor_plan(3) != floor_plan(4)
    assert load_world("plan:3") == floor_plan(3)
    assert floor_plan(3).name == "plan:3"


@pytest.mark.parametrize("rooms", [2, 3, 9])
def test_a_plan_has_as_many_rooms_as_wanted(rooms: int) -> None:
    plan = floor_plan(1, rooms=rooms)
    assert len(plan.places) == rooms + 1
    assert are_connected(FreeSpace(plan, RADIUS), list(plan.places.values()))


@pytest.mark.parametrize("rooms", [1, MOST_ROOMS + 1])
def test_a_plan_of_too_few_or_too_many_rooms_is_refused(rooms: int) -> None:
    with pytest.raises(WorldError, match=f"from 2 to {MOST_ROOMS} rooms, not {rooms}"):
        floor_plan(1, rooms=rooms)


@pytest.mark.parametrize("name", ["plan:", "plan:seven", "plan:1.5"])
def test_a_plan_needs_a_whole_number(name: str) -> None:
    with pytest.raises(WorldError, match="write a whole number, as in plan:7"):
        load_world(name)


@pytest.mark.parametrize("name", ["house", "office", "plan:5"])
def test_obstacles_leave_a_way_to_every_place(name: str) -> None:
    spec = load_world(name)
    harder = with_obstacles(spec, 7, 4)
    added = harder.objects[len(spec.objects) :]
    places = list(spec.places.values())
    assert [thing.name for thing in added] == [f"obstacle {number}" for number in (1, 2, 3, 4)]
    assert are_connected(FreeSpace(harder, RADIUS), places)
    assert FreeSpace(replace(harder, walls=(), furniture=()), 0.7).are_free(_table(places)).all()


def test_the_same_seed_makes_a_world_harder_in_the_same_way() -> None:
    plan = floor_plan(1, rooms=2)
    assert with_obstacles(plan, 7, 2) == with_obstacles(plan, 7, 2) != with_obstacles(plan, 8, 2)
    assert with_people(plan, 7, 2) == with_people(plan, 7, 2) != with_people(plan, 8, 2)


def test_obstacles_leave_people_their_routes() -> None:
    walked = with_people(floor_plan(2, rooms=4), 1, 3)
    space = FreeSpace(with_obstacles(walked, 1, 5), BODY_RADIUS)
    assert all(space.has_way(person.route) for person in walked.people)


@pytest.mark.parametrize("name", ["house", "plan:5"])
def test_people_walk_between_places_and_begin_away_from_robots(name: str) -> None:
    spec = load_world(name)
    start = spec.starts[0].x, spec.starts[0].y
    peopled = with_people(spec, 3, 10)
    assert len({person.name for person in peopled.people}) == 10
    assert all({person.route[0], person.route[-1]} <= set(spec.places.values()) for person in peopled.people)
    with World(peopled) as world:
        away = [((p.x - start[0]) ** 2 + (p.y - start[1]) ** 2) ** 0.5 for p in world.people().values()]
    assert min(away) >= 2.0


def test_too_many_obstacles_are_refused() -> None:
    corners = ((0.0, 0.0), (4.0, 0.0), (4.0, 2.5), (0.0, 2.5))
    walls = [WallEntry(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    closet = WorldSpec("closet", walls=tuple(block for wall in walls for block in wall.blocks()))
    with pytest.raises(WorldError, match="no room for 9 obstacles: ask for"):
        with_obstacles(replace(closet, places={"a": (0.8, 1.2), "b": (3.2, 1.2)}), 1, 9)


def test_a_world_without_places_cannot_be_made_harder() -> None:
    with pytest.raises(WorldError, match="needs two places"):
        with_obstacles(WorldSpec("floor"), 1, 1)


def _table(places: list[tuple[float, float]]) -> "np.ndarray[tuple[int, ...], np.dtype[np.float64]]":
    return np.array(places, np.float64)
