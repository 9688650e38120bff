"""What is remembered of doors and of the ways between them."""

from math import pi
from pathlib import Path

import pytest

from apps.indoor_navigation.algorithms.planning.doors_map import DoorsMap, thinned
from apps.indoor_navigation.data import DLEData, Door
from apps.indoor_navigation.parameters import shipped_parameters

PARAMETERS = shipped_parameters("path_planning").mission.guide.memory.doors

DOOR = Door(2.0, 3.0, 0.9, 0.0, 0.9)


def seen(*doors: Door, times: int = 3) -> DoorsMap:
    doors_map = DoorsMap(PARAMETERS)
    for _ in range(times):
        doors_map.see(DLEData(0.0, (0.0, 0.0, 0.0), doors))
    return doors_map


def test_sightings_of_one_door_become_one_door() -> None:
    doors_map = seen(DOOR)
    doors_map.see(DLEData(0.0, (0.0, 0.0, 0.0), (Door(2.2, 3.0, 1.1, pi, 0.9),)))  # from behind
    (door,) = doors_map.doors
    assert door.x == pytest.approx(2.05)
    assert door.width == pytest.approx(0.95)
    assert abs(door.normal) < 1e-6


def test_doors_apart_or_in_other_walls_are_two() -> None:
    doors_map = seen(DOOR, Door(2.0, 4.0, 0.9, 0.0, 0.9), Door(2.1, 3.1, 0.9, pi / 2.0, 0.9))
    assert len(doors_map.believed) == 3


def test_a_door_is_believed_when_it_was_seen_often_and_surely_or_gone_through() -> None:
    assert not seen(DOOR, times=2).believed
    assert not seen(Door(2.0, 3.0, 0.9, 0.0, 0.3), times=9).believed
    doors_map = seen(DOOR, times=1)
    doors_map.passed(0)
    assert doors_map.believed


@pytest.mark.parametrize(
    ("start", "end", "through"),
    [
        ((1.0, 3.2), (3.0, 3.0), (0, 1.0)),
        ((3.0, 3.2), (1.0, 3.0), (0, -1.0)),
        ((1.0, 3.8), (3.0, 3.8), None),
        ((1.0, 3.0), (1.9, 3.0), None),
        ((2.0, 2.0), (2.0, 4.0), None),
    ],
)
def test_who_goes_through_a_door_is_noticed(
    start: tuple[float, float], end: tuple[float, float], through: tuple[int, float] | None
) -> None:
    assert seen(DOOR).crossed(start, end) == through


def test_between_two_doors_the_shortest_way_is_kept() -> None:
    doors_map = seen(DOOR, Door(8.0, 3.0, 0.9, 0.0, 0.9))
    doors_map.gone(0, 1, [(2.0, 3.0), (5.0, 6.0), (8.0, 3.0)])
    doors_map.gone(1, 0, [(8.0, 3.0), (5.0, 4.0), (2.0, 3.0)])
    doors_map.gone(0, 1, [(2.0, 3.0), (5.0, 7.0), (8.0, 3.0)])
    assert [way.points for way in doors_map.ways] == [((8.0, 3.0), (5.0, 4.0), (2.0, 3.0))]


def test_a_file_brings_back_what_is_believed(tmp_path: Path) -> None:
    doors_map = seen(Door(9.0, 9.0, 0.9, 0.0, 0.1), DOOR, Door(8.0, 3.0, 0.9, 0.0, 0.9))
    doors_map.gone(1, 2, [(2.0, 3.0), (8.0, 3.0)])
    doors_map.gone(2, None, [(8.0, 3.0), (9.0, 3.0)])
    doors_map.write(tmp_path / "doors.json")
    again = DoorsMap(PARAMETERS)
    again.read(tmp_path / "doors.json")
    assert again.doors == doors_map.doors[1:]
    assert [(way.start, way.end) for way in again.ways] == [(0, 1), (1, None)]


def test_a_file_that_is_not_there_is_no_error(tmp_path: Path) -> None:
    doors_map = DoorsMap(PARAMETERS)
    doors_map.read(tmp_path / "doors.json")
    assert doors_map.doors == []


@pytest.mark.parametrize(
    "text",
    [
        "no JSON",
        "[]",
        '{"doors": [{"x": 1.0}], "ways": []}',
        '{"doors": [], "ways": [{"from": 3, "to": "place", "points": [[0, 0]]}]}',
        '{"doors": [{"x": "a", "y": 1, "width": 1, "normal": 1, "confidence": 1}], "ways": []}',
    ],
)
def test_a_file_that_cannot_be_used_is_told_and_leaves_the_map_as_it_is(tmp_path: Path, text: str) -> None:
    doors_map, path = seen(DOOR), tmp_path / "doors.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"the map of doors .* cannot be used: .*; remove it to begin a new one"):
        doors_map.read(path)
    assert len(doors_map.doors) == 1


def test_a_thinned_trail_keeps_its_ends() -> None:
    trail = [(0.1 * step, 0.0) for step in range(18)]
    points = thinned(trail)
    assert (points[0], points[-1]) == (trail[0], trail[-1])
    assert len(points) == 5
