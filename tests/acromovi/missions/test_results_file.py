"""The file of results from which a long run that was interrupted goes on."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from acromovi.missions.results_file import ResultsFile
from configs import ConfigError


@dataclass(frozen=True, slots=True)
class Score:
    name: str
    seconds: tuple[float, ...]
    room: float | None = None


FIRST, SECOND, THIRD = Score("first", (1.0, 2.5)), Score("second", (), 0.2), Score("third", (0.1,))


def write(path: Path, *scores: Score, resume: bool) -> list[Score]:
    with ResultsFile(path, Score, resume=resume) as kept:
        kept.add(scores)
        return kept.earlier


def test_results_of_an_earlier_run_are_there_when_it_is_resumed_and_forgotten_otherwise(tmp_path: Path) -> None:
    path = tmp_path / "new" / "scores.jsonl"
    assert write(path, FIRST, resume=True) == []
    assert write(path, SECOND, resume=True) == [FIRST]
    assert write(path, THIRD, resume=True) == [FIRST, SECOND]
    assert write(path, resume=False) == []
    assert write(path, resume=True) == []


def test_a_last_line_that_was_not_written_whole_is_left_out_and_the_rest_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "scores.jsonl"
    write(path, FIRST, SECOND, resume=False)
    path.write_bytes(path.read_bytes()[:-5])
    assert write(path, THIRD, resume=True) == [FIRST]
    assert write(path, resume=True) == [FIRST, THIRD]


@pytest.mark.parametrize(
    ("line", "why"), [("nonsense", "not JSON"), ('{"name": 3}', "key seconds is missing"), ("[]", "a table is needed")]
)
def test_a_line_that_is_no_result_is_said_and_the_file_stays_as_it_was(tmp_path: Path, line: str, why: str) -> None:
    path = tmp_path / "scores.jsonl"
    write(path, FIRST, resume=False)
    text = path.read_text(encoding="utf-8") + line + "\n"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=f"scores.jsonl, line 2: .*{why}"):
        write(path, THIRD, resume=True)
    assert path.read_text(encoding="utf-8") == text


def test_a_file_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match=r"cannot be written: .*; choose another folder"):
        write(tmp_path / "file" / "scores.jsonl", FIRST, resume=False)
