"""A robot that has only sonar before something that may be a person, and before what is too large for one."""

from collections.abc import Callable

import pytest

from apps.indoor_navigation.algorithms.planning.area import OCCUPIED
from apps.indoor_navigation.algorithms.planning.grid import Grid
from apps.indoor_navigation.algorithms.planning.mission import Navigator
from apps.indoor_navigation.data import Floats, ObstRead, Place
from apps.indoor_navigation.parameters import shipped_parameters
from tests.apps.indoor_navigation.planning.house import HALF_WIDTH, House, Walker, shortest, still
from tests.apps.indoor_navigation.planning.sonar import RING, heard

MISSION = shipped_parameters("path_planning").mission
PARAMETERS = MISSION.guide.memory.grid
BOX = ((0.8, -0.25, 0.8, 0.25),)
WALL = ((0.8, -2.0, 0.8, 2.0),)


class SonarWalker(Walker):
    """A robot with sonar discs all about it, and nothing else."""

    def reading(self, lines: Floats) -> ObstRead:
        """What it hears."""
        return heard(self.pose, lines, self.time, RING)


def ring() -> House:
    """A corridor, and another one that leads round to its other end: 1.5 m wide, about a block."""
    return House([]).box(0.0, 0.0, 10.0, 5.4).box(1.5, 1.5, 7.0, 2.4)


def walks_on(at: Place, leaves: float) -> Callable[[float], Place]:
    """Somebody who stands at a place for so many s, and is gone then."""
    return lambda time: at if time < leaves else (-5.0, -5.0)


def sonar_walker(plan: House, pose: tuple[float, float, float]) -> SonarWalker:
    return SonarWalker(plan, Navigator(MISSION, HALF_WIDTH), pose)


def test_what_is_heard_first_and_is_no_larger_may_be_a_person_until_it_has_stood_for_too_long() -> None:
    grid = Grid(PARAMETERS)
    for step in range(round(PARAMETERS.stands / 0.1) + 10):
        grid.see(heard((0.0, 0.0, 0.0), BOX, step * 0.1))
        is_there = grid.area.evidence >= OCCUPIED
        if step == 50:
            assert grid.area.body[is_there].all()
            assert not grid.area.staying[is_there].any()
            assert not grid.area.fixed.any()
    assert not grid.area.body.any()
    assert grid.area.staying[is_there].all()
    assert grid.area.fixed[is_there].any()


def test_what_is_larger_is_no_person() -> None:
    grid = Grid(PARAMETERS)
    for step in range(20):
        grid.see(heard((0.0, 0.0, 0.0), WALL, step * 0.1))
    ahead = grid.area.around((0.8, 0.0), margin=0.45)
    assert (ahead.evidence >= OCCUPIED).any()
    assert not ahead.body.any()
    assert ahead.staying[ahead.evidence >= OCCUPIED].all()


@pytest.mark.parametrize("leaves", [8.0, 12.0])
def test_a_robot_with_only_sonar_waits_for_somebody_in_its_way_and_does_not_drive_round(leaves: float) -> None:
    plan = ring()
    plan.people = [walks_on((5.0, 0.75), leaves)]
    robot = sonar_walker(plan, (2.1, 0.75, 0.0))
    robot.go(8.0, 0.75)
    assert robot.run_to_end() == "done"
    assert "waiting" in robot.states
    assert robot.length < 1.5 * shortest(ring(), (2.1, 0.75), (8.0, 0.75))


def test_where_nobody_goes_away_it_drives_round_in_the_end() -> None:
    plan = ring()
    plan.people = [still((5.0, 0.75))]
    robot = sonar_walker(plan, (2.1, 0.75, 0.0))
    robot.go(8.0, 0.75)
    assert robot.run_to_end(240.0) == "done"
    assert max(y for _, y in robot.trail) > 4.0


def test_before_a_wall_it_turns_round_at_once() -> None:
    plan = House([]).box(0.0, 0.0, 12.0, 6.4).box(2.0, 2.0, 8.0, 2.4)
    plan.walls += [(6.0, 0.0, 6.0, 2.0)]
    robot = sonar_walker(plan, (3.5, 1.0, 0.0))
    robot.go(8.5, 1.0)
    assert robot.run_to_end(240.0) == "done"
    assert "waiting" not in robot.states
