"""Maps of two robots in one building: how they lie is found, and what does not fit is refused."""

from functools import cache
from math import hypot

import numpy as np
import pytest

from geometry import Cairn, Pose2D, Segment, wrap_angle
from maps.building.building import map_of
from maps.building.laser_builder import LaserMapBuilder
from maps.building.merging import NoOverlap, merged, placed
from maps.building.surfaces import map_at
from maps.building_map import BuildingMap
from tests.maps.building.drawn_rooms import drive, ring, room


@cache
def part(*way: tuple[float, float]) -> BuildingMap:
    """A map of what is seen on a way, in the frame of the rooms."""
    builder = LaserMapBuilder(origin=Pose2D(*way[0], np.arctan2(way[1][1] - way[0][1], way[1][0] - way[0][0])))
    for _, view in drive(ring(), way, seed=4, drift=0.005):
        builder.add(view)
    return map_of(builder.keys)


SOUTH = ((2.0, 2.0), (7.0, 2.0), (6.5, 3.0))
NORTH = ((7.0, 7.0), (2.5, 6.6), (2.5, 2.2))


@pytest.mark.parametrize("pose", [Pose2D(4.0, -3.0, 2.5), Pose2D(-1.0, 0.5, -0.4)])
def test_maps_that_share_a_room_are_placed_exactly(pose: Pose2D) -> None:
    theirs = map_at(part(*NORTH), Pose2D().relative_to(pose))
    placement = placed(part(*SOUTH), theirs)
    assert hypot(placement.pose.x - pose.x, placement.pose.y - pose.y) < 0.08
    assert abs(wrap_angle(placement.pose.heading - pose.heading)) < 0.02
    assert placement.against < 0.03


def test_the_joined_map_shows_all_rooms_once() -> None:
    pose = Pose2D(4.0, -3.0, 2.5)
    goal = Cairn("Goal", Pose2D(7.0, 7.0), "kitchen")
    theirs = map_at(part(*NORTH).with_places(goal), Pose2D().relative_to(pose))
    made, _ = merged(part(*SOUTH), theirs)
    assert made.bounds == pytest.approx((0.0, 0.0, 9.1, 9.1), abs=0.7)
    walls = ring()
    lines = [line for line in made.lines if line.length > 0.5]
    for line in lines:
        middle = (line.x1 + line.x2) / 2, (line.y1 + line.y2) / 2
        assert min(wall.distance_to(*middle) for wall in walls) < 0.08
    assert [round(made.goal("kitchen").pose.x), round(made.goal("kitchen").pose.y)] == [7, 7]
    assert made.grid is not None
    assert made.grid.values_at(np.array([[7.0, 1.5], [2.0, 6.0]])).tolist() == [0, 0]


def test_places_of_both_maps_are_kept_unless_they_coincide() -> None:
    pose = Pose2D(4.0, -3.0, 2.5)

    def line(*ends: float) -> Cairn:
        return Cairn("ForbiddenLine", Pose2D(), "", Segment(*ends))

    def area(*corners: float) -> Cairn:
        return Cairn("ForbiddenArea", Pose2D(), "", Segment(*corners))

    common = (line(1.0, 1.0, 2.0, 1.0), area(1.0, 3.0, 2.0, 4.0), Cairn("Goal", Pose2D(2.0, 2.0), "door"))
    others = (line(6.0, 7.0, 7.0, 7.0), area(7.0, 7.5, 8.0, 8.0), Cairn("Dock", Pose2D(7.0, 7.0), ""))
    elsewhere = Cairn("Goal", Pose2D(7.0, 7.0), "lab")
    ours = part(*SOUTH).with_places(
        *common, Cairn("Dock", Pose2D(2.0, 3.0), ""), Cairn("Goal", Pose2D(6.5, 3.0), "lab")
    )
    theirs = map_at(part(*NORTH).with_places(*common, *others, elsewhere), Pose2D().relative_to(pose))
    made, _ = merged(ours, theirs)
    assert made.places[: len(ours.places)] == ours.places
    added = made.places[len(ours.places) :]
    assert [each.kind for each in added] == ["ForbiddenLine", "ForbiddenArea", "Dock", "Goal"]
    assert made.is_forbidden(7.5, 7.75)
    assert made.forbidden_lines[1] == pytest.approx((6.0, 7.0, 7.0, 7.0), abs=0.1)
    assert [(round(each.pose.x), round(each.pose.y)) for each in added[2:]] == [(7, 7), (7, 7)]


def test_maps_without_a_common_room_are_refused() -> None:
    hall = BuildingMap((*room(0.0, 0.0, 14.0, 2.2), Segment(3.0, 0.0, 3.0, 1.0), Segment(9.0, 1.2, 9.0, 2.2)))
    with pytest.raises(NoOverlap, match=r"same rooms|several ways"):
        placed(part(*NORTH), hall)


def test_a_map_with_hardly_any_walls_is_refused() -> None:
    with pytest.raises(NoOverlap, match="hardly any walls"):
        placed(part(*SOUTH), BuildingMap((Segment(0.0, 0.0, 0.5, 0.0),)))
