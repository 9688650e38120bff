"""Shortest ways for a disc: as long as geometry says, free all along, and none where there is none."""

from dataclasses import replace
from itertools import pairwise
from math import asin, atan2, dist, hypot, pi, sqrt
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry import Pose2D, Segment, polygon_edges
from p2os_emu.world import Block, MovingDoor, WorldSpec, load_world
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.shortest_path import are_connected, path_in, shortest_path
from p2os_emu.world.spec import DoorEntry, WallEntry

BOX = Block(0.0, 0.0, 0.0, 2.0, 2.0, 1.0)
RADIUS = 0.4
ROOM = WorldSpec("room", walls=tuple(WallEntry((0.0, -40.0), (0.0, 40.0), doors=(DoorEntry(40.0, 1.0),)).blocks()))


def test_a_free_way_is_straight() -> None:
    path = shortest_path(WorldSpec("floor"), (0.0, 0.0), (3.0, 4.0), RADIUS)
    assert path is not None
    assert path.points == ((0.0, 0.0), (3.0, 4.0))
    assert path.length == 5.0


def test_round_a_box_the_way_is_as_long_as_geometry_says() -> None:
    path = shortest_path(WorldSpec("box", walls=(BOX,)), (-3.0, 0.0), (3.0, 0.0), RADIUS)
    to_corner = hypot(2.0, 1.0)
    tangent = sqrt(to_corner**2 - RADIUS**2)
    arc = RADIUS * (atan2(1.0, 2.0) + asin(RADIUS / to_corner))
    assert path is not None
    assert path.length == pytest.approx(2 * (tangent + arc) + 2.0, rel=0.005)
    assert path.length >= 2 * (tangent + arc) + 2.0


@pytest.mark.parametrize("heading", [0.0, 0.3, pi / 4, -1.2])
def test_a_turned_world_has_turned_ways(heading: float) -> None:
    turn = Pose2D(1.0, 2.0, heading)
    box = Block(1.0, 2.0, heading, 2.0, 2.0, 1.0)
    straight = shortest_path(WorldSpec("box", walls=(BOX,)), (-3.0, 0.1), (3.0, 0.4), RADIUS)
    turned = shortest_path(WorldSpec("box", walls=(box,)), turn.transform(-3.0, 0.1), turn.transform(3.0, 0.4), RADIUS)
    assert straight is not None
    assert turned is not None
    assert turned.length == pytest.approx(straight.length)


def test_round_a_cylinder_the_way_keeps_both_radii_apart() -> None:
    post = Movable("post", Shape.CYLINDER, Pose2D(), 0.6, 0.6, 1.0, 9.0, 0.5, "red")
    path = shortest_path(WorldSpec("post", objects=(post,)), (-2.0, 0.0), (2.0, 0.0), RADIUS)
    radius = RADIUS + 0.3
    assert path is not None
    assert path.length == pytest.approx(2 * (sqrt(4.0 - radius**2) + radius * asin(radius / 2.0)), rel=0.01)


def test_a_disc_passes_doors_that_are_wide_enough() -> None:
    assert shortest_path(ROOM, (-2.0, 0.5), (2.0, 0.5), 0.49)
    wide = shortest_path(ROOM, (-2.0, 0.5), (2.0, 0.5), 0.51)
    assert wide is not None, "the wall ends somewhere"
    assert wide.length > 80.0


def test_a_shut_door_is_in_the_way_and_an_open_one_is_not() -> None:
    spec = replace(ROOM, moving_doors=(MovingDoor("door", (0.0, 0.0), (0.0, 1.0)),))
    opened, shut = (shortest_path(spec, (-1.0, 0.5), (1.0, 0.5), 0.3, shut=names) for names in ((), ("door",)))
    assert opened is not None
    assert opened.length == pytest.approx(2.0)
    assert shut is not None
    assert shut.length > 70.0


def test_there_is_no_way_out_of_a_closed_room_or_into_a_wall() -> None:
    corners = ((-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0))
    walls = tuple(
        block for a, b in zip(corners, corners[1:] + corners[:1], strict=True) for block in WallEntry(a, b).blocks()
    )
    spec = WorldSpec("cell", walls=(*walls, BOX))
    assert shortest_path(spec, (-2.0, 0.0), (5.0, 0.0), RADIUS) is None
    assert shortest_path(spec, (-2.0, 0.0), (0.0, 0.0), RADIUS) is None
    assert shortest_path(spec, (-2.9, 0.0), (-2.0, 0.0), RADIUS) is None, "too near to the wall to begin with"
    assert shortest_path(spec, (-2.0, 0.0), (2.0, 0.0), RADIUS)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=40, deadline=None)
def test_ways_are_free_all_along_and_no_longer_than_others(seed: int) -> None:
    random = Random(seed)
    blocks = tuple(
        Block(
            random.uniform(-4, 4),
            random.uniform(-4, 4),
            random.uniform(-pi, pi),
            random.uniform(0.1, 2.0),
            random.uniform(0.1, 2.0),
            1.0,
        )
        for _ in range(8)
    )
    space = FreeSpace(WorldSpec("heap", furniture=blocks), 0.3)
    a, b, c = ((random.uniform(-6, 6), random.uniform(-6, 6)) for _ in range(3))
    path = path_in(space, a, b)
    if path is None:
        return
    edges = [edge for block in blocks for edge in polygon_edges(block.footprint)]
    for (x1, y1), (x2, y2) in pairwise(path.points):
        for share in np.linspace(0.0, 1.0, 12):
            x, y = x1 + share * (x2 - x1), y1 + share * (y2 - y1)
            assert min(edge.distance_to(x, y) for edge in edges) >= 0.3 - 1e-3
            assert not any(block.contains(x, y) for block in blocks)
    assert path.length >= Segment(*a, *b).length - 1e-9
    back = path_in(space, b, a)
    assert back is not None
    assert back.length == pytest.approx(path.length)
    first, second = path_in(space, a, c), path_in(space, c, b)
    if first and second:
        assert path.length <= first.length + second.length + 1e-9


def test_the_house_is_one_whole_and_a_shut_door_lengthens_a_way() -> None:
    house = load_world("house")
    assert are_connected(FreeSpace(house, 0.42), list(house.places.values()))
    start, goal = house.places["living-room"], house.places["study"]
    direct = shortest_path(house, start, goal, 0.35)
    round_about = shortest_path(house, start, goal, 0.35, shut=["door between living room and study"])
    assert direct is not None
    assert round_about is not None
    assert direct.length < dist(start, goal) + 0.2
    assert round_about.length > direct.length + 2.0


def test_places_behind_a_wall_are_not_connected() -> None:
    cell = WorldSpec("cell", walls=(Block(0.0, 0.0, 0.0, 0.1, 40.0, 2.0),))
    assert are_connected(FreeSpace(cell, 0.3), [(-1.0, 0.0), (1.0, 0.0)]), "round the end of it"
    assert not are_connected(FreeSpace(cell, 0.3), [(-1.0, 0.0), (0.1, 0.0)])
    assert not are_connected(FreeSpace(load_world("office"), 0.6), [(8.2, 6.1), (8.2, 2.5)])
