"""What is believed of the leader."""

from math import cos, pi, sin
from random import Random

import pytest

from apps.robot_following.leader import LeaderTrack, Sighting, leader_pose
from apps.robot_following.settings import FollowingSettings
from geometry import Pose2D, Twist2D, integrate

SETTINGS = FollowingSettings.load().leader
DT = 1 / 15


def sighting(pose: Pose2D) -> Sighting:
    return Sighting(pose, SETTINGS.position_deviation, SETTINGS.heading_deviation)


def seen(track: LeaderTrack, twist: Twist2D, seconds: float, rng: Random | None = None) -> Pose2D:
    """Let a leader drive from the origin, seen at 15 Hz; return where it is."""
    pose, at = Pose2D(0.0, 0.0, 0.0), 0.0
    for _ in range(round(seconds / DT)):
        pose, at = integrate(pose, twist, DT), at + DT
        off = (rng.gauss(0.0, 0.01), rng.gauss(0.0, 0.01), rng.gauss(0.0, 0.05)) if rng else (0.0, 0.0, 0.0)
        track.see(sighting(Pose2D(pose.x + off[0], pose.y + off[1], pose.heading + off[2])), at)
    return pose


@pytest.mark.parametrize("twist", [Twist2D(0.3, 0.0), Twist2D(0.3, 0.5), Twist2D(0.0, 0.4), Twist2D(-0.2, 0.0)])
def test_speed_and_turn_are_found_from_poses(twist: Twist2D) -> None:
    track = LeaderTrack(SETTINGS)
    pose = seen(track, twist, 3.0, Random(3))
    found = track.at(3.0)
    assert (found.speed, found.turn) == pytest.approx((twist.linear, twist.angular), abs=0.12)
    assert (found.pose.x, found.pose.y, found.pose.heading) == pytest.approx((pose.x, pose.y, pose.heading), abs=0.05)


def test_unseen_it_is_expected_to_go_on() -> None:
    track = LeaderTrack(SETTINGS)
    seen(track, Twist2D(0.3, 0.0), 3.0)
    assert track.at(4.0).pose.x == pytest.approx(1.2, abs=0.02)


def test_a_pose_that_it_cannot_have_reached_is_not_believed_until_others_agree() -> None:
    track = LeaderTrack(SETTINGS)
    seen(track, Twist2D(0.3, 0.0), 3.0)
    elsewhere = sighting(Pose2D(3.0, 3.0, 1.0))
    assert [track.see(elsewhere, 3.0 + DT * (1 + tries)) for tries in range(SETTINGS.refusals + 1)] == [
        *[False] * SETTINGS.refusals,
        True,
    ]
    assert track.at(3.5).pose == Pose2D(3.0, 3.0, 1.0)


def test_an_image_that_comes_late_changes_nothing() -> None:
    track = LeaderTrack(SETTINGS)
    seen(track, Twist2D(0.3, 0.0), 3.0)
    before = track.at(3.2)
    assert not track.see(sighting(Pose2D(0.5, 0.0, 0.0)), 1.0)
    assert track.at(3.2) == before


def test_pan_of_the_head_and_place_of_the_target_are_taken_into_account() -> None:
    pose = leader_pose(Pose2D(1.0, 2.0, pi / 2), Pose2D(0.1, 0.0, -pi / 2), (2.0, 0.0, pi / 4), 0.5)
    assert (pose.x, pose.y) == pytest.approx((3.0 + 0.5 * cos(pi / 4), 2.1 + 0.5 * sin(pi / 4)))
    assert pose.heading == pytest.approx(pi / 4)
