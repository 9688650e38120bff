"""Containers and agents from the command line, run as people run them."""

import json
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from acromovi.__main__ import main
from tests.acromovi.container_process import container, starting
from tests.waiting import exit_code

COUNTER = """
import time
from agents.platform import Agent, every, request

class Counter(Agent):
    services = ("counting",)

    async def setup(self):
        self.count = self.properties.get("first", 0)

    def pack(self):
        return {"count": self.count}

    def unpack(self, state):
        self.count = state["count"]

    @request("next")
    def next(self):
        self.count += 1
        return self.count

    @request("block")
    async def block(self):
        time.sleep(3600.0)
"""


@pytest.fixture
def acromovi(capsys: pytest.CaptureFixture[str]) -> Callable[..., Any]:
    """Runs a command that succeeds and prints JSON."""

    def run(*arguments: str) -> Any:
        capsys.readouterr()
        code = main([*arguments, "--json"])
        shown = capsys.readouterr()
        assert code == 0, shown.err
        return json.loads(shown.out)

    return run


@pytest.fixture
def apps(tmp_path: Path) -> str:
    (tmp_path / "counter_for_tests.py").write_text(COUNTER)
    return str(tmp_path)


def test_an_agent_is_started_asked_looked_into_suspended_resumed_and_stopped(
    acromovi: Callable[..., Any], robot: str, apps: str, capsys: pytest.CaptureFixture[str]
) -> None:
    name = f"counter@{robot}"
    with container(robot, "--apps", apps) as process:
        started = acromovi("agent", "start", name, "counter_for_tests:Counter", "first=41", "--in", robot)
        assert started == {"name": name, "state": "active", "container": robot}
        assert acromovi("ask", name, "next") == 42
        seen = acromovi("introspect", name)
        assert (seen["kind"], seen["properties"], seen["state"]) == (
            "counter_for_tests:Counter",
            {"first": 41},
            "active",
        )
        assert main(["introspect", name]) == 0
        assert f"{name} is active in {robot}, of the kind counter_for_tests:Counter" in capsys.readouterr().out
        assert acromovi("agent", "suspend", name)["state"] == "suspended"
        assert main(["ask", name, "next"]) == 1
        assert acromovi("agent", "resume", name)["state"] == "active"
        assert main(["agent", "stop", f"countre@{robot}"]) == 1
        assert f"did you mean {name}?" in capsys.readouterr().err
        assert main(["agent", "move", name, robot]) == 1
        assert f"it lives in {robot} already" in capsys.readouterr().err
        assert main(["agent", "start", f"x@{robot}", "counter_for_tests:Countr", "--in", robot]) == 1
        assert "did you mean Counter?" in capsys.readouterr().err
        assert main(["agent", "start", f"x@{robot}", "counter_for_tests:Counter", "--in", f"{robot}x"]) == 1
        assert f"there is no container '{robot}x'; did you mean '{robot}'?" in capsys.readouterr().err
        assert acromovi("agent", "stop", name)["state"] == "deleted"
        process.send_signal(signal.SIGTERM)
        assert exit_code(process) == 143


def test_a_container_ends_even_while_an_agent_blocks_it(acromovi: Callable[..., Any], robot: str, apps: str) -> None:
    with container(robot, "--apps", apps) as process:
        acromovi("agent", "start", f"counter@{robot}", "counter_for_tests:Counter", "--in", robot)
        assert main(["ask", f"counter@{robot}", "block", "--timeout", "0.3"]) == 1
        process.send_signal(signal.SIGINT)
        assert exit_code(process) == 130


def test_a_second_container_of_one_name_refuses_and_names_the_first(robot: str) -> None:
    with container(robot) as first, starting(robot) as second:
        assert exit_code(second) == 1
        assert second.stdout is not None
        assert second.stdout.read() == "", "it has never served"
        assert second.stderr is not None
        holder = (
            f"the container {robot} is on this bus already, in process {first.pid} on this machine; end that one, or"
        )
        assert holder in second.stderr.read()
        assert first.poll() is None


def test_with_force_a_container_waits_until_the_other_of_its_name_has_ended(robot: str) -> None:
    with container(robot) as first, starting(robot, "--force") as second:
        assert second.stderr is not None
        assert "waiting until it has ended" in second.stderr.readline()
        first.send_signal(signal.SIGTERM)
        assert second.stdout is not None
        assert json.loads(second.stdout.readline()) == {"container": robot}


def test_a_container_that_follows_a_killed_one_is_not_refused(robot: str) -> None:
    with container(robot) as first:
        first.kill()
        with container(robot) as second:
            second.send_signal(signal.SIGTERM)
            assert exit_code(second) == 143


def test_of_two_containers_of_one_name_that_start_together_one_stays(robot: str, until: Callable[..., None]) -> None:
    with starting(robot) as one, starting(robot) as other:
        until(lambda: one.poll() is not None or other.poll() is not None, "one of them ends")
        stays, leaves = (one, other) if one.poll() is None else (other, one)
        assert leaves.poll() == 1
        assert stays.stdout is not None
        assert json.loads(stays.stdout.readline()) == {"container": robot}
        assert stays.poll() is None


def test_a_robots_container_serves_while_its_robot_is_absent(robot: str) -> None:
    with container("--robot", robot) as process:
        process.send_signal(signal.SIGINT)
        assert exit_code(process) == 130


def test_a_folder_that_is_not_there_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["container", "workshop", "--apps", os.devnull + "/nowhere"])
    assert "there is no folder" in capsys.readouterr().err


@pytest.mark.parametrize("action", ["start", "stop", "suspend", "resume", "move"])
def test_the_help_of_an_action_has_an_example_and_exit_codes(action: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["agent", action, "--help"])
    shown = capsys.readouterr().out
    assert f"acromovi agent {action}" in shown.partition("example")[2]
    assert "Exit codes: " in shown


def test_an_agent_is_cloned_with_its_state(apps: str, robot: str, acromovi: Callable[..., Any]) -> None:
    name, twin = f"counter@{robot}", f"twin@{robot}"
    with container(robot, "--apps", apps):
        acromovi("agent", "start", name, "counter_for_tests:Counter", "first=4", "--in", robot)
        assert acromovi("agent", "clone", name, twin) == {"name": twin, "state": "active", "container": robot}
        assert acromovi("ask", twin, "next") == 5
        assert acromovi("ask", name, "next") == 5
