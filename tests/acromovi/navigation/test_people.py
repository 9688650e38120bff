"""What people tell and ask a navigation from the command line, on the real bus."""

import asyncio
import json
from collections.abc import AsyncIterator, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from acromovi.__main__ import main
from acromovi.navigation.log import messages
from agents.platform import Agent, AgentName, Container, subscription
from apps.indoor_navigation.component import answers_query, is_told
from apps.indoor_navigation.components.user_interface import UserInterface
from apps.indoor_navigation.data import GoalPoint, LogMessage
from bus import Refused, ZenohBus
from tests.acromovi.agents_alive import living
from tests.acromovi.navigation.planning import Planning, navigation


@pytest.fixture
def going(robot: str) -> Iterator[str]:
    """A robot whose missions do not end by themselves."""
    with living(robot, *navigation(robot, "going")):
        yield robot


@pytest.fixture
def arriving(robot: str) -> Iterator[str]:
    """A robot that is there at once."""
    with living(robot, *navigation(robot, "done")):
        yield robot


@pytest.fixture
def failing(robot: str) -> Iterator[str]:
    """A robot that finds no way."""
    with living(robot, *navigation(robot, "failed")):
        yield robot


def test_a_robot_is_sent_its_state_is_told_and_its_mission_ended(
    going: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["navigate", "state", going]) == 0
    assert capsys.readouterr().out == "no mission yet\n"
    assert main(["navigate", "go", going, "3", "-0.5", "--heading", "1.5", "--json"]) == 0
    mission = json.loads(capsys.readouterr().out)["mission"]
    assert main(["navigate", "state", going]) == 0
    shown = capsys.readouterr().out.splitlines()
    assert shown[0].startswith(f"{mission}: going: as the test wants it, for ")
    assert shown[1] == "goal         x 3.00 m, y -0.50 m, heading 1.50 rad"
    assert main(["navigate", "state", going, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["goal"]["y"] == -0.5
    assert main(["navigate", "cancel", going]) == 0
    assert capsys.readouterr().out == f"{mission} is cancelled\n"
    assert main(["navigate", "cancel", going]) == 0
    assert "no mission was active" in capsys.readouterr().out


def test_who_waits_is_told_how_the_mission_goes_and_ends(arriving: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["navigate", "go", arriving, "1", "2", "--wait"]) == 0
    *log, last = capsys.readouterr().out.splitlines()
    assert last == "done: as the test wants it"
    assert any("done: to (1.00, 2.00)" in line for line in log)


class SlowToTell(UserInterface):
    """A face whose messages reach subscribers long after the end of the mission is answered."""

    @subscription("log")
    async def log(self) -> AsyncIterator[dict[str, Any]]:
        await asyncio.sleep(1.0)
        for message in await self.messages():
            yield message
        await asyncio.sleep(3600.0)


def test_who_waits_is_told_all_even_when_the_last_message_comes_after_the_end(
    robot: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with living(robot, *navigation(robot, "done", SlowToTell)):
        assert main(["navigate", "go", robot, "1", "2", "--wait"]) == 0
    log, last = capsys.readouterr().out.splitlines()
    assert log.endswith("done: to (1.00, 2.00)")
    assert last == "done: as the test wants it"


class Jumbled(UserInterface):
    """A face that hears of two components whose clocks differ: the later message has the earlier stamp."""

    @subscription("log")
    async def log(self) -> AsyncIterator[dict[str, Any]]:
        yield asdict(LogMessage(5.0, "path_planning", "m1", "info", "first"))
        yield asdict(LogMessage(4.0, "user_interface", "m1", "info", "second"))
        yield asdict(LogMessage(5.0, "path_planning", "m1", "info", "first"))  # as after a reconnect
        raise Refused("that is all")


def test_messages_of_components_with_different_clocks_are_all_shown_and_once(robot: str) -> None:
    async def heard() -> list[str]:
        with ZenohBus.open() as bus:
            async with Container(bus) as container:
                person = Agent(f"person@{robot}")
                await container.start(person)
                told = messages(person, AgentName("user_interface", robot))
                return [(await anext(told))["what"] for _ in range(2)]

    with living(robot, *navigation(robot, "done", Jumbled)):
        assert asyncio.run(heard()) == ["first", "second"]


def test_a_mission_that_fails_is_an_exit_code_and_a_reason(failing: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["navigate", "go", failing, "1", "2", "--wait", "--json"]) == 1
    out, err = capsys.readouterr()
    assert json.loads(out)["state"] == "failed"
    assert err == "acromovi navigate go: failed: as the test wants it\n"


def test_who_waits_too_long_is_told_what_to_do(going: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["navigate", "go", going, "1", "2", "--wait", "--timeout", "0.3"]) == 1
    assert "has not ended within 0.3 s; to follow it: acromovi navigate watch" in capsys.readouterr().err


def test_the_log_is_what_was_told(arriving: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["navigate", "go", arriving, "1", "2", "--wait", "--json"]) == 0
    mission = json.loads(capsys.readouterr().out)["mission"]
    assert main(["navigate", "log", arriving, "--json"]) == 0
    (message,) = map(json.loads, capsys.readouterr().out.splitlines())
    assert (message["mission"], message["what"]) == (mission, "done: to (1.00, 2.00)")
    assert main(["navigate", "log", arriving]) == 0
    assert capsys.readouterr().out.strip().endswith(f"{mission}  done: to (1.00, 2.00)")


def test_the_mission_is_drawn_as_it_stands_and_at_its_end(
    arriving: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    end, now = tmp_path / "end.svg", tmp_path / "now.png"
    assert main(["navigate", "go", arriving, "1", "2", "--wait", "--picture", str(end)]) == 0
    assert "as the test wants it" in end.read_text()
    assert main(["navigate", "picture", arriving, str(now)]) == 0
    assert now.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("order", [["state"], ["cancel"], ["log"], ["go", "1", "2"], ["picture", "file.svg"]])
def test_a_robot_that_nobody_navigates_is_told_with_what_to_do(
    robot: str, order: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    first, *rest = order
    assert main(["navigate", first, robot, *rest]) == 1
    err = capsys.readouterr().err
    assert err.startswith(f"acromovi navigate: nobody navigates {robot}")
    assert err.endswith(f"start it with: acromovi navigate up {robot}\n")


def test_a_refusal_is_one_sentence(going: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["navigate", "go", going, "1", "2", "--tolerance", "-1"]) == 1
    err = capsys.readouterr().err
    assert "tolerance must be at least 0.1 m, not -1" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["go", "happy", "one", "2"], 'give X and Y in m, or one name in quotes, not "one" "2"'),
        (["go", "happy", "Lab", "2", "b"], "one name in quotes"),
        (["go", "happy", "inf", "2"], "inf is not a finite number"),
        (["picture", "happy", "now.gif"], "ends neither in .svg nor in .png"),
        (["picture", "happy", "/no/folder/now.svg"], "there is no folder"),
        (["wander", "happy"], "invalid choice"),
    ],
)
def test_wrong_usage_is_told(arguments: list[str], why: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["navigate", *arguments])
    assert ended.value.code == 2
    assert why in capsys.readouterr().err


def test_a_picture_at_the_end_needs_one_who_waits(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["navigate", "go", "happy", "1", "2", "--picture", "end.svg"]) == 2
    assert "add --wait" in capsys.readouterr().err


def test_watching_needs_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["navigate", "watch", "happy"]) == 1
    assert "needs a terminal" in capsys.readouterr().err


class HearsLate(Planning):
    """A path planning that has not yet heard of the goal when it is asked for the first time."""

    is_asked_again = False

    @answers_query("state")
    def tell_state(self) -> dict[str, Any]:
        if self.goal is None:
            raise Refused("the goal is really on its way")  # on a busy machine; this must not count as the first time
        told = super().tell_state()
        if not self.is_asked_again:
            self.is_asked_again = True
            return {**told, "mission": ""}
        return told


class Forgets(Planning):
    """A path planning that is begun anew right after the first goal has come, and knows it no more."""

    is_anew = False

    @is_told(GoalPoint)
    async def take_up(self, goal: GoalPoint) -> None:
        if self.is_anew:
            await super().take_up(goal)
        self.is_anew = True


@pytest.mark.parametrize(("planning", "is_told_again"), [(HearsLate, False), (Forgets, True)])
def test_a_goal_is_told_again_only_if_planning_has_forgotten_it(
    robot: str, planning: type[Planning], is_told_again: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    with living(robot, *navigation(robot, "done", planning=planning)):
        assert main(["navigate", "go", robot, "1", "2", "--wait"]) == 0
    log, last = capsys.readouterr().out.rsplit("\n", 2)[:2]
    assert ("path planning was restarted" in log) is is_told_again
    assert last == "done: as the test wants it"
