"""Where maps of several robots lie in one frame, by grids of drawn rooms."""

from math import hypot

from geometry import Pose2D
from maps.building.merging import PERIOD, CommonFrame
from maps.building.surfaces import map_at
from maps.occupancy import OccupancyGrid
from tests.maps.building.test_merging import NORTH, SOUTH, part

POSE = Pose2D(4.0, -3.0, 2.5)
ELSEWHERE = ((7.0, 7.0), (6.0, 6.6))


def grid_of(*way: tuple[float, float], seen_from: Pose2D | None = None) -> OccupancyGrid:
    """The grid of what is seen on a way, in a frame of its own."""
    made = part(*way)
    grid = (map_at(made, Pose2D().relative_to(seen_from)) if seen_from else made).grid
    assert grid is not None
    return grid


def test_maps_that_show_the_same_rooms_are_placed_at_once_and_stay_so() -> None:
    frame = CommonFrame("happy")
    grids = {"happy": grid_of(*SOUTH), "doc": grid_of(*NORTH, seen_from=POSE)}
    frame.look(0.0, grids)
    pose = frame.poses["doc"]
    assert hypot(pose.x - POSE.x, pose.y - POSE.y) < 0.15
    frame.look(2.0 * PERIOD, grids | {"doc": grids["happy"]})
    assert frame.poses["doc"] == pose


def test_maps_without_a_common_room_are_tried_again_after_a_while_only() -> None:
    frame = CommonFrame("happy")
    apart, together = grid_of(*ELSEWHERE), grid_of(*NORTH, seen_from=POSE)
    south = grid_of(*SOUTH)
    frame.look(0.0, {"happy": south, "doc": apart})
    frame.look(PERIOD / 2.0, {"happy": south, "doc": together})
    assert frame.poses == {"happy": Pose2D()}
    frame.look(PERIOD, {"happy": south, "doc": together})
    assert set(frame.poses) == {"happy", "doc"}
