"""Applications that a container starts by name, as it is told to over the bus."""

import asyncio
from pathlib import Path
from typing import Any

import pytest

from agents.platform import Agent, Container, Kinds
from agents.services.loaded import KIND, digest
from bus import MemoryBus, MemoryNetwork, Refused
from bus.aio import query

PATROL = """
from agents import request

SERVICES = ("patrol",)
given = []

def main(team, robot="happy", laps: int = 1):
    given.append([robot, laps])

@request("given")
def what():
    return given
"""


class Place:
    """A container with a folder of applications, on a network in memory."""

    def __init__(self, folder: Path) -> None:
        self.file = folder / "patrol.py"
        self.file.write_text(PATROL)
        self._network = MemoryNetwork()
        self._kinds = Kinds([folder])

    def start(self, **properties: Any) -> Any:
        """Have one started; returns what it says of itself, and what its `main` was given."""
        return asyncio.run(self._start({"program": "patrol", **properties}))

    async def _start(self, properties: dict[str, Any]) -> Any:
        order = {"do": "start", "name": "patrol@apps", "kind": KIND, "properties": properties}
        outside = MemoryBus(self._network)
        async with (
            Container(MemoryBus(self._network), "shop", lambda report: None, kinds=self._kinds),
            Container(outside, "lab") as lab,
        ):
            await query(outside, "shop/containers/shop/control", order, 10.0)
            asker = Agent("asker@lab")
            await lab.start(asker)
            while not (given := (await asker.request("patrol@apps", "given")).value()):
                await asyncio.sleep(0.01)  # its main begins in a thread
            return (await query(outside, "apps/agents/patrol/description", None, 5.0))[0].value, given


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Place:
    monkeypatch.setattr("agents.client.discovery.MEETING_TIME", 0.1)
    return Place(tmp_path)


def test_a_program_is_found_by_its_name_and_found_in_the_directory(place: Place) -> None:
    description, given = place.start(arguments={"laps": 3}, sha256=digest(place.file))
    assert given == [["happy", 3]]
    assert description["services"] == ["application", "patrol"]
    assert description["requests"] == ["given"]
    assert description["properties"]["program"] == "patrol"


@pytest.mark.parametrize(
    ("properties", "text", "why"),
    [
        ({"program": "petrol"}, PATROL, "there is no application 'petrol' there; copy petrol.py into"),
        ({"program": "/tmp/patrol.py"}, PATROL, "'/tmp/patrol.py' names no application"),
        ({"program": 7}, PATROL, "the properties of an application are like"),
        ({"arguments": [1]}, PATROL, "the properties of an application are like"),
        ({"arguments": {"lapse": 1}}, PATROL, "it takes robot, laps"),
        ({"sha256": "0" * 64}, PATROL, "patrol.py there is another program than yours"),
        ({}, "def main(team:\n", "patrol.py, line 1: '(' was never closed"),
        ({}, "import sys\nsys.exit(1)\n", "patrol calls sys.exit as it is loaded"),
        ({}, "x = 1\n", "has no function main(team)"),
    ],
)
def test_what_cannot_be_loaded_is_refused_in_one_sentence(
    place: Place, properties: dict[str, Any], text: str, why: str
) -> None:
    place.file.write_text(text)
    with pytest.raises(Refused) as caught:
        place.start(**properties)
    assert why in caught.value.why
    assert "ProgramNotValid" not in caught.value.why
    assert "\n" not in caught.value.why


def test_its_text_is_never_taken_from_the_bus(place: Place) -> None:
    place.file.unlink()
    with pytest.raises(Refused, match="there is no application 'patrol' there"):
        place.start(text=PATROL)
