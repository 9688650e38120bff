"""Exploration on grids of drawn rooms: robots that go where they are sent on the shortest way, and look about."""

from dataclasses import dataclass, field
from functools import cache
from math import atan2, dist, inf, pi

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry import Point, Pose2D
from maps.building.building import grid_of_evidence
from maps.building.evidence import EvidenceGatherer
from maps.building.exploring import MOST_MISSIONS, Explorer, ExploringOrder, MissionStanding, RobotSight
from maps.building.frontiers import frontiers, ways_from
from maps.building.readings import BeamView, Floats
from maps.distance import distance_transform
from maps.occupancy import OccupancyGrid
from maps.rasterization import points_along
from tests.maps.building.drawn_rooms import BEARINGS, ring, scan

RESOLUTION = 0.1
RADIUS = 0.25
STEP = 0.6  # m that a robot drives in a turn


def offsets(pose: Pose2D) -> tuple[Floats, Floats]:
    """From a robot to the cells of the true floor, m."""
    rows, columns = np.indices(floor().shape)
    x = RESOLUTION * (np.asarray(columns, np.float64) + 0.5) - 1.0 - pose.x
    y = RESOLUTION * (np.asarray(rows, np.float64) + 0.5) - 1.0 - pose.y
    return x, y


def cell_of(x: float, y: float) -> tuple[int, int]:
    return int((y + 1.0) / RESOLUTION), int((x + 1.0) / RESOLUTION)


@cache
def floor() -> NDArray[np.bool_]:
    """Where there is room for a robot; cell (0, 0) is at -1, -1 m."""
    solid = np.zeros((112, 112), np.bool_)
    points = points_along(ring(), 0.05)
    solid[((points[:, 1] + 1.0) / RESOLUTION).astype(int), ((points[:, 0] + 1.0) / RESOLUTION).astype(int)] = True
    return distance_transform(solid, RESOLUTION, 1.0) > RADIUS - 0.05


def ways_to(goal: Point) -> Floats:
    """The way from every cell to a goal, m."""
    return ways_from(floor(), cell_of(*goal), RESOLUTION)


@dataclass
class DrawnRobot:
    """A robot that drives to its goal, a step in each turn; its map has its own frame."""

    pose: Pose2D
    frame: Pose2D = field(default_factory=Pose2D)  # of its map, in the rooms
    goal: Point | None = None
    mission: MissionStanding = MissionStanding.NONE
    driven: float = 0.0
    cannot: Point | None = None  # in the rooms; missions to about there fail
    within: float = 1.0  # m from there
    bars: float = inf  # how many of them

    def __post_init__(self) -> None:
        self._gatherer = EvidenceGatherer(RESOLUTION)
        self._views: list[tuple[Pose2D, BeamView]] = []
        self._rng = np.random.default_rng(0)
        for turn in (0.0, np.pi):  # it looks round
            self.look(turn)

    def look(self, turn: float = 0.0) -> None:
        pose = Pose2D(self.pose.x, self.pose.y, self.pose.heading + turn)
        ranges = scan(ring(), pose, self._rng)
        seen = np.isfinite(ranges)
        points = ranges[seen, None] * np.stack((np.cos(BEARINGS[seen]), np.sin(BEARINGS[seen])), axis=1)
        self._views.append((pose.relative_to(self.frame), BeamView(0.0, pose, np.zeros_like(points), points)))

    def sight(self) -> RobotSight:
        grid = grid_of_evidence(self._gatherer.gathered(self._views))
        return RobotSight(grid, self.pose.relative_to(self.frame), self.mission)

    def follow(self, order: ExploringOrder) -> None:
        self.goal = None if order.goal is None else self.frame.transform(order.goal.x, order.goal.y)
        self.mission = MissionStanding.NONE if order.goal is None else MissionStanding.ACTIVE

    def drive(self) -> None:
        """A step on the way through the true rooms."""
        if self.goal is None or self.mission is not MissionStanding.ACTIVE:
            return
        if self.cannot is not None and dist(self.goal, self.cannot) < self.within and self.bars:
            self.bars -= 1
            self.mission = MissionStanding.FAILED
            return
        left = ways_to(self.goal)
        near = [tuple(cell) for cell in np.argwhere(np.hypot(*offsets(self.pose)) < STEP)]
        row, column = min(near, key=lambda cell: left[cell])
        if left[row, column] >= left[cell_of(self.pose.x, self.pose.y)] - 0.05:
            self.look(np.pi)
            self.mission = MissionStanding.DONE
            return
        x, y = RESOLUTION * (column + 0.5) - 1.0, RESOLUTION * (row + 0.5) - 1.0
        self.driven += dist((x, y), (self.pose.x, self.pose.y))
        self.pose = Pose2D(x, y, atan2(y - self.pose.y, x - self.pose.x))
        self.look()


def explore(robots: dict[str, DrawnRobot], frames: dict[str, Pose2D] | None = None) -> tuple[Explorer, int]:
    """Let robots explore; return the explorer, and after how many turns it was finished."""
    explorer = Explorer(RADIUS)
    for turn in range(120):
        orders = explorer.decide(float(turn), {name: robot.sight() for name, robot in robots.items()}, frames)
        if explorer.is_finished:
            return explorer, turn
        for name, order in orders.items():
            robots[name].follow(order)
        for robot in robots.values():
            robot.drive()
    raise AssertionError("it does not end")


