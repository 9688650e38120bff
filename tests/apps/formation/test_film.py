"""The film of a formation, checked frame by frame."""

from pathlib import Path

import pytest

from apps.film import SIDE, TopView
from apps.formation.plots import write_film
from apps.formation.record import FormationRecord
from geometry import Pose2D
from tests.apps.film_frames import frames_of


@pytest.mark.parametrize("ending", ["gif", "mp4"])
def test_each_frame_shows_leader_and_follower_where_they_were(tmp_path: Path, ending: str) -> None:
    record = FormationRecord("happy")
    for number in range(21):
        at = 0.1 * number
        follower = Pose2D(at - 1.0, 0.5, 0.0) if number > 5 else None
        record.add(at, {"happy": Pose2D(at, 0.0, 0.0), "doc": follower}, {"doc": (at - 1.0, 0.9)})
    file = tmp_path / f"formation.{ending}"
    assert write_film(file, record) == 11
    frames = frames_of(file)
    assert len(frames) == 11
    view = TopView(record.poses)
    for number, frame in enumerate(frames):
        for name, colour in (("happy", (72, 66, 61)), ("doc", (180, 119, 31))):
            pose = record.poses[name][2 * number]
            if pose is None:
                continue
            left, down = view.pixel(*pose.transform(-0.1, 0.0))  # behind the line that shows the heading
            assert abs(frame[down, left].astype(int) - colour).max() < 40
        assert frame[:SIDE].mean() > 240
