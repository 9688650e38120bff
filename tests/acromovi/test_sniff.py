"""`acromovi sniff`, against agents that talk on the real bus."""

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from acromovi.__main__ import main
from agents.platform import Agent, AgentName, every, request
from tests.acromovi.agents_alive import living
from tests.waiting import end_of

ROOT = Path(__file__).resolve().parents[2]


class Base(Agent):
    @request("move")
    async def move(self, distance: float) -> float:
        return distance


class App(Agent):
    @every(0.05)
    async def drive(self) -> None:
        await self.request(AgentName("base", self.name.platform), "move", distance=1.0)


@pytest.fixture
def talking(robot: str) -> Iterator[str]:
    """A robot whose base is told to move all the time."""
    with living(robot, Base(AgentName("base", robot)), App(AgentName("app", robot))):
        yield robot


def test_it_prints_each_message_of_those_asked_for_once_and_in_order(
    talking: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sniff", f"app@{talking}", "x-*", "--seconds", "2", "--json"]) == 0
    said: list[dict[str, Any]] = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert said
    assert [each["time"] for each in said] == sorted(each["time"] for each in said)
    whole: dict[str, list[str]] = {}
    for each in said:
        whole.setdefault(each["message"]["conversation_id"], []).append(each["message"]["performative"])
    for acts in list(whole.values())[1:-1]:  # the first and the last may be cut
        assert acts == ["request", "agree", "inform"]
    assert all(each["container"] == talking for each in said)


def test_ctrl_c_ends_it_with_the_diagrams(talking: str, tmp_path: Path) -> None:
    picture = tmp_path / "talk.svg"
    words = ["sniff", f"*@{talking}", "--diagram", "--svg", str(picture)]
    with subprocess.Popen(
        [sys.executable, "-m", "acromovi", *words], cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            process.send_signal(signal.SIGINT)
            rest, errors = end_of(process)
        finally:
            process.kill()
    assert (process.returncode, errors) == (130, "")
    assert f"@{talking} → " in line
    _, _, diagram = rest.partition("\n\n")
    assert f"app@{talking}"[:20] in diagram
    assert "▶│" in diagram
    assert f"base@{talking}"[:20] in "".join(ElementTree.fromstring(picture.read_text()).itertext())


def test_what_is_no_message_is_shown_as_unreadable(robot: str, capsys: pytest.CaptureFixture[str]) -> None:
    class Babbler(Agent):
        @every(0.1)
        async def babble(self) -> None:
            self.bus.put(f"{robot}/containers/{robot}/said", {"hello": "there"})

    with living(robot, Babbler(AgentName("babbler", robot))):
        assert main(["sniff", "--seconds", "2"]) == 0
    shown = capsys.readouterr()
    assert f"17 bytes of {robot} are unreadable: " in shown.out
    assert "Traceback" not in shown.err


def test_when_nobody_says_anything_it_says_what_to_try(robot: str, capsys: pytest.CaptureFixture[str]) -> None:
    with living(robot, Base(AgentName("base", robot))):
        assert main(["sniff", f"basis@{robot}", "--seconds", "1", "--diagram"]) == 0
        shown = capsys.readouterr()
        assert f"nothing has been said; none of the agents here is called basis@{robot}" in shown.err
        assert "nobody said anything" in shown.out
        assert main(["sniff", f"base@{robot}", "--seconds", "1"]) == 0
        assert "nothing has been said; agents speak when there is something to do" in capsys.readouterr().err


def test_a_picture_that_cannot_be_written_is_wrong_usage_before_anything_is_heard(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for path in (tmp_path, tmp_path / "nowhere" / "talk.svg"):
        with pytest.raises(SystemExit, match="2"):
            main(["sniff", "--svg", str(path)])
    shown = capsys.readouterr().err
    assert f"{tmp_path} is a folder" in shown
    assert f"there is no folder {tmp_path / 'nowhere'}" in shown
    assert main(["sniff", "--json", "--diagram"]) == 2
