"""How faults are written."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os_emu.fault_spec import FaultError, FaultSpec, parse_fault

WORDS = st.from_regex(r"[a-z][a-z0-9-]{0,15}", fullmatch=True)
VALUES = st.text(st.characters(exclude_characters=",=@:", exclude_categories=("Z", "C")), min_size=1, max_size=15)
SECONDS = st.floats(min_value=0, allow_nan=False, allow_infinity=False).map(abs)


@pytest.mark.parametrize(
    ("text", "spec"),
    [
        ("stop-pressed", FaultSpec("stop-pressed")),
        ("line-cut@5", FaultSpec("line-cut", start=5.0)),
        ("line-cut@5+10", FaultSpec("line-cut", start=5.0, duration=10.0)),
        ("line-cut@1e+1+.5", FaultSpec("line-cut", start=10.0, duration=0.5)),
        (
            "sonar-dead:robot=happy,disc=3@5+10",  # source: the design, section 4
            FaultSpec("sonar-dead", {"robot": "happy", "disc": "3"}, start=5.0, duration=10.0),
        ),
    ],
)
def test_fault_is_read_as_it_is_written(text: str, spec: FaultSpec) -> None:
    assert parse_fault(text) == spec


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "has no name"),
        ("@5", "has no name"),
        ("Stop Pressed", "has no name"),
        ("line-cut:", "'' is not key=value"),
        ("line-cut:robot", "'robot' is not key=value"),
        ("line-cut:robot=", "'robot=' is not key=value"),
        ("line-cut:robot=a,robot=b", "gives 'robot' twice"),
        ("line-cut@", "'' is not START"),
        ("line-cut@soon", "'soon' is not START"),
        ("line-cut@5+", "is not START"),
        ("line-cut@-5", "is not START"),
        ("line-cut@5+nan", "is not START"),
        ("line-cut@1e999", "beyond any run"),
    ],
)
def test_wrong_writing_is_refused_with_the_part_that_is_wrong(text: str, complaint: str) -> None:
    with pytest.raises(FaultError, match=complaint):
        parse_fault(text)


@given(
    st.builds(FaultSpec, WORDS, st.dictionaries(WORDS, VALUES, max_size=3), start=SECONDS, duration=st.none() | SECONDS)
)
def test_every_fault_that_can_be_written_is_read_back(spec: FaultSpec) -> None:
    assert parse_fault(str(spec)) == spec


@given(st.text())
def test_any_text_is_a_fault_or_refused_as_one(text: str) -> None:
    with contextlib.suppress(FaultError):  # the one that is allowed
        assert parse_fault(text).name
