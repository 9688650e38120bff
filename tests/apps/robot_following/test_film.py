"""The film of robot following: the target is drawn where it is, and frames show the drive."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from apps.film import SIDE, TEXT
from apps.robot_following.cycle import FollowingCycle
from apps.robot_following.film import FollowingFilm, draw_picture
from apps.robot_following.record import FollowingRecord
from apps.robot_following.settings import FollowingSettings
from configs.target_file import target_file
from geometry import Pose2D, Twist2D
from tests.apps.film_frames import frames_of
from tests.apps.robot_following.test_faults import CAMERA, LEADER

LINE = 40, 220, 250  # blue, green and red


def seen() -> FollowingCycle:
    """A follower that has seen its leader."""
    cycle = FollowingCycle(FollowingSettings.load(), {"field_of_view": CAMERA.view})
    cycle.take_odometry(1.0, Pose2D(), Twist2D())
    cycle.take_picture(1.0, LEADER(Pose2D(), 0.0))
    cycle.step(1.0, [])
    return cycle


def test_the_target_is_outlined_in_the_picture_that_was_looked_at() -> None:
    shown, target = seen().shown, target_file()
    assert shown is not None
    data, outline = shown
    assert outline is not None
    pixels = np.asarray(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR))
    for rectangle, colour in zip(outline, (target.left, target.centre, target.right), strict=True):
        left, top = np.rint(rectangle.mean(axis=0)).astype(int)
        assert int(pixels[top, left].argmax()) == 2 - int(np.argmax(colour))
    drawn, plain = draw_picture(data, outline), draw_picture(data, None)
    assert drawn.shape == (SIDE + TEXT, SIDE, 3)
    left, top = np.rint((outline[0, 0] + 0.5) * SIDE / pixels.shape[1] - 0.5).astype(int)
    assert abs(drawn[top, left].astype(int) - LINE).max() < 60
    assert abs(plain[top, left].astype(int) - LINE).max() > 60


def test_a_film_has_the_view_from_above_beside_the_picture(tmp_path: Path) -> None:
    record, film = FollowingRecord("happy"), FollowingFilm(tmp_path / "following.mp4")
    shown = seen().shown
    for number in range(21):
        at = 0.1 * number
        record.add(at, Pose2D(at / 4.0, 0.0, 0.0), Pose2D(1.2 + at / 4.0, 0.0, 0.0), 1.2)
        film.add(record, shown)
    assert film.close(record) == 11
    frames = frames_of(film.file)
    assert {frame.shape for frame in frames} == {(SIDE + TEXT, 2 * SIDE, 3)}
    assert abs(frames[0][:, :SIDE].astype(int) - frames[-1][:, :SIDE]).max() > 100  # the robots have moved
    assert abs(frames[0][:SIDE, SIDE:].astype(int) - frames[-1][:SIDE, SIDE:]).mean() < 3.0  # the picture is the same


def test_a_film_of_a_record_that_keeps_few_entries_shows_those(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("apps.records.MOST", 10)
    record, film = FollowingRecord("happy"), FollowingFilm(tmp_path / "following.mp4")
    shown = seen().shown
    for number in range(41):
        record.add(0.1 * number, Pose2D(0.025 * number, 0.0, 0.0), None, None)
        film.add(record, shown)
    assert len(record.times) == 6
    assert film.close(record) == 6
