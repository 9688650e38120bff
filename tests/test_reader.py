"""The reader of pages compares outputs as the pages promise, and says what it has seen instead."""

from pathlib import Path

import pytest

from tests.live_team import LIMIT, own_bus
from tests.reader import Reader, looks_like


@pytest.mark.parametrize(
    ("expected", "shown", "is_alike"),
    [
        ("x is ... m\n", "x is 1.5 m\n", True),
        ("x is ... m\n", "x is 1.5\ny is 2 m\n", False),
        ("...\nend\n", "end\n", True),
        ("...\nend\n", "a\nb\nend\n", True),
        ("...\nend\n", "end\nmore\n", False),
        ("f(x)\n", "fx\n", False),
    ],
)
def test_outputs_are_compared_line_by_line(expected: str, shown: str, is_alike: bool) -> None:
    assert looks_like(expected, shown) is is_alike


def test_an_output_that_does_not_come_is_reported_with_what_the_other_terminals_show(tmp_path: Path) -> None:
    reader = Reader(own_bus(tmp_path))
    reader.type("acromovi promote nobody.py\n")
    assert reader.open["acromovi promote nobody.py"].wait(LIMIT) == 1
    reader.type("acromovi --version\n")
    with pytest.raises(AssertionError, match=r"acromovi promote nobody.py:\nacromovi promote: there is no application"):
        reader.see("nothing like this\n")
