"""The page on vision: its tables are what the agents say of themselves, and what it says to try fits them."""

import inspect
import re
import shlex
from pathlib import Path

import pytest

from acromovi.options import argument
from agents.components.all_components import DERIVED
from agents.components.component import ElementAgent
from tests.agents.components.page import requests_of, tables

PAGE = (Path(__file__).resolve().parents[4] / "docs" / "vision.md").read_text()
SECTIONS = dict(re.findall(r"^### ([^\n]+)\n(.*?)(?=^##|\Z)", PAGE, re.MULTILINE | re.DOTALL))
TO_TRY = re.findall(r"^acromovi ask (\w+)@happy (.*)$", PAGE, re.MULTILINE)
AGENTS = DERIVED["camera"]


@pytest.mark.parametrize(("name", "kind"), AGENTS.items())
def test_a_section_tells_what_the_agent_says_of_itself(name: str, kind: type[ElementAgent]) -> None:
    for table in tables(name, kind).split("\n\n"):
        assert table in SECTIONS[name], table


@pytest.mark.parametrize(("name", "line"), TO_TRY)
def test_what_it_says_to_try_is_a_request_with_arguments_that_it_takes(name: str, line: str) -> None:
    request, *rest = shlex.split(line)
    given = dict(argument(text) for text in rest)
    inspect.signature(requests_of(name, AGENTS[name])[request]).bind(**given)


def test_there_is_something_to_try_for_every_agent() -> None:
    assert AGENTS.keys() == {name for name, _ in TO_TRY}
