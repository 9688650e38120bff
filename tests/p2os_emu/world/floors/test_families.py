"""Every family of generated floors: passable for a PowerBot, tight somewhere, the same for the same seed."""

from dataclasses import replace
from functools import cache
from math import atan2, pi

import numpy as np
import pytest

import configs
from p2os import RobotModel
from p2os_emu.lists import listing
from p2os_emu.world import World, WorldError, WorldSpec, load_world
from p2os_emu.world.conditions import with_obstacles, with_people
from p2os_emu.world.floors.building import HALF_WIDTH, PASSAGE, PASSING, TIGHT, TURNING_ROOM
from p2os_emu.world.floors.families import FAMILIES
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.shortest_path import are_connected, shortest_path
from tools.floor_picture import FILE, SEED, draw, names

NEW = [family for family in FAMILIES if family != "plan"]
SEEDS = range(2)
floor = cache(load_world)

EVERY = pytest.mark.parametrize("name", [f"{family}:{seed}" for family in NEW for seed in SEEDS])
ONE_EACH = pytest.mark.parametrize("name", names(SEED))
"""The floors of the picture in the documentation: each takes a while to make, and is made once."""


def places_of(spec: WorldSpec) -> "np.ndarray[tuple[int, ...], np.dtype[np.float64]]":
    return np.array(list(spec.places.values()), np.float64)


@EVERY
def test_a_powerbot_gets_from_every_place_to_every_other_and_turns_there(name: str) -> None:
    spec = floor(name)
    assert spec.name == name
    assert are_connected(FreeSpace(spec, PASSING), list(spec.places.values()))
    assert FreeSpace(spec, TURNING_ROOM - 0.005).are_free(places_of(spec)).all()


@EVERY
def test_some_place_is_reached_by_a_tight_passage_only(name: str) -> None:
    spec = floor(name)
    assert not are_connected(FreeSpace(spec, HALF_WIDTH + TIGHT[1] + 0.005), list(spec.places.values()))


@EVERY
def test_a_floor_has_places_to_go_to_and_passages_and_a_size_of_buildings(name: str) -> None:
    spec = floor(name)
    passages = [place for place in spec.places if place.startswith(PASSAGE)]
    assert len(spec.places) >= 6
    assert 1 <= len(passages) < len(spec.places) - 1
    (left, bottom), (right, top) = (
        extreme([corner for wall in spec.walls for corner in wall.footprint], axis=0) for extreme in (np.min, np.max)
    )
    assert 60.0 < (right - left) * (top - bottom) < 400.0
    assert len(spec.furniture) >= 6


@ONE_EACH
def test_a_shortest_way_leads_from_the_first_place_to_the_last(name: str) -> None:
    spec = floor(name)
    first, *_, last = spec.places.values()
    assert shortest_path(spec, first, last, PASSING)


@ONE_EACH
def test_leaves_that_stand_open_are_out_of_the_way(name: str) -> None:
    spec = floor(name)
    beside_walls = FreeSpace(replace(spec, furniture=()), 0.001)
    with World(spec) as world:
        leaves = [each.footprint for each in world.moving if each.name in world.doors()]
    assert not any(beside_walls.is_free(corner) for leaf in leaves for corner in leaf)
    assert len({door.name for door in spec.moving_doors}) == len(spec.moving_doors)


@ONE_EACH
def test_a_powerbot_can_stand_and_turn_at_every_start(name: str) -> None:
    spec = floor(name)
    model = configs.load(RobotModel, "robots", "powerbot-sh")
    with World(spec, perfect=True) as world:
        world.add_robot("robot", model)
        for start in spec.starts:
            world.place("robot", start)
            world.place("robot", replace(start, heading=start.heading + pi / 2))


@pytest.mark.parametrize("family", ["flat"])
def test_people_and_obstacles_find_room_on_a_narrow_floor(family: str) -> None:
    spec = with_obstacles(with_people(floor(f"{family}:0"), 2, 2), 2, 1)
    assert (len(spec.people), len(spec.objects)) == (2, 1)
    assert are_connected(FreeSpace(spec, PASSING), list(spec.places.values()))
    with World(spec) as world:
        world.step()


def test_only_glass_and_tables_are_missed_by_scanners() -> None:
    assert sum(wall.glass for wall in floor("glass:0").walls) > 10
    assert not any(wall.glass for family in NEW if family != "glass" for wall in floor(f"{family}:0").walls)
    assert sum(block.bottom > 0.0 for block in floor("desks:0").furniture) > 20


def test_a_skew_building_has_no_right_angles() -> None:
    walls = [wall for wall in floor("skew:0").walls if wall.length > 1.0]
    headings = [
        atan2(wall.footprint[1][1] - wall.footprint[0][1], wall.footprint[1][0] - wall.footprint[0][0])
        for wall in walls
    ]
    assert all(min(heading % (pi / 2), pi / 2 - heading % (pi / 2)) > 0.01 for heading in headings)


def test_branching_corridors_have_dead_ends() -> None:
    assert sum(name.startswith("end-") for name in floor("culs:0").places) >= 3


def test_the_same_seed_makes_the_same_floor_in_every_process() -> None:
    """The picture of the documentation was drawn by another process, with other hashes."""
    assert FILE.read_text(encoding="utf-8") == draw([floor(name) for name in names(SEED)], SEED), (
        "if it is meant: python tools/floor_picture.py"
    )


def test_another_seed_makes_another_floor() -> None:
    assert all(floor(f"{family}:0").walls != floor(f"{family}:1").walls for family in FAMILIES)


@pytest.mark.parametrize("name", ["hall:", "hall:x", "hall:1.5"])
def test_a_floor_needs_a_whole_number(name: str) -> None:
    with pytest.raises(WorldError, match=f"{name} is no floor: write a whole number, as in hall:7"):
        load_world(name)


def test_a_family_without_a_number_is_told_what_is_missing() -> None:
    with pytest.raises(WorldError, match="store is a family of floors: write a whole number behind it, as in store:7"):
        load_world("store")


def test_a_misspelt_family_gets_a_suggestion() -> None:
    with pytest.raises(WorldError, match="there is no family of floors 'corridor'; did you mean corridors"):
        load_world("corridor:7")


def test_the_list_of_worlds_names_every_family() -> None:
    rows = listing("worlds").splitlines()
    assert all(any(row.startswith(f"{family}:SEED ") for row in rows) for family in FAMILIES)
