"""The page on services: it names what they can be asked for, with what, and what it says to try fits them."""

import inspect
import re
import shlex
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from acromovi.options import argument
from agents.platform import Agent, AgentName
from agents.platform.hooks import hooks_of
from agents.services.all_services import SERVICES
from agents.services.restarts import Restarts

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "services.md").read_text()
SECTIONS = {
    title.lower(): text for title, text in re.findall(r"^## ([^\n]+)\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL)
}
TABLE = r"^\| (request|subscription) \|[^\n]*\n\|[-|]+\n((?:\|[^\n]*\n)+)"
TO_TRY = re.findall(r"^acromovi ask (\w+)@acromovi (.*)$", PAGE, re.MULTILINE)


class Listing:
    """Stands in for an agent whose decorated methods are looked at."""

    def __init__(self) -> None:
        self.found: dict[str, dict[str, Callable[..., Any]]] = {"request": {}, "subscription": {}}

    def answer(self, name: str, function: Callable[..., Any], **options: Any) -> None:
        self.found["request"][name] = function

    def answer_subscriptions(self, name: str, function: Callable[..., Any]) -> None:
        self.found["subscription"][name] = function

    def __getattr__(self, other: str) -> Callable[..., None]:
        """What else a decorator does with an agent, such as beginning a behaviour, is none of the page's business."""
        return lambda *what, **options: None


def offered(service: str) -> dict[str, dict[str, Callable[..., Any]]]:
    """What a service can be asked for and subscribed to, by name."""
    listing: Any = Listing()
    for method, hook in hooks_of(SERVICES[service](AgentName(service, "acromovi"))):
        hook.begin(listing, method)
    found: dict[str, dict[str, Callable[..., Any]]] = listing.found
    return found


def named(service: str) -> dict[str, dict[str, list[str]]]:
    """What the page says of that, each with its arguments."""
    found: dict[str, dict[str, list[str]]] = {"request": {}, "subscription": {}}
    for kind, rows in re.findall(TABLE, SECTIONS[service], re.MULTILINE):
        for row in rows.splitlines():
            _, name, arguments, *_ = row.split("|")
            found[kind][name.strip(" `")] = re.findall(r"`(\w+)`", arguments)
    return found


def test_there_is_a_section_for_every_service() -> None:
    assert SECTIONS.keys() == SERVICES.keys()


@pytest.mark.parametrize("service", sorted(SERVICES))
def test_a_section_names_what_its_service_offers_and_every_argument(service: str) -> None:
    assert named(service) == {
        kind: {name: list(inspect.signature(function).parameters) for name, function in functions.items()}
        for kind, functions in offered(service).items()
    }
    for name in SERVICES[service].services:
        assert f"offers\n`{name}`" in SECTIONS[service] or f"offers `{name}`" in SECTIONS[service]


@pytest.mark.parametrize(("service", "line"), TO_TRY)
def test_what_it_says_to_try_is_offered_and_takes_these_arguments(service: str, line: str) -> None:
    name, *words = shlex.split(line)
    kind = "subscription" if "--follow" in words else "request"
    given = dict(argument(word) for word in words if not word.startswith("--"))
    inspect.signature(offered(service)[kind][name]).bind(**given)


def test_there_is_something_to_try_for_every_service() -> None:
    assert SERVICES.keys() == {service for service, _ in TO_TRY}


def test_properties_that_it_shows_can_be_given() -> None:
    shown: dict[str, dict[str, Any]] = {}
    for text in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL):
        shown |= tomllib.loads(text)["services"]
    assert shown.keys() == {"arbiter", "monitor", "loader"}
    for service, properties in shown.items():
        assert isinstance(SERVICES[service](AgentName(service, "acromovi"), properties), Agent)
        Restarts(properties.get("restart"))
