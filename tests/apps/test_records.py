"""Records of long drives: a limited number of entries, and summaries of everything that happened."""

import pytest

from apps.formation.record import FormationRecord
from apps.robot_following.record import FollowingRecord
from geometry import Pose2D

FEW, STEPS, PERIOD = 100, 1001, 0.1


@pytest.fixture(autouse=True)
def _few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("apps.records.MOST", FEW)


def zigzag(step: int) -> Pose2D:
    """A place 0.05 m ahead of the one before, and 0.1 m to its left or right."""
    return Pose2D(0.05 * step, 0.1 * (step % 2), 0.0)


def test_a_follower_that_drives_for_long_has_few_entries_and_a_summary_of_its_whole_drive() -> None:
    record = FollowingRecord("happy")
    for step in range(STEPS):
        is_odd = step % 2 == 1  # of which thinning keeps none
        gap = 2.0 if step == 501 else 0.5 if step == 503 else 1.0
        record.add(PERIOD * step, zigzag(step), None if is_odd and step < 500 else zigzag(step), gap)
    assert {len(each) for each in (record.times, record.own, record.leader, record.gaps)} == {63}
    assert record.times == pytest.approx([PERIOD * 16 * number for number in range(63)])
    assert record.own[1] == zigzag(16)
    assert record.summary() == (
        "happy: 111.8 m behind a leader that drove 80.9 m; gap 1.00 m in the median, 0.50 to 2.00 m; "
        "without leader for 0 s"
    )


def test_the_time_without_a_leader_is_that_of_the_whole_drive() -> None:
    record = FollowingRecord("happy")
    for step in range(1000):
        record.add(PERIOD * step, Pose2D(), None, 1.0 if step % 2 == 0 else None)
    assert record.summary().endswith("without leader for 50 s")


def test_a_formation_that_drives_for_long_has_few_entries_and_a_summary_of_its_whole_drive() -> None:
    record = FormationRecord("happy")
    for step in range(STEPS):
        x, y = 0.05 * step, 0.1 * (step % 2)
        off = 0.3 if step == 501 else 0.1
        record.add(PERIOD * step, {"happy": zigzag(step), "doc": zigzag(step)}, {"doc": (x, y + off)})
    assert len(record.times) == 63
    assert {name: len(each) for name, each in record.poses.items()} == {"happy": 63, "doc": 63}
    assert len(record.points["doc"]) == 63
    assert record.errors("doc") == pytest.approx([0.1] * 63)
    assert record.summary() == [
        "happy: 111.8 m",
        "doc: 111.8 m, on the average 10 cm from its point, at most 30 cm",
    ]


def test_what_is_told_is_limited() -> None:
    for record in (FollowingRecord("happy"), FormationRecord("happy")):
        for number in range(5000):
            record.told.append(f"{number} s: follows")
        assert len(record.told) == 1000
        assert record.told[-1] == "4999 s: follows"
