"""What rays leave behind in the grid."""

from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apps.indoor_navigation.algorithms.planning.area import undrawn
from apps.indoor_navigation.algorithms.planning.grid import Grid
from apps.indoor_navigation.data import ObstRead
from apps.indoor_navigation.parameters import shipped_parameters
from tests.apps.indoor_navigation.planning.house import House
from tests.apps.indoor_navigation.planning.on_a_map import floor_of

SHIPPED = shipped_parameters("path_planning").mission.guide.memory.grid
PARAMETERS = replace(SHIPPED, resolution=0.1)

Ray = tuple[float, float, bool]  # end, and whether it hits

SOMEWHERE = st.floats(-7.0, 7.0)


def reading(*rays: Ray, pose: tuple[float, float, float] = (0.0, 0.0, 0.0), stamp: float = 0.0) -> ObstRead:
    """Each ray twice, as if a scanner had sent them."""
    rays = (*rays, *rays)
    ends = np.array([(x, y) for x, y, _ in rays], np.float64).reshape(-1, 2)
    origins = np.ones(len(rays)) * pose[0], np.ones(len(rays)) * pose[1]
    hits = np.array([float(hit) for _, _, hit in rays])
    return ObstRead(stamp, pose, None, 0.0, *origins, ends[:, 0], ends[:, 1], hits, False)


def occupied(grid: Grid, x: float, y: float) -> bool:
    return bool(grid.area.occupied[grid.area.cell(x, y)])


def unknown(grid: Grid, x: float, y: float) -> bool:
    return bool(grid.area.unknown[grid.area.cell(x, y)])


def test_a_hit_is_an_obstacle_and_all_before_it_is_free() -> None:
    grid = Grid(PARAMETERS)
    grid.see(reading((3.05, 0.05, True)))
    assert occupied(grid, 3.05, 0.05)
    assert not unknown(grid, 1.05, 0.05)
    assert not occupied(grid, 1.05, 0.05)
    assert unknown(grid, 3.25, 0.05)
    assert unknown(grid, 1.05, 0.5)


def test_the_surface_in_a_cell_is_where_it_is_hit() -> None:
    grid, rng = Grid(PARAMETERS), np.random.default_rng(1)
    for _ in range(20):
        grid.see(reading((3.02 + rng.normal(0.0, 0.005), 0.05, True)))
    row, column = grid.area.cell(3.02, 0.05)
    assert grid.area.place(row, column)[0] + grid.area.surface_x[row, column] == pytest.approx(3.02, abs=0.01)


def test_sonar_is_believed_near_by_only() -> None:
    grid = Grid(PARAMETERS)
    ends, hits = np.array([3.05, 0.85]), np.ones(2)
    sonar = ObstRead(
        0.0, (0.0, 0.0, 0.0), None, 0.0, np.array([0.0, 0.1]), np.array([0.05, 0.55]), ends, ends, hits, False
    )
    grid.see(sonar)
    assert not occupied(grid, 3.05, 3.05)
    assert occupied(grid, 0.85, 0.85)


def test_a_ray_that_only_ends_says_nothing_of_its_end() -> None:
    grid = Grid(PARAMETERS)
    grid.see(reading((3.05, 0.05, False)))
    assert not occupied(grid, 3.05, 0.05)


def test_somebody_who_has_walked_on_is_forgotten_within_a_second_of_readings() -> None:
    grid = Grid(PARAMETERS)
    for _ in range(50):
        grid.see(reading((3.05, 0.05, True)))
    for _ in range(10):
        grid.see(reading((5.05, 0.05, True)))
    assert not occupied(grid, 3.05, 0.05)


