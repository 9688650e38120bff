"""The benchmark of missions on a map goes on where it was interrupted."""

import argparse
from collections.abc import Sequence
from pathlib import Path

import pytest

from acromovi.missions.results_file import ResultsFile
from benchmarks import map_navigation
from benchmarks.__main__ import main
from benchmarks.map_course import FloorJob, GoalScore
from benchmarks.map_navigation import jobs, measure, of_whole_floors
from configs.defaults import VARIABLE
from geometry import Pose2D


def goals(job: FloorJob, count: int | None = None) -> list[GoalScore]:
    pose = Pose2D(1.0, 2.0, 0.5)
    return [
        GoalScore(job, n, "happy", pose, (3.0, 4.0), "", 9.0, 4.0, 3.9, 0.1, (), (), (pose,), ("there",), ())
        for n in range(job.goals if count is None else count)
    ]


def test_floors_that_were_played_are_kept_and_those_that_were_not_written_whole_are_played_again() -> None:
    first, second, third = jobs(1)
    kept = [*goals(first), *goals(second)]
    assert of_whole_floors(kept, [first, second, third]) == kept
    assert of_whole_floors(kept, [second]) == goals(second)
    tens = jobs(10)
    torn = [*goals(tens[0], 4), *goals(tens[1]), *goals(tens[0])]
    assert of_whole_floors(torn, tens) == [*goals(tens[0]), *goals(tens[1])]
    assert of_whole_floors(torn[:-1], tens) == goals(tens[1])


def test_a_run_that_is_resumed_plays_no_floor_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    floors = jobs(20)
    with ResultsFile(tmp_path / "map-navigation.jsonl", GoalScore, resume=False) as kept:
        for job in floors:
            kept.add(goals(job))
    drawn: list[Sequence[GoalScore]] = []
    monkeypatch.setattr(map_navigation, "draw", lambda path, scores: drawn.append(scores))
    figures = measure(argparse.Namespace(out=tmp_path, goals=20, first_seed=None, resume=True))
    assert {figure.name for figure in figures} >= {"static: goals not reached", "busy: goals not reached"}
    assert all(figure.samples == 20 for figure in figures)
    assert len(drawn[0]) == 3 * 20


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["map_navigation", "--resume"], "map-navigation.jsonl, line 1: not JSON"),
        (["mapping", "--map", "nowhere.map"], "there is no file nowhere.map"),
    ],
)
def test_a_file_that_cannot_be_used_is_one_sentence(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    why: str,
) -> None:
    monkeypatch.setenv(VARIABLE, "local:test")
    kept = tmp_path / "map-navigation.jsonl"
    kept.write_text("nonsense\n", encoding="utf-8")
    with pytest.raises(SystemExit) as caught:
        main([*words, "--out", str(tmp_path)])
    assert caught.value.code == 2
    (said,) = capsys.readouterr().err.splitlines()
    assert why in said
    assert kept.read_text(encoding="utf-8") == "nonsense\n"
