"""Bad pictures, several targets, a head that does not answer, a silent base: the follower does not drive on by them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import hypot, pi, radians

import numpy as np
import pytest

from apps.robot_following.cycle import FollowingCycle
from apps.robot_following.follower import FollowerState
from apps.robot_following.settings import FollowingSettings
from benchmarks.vision_drawing import Camera, Flaws, draw, quads
from configs.target_file import target_file
from geometry import Pose2D, Twist2D, integrate
from vision.image import Image, Pixels

SETTINGS = FollowingSettings.load()
CAMERA = Camera(160, 120, radians(60.0))
NEAR, FAR = 1.3, 2.2  # m from the camera to a target
DT = 0.1  # s
STOPPED = SETTINGS.search.coast + 4 * DT  # s after which a follower without sightings stands


def colours() -> list[tuple[int, int, int]]:
    """Blue, green and red of left flank, centre and right flank, in good light."""
    target = target_file()
    rows = (target.left, target.centre, target.right)
    return [(round(230 * blue), round(230 * green), round(230 * red)) for red, green, blue in rows]


def drawn(
    targets: Sequence[Pose2D], seed: int, roll: float = 0.0, covers: Sequence[tuple[int, int, int, int]] = ()
) -> Pixels:
    """Targets by their poses in the camera's frame."""
    surfaces = [
        surface for at in targets for surface in zip(quads(at.x, at.y, 0.0, at.heading, roll), colours(), strict=True)
    ]
    return draw(CAMERA, surfaces, np.random.default_rng(seed), Flaws(noise=2.0, blur=0.3, quality=0), covers)


def file_of(pixels: Pixels) -> bytes:
    return Image.of(pixels).encode()


@dataclass
class Drive:
    """A follower that moves as its cycle says, and whose camera sees what a function of its pose and of time draws."""

    see: Callable[[Pose2D, float], bytes | None]
    cycle: FollowingCycle = field(default_factory=lambda: FollowingCycle(SETTINGS, {"field_of_view": CAMERA.view}))
    pose: Pose2D = field(default_factory=Pose2D)
    twist: Twist2D = field(default_factory=Twist2D)
    time: float = 0.0
    way: float = 0.0

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / DT)):
            self.time += DT
            before, self.pose = self.pose, integrate(self.pose, self.twist, DT)
            self.way += hypot(self.pose.x - before.x, self.pose.y - before.y)
            self.cycle.take_odometry(self.time, self.pose, self.twist)
            data = self.see(self.pose, self.time)
            if data is not None:
                self.cycle.take_picture(self.time, data)
            step = self.cycle.step(self.time, [])
            self.twist = step.twist if step is not None else Twist2D()

    @property
    def stands(self) -> bool:
        return self.twist == Twist2D()


def looking_at(*places: Pose2D) -> Callable[[Pose2D, float], bytes]:
    """Targets that stand in odom."""

    def see(pose: Pose2D, time: float) -> bytes:
        eye = pose.compose(Pose2D(SETTINGS.camera.forward, 0.0, 0.0))
        return file_of(drawn([each.relative_to(eye) for each in places], round(10 * time)))

    return see


LEADER = looking_at(Pose2D(FAR, 0.0, 0.0))


def driving() -> Drive:
    """A follower on its way to a leader."""
    drive = Drive(LEADER)
    drive.run(1.5)
    assert not drive.stands
    return drive


def black(pose: Pose2D, time: float) -> bytes:
    noise = np.random.default_rng(round(10 * time)).integers(0, 8, (CAMERA.height, CAMERA.width, 3))
    return file_of(noise.astype(np.uint8))


def torn(pose: Pose2D, time: float) -> bytes:
    return LEADER(pose, time)[:900]


def nothing(pose: Pose2D, time: float) -> None:
    return None


def upside_down(pose: Pose2D, time: float) -> bytes:
    return file_of(drawn([Pose2D(NEAR, 0.0, 0.0)], round(10 * time), roll=pi))


def half_hidden(pose: Pose2D, time: float) -> bytes:
    return file_of(drawn([Pose2D(NEAR, 0.0, 0.0)], round(10 * time), covers=[(78, 0, 82, 120)]))


