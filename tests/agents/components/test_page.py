"""The page on components: its tables are what the agents say of themselves, and what it says to try fits them."""

import inspect
import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

from acromovi.options import argument
from agents.components.all_components import COMPONENTS
from gateway.elements.adapter import adapter_types
from gateway.elements.all_elements import ELEMENTS
from tests.agents.components.bench import Bench
from tests.agents.components.conftest import MakeLab
from tests.agents.components.page import requests_of, tables

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "components.md").read_text()
ROW = r"^\| `(\w+)` \|[^|]*\| (?:`(\w+))?"
SECTIONS = dict(re.findall(r"^## ([^\n]+)\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL))
TO_TRY = re.findall(r"^acromovi ask (\w+)@happy (.*)$", PAGE, re.MULTILINE)
OTHERS: dict[str, str] = dict(re.findall(ROW, SECTIONS["All others"], re.MULTILINE))
"""The request of each element without a class, or an empty text."""
OF_MANY = {"All others", "Results of several elements together"}
WITH_A_ROW = {"encoders"}
"""Elements that have a class, which makes no other results than the generic one."""


@pytest.mark.parametrize("element", sorted(COMPONENTS.keys() - WITH_A_ROW))
def test_a_section_tells_what_the_agent_says_of_itself(element: str, make_bench: Callable[..., Bench]) -> None:
    kind = COMPONENTS[element]
    assert tables(element, kind) in SECTIONS[element], tables(element, kind)
    assert {"read", *requests_of(element, kind)} == set(make_bench(element).component.describe()["requests"])


def test_every_element_that_a_gateway_can_find_is_on_the_page() -> None:
    known = {adapter.name for row in ELEMENTS for adapter in adapter_types(row)}
    assert known == (SECTIONS.keys() | OTHERS.keys()) - OF_MANY


@pytest.mark.parametrize(("model", "fit"), [("powerbot-sh", "compass,gyro"), ("peoplebot-sh", "compass")])
def test_elements_without_a_class_can_be_asked_for_what_their_row_says(make_lab: MakeLab, model: str, fit: str) -> None:
    lab = make_lab(fit, model)
    lab.until(lambda: "compass" in lab.elements)
    described = {agent.name.local: agent.describe()["requests"] for agent in lab.container.agents}
    checked = OTHERS.keys() & described
    assert {"compass", "charger", "servos"} <= checked
    for element in checked:
        assert set(described[element]) - {"read"} == {OTHERS[element]} - {""}


@pytest.mark.parametrize(("element", "line"), TO_TRY)
def test_what_it_says_to_try_is_a_request_with_arguments_that_it_takes(element: str, line: str) -> None:
    name, *rest = shlex.split(line.partition(" --")[0])
    given = dict(argument(text) for text in rest)
    if element in COMPONENTS:
        inspect.signature(requests_of(element, COMPONENTS[element])[name]).bind(**given)
    else:
        assert name in ("read", OTHERS[element])


def test_there_is_something_to_try_for_every_component() -> None:
    assert COMPONENTS.keys() - WITH_A_ROW <= {element for element, _ in TO_TRY}
