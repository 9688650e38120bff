"""Passages of a map, and who waits before them."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from apps.indoor_navigation.algorithms.planning import driving
from apps.indoor_navigation.algorithms.planning.passages import NarrowPassages, PassageAhead, together
from apps.indoor_navigation.algorithms.planning.right_of_way import RightOfWay
from apps.indoor_navigation.data import Place
from tests.apps.indoor_navigation.planning.house import House, Walker, house
from tests.apps.indoor_navigation.planning.on_a_map import MapWalker, floor_of


def two_rooms(gap: tuple[float, float] = (1.45, 2.55)) -> House:
    """Two rooms of 4 m, and a corridor of 4 m between them, 1.1 m wide."""
    low, high = gap
    plan = House([(0.0, 0.0, 4.0, 0.0), (0.0, 4.0, 4.0, 4.0), (0.0, 0.0, 0.0, 4.0)])
    plan.walls += [(8.0, 0.0, 12.0, 0.0), (8.0, 4.0, 12.0, 4.0), (12.0, 0.0, 12.0, 4.0)]
    plan.walls += [(4.0, low, 8.0, low), (4.0, high, 8.0, high)]
    plan.walls += [(x, y, x, to) for x in (4.0, 8.0) for y, to in ((0.0, low), (high, 4.0))]
    return plan


def found(plan: House) -> NarrowPassages:
    return NarrowPassages.of(floor_of(plan))


def test_doors_and_narrow_corridors_are_passages_and_corners_are_not() -> None:
    doors = np.array([((ax + bx) / 2, (ay + by) / 2) for ax, ay, bx, by in house().doors])
    assert (found(house()).at(*doors.T) > 0).all()
    assert len(found(two_rooms()).names) == 1
    assert not found(House([]).box(0.0, 0.0, 6.0, 6.0)).names
    assert not found(two_rooms((0.8, 3.2))).names  # 2.4 m wide


def test_robots_with_the_same_map_find_the_same_passages_and_with_another_one_others() -> None:
    assert found(house()).names == found(house()).names
    assert not set(found(house()).names) & set(found(two_rooms()).names)


def test_a_way_leads_through_passages_in_turn() -> None:
    passages = found(two_rooms())
    (passage,) = passages.along(np.array([(2.0, 2.0), (10.0, 2.0)]))
    assert passage.enters == pytest.approx(2.0, abs=0.3)
    assert passage.leaves == pytest.approx(6.0, abs=0.3)
    assert passages.along(np.array([(2.0, 1.0), (2.0, 3.0)])) == []
    assert passages.along(np.empty((0, 2))) == []
    assert passages.around((6.0, 2.0), 0.3) == {passage.name}
    assert not passages.around((2.0, 2.0), 0.3)


def test_passages_without_room_to_wait_between_them_are_taken_together() -> None:
    passages = [PassageAhead("a", 1.0, 1.5), PassageAhead("b", 2.0, 2.5), PassageAhead("c", 5.0, 6.0)]
    assert [passage.name for passage in together(passages)] == ["a", "b"]
    assert together([]) == []


class _Arbiter:
    """Gives each passage to one robot at a time, as the leases of an arbiter do."""

    def __init__(self) -> None:
        self._holders: dict[str, str] = {}

    def serve(self, name: str, rights: RightOfWay) -> None:
        held = {passage for passage, holder in self._holders.items() if holder == name}
        for passage in held - set(rights.needed):
            del self._holders[passage]
        missing = set(rights.needed) - held
        if not any(passage in self._holders for passage in missing):
            self._holders |= dict.fromkeys(missing, name)
        theirs = {passage: holder for passage, holder in self._holders.items() if holder != name}
        rights.grant({passage for passage, holder in self._holders.items() if holder == name}, theirs)


def place_of(robot: MapWalker) -> Callable[[float], Place]:
    return lambda time: (robot.x, robot.y)


def bars(rights: RightOfWay) -> bool:
    return rights.barred is not None


def meeting(plan: House, goals: Sequence[tuple[tuple[float, float, float], tuple[float, float]]]) -> list[MapWalker]:
    """Robots in one house that set out at the same time, each of which sees the others; returns when all have ended."""
    arbiter, robots = _Arbiter(), list[MapWalker]()
    floor = floor_of(plan)
    for start, _ in goals:
        robots.append(MapWalker(House(list(plan.walls)), start, floor))
    for number, (robot, (_, goal)) in enumerate(zip(robots, goals, strict=True)):
        robot.plan.people = [place_of(other) for other in robots if other is not robot]
        name = f"robot-{number}"

        def ask(robot: Walker, name: str = name) -> None:
            arbiter.serve(name, robot.navigator.rights)

        robot.meanwhile = ask
        robot.go_to(*goal)
    while any(robot.navigator.is_active for robot in robots) and robots[0].time < 150.0:
        for robot in robots:
            robot.step()
    return robots


def test_two_robots_that_meet_at_a_corridor_agree_who_waits_and_both_arrive() -> None:
    robots = meeting(two_rooms(), [((2.0, 2.0, 0.0), (10.0, 1.0)), ((10.0, 2.2, 3.1), (2.0, 3.0))])
    assert [robot.navigator.state for robot in robots] == ["done", "done"]
    assert min(robot.nearest for robot in robots) > 0.2
    said = ["\n".join(note.what for note in robot.navigator.notes) for robot in robots]
    assert sum("passes a narrow place" in each for each in said) == 1
    assert max(robot.time for robot in robots) < 60.0


def test_a_passage_that_is_never_given_back_is_entered_in_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(driving, "PATIENCE", 6.0)
    robot = MapWalker(two_rooms(), (2.0, 2.0, 0.0), floor_of(two_rooms()))
    robot.go_to(6.0, 2.0)
    robot.meanwhile = lambda robot: robot.navigator.rights.grant(
        set(), dict.fromkeys(robot.navigator.rights.needed, "grumpy")
    )
    robot.run(8.0)
    assert robot.x < 3.6
    assert "grumpy passes a narrow place" in "\n".join(note.what for note in robot.navigator.notes)
    assert robot.run_to_end() == "done"


def test_without_an_arbiter_robots_drive_by_their_sensors() -> None:
    rights = RightOfWay()
    rights.use_map(floor_of(two_rooms()))
    rights.look((3.0, 2.0), ((3.0, 2.0), (6.0, 2.0)), frozenset())
    assert len(rights.needed) == 1
    assert not bars(rights)
    rights.grant(set(), {})
    assert bars(rights)
    rights.grant(set(rights.needed), {})
    assert not bars(rights)
