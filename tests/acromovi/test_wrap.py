"""`acromovi wrap`: a program as an agent on the bus, from start to Ctrl-C."""

import asyncio
import signal
import subprocess
import sys
import uuid
from pathlib import Path

import pytest

from acromovi.__main__ import main
from agents.platform import Agent, AgentName, Container
from bus import ZenohBus
from tests.waiting import exit_code, waiting

COUNTER = """
[program]
command = ["sh", "-c", 'while read word number; do echo "SUM $number"; done']
[[requests]]
name = "add"
takes = { number = "integer" }
send = "ADD {number}"
answer = 'SUM (?P<sum>.*)'
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "counter.toml"
    path.write_text(COUNTER)
    return path


def test_a_wrapped_program_is_asked_over_the_bus_and_ends_with_ctrl_c(file: Path) -> None:
    robot = f"robot-{uuid.uuid4().hex[:8]}"
    command = [sys.executable, "-m", "acromovi", "wrap", str(file), "--name", f"counter@{robot}"]

    async def ask() -> object:
        with ZenohBus.open() as bus:
            async with Container(bus, f"asker-{robot}", platform=robot) as container:
                asker = Agent(AgentName("asker", robot))
                await container.start(asker)
                async with waiting():
                    while not (outcome := await asker.request(f"counter@{robot}", "add", number=3)).is_done:
                        await asyncio.sleep(0.05)
                return outcome.value()

    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == f"counter@{robot} lives, and can be asked for add; stop with Ctrl-C\n"
        assert asyncio.run(ask()) == {"sum": 3}
        process.send_signal(signal.SIGINT)
        assert exit_code(process) == 130


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["nothing.toml", "--name", "a@b"], "there is no file nothing.toml"),
        (["acts", "--name", "colours"], "'colours' names no agent"),
    ],
)
def test_a_mistake_is_told_in_one_sentence(capsys: pytest.CaptureFixture[str], arguments: list[str], why: str) -> None:
    assert main(["wrap", *arguments]) == 1
    assert why in capsys.readouterr().err