@pytest.mark.parametrize(
    ("see", "words"),
    [
        (black, "none of the target's colours is in view"),
        (torn, "a picture cannot be used: the PNG file is truncated"),
        (nothing, ""),
        (upside_down, "upside down"),
        (half_hidden, "right flank of the target cannot be seen"),
    ],
)
def test_without_a_good_picture_it_does_not_begin_and_stops_on_its_way(
    see: Callable[[Pose2D, float], bytes | None], words: str
) -> None:
    waiting = Drive(see)
    waiting.run(1.0)
    assert (waiting.way, waiting.cycle.follower.state) == (0.0, FollowerState.WAITING)
    moving = driving()
    moving.see = see
    moving.run(STOPPED)
    assert moving.stands
    assert words in moving.cycle.words
    assert moving.cycle.follower.state is FollowerState.SEARCHING


def test_a_camera_that_is_back_is_believed_again() -> None:
    drive = driving()
    drive.see = nothing
    drive.run(STOPPED)
    drive.see = LEADER
    drive.run(4.0)
    gap = FAR + SETTINGS.leader.carried - drive.pose.x
    assert gap == pytest.approx(SETTINGS.drive.gap, rel=0.15)


def test_a_frozen_picture_stops_it_although_a_leader_is_in_it() -> None:
    drive = driving()
    frozen = drive.see(drive.pose, drive.time)
    drive.see = lambda pose, time: frozen
    drive.run(STOPPED + 0.2)
    assert drive.stands
    assert drive.cycle.words == "the camera repeats one picture although the robot moves"
    way = drive.way
    drive.run(2.0)
    assert drive.way == way


def test_the_same_picture_again_is_believed_while_the_robot_stands() -> None:
    frozen = LEADER(Pose2D(), 0.0)
    drive = Drive(lambda pose, time: frozen)
    drive.run(0.3)
    assert drive.cycle.words.startswith("target at ")


def test_of_two_targets_it_follows_the_near_one_and_none_if_both_are_near() -> None:
    drive = Drive(looking_at(Pose2D(NEAR + 0.4, -0.2, 0.0), Pose2D(NEAR + 1.4, 0.6, 0.0)))
    drive.run(1.0)
    assert not drive.stands
    unclear = Drive(looking_at(Pose2D(NEAR + 0.3, -0.4, 0.0), Pose2D(NEAR + 0.4, 0.4, 0.0)))
    unclear.run(1.0)
    assert unclear.way == 0.0
    assert unclear.cycle.words == "2 targets are in view; it is not known which is meant"


def test_a_second_target_beside_its_leader_does_not_distract_it() -> None:
    drive = driving()
    drive.see = looking_at(Pose2D(FAR, 0.0, 0.0), Pose2D(FAR, 0.8, 0.0))
    drive.run(3.5)
    assert FAR + SETTINGS.leader.carried - drive.pose.x == pytest.approx(SETTINGS.drive.gap, rel=0.15)
    assert abs(drive.pose.y) < 0.05


def test_a_head_that_does_not_answer_makes_pictures_useless() -> None:
    drive = Drive(LEADER, FollowingCycle(SETTINGS, {"field_of_view": CAMERA.view}, 1.5))
    drive.run(1.0)
    assert drive.way == 0.0
    assert "since the head of the camera has not reported" in drive.cycle.words


def test_a_picture_waits_until_it_is_known_where_the_head_looked() -> None:
    cycle = FollowingCycle(SETTINGS, {"field_of_view": CAMERA.view}, 1.5)
    cycle.take_odometry(1.0, Pose2D(), Twist2D())
    cycle.take_head(1.0, 0.0, 0.0, is_moving=True)
    cycle.take_picture(1.05, LEADER(Pose2D(), 1.0))
    cycle.step(1.06, [])
    assert cycle.words == "no picture has come"
    cycle.take_head(1.1, 0.1, 0.0, is_moving=True)
    cycle.step(1.11, [])
    assert cycle.words.startswith("target at ")


def test_a_silent_base_leaves_nothing_to_do_but_stand() -> None:
    drive = driving()
    assert drive.cycle.step(drive.time + SETTINGS.silent + 0.1, []) is None


def test_odometry_that_begins_elsewhere_makes_it_forget_the_leader() -> None:
    drive = driving()
    drive.pose = Pose2D(5.0, 5.0, 1.0)
    drive.see = nothing
    drive.run(0.2)
    assert (drive.stands, drive.cycle.follower.state) == (True, FollowerState.WAITING)