def test_of_somebody_who_has_walked_on_nothing_stays_between_two_rays() -> None:
    grid = Grid(SHIPPED)
    angles = np.radians(np.linspace(-90.0, 90.0, 120))

    def scan(distance: float, seen_from: float) -> ObstRead:
        return reading(*((seen_from + distance * np.cos(a), distance * np.sin(a), True) for a in angles))

    for shift in np.linspace(0.0, 0.2, 20):
        grid.see(scan(2.5 + shift, 0.0))
    for _ in range(10):
        grid.see(scan(5.0, 0.0))
    rows, columns = np.nonzero(grid.area.occupied)
    x, y = grid.area.x + columns * 0.05, grid.area.y + rows * 0.05
    is_inside = np.abs(np.arctan2(y, x)) < 1.5
    assert is_inside.any()
    assert np.hypot(x, y)[is_inside].min() > 4.5


def with_somebody(x: float, y: float, stamp: float) -> ObstRead:
    """A reading that hits somebody who has walked there, and a wall."""
    seen = reading((x, y, True), (0.05, 3.05, True), stamp=stamp)
    return with_body(seen, x, y, moved=True)


def with_body(seen: ObstRead, x: float, y: float, *, moved: bool) -> ObstRead:
    """A reading with a body of 0.35 m."""
    radius, has_moved = np.array([0.35]), np.array([float(moved)])
    return replace(seen, body_x=np.array([x]), body_y=np.array([y]), body_radius=radius, body_moved=has_moved)


@pytest.mark.parametrize("was_free", [True, False])
def test_somebody_who_walked_and_is_out_of_sight_has_walked_on(was_free: bool) -> None:
    grid = Grid(replace(PARAMETERS, gone=1.5))
    for stamp in np.arange(0.0, 1.0, 0.1) if was_free else ():
        grid.see(reading((5.05, 0.05, True), stamp=stamp))
    for stamp in np.arange(1.0, 9.0, 0.1):
        grid.see(with_somebody(3.05, 0.05, stamp))
    for stamp, is_there in ((10.0, True), (10.5, False)):
        grid.see(reading((-1.05, 0.05, True), stamp=stamp))
        assert occupied(grid, 3.05, 0.05) == is_there
    assert occupied(grid, 0.05, 3.05)


def test_what_never_walked_is_believed_to_stand_there_though_nobody_looks() -> None:
    grid = Grid(replace(PARAMETERS, gone=1.5))
    for stamp in np.arange(0.0, 1.0, 0.1):
        grid.see(reading((5.05, 0.05, True), stamp=stamp))
    grid.see(reading((3.05, 0.05, True), stamp=1.0))
    grid.see(reading((3.05, 0.05, True), stamp=1.1))
    grid.see(reading((3.05, 0.05, True), stamp=1.2))
    grid.see(reading((-1.05, 0.05, True), stamp=20.0))
    assert occupied(grid, 3.05, 0.05)


def test_what_is_no_wall_is_forgotten_once_nobody_has_seen_it_for_long() -> None:
    grid = Grid(PARAMETERS)
    for stamp in np.arange(0.0, 5.0, 0.1):
        grid.see(reading((0.05, 3.05, True), stamp=stamp))
    grid.see(reading((3.05, 0.05, True), stamp=5.0))
    grid.see(reading((3.05, 0.05, True), stamp=5.1))
    assert not grid.forget_transient(5.0)
    assert occupied(grid, 3.05, 0.05)
    assert grid.forget_transient(6.0)
    assert not occupied(grid, 3.05, 0.05)
    assert occupied(grid, 0.05, 3.05), "a wall stays"


def test_somebody_who_did_not_yield_is_not_forgotten() -> None:
    grid = Grid(replace(PARAMETERS, gone=1.5))
    grid.see(with_somebody(3.05, 0.05, 0.0))
    grid.take_for_walls(3.0, 0.0, 0.5)
    grid.see(reading((-1.05, 0.05, True), stamp=20.0))
    assert occupied(grid, 3.05, 0.05)


