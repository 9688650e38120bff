"""The reader of pages compares outputs as the pages promise."""

import pytest

from tests.reader import looks_like


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
