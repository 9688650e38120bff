"""The page on the navigation: every row on faults names a test, and every test that it names is there."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[4]
PAGE = (ROOT / "docs" / "navigation.md").read_text(encoding="utf-8")
FAULTS = PAGE[PAGE.index("| fault |") :].splitlines()[2:]
ROWS = [line.strip("| ").split(" | ") for line in FAULTS if line.startswith("| ")]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0][:60])
def test_every_row_says_all_and_names_tests_that_are_there(row: list[str]) -> None:
    fault, seen, done, tests = row
    assert all((fault, seen, done))
    named = re.findall(r"`(test_\w+\.py)::(test_\w+)`", tests)
    assert named
    for file, test in named:
        found = [path for path in (ROOT / "tests").rglob(file) if f"def {test}(" in path.read_text(encoding="utf-8")]
        assert found, f"there is no {test} in any {file}"


def test_every_test_of_faults_stands_on_the_page() -> None:
    for path in sorted(Path(__file__).parent.glob("test_*.py")):
        for test in re.findall(r"^def (test_\w+)\(", path.read_text(encoding="utf-8"), re.MULTILINE):
            assert path.name == "test_page.py" or f"`{path.name}::{test}`" in PAGE, f"{test} is in no row"


def test_the_ten_of_the_page_are_those_of_the_wiring() -> None:
    from apps.indoor_navigation.wiring import load_wiring

    table = PAGE[PAGE.index("| component |") : PAGE.index("- **push**")]
    assert sorted(re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE)) == sorted(p.local for p in load_wiring().parts)