def test_a_body_bars_its_whole_disc_while_it_is_one_and_is_no_wall() -> None:
    grid = Grid(PARAMETERS)
    for stamp in np.arange(0.0, 5.0, 0.1):
        grid.see(with_body(reading((3.05, 0.05, True), stamp=stamp), 3.05, 0.05, moved=False))
    assert occupied(grid, 3.05, 0.35)
    assert occupied(grid, 2.75, 0.05)
    assert not is_wall(grid, 3.05, 0.35)
    assert not is_wall(grid, 3.05, 0.05), "who stands there may go away"
    grid.see(reading((3.05, 0.05, True), stamp=5.0))
    assert not occupied(grid, 3.05, 0.35)
    assert is_wall(grid, 3.05, 0.05), "it was no body, and has stood there for long"


def test_where_a_person_came_from_before_it_was_known_is_no_obstacle() -> None:
    grid = Grid(replace(PARAMETERS, gone=1.5))
    for stamp in np.arange(0.0, 1.0, 0.1):
        grid.see(reading((5.05, 0.05, True), stamp=stamp))
    for stamp, y in ((1.0, 1.05), (1.1, 1.05), (1.2, 1.05), (1.3, 0.55), (1.4, 0.55), (1.5, 0.55)):
        grid.see(reading((3.05, y, True), stamp=stamp))
    grid.see(with_body(reading((3.05, 0.05, True), stamp=1.8), 3.05, 0.05, moved=True))
    assert occupied(grid, 3.05, 1.05)
    grid.see(reading((-1.05, 0.05, True), stamp=3.5))
    assert not occupied(grid, 3.05, 1.05)
    assert not occupied(grid, 3.05, 0.55)


def heard(end: float | None, *, y: float = 0.05, turned: float = 0.0, stamp: float = 0.0) -> ObstRead:
    """The laser sees through all in front; one disc at y hears something at an x, or nothing within 3 m."""
    beams = np.radians(np.linspace(-90.0, 90.0, 121))
    length = 3.0 if end is None else end
    return ObstRead(
        stamp,
        (0.0, 0.0, 0.0),
        None,
        0.0,
        np.append(np.zeros(121), 0.0),
        np.append(np.zeros(121), y),
        np.append(6.0 * np.cos(beams), length * np.cos(turned)),
        np.append(6.0 * np.sin(beams), y + length * np.sin(turned)),
        np.append(np.ones(121), float(end is not None)),
        False,
    )


def test_what_sonar_hears_and_the_laser_sees_through_is_a_wall_until_sonar_no_longer_hears_it() -> None:
    grid = Grid(PARAMETERS)
    grid.see(heard(0.85))
    assert occupied(grid, 0.85, 0.05)
    assert is_wall(grid, 0.85, 0.05)
    for _ in range(20):
        grid.see(reading((5.05, 0.05, True)))
    assert occupied(grid, 0.85, 0.05), "the laser shows nothing of it"
    for _ in range(5):
        grid.see(heard(None))
    assert not occupied(grid, 0.85, 0.05)


def test_without_a_map_what_only_sonar_hears_is_forgotten_where_no_way_is_left_and_not_before() -> None:
    grid = Grid(PARAMETERS)
    grid.see(heard(0.85, stamp=10.0))
    assert not grid.forget_transient(9.0, with_panes=True)
    grid.forget_transient(100.0)
    assert occupied(grid, 0.85, 0.05)
    assert grid.forget_transient(11.0, with_panes=True)
    assert not occupied(grid, 0.85, 0.05)


def test_a_wall_is_not_forgotten_with_the_panes() -> None:
    grid = Grid(PARAMETERS)
    for stamp in np.arange(0.0, 5.0, 0.1):
        grid.see(reading((3.05, 0.05, True), stamp=stamp))
    assert not grid.forget_transient(100.0, with_panes=True)
    assert occupied(grid, 3.05, 0.05)


def test_what_only_sonar_hears_on_free_floor_of_a_map_is_remembered_for_a_time() -> None:
    grid = Grid(PARAMETERS)
    grid.use_map(floor_of(House([]).box(-4.0, -4.0, 12.0, 8.0)))
    grid.see(heard(0.85, stamp=10.0))
    assert not grid.forget_transient(9.0)
    assert occupied(grid, 0.85, 0.05)
    assert grid.forget_transient(11.0)
    assert not occupied(grid, 0.85, 0.05)


