"""pre-commit runs the checks of `make test` that take seconds, and no others."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SLOW = {"tests"}  # which pre-commit leaves to make


def test_hooks_are_the_checks_of_make_test() -> None:
    hooks = re.findall(r"^ +entry: make (\S+)$", (ROOT / ".pre-commit-config.yaml").read_text(), re.MULTILINE)
    (checks,) = re.findall(r"^test:.*\n\t.* -j2 (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert set(hooks) == set(checks.split()) - SLOW