def known(robot: DrawnRobot, *points: Point) -> list[bool]:
    grid = robot.sight().grid
    own = np.array([robot.frame.locate(*point) for point in points])
    return [value >= 0 for value in grid.values_at(own).tolist()]


ROOMS = ((2.0, 2.0), (7.0, 2.0), (2.0, 6.0), (7.0, 6.5))


def test_one_robot_sees_all_rooms_and_then_ends() -> None:
    robot = DrawnRobot(Pose2D(1.5, 1.5, 0.0), Pose2D(1.5, 1.5, 0.3))
    explore({"happy": robot})
    assert all(known(robot, *ROOMS))
    left = frontiers(robot.sight().grid, (0.0, 0.0), RADIUS)
    assert all(each.length < 3.0 for each in left)


def test_two_robots_share_the_rooms_and_are_done_sooner() -> None:
    _, alone = explore({"happy": DrawnRobot(Pose2D(2.0, 3.0, 0.0))})
    frames = {"happy": Pose2D(), "doc": Pose2D(2.5, 3.2, 1.0)}
    pair = {"happy": DrawnRobot(Pose2D(2.0, 3.0, 0.0)), "doc": DrawnRobot(Pose2D(2.5, 3.2, 2.0), frames["doc"])}
    _, together = explore(pair, frames)
    assert together <= 0.8 * alone
    for room in ROOMS:
        assert known(pair["happy"], room) + known(pair["doc"], room) != [False, False]


def test_two_robots_do_not_drive_to_the_same_frontier() -> None:
    frames = {"happy": Pose2D(), "doc": Pose2D()}
    pair = {"happy": DrawnRobot(Pose2D(2.0, 2.0, 0.0)), "doc": DrawnRobot(Pose2D(2.6, 2.4, 0.0))}
    explorer = Explorer(RADIUS)
    explorer.decide(0.0, {name: robot.sight() for name, robot in pair.items()}, frames)
    targets = explorer.targets()
    assert dist(targets["happy"], targets["doc"]) > 2.0


def test_a_frontier_that_cannot_be_reached_is_given_up() -> None:
    robot = DrawnRobot(Pose2D(1.5, 1.5, 0.0))
    first = Explorer(RADIUS)
    first.decide(0.0, {"happy": robot.sight()})
    robot.cannot = first.targets()["happy"]
    explore({"happy": robot})


def test_what_could_not_be_reached_is_tried_again_when_nothing_else_is_left() -> None:
    robot = DrawnRobot(Pose2D(1.5, 1.5, 0.0), within=inf)
    robot.cannot, robot.bars = (0.0, 0.0), MOST_MISSIONS * len(frontiers(robot.sight().grid, (1.5, 1.5), RADIUS))
    explore({"happy": robot})
    assert robot.bars == 0
    assert all(known(robot, *ROOMS))


def test_a_robot_that_can_go_nowhere_ends() -> None:
    explore({"happy": DrawnRobot(Pose2D(1.5, 1.5, 0.0), cannot=(0.0, 0.0), within=inf)})


def test_a_robot_is_told_to_face_what_it_is_to_see() -> None:
    robot = DrawnRobot(Pose2D(1.5, 1.5, 0.0), Pose2D(1.5, 1.5, 0.3))
    sight = robot.sight()
    order = Explorer(RADIUS).decide(0.0, {"happy": sight})["happy"]
    ahead = order.goal
    assert ahead is not None
    places = [(x, y) for x in (-0.6, 0.6) for y in (-0.2, 0.0, 0.2)]
    before, behind = (
        sight.grid.values_at(np.array([ahead.transform(x, y) for x, y in places if (x > 0.0) is is_ahead]))
        for is_ahead in (True, False)
    )
    assert (before < 0).sum() > (behind < 0).sum()


def test_a_robot_that_is_late_is_sent_elsewhere() -> None:
    robot, explorer = DrawnRobot(Pose2D(1.5, 1.5, 0.0)), Explorer(RADIUS)
    robot.follow(explorer.decide(0.0, {"happy": robot.sight()})["happy"])
    goals = set()
    for now in (10.0, 100.0, 200.0, 300.0, 400.0):
        for order in explorer.decide(now, {"happy": robot.sight()}).values():
            robot.follow(order)
            goals.add(order.goal)
    assert len(goals) >= 2


def test_the_opening_of_a_door_is_told_from_other_frontiers() -> None:
    cells = np.full((60, 60), -1, np.int8)
    cells[5:30, 5:55] = 0
    cells[30, 5:55] = 100
    cells[30, 20:29] = 0
    cells[5:30, 4], cells[4, 4:56] = 100, 100
    found = frontiers(OccupancyGrid(cells, RESOLUTION), (3.0, 1.5), RADIUS)
    doors = [each for each in found if each.is_door]
    assert [each.is_door for each in found].count(False) == 1
    assert doors[0].middle == pytest.approx((2.45, 3.05), abs=0.3)
    assert doors[0].facing == pytest.approx(pi / 2.0, abs=0.3)


def test_ways_are_as_long_as_they_are_in_any_direction() -> None:
    ways = ways_from(np.ones((101, 101), np.bool_), (50, 50), 0.1)
    rows, columns = np.indices(ways.shape)
    straight = 0.1 * np.hypot(rows - 50, columns - 50)
    far = straight > 1.0
    assert np.all(np.abs(ways[far] / straight[far] - 1.0) < 0.2)
    assert np.isinf(ways_from(np.zeros((5, 5), np.bool_), (2, 2), 0.1)).sum() == 24
