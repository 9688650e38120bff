"""What moves for `acromovi send` stops when that program is killed or freezes, with a broker in between as well."""

import asyncio
import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import pytest

from agents.platform import Agent, AgentName, answers, request
from agents.platform.conversations.responder_conversation import agree, attended
from agents.services.broker import BrokerAgent
from tests.acromovi.agents_alive import living
from tests.acromovi.team.private_bus import private_bus
from tests.live_team import environment
from tests.waiting import end_of, wait_until

BROKERED = json.dumps({"action": "broker", "arguments": {"request": "move", "robot": "carts", "within": 60}})
WHEN = json.dumps({"action": "move", "when": {"query": "is_free"}})
LINES = {
    "request": ["request", "cart@carts", "--action", "move"],
    "request-when": ["request-when", "cart@carts", "--content", WHEN],
    "brokering": ["proxy", "broker@carts", "--content", BROKERED],
}


class Cart(Agent):
    """Moves until it is told to stop, as the agent of a robot's wheels does."""

    def __init__(self) -> None:
        super().__init__(AgentName("cart", "carts"))
        self.is_moving = False

    @answers("is_free")
    async def is_free(self) -> bool:
        return True

    @request("move", agrees_itself=True)
    async def move(self) -> None:
        agree()
        with attended():
            self.is_moving = True
            try:
                await asyncio.sleep(600.0)
            finally:
                self.is_moving = False


@pytest.fixture(scope="module")
def cart() -> Iterator[tuple[Cart, str]]:
    profile, agent = private_bus(), Cart()
    with living("carts", agent, BrokerAgent(AgentName("broker", "carts")), profile=profile):
        yield agent, profile


@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "frozen"])
def test_the_motion_ends_with_the_program_that_asked_for_it(cart: Any, line: str, number: signal.Signals) -> None:
    agent, profile = cart
    command = [sys.executable, "-m", "acromovi", "send", *LINES[line], "--wait", "60", "--bus", profile]
    with subprocess.Popen(command, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        try:
            wait_until(lambda: agent.is_moving, "it moves")
            process.send_signal(number)
            wait_until(lambda: not agent.is_moving, "it stands")
        finally:
            process.kill()
            end_of(process)