def test_a_disc_that_listens_from_another_side_shows_nothing_of_a_pane() -> None:
    grid = Grid(PARAMETERS)
    grid.see(heard(0.85))
    for _ in range(20):
        grid.see(heard(None, y=-0.5, turned=0.6))
    assert occupied(grid, 0.85, 0.05)


def test_an_echo_is_not_where_a_disc_beside_it_hears_nothing() -> None:
    grid = Grid(PARAMETERS)
    one, other = heard(0.85), heard(None, y=0.1)
    both = replace(
        one,
        origin_x=np.append(one.origin_x, other.origin_x[-1]),
        origin_y=np.append(one.origin_y, other.origin_y[-1]),
        end_x=np.append(one.end_x, other.end_x[-1]),
        end_y=np.append(one.end_y, other.end_y[-1]),
        hits=np.append(one.hits, other.hits[-1]),
    )
    grid.see(both)
    assert not occupied(grid, 0.85, 0.05)


def test_an_echo_of_a_body_is_no_pane() -> None:
    grid = Grid(PARAMETERS)
    grid.see(with_body(heard(0.85), 1.15, 0.05, moved=False))
    grid.see(reading((5.05, 0.05, True)))
    assert not occupied(grid, 0.75, 0.05)


def test_an_echo_beside_somebody_who_was_not_known_yet_is_expected_to_go_with_them() -> None:
    grid = Grid(PARAMETERS)
    grid.see(heard(0.85))
    cell = grid.area.cell(0.85, 0.05)
    assert grid.area.staying[cell], "it is glass as far as is known"
    grid.see(with_body(heard(0.85), 1.15, 0.05, moved=False))
    assert occupied(grid, 0.85, 0.05)
    assert not is_wall(grid, 0.85, 0.05)
    assert not grid.area.staying[grid.area.cell(0.85, 0.05)]
    grid.see(heard(0.85))
    assert is_wall(grid, 0.85, 0.05), "nobody is there any more"


def test_where_no_laser_looks_sonar_shows_what_is_there_and_what_has_gone() -> None:
    grid = Grid(PARAMETERS)
    ends, origins = np.array([-0.85, -3.0]), np.zeros(2)
    behind = ObstRead(
        0.0, (0.0, 0.0, 0.0), None, 0.0, origins, np.array([0.05, 0.3]), ends, np.array([0.05, 0.3]), np.ones(2), False
    )
    grid.see(behind)
    assert occupied(grid, -0.85, 0.05)
    for _ in range(10):
        grid.see(reading((-5.05, 0.05, True)))
    assert not occupied(grid, -0.85, 0.05)


def is_wall(grid: Grid, x: float, y: float) -> bool:
    return bool(grid.area.walls[grid.area.cell(x, y)])


def test_what_was_free_and_is_not_is_no_wall_until_it_does_not_yield() -> None:
    grid = Grid(PARAMETERS)
    for stamp in range(10):
        grid.see(reading((5.05, 0.05, True), stamp=stamp))
    for stamp in range(10, 20):
        grid.see(reading((3.05, 0.05, True), stamp=stamp))
    assert is_wall(grid, 5.05, 0.05)
    assert occupied(grid, 3.05, 0.05)
    assert not is_wall(grid, 3.05, 0.05)
    grid.take_for_walls(3.0, 0.0, 0.5)
    assert is_wall(grid, 3.05, 0.05)


def test_what_was_never_free_is_a_wall_when_it_has_stood_there_for_long() -> None:
    grid = Grid(replace(PARAMETERS, settled=3.0))
    for stamp, wanted in ((0.0, False), (2.0, False), (3.5, True)):
        grid.see(reading((3.05, 0.05, True), stamp=stamp))
        assert is_wall(grid, 3.05, 0.05) == wanted
    grid.doubt(3.0, 0.0, 0.5)
    grid.see(reading((3.05, 0.05, True), stamp=4.0))
    assert occupied(grid, 3.05, 0.05)
    assert not is_wall(grid, 3.05, 0.05)


