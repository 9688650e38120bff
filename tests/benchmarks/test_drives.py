"""Which seeds a benchmark drives, and what it prints and draws while it does."""

import argparse
from pathlib import Path

import pytest

from benchmarks.drives import add_options, drive_all, seconds_of, seeds_of


def options_of(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_options(parser)
    return parser.parse_args(arguments)


def drive(seed: int, out: Path | None) -> tuple[int, Path | None]:
    return seed, out


def row(score: tuple[int, Path | None]) -> str:
    return f"| {score[0]} |"


@pytest.mark.parametrize(
    ("text", "seeds"), [("20-23", (20, 21, 22, 23)), ("7", (7,)), ("5,9-10,5", (5, 9, 10)), ("3-3", (3,))]
)
def test_seeds_are_numbers_and_ranges(text: str, seeds: tuple[int, ...]) -> None:
    assert seeds_of(text) == seeds


@pytest.mark.parametrize("text", ["", "4-", "9-7", "-3", "a-b", "1,,2", "1.5"])
def test_what_names_no_seeds_is_refused_with_an_example(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="write 20-39 or 20,25,31"):
        seeds_of(text)


def test_a_drive_has_its_usual_length_unless_another_one_is_given() -> None:
    assert seconds_of(options_of(), 300.0) == 300.0
    assert seconds_of(options_of("--drive-minutes", "0.5"), 300.0) == 30.0


def test_each_seed_is_driven_once_and_told_and_only_the_first_one_draws(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = options_of("--jobs", "1")
    options.out = tmp_path
    assert drive_all(drive, (8, 3, 5), options, row) == [(8, tmp_path), (3, None), (5, None)]
    assert capsys.readouterr().out.split("\n") == ["     | 8 |", "     | 3 |", "     | 5 |", ""]
