from geometry import Pose2D, Segment
from p2os_emu.world import Block
from p2os_emu.world.placement import CLEARANCE, Obstacles, free_pose

WALL = Block(0.0, 2.0, 0.0, 100.0, 0.1, 2.0, "wall")
NOTHING = Obstacles(())


def test_the_first_free_start_is_taken() -> None:
    starts = [Pose2D(0.0, 0.0, 1.0), Pose2D(5.0, 0.0, 2.0)]
    assert free_pose(starts, NOTHING, [], 0.5) == starts[0]
    assert free_pose(starts, NOTHING, [(0.0, 0.5, 0.5)], 0.5) == starts[1]


def test_when_all_starts_are_taken_a_place_beside_one_is_found() -> None:
    start = Pose2D(0.0, 0.0, 0.5)
    pose = free_pose([start], NOTHING, [(0.0, 0.0, 0.4)], 0.4)
    assert pose is not None
    assert 0.8 + CLEARANCE < (pose.x**2 + pose.y**2) ** 0.5 < 2.1
    assert pose.heading == start.heading


def test_a_place_behind_a_wall_is_not_beside_a_start() -> None:
    others = [(float(x), float(y), 0.4) for x in range(-14, 15) for y in range(-14, 2)]
    assert free_pose([Pose2D()], Obstacles([WALL]), others, 0.4) is None


def test_a_circle_needs_room_from_every_block() -> None:
    obstacles = Obstacles([WALL])
    assert obstacles.leave_room(0.0, 0.0, 1.9)
    assert not obstacles.leave_room(0.0, 0.0, 1.96)
    assert not obstacles.leave_room(0.0, 2.0, 0.01)


def test_a_wall_hides_what_lies_behind_it() -> None:
    obstacles = Obstacles([WALL])
    assert obstacles.hide(Segment(0.0, 0.0, 0.0, 3.0))
    assert not obstacles.hide(Segment(0.0, 0.0, 3.0, 1.0))


def test_an_overlap_is_told_by_name() -> None:
    obstacles = Obstacles([WALL, Block(0.0, -2.0, 0.0, 1.0, 1.0, 1.0)])
    assert obstacles.overlapping(((-1.0, 1.9), (1.0, 1.9), (1.0, 2.5), (-1.0, 2.5))) == "wall"
    assert obstacles.overlapping(((-0.1, -2.1), (0.1, -2.1), (0.1, -1.9), (-0.1, -1.9))) == "a wall"
    assert obstacles.overlapping(((-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1))) == ""
