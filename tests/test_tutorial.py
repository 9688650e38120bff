"""The tutorial, done as it says: each of its files written, each command typed and each output compared, in order."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path

import pytest

from agents.client.element import ElementClient
from agents.client.robot import ELEMENTS
from agents.client.sensors import Picture
from tests.live_team import LIMIT, ROOT, own_bus
from tests.reader import Reader, links

PAGE = ROOT / "docs" / "tutorial.md"
TUTORIAL = PAGE.read_text(encoding="utf-8")


@contextmanager
def reading(folder: Path) -> Iterator[Reader]:
    folder.mkdir()
    reader = Reader(own_bus(folder))
    try:
        yield reader
    finally:
        reader.leave()


def test_the_tutorial_can_be_followed(tmp_path: Path) -> None:
    with reading(tmp_path / "tutorial") as reader:
        reader.follow(TUTORIAL)
        assert reader.open.pop("acromovi promote wander.py").wait(LIMIT) == 0  # the page has stopped it
        assert reader.end("acromovi up team.toml") == 130


@pytest.mark.parametrize("part", ELEMENTS)
def test_the_table_lists_all_that_a_part_tells_and_does(part: str) -> None:
    kind = ELEMENTS[part]
    told = [each.name for each in fields(kind.reading)] + _public(kind.reading)
    done = [name for cls in kind.__mro__ if cls not in ElementClient.__mro__ for name in _public(cls)]
    (row,) = re.findall(rf"^\| `{part}` \|.*", TUTORIAL, re.MULTILINE)
    _, _, has, does, _ = row.split("|")
    assert set(re.findall(r"`(\w+)`", has)) == set(told) - {"of", "stamp", "result"}
    assert set(re.findall(r"`(\w+)`", does)) - set(_public(Picture)) == set(done) - {"reading"}


@pytest.mark.parametrize("target", links(PAGE), ids=str)
def test_links_lead_somewhere(target: Path) -> None:
    assert target.exists()


def _public(cls: type) -> list[str]:
    return [name for name in vars(cls) if not name.startswith("_")]
