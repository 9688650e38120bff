"""Maps of laser scans: loops are closed, walls are where they are and not double, and maps are extended."""

from functools import cache
from math import hypot

import numpy as np
import pytest

from geometry import Pose2D, Segment, wrap_angle
from maps.building.building import map_of
from maps.building.laser_builder import LaserMapBuilder, NotPlaced
from maps.building.readings import Floats, OdometryTrack, moved
from maps.building.surfaces import map_at, surface_points
from maps.building_map import BuildingMap
from tests.maps.building.drawn_rooms import ROUND, drive, ring, room


@cache
def built() -> tuple[LaserMapBuilder, tuple[Pose2D, ...]]:
    """A map of all rooms, in the frame of the true walls, and the true poses of its key scans."""
    builder, true = LaserMapBuilder(origin=Pose2D(*ROUND[0], 0.0)), []
    for pose, view in drive(ring(), ROUND, seed=3):
        if builder.add(view):
            true.append(pose)
    builder.refine(1)
    return builder, tuple(true)


def distances(points: Floats, walls: list[Segment]) -> Floats:
    return np.array([min(wall.distance_to(x, y) for wall in walls) for x, y in points.tolist()])


def samples(lines: tuple[Segment, ...]) -> Floats:
    return surface_points(BuildingMap(lines))[0]


def test_poses_are_right_within_centimetres_although_odometry_drifts_by_metres() -> None:
    builder, true = built()
    first, last = builder.keys[0].view.pose, builder.keys[-1].view.pose
    drifted = Pose2D(*ROUND[0], 0.0).compose(last.relative_to(first))
    assert hypot(drifted.x - true[-1].x, drifted.y - true[-1].y) > 1.0
    for key, pose in zip(builder.keys, true, strict=True):
        assert hypot(key.pose.x - pose.x, key.pose.y - pose.y) < 0.04
        assert abs(wrap_angle(key.pose.heading - pose.heading)) < 0.015


def test_a_loop_is_closed_where_the_robot_comes_back() -> None:
    assert built()[0].loops >= 1


def test_lines_lie_on_the_walls_and_no_wall_is_double() -> None:
    made = map_of(built()[0].keys)
    away = distances(samples(made.lines), ring())
    assert np.mean(away < 0.04) > 0.97
    assert np.max(away) < 0.1


def test_all_walls_that_were_seen_have_a_line() -> None:
    made = map_of(built()[0].keys)
    seen = np.concatenate([moved(view.points[::30], pose) for pose, view in drive(ring(), ROUND, seed=3)])
    away = distances(seen, list(made.lines))
    assert np.mean(away < 0.05) > 0.95


def test_a_robot_that_drives_in_a_known_room_keeps_no_more_scans() -> None:
    builder = LaserMapBuilder()
    here = ((2.0, 2.0), (3.0, 2.0), (2.0, 2.0), (3.0, 2.0), (2.0, 2.0))
    for _, view in drive(ring(), here * 4, seed=1, drift=0.0):
        builder.add(view)
    assert len(builder.keys) < 25


def test_scans_that_are_missing_for_a_while_do_not_break_the_map() -> None:
    builder = LaserMapBuilder(origin=Pose2D(*ROUND[0], 0.0))
    views = list(drive(ring(), ROUND[:4], seed=5, drift=0.005))
    for _, view in [*views[:8], *views[20:]]:
        builder.add(view)
    pose, _ = views[-1]
    assert hypot(builder.pose.x - pose.x, builder.pose.y - pose.y) < 0.2


def test_odometry_that_begins_anew_goes_on_where_it_was() -> None:
    track, shift = OdometryTrack(), Pose2D(4.0, 7.0, 2.0)
    for number in range(20):
        pose = Pose2D(0.05 * number, 0.0, 0.1 * number)
        track.add(0.1 * number, pose if number < 10 else shift.compose(pose))
    found = track.at(np.array([0.85, 1.85]))
    assert found is not None
    assert found[0] == pytest.approx([0.425, 0.0, 0.85])
    assert found[1] == pytest.approx([0.875, 0.0, 1.75], abs=0.15)


