"""The page on faults: every row names a test, and every test that it names is there."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PAGE = ROOT / "docs" / "agents-faults.md"
ROWS = [
    line.strip("| ").split(" | ") for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")
]


@pytest.mark.parametrize("row", [row for row in ROWS if row[0] != "fault"], ids=lambda row: row[0][:60])
def test_every_row_says_all_and_names_tests_that_are_there(row: list[str]) -> None:
    fault, seen, done, tests = row
    assert fault
    assert seen
    assert done
    named = re.findall(r"`(test_\w+\.py)::(test_\w+)`", tests)
    assert named
    for file, test in named:
        found = [path for path in (ROOT / "tests").rglob(file) if f"def {test}(" in path.read_text(encoding="utf-8")]
        assert found, f"there is no {test} in any {file}"


def test_every_test_of_faults_stands_on_the_page() -> None:
    page = PAGE.read_text(encoding="utf-8")
    others = {"test_page.py"}
    for path in sorted(Path(__file__).parent.glob("test_*.py")):
        assert path.name in others or f"`{path.name}::" in page, f"{path.name} is in no row"