def test_a_wall_seen_at_a_grazing_angle_stays() -> None:
    grid = Grid(PARAMETERS)
    near = [(x, 0.52, True) for x in np.arange(-4.0, 4.0, 0.05)]
    far = [(x, 0.52 + 0.0 * x, True) for x in np.arange(2.0, 7.9, 0.45)]
    for _ in range(10):
        grid.see(reading(*near))
    for _ in range(50):
        grid.see(reading(*far))
    assert all(occupied(grid, x, 0.52) for x in np.arange(-3.9, 3.9, 0.05))


def test_the_area_grows_with_the_robot_and_keeps_what_was_seen() -> None:
    grid = Grid(PARAMETERS)
    grid.see(reading((3.05, 0.05, True)))
    grid.see(reading((40.0, 33.0, True), pose=(40.0, 30.0, 0.0)))
    assert occupied(grid, 3.05, 0.05)
    assert occupied(grid, 40.0, 33.0)


@pytest.mark.parametrize(("x", "y"), [(60.0, 0.0), (0.0, 60.0), (-60.0, -60.0)])
def test_the_area_begins_wherever_the_robot_is(x: float, y: float) -> None:
    grid = Grid(PARAMETERS)
    grid.see(reading((x + 3.05, y + 0.05, True), pose=(x, y, 0.0)))
    assert occupied(grid, x + 3.05, y + 0.05)
    assert not occupied(grid, x + 1.05, y + 0.05)
    assert not unknown(grid, x + 1.05, y + 0.05)


def test_an_area_that_would_be_too_large_stays_as_it_is() -> None:
    grid = Grid(replace(PARAMETERS, largest=40.0))
    assert grid.include((0.0, 0.0), 5.0)
    before = grid.area
    assert not grid.include((100.0, 0.0))
    assert grid.area is before


def test_a_robot_sees_wherever_it_is_however_large_the_area_becomes() -> None:
    grid = Grid(replace(PARAMETERS, largest=40.0))
    grid.see(reading((3.05, 0.05, True)))
    grid.see(reading((63.05, 0.05, True), pose=(60.0, 0.0, 0.0)))
    assert occupied(grid, 3.05, 0.05)
    assert occupied(grid, 63.05, 0.05)


def test_a_large_area_is_extended_to_a_goal_across_it() -> None:
    grid = Grid(replace(PARAMETERS, largest=40.0))
    grid.include((60.0, 0.0), 5.0, always=True)
    grid.include((0.0, 0.0), 5.0, always=True)
    assert grid.include((30.0, 12.0))
    assert not grid.include((90.0, 0.0))


def test_rays_that_are_no_numbers_and_rays_without_length_are_left_out() -> None:
    grid = Grid(PARAMETERS)
    grid.see(reading((nan, 1.0, True), (inf, 0.0, True), (0.0, 0.0, True), (2.05, 0.05, True)))
    assert occupied(grid, 2.05, 0.05)
    assert int(grid.area.occupied.sum()) == 1


@given(st.lists(st.tuples(SOMEWHERE, SOMEWHERE, st.booleans()), max_size=20))
def test_no_hit_is_ever_cleared_by_the_same_reading(rays: list[Ray]) -> None:
    grid = Grid(PARAMETERS)
    grid.see(reading(*rays))
    for x, y, hits in rays:
        if hits and 0.0 < np.hypot(x, y) <= 8.0:
            assert occupied(grid, x, y)


@given(st.lists(st.tuples(SOMEWHERE, SOMEWHERE, st.booleans()), max_size=20))
def test_a_picture_of_the_grid_holds_all_that_is_known(rays: list[Ray]) -> None:
    grid = Grid(PARAMETERS)
    grid.see(reading(*rays))
    picture = grid.area.drawn()
    values, known = undrawn(picture), grid.area.known()
    assert (values == 2).sum() == grid.area.occupied.sum()
    assert (values == 1).sum() == (grid.area.evidence < 0).sum()
    assert picture["x"] == pytest.approx(known.x)
    assert values.shape == known.evidence.shape