def test_odometry_that_begins_anew_after_a_long_gap_goes_on_where_it_was() -> None:
    track = OdometryTrack()
    for stamp, pose in ((0.0, Pose2D(8.0, 0.0)), (0.1, Pose2D(8.05, 0.0)), (6.0, Pose2D()), (6.1, Pose2D(0.05, 0.0))):
        track.add(stamp, pose)
    found = track.at(np.array([0.1, 6.1]))
    assert found is not None
    assert found[1] == pytest.approx([8.1, 0.0, 0.0])


def test_a_map_is_extended_in_its_own_frame() -> None:
    shifted = map_at(map_of(built()[0].keys), Pose2D(3.0, -2.0, 0.5))
    extra = room(-5.1, 0.0, 5.0, 4.0, ("east", 1.5))
    walls = [*(wall for wall in ring() if wall[0] > 0.0 or wall[2] > 0.0), *extra]
    walls += [Segment(0.0, 0.0, 0.0, 1.5), Segment(0.0, 2.4, 0.0, 4.0), Segment(0.0, 4.1, 0.0, 9.1)]
    base = surface_points(shifted)
    start = Pose2D(3.0, -2.0, 0.5).compose(Pose2D(2.3, 2.2, np.pi - 0.2))
    builder = LaserMapBuilder(origin=start, base=base)
    drove = list(drive(walls, ((2.0, 2.0), (-2.5, 2.0), (-1.0, 1.0)), seed=8))
    for _, view in drove:
        builder.add(view)
    pose, _ = drove[-1]
    true = Pose2D(3.0, -2.0, 0.5).compose(pose)
    assert hypot(builder.pose.x - true.x, builder.pose.y - true.y) < 0.06
    made = map_at(map_of(builder.keys, shifted), Pose2D().relative_to(Pose2D(3.0, -2.0, 0.5)))
    away = distances(samples(made.lines), [*walls, *ring()])
    assert np.mean(away < 0.05) > 0.95
    opening = (made.grid.values_at(np.array([[0.0, 1.9]])) if made.grid else [100])[0]
    assert opening < 30, "the new door was driven through"
    assert np.mean(distances(samples(tuple(extra)), list(made.lines)) < 0.06) > 0.8


def test_a_scan_that_does_not_fit_the_map_to_extend_is_refused() -> None:
    base = surface_points(map_of(built()[0].keys))
    builder = LaserMapBuilder(origin=Pose2D(2.0, 2.0), base=base)
    _, view = next(drive(room(0.0, 0.0, 9.0, 2.2), ((4.0, 1.0), (5.0, 1.0)), seed=1))
    with pytest.raises(NotPlaced, match="give the pose"):
        builder.add(view)


def test_people_who_walk_past_are_not_in_the_map() -> None:
    builder, rng = LaserMapBuilder(origin=Pose2D(2.0, 2.0)), np.random.default_rng(0)
    for number, (_, view) in enumerate(drive(ring(), ((2.0, 2.0), (3.9, 2.0), (2.2, 2.4), (3.5, 1.5)), seed=2)):
        person = np.array([3.0 + 0.1 * (number % 20), 0.6 + 0.15 * (number % 17)])
        local = np.array(view.pose.locate(*(person - 2.0)))
        beams = np.arctan2(view.points[:, 1], view.points[:, 0])
        length = np.hypot(*view.points.T)
        hit = (np.abs(beams - np.arctan2(local[1], local[0])) < 0.15 / np.hypot(*local)) & (np.hypot(*local) < length)
        view.points[hit] *= ((np.hypot(*local) - 0.1 + rng.normal(0, 0.01)) / length[hit])[:, None]
        builder.add(view)
    made = map_of(builder.keys)
    away = distances(np.concatenate((samples(made.lines), made.points)), ring())
    assert np.mean(away < 0.06) > 0.97
