"""Films and views from above, looked at frame by frame."""

from pathlib import Path

import numpy as np
import pytest

from agents import RobotError
from apps.film import MOST, SIDE, TEXT, FilmWriter, TopView, check_film, moments
from geometry import Pose2D
from tests.apps.film_frames import frames_of


@pytest.mark.parametrize("ending", ["gif", "mp4"])
def test_a_film_has_the_frames_that_it_was_given(tmp_path: Path, ending: str) -> None:
    writer = FilmWriter(tmp_path / f"drive.{ending}", 3)
    levels = (40, 120, 200, 250)
    for level in levels:
        writer.add(np.full((96, 128, 3), level, np.uint8))
    assert writer.close() == 3
    found = frames_of(writer.file)
    assert [each.shape for each in found] == [(96, 128, 3)] * 3
    assert [round(float(each.mean()), -1) for each in found] == list(levels[:3])


def test_without_frames_there_is_no_film(tmp_path: Path) -> None:
    writer = FilmWriter(tmp_path / "drive.gif", 3)
    assert writer.close() == 0
    assert not writer.file.exists()


def test_robots_are_drawn_at_their_places_and_only_the_way_behind_them() -> None:
    track = [Pose2D(0.5 * number, 0.0, 0.0) for number in range(9)]
    view = TopView({"happy": track, "doc": [None] * 9})
    assert view.scale == pytest.approx(SIDE / 5.2)  # 4 m and the edges
    assert view.pixel(2.0, 0.0) == (SIDE // 2, SIDE // 2)
    assert view.pixel(2.0, 1.0)[1] < SIDE // 2
    frame = view.draw(4, "2.0 s", [(2.0, 1.0)])
    assert frame.shape == (SIDE + TEXT, SIDE, 3)
    left, down = view.pixel(2.0, 0.0)
    assert tuple(frame[down, left - 10]) == (72, 66, 61)  # the robot
    assert (frame[view.pixel(1.0, 0.0)[::-1]] < 200).all()  # where it was
    assert (frame[view.pixel(3.5, 0.0)[::-1]] == 255).all()  # where it will be
    assert (frame[view.pixel(2.0, 1.0)[::-1]] < 200).all()  # the point
    assert (frame[SIDE:] < 100).any()  # the words


def test_a_long_drive_is_shown_in_larger_steps_and_a_short_one_in_small_ones() -> None:
    assert moments([]) == []
    assert moments([0.0]) == [0]
    short = [0.1 * number for number in range(101)]
    assert moments(short) == list(range(0, 101, 2))
    long = [0.1 * number for number in range(6001)]
    shown = moments(long)
    assert len(shown) == MOST
    assert (shown[0], shown[-1]) == (0, 6000)
    assert set(np.diff(shown)) <= {10, 11}


@pytest.mark.parametrize("film", ["drive.avi", "nowhere/drive.gif"])
def test_a_film_that_cannot_be_written_is_refused_before_anything_moves(film: str) -> None:
    with pytest.raises(RobotError, match=r"name a \.gif or \.mp4 file in a folder that exists"):
        check_film(film)
