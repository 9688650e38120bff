"""`acromovi command` against a robot that is a few lines on the bus."""

import json
from collections.abc import Iterator
from typing import Any

import pytest

from acromovi.__main__ import main
from bus import Refused, ZenohBus, keys


@pytest.fixture
def told(robot: str) -> Iterator[list[dict[str, Any]]]:
    heard: list[dict[str, Any]] = []

    def answer(arguments: dict[str, Any]) -> dict[str, Any]:
        heard.append(arguments)
        if not arguments:
            raise Refused("move needs distance: a number")
        return {"accepted": True, "id": "move-1"}

    with ZenohBus.open() as bus, bus.serve(keys.MOVE.key(robot), answer):
        yield heard


def test_arguments_reach_the_robot_and_its_answer_is_printed(
    robot: str, told: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["command", robot, "move", "distance=0.5", "note=slowly", 'more={"a": [1]}']) == 0
    assert told == [{"distance": 0.5, "note": "slowly", "more": {"a": [1]}}]
    assert json.loads(capsys.readouterr().out) == {"accepted": True, "id": "move-1"}


def test_refusal_is_told_and_fails(robot: str, told: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["command", robot, "move"]) == 1
    assert "move needs distance" in capsys.readouterr().err


def test_robot_that_is_not_there_is_told_and_fails(robot: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["command", robot, "stop", "--timeout", "0.3"]) == 1
    assert robot in capsys.readouterr().err


def test_command_that_does_not_exist_is_answered_with_those_that_do(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["command", "happy", "dance"]) == 2
    assert "gripper" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["command", "happy", "move", "quickly"])
    assert "write for example on=true" in capsys.readouterr().err
