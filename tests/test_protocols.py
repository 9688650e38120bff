"""The page on protocols prints what its example does."""

import sys

from tests.live_team import ROOT, environment
from tests.shown import files, page
from tests.waiting import run


def test_the_example_prints_what_the_page_shows() -> None:
    done = run([sys.executable, str(ROOT / "examples" / "protocols.py")], env=environment())
    assert done.stderr == ""
    assert files("protocols", "text") == [done.stdout]


def test_the_page_names_every_protocol_of_the_example() -> None:
    for word in ("considers", "request_when", "revise", "broker", "recruit", "clone"):
        assert word in page("protocols"), word
