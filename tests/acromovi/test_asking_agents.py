"""`acromovi ps`, `directory` and `ask`, against agents on the real bus."""

import io
import json
from collections.abc import AsyncIterator, Iterator
from typing import Any, ClassVar

import pytest

from acromovi import ps, yellow_pages
from acromovi.__main__ import main
from acromovi.known_agents import advice
from agents.platform import Agent, AgentName, AgentState, request, subscription
from agents.platform.directory import Description
from bus import Refused
from tests.acromovi.agents_alive import living


class Laser(Agent):
    services: ClassVar[tuple[str, ...]] = ("laser", "component")

    @request("read")
    async def read(self, sector: str = "all") -> dict[str, Any]:
        return {"nearest": 1.5, "sector": sector}

    @request("sleep")
    async def sleep(self) -> None:
        raise Refused("I never sleep")

    @subscription("beams")
    async def beams(self, first: int = 0) -> AsyncIterator[int]:
        for beam in range(first, 3):
            yield beam
        raise Refused("no more light")

    @request("break")
    async def break_down(self) -> None:
        raise RuntimeError("the mirror stands")


@pytest.fixture
def laser(robot: str) -> Iterator[str]:
    agent = Laser(AgentName("laser", robot), {"beams": 181})
    with living(robot, agent):
        yield str(agent.name)


def test_ps_lists_a_living_agent_with_state_container_and_services(
    laser: str, robot: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["ps", "--json"]) == 0
    (row,) = [row for row in json.loads(capsys.readouterr().out)["agents"] if row["name"] == laser]
    assert row == {"name": laser, "state": "active", "container": robot, "services": ["laser", "component"]}


def test_directory_finds_by_service_robot_and_property(
    laser: str, robot: str, capsys: pytest.CaptureFixture[str]
) -> None:
    def found(*filters: str) -> list[dict[str, Any]]:
        assert main(["directory", "--robot", robot, "--json", *filters]) == 0
        agents: list[dict[str, Any]] = json.loads(capsys.readouterr().out)["agents"]
        return agents

    (entry,) = found("--service", "laser", "--property", "beams=181")
    assert entry["name"] == laser
    assert {"read", "sleep"} <= set(entry["requests"])
    assert entry["subscriptions"] == ["beams"]
    assert entry["properties"] == {"beams": 181}
    assert found("--service", "sonar") == found("--property", "beams=180") == []


def test_ask_prints_the_result_as_json(laser: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ask", laser, "read", "sector=front", "--json"]) == 0
    assert capsys.readouterr().out == '{"nearest": 1.5, "sector": "front"}\n'
    assert main(["ask", laser, "read"]) == 0
    assert json.loads(capsys.readouterr().out)["sector"] == "all"


def test_ask_follows_what_an_agent_tells_until_it_ends(laser: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ask", laser, "beams", "first=1", "--follow"]) == 1
    said = capsys.readouterr()
    assert said.out == "1\n2\n"
    assert said.err.startswith("acromovi ask: ")
    assert "no more light" in said.err
    assert said.err.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["sleep"], "refused: I never sleep"),
        (["break"], "the mirror stands"),
        (["reed"], "not-understood: there is no request 'reed' here (did you mean read?); known: "),
        (["read", "sector=3"], "read takes sector as str, not int"),
    ],
)
def test_a_request_that_is_not_done_says_why_in_one_line(
    laser: str, words: list[str], reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["ask", laser, *words]) == 1
    heard = capsys.readouterr()
    assert reason in heard.err
    assert (heard.out, heard.err.count("\n")) == ("", 1)


def test_asking_an_agent_that_is_not_there_names_the_nearest(laser: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ask", laser.replace("laser@", "lazer@"), "read"]) == 1
    assert f"did you mean {laser}?" in capsys.readouterr().err


def test_asking_by_a_name_that_is_none_says_how_names_are_written(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ask", "happy", "read"]) == 1
    assert capsys.readouterr().err == "acromovi ask: 'happy' names no agent; a name is written like base@happy\n"


def test_how_long_to_wait_is_no_argument_of_a_request(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ask", "base@happy", "read", "reply_within=3"]) == 2
    assert "--timeout" in capsys.readouterr().err


def test_advice_is_the_nearest_name_or_the_robots_own_agents_or_a_command() -> None:
    seen = [AgentName("base", "happy"), AgentName("sonar", "happy")]
    assert advice(AgentName("bas", "happy"), seen) == "did you mean base@happy?"
    assert advice(AgentName("sonar", "hapy"), seen) == "did you mean sonar@happy?"
    assert advice(AgentName("follow", "happy"), [AgentName("io", "happy")]) == "those of happy are io@happy"
    assert "acromovi ps" in advice(AgentName("xyzzyplugh", "max"), [AgentName("io", "happy")])
    assert "acromovi up" in advice(AgentName("base", "happy"), [])


def test_lists_are_for_people_too() -> None:
    base = Description(
        AgentName("base", "happy"), AgentState.ACTIVE, "happy", ("base", "component"), ("move",), {"x": [1]}
    )
    shown = io.StringIO()
    ps.show([base], False, shown)
    assert shown.getvalue().splitlines() == [
        "AGENT       STATE   CONTAINER  SERVICES",
        "base@happy  active  happy      base, component",
    ]
    shown = io.StringIO()
    yellow_pages.show([base], False, shown)
    assert shown.getvalue().splitlines() == [
        "base@happy  active in happy",
        "  services: base, component",
        "  requests: move",
        "  x: [1]",
    ]


def test_empty_lists_say_how_to_go_on() -> None:
    shown = io.StringIO()
    ps.show([], False, shown)
    yellow_pages.show([], False, shown)
    assert "acromovi up" in shown.getvalue()
    assert "acromovi ps" in shown.getvalue()
