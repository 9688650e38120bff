"""A robot with its agents under one virtual clock, as the tests of the components have it, and a console of it."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from apps.console.program import Console, ConsoleInputs
from apps.console.settings import ConsoleSettings
from apps.web.access import PasswordHash, Sessions
from tests.agents.components.conftest import loop as loop
from tests.agents.components.conftest import make_lab as make_lab

if TYPE_CHECKING:
    from tests.agents.components.conftest import Lab, MakeLab

PASSWORD = "correct horse"


@pytest.fixture
def lab(make_lab: "MakeLab") -> "Lab":
    return make_lab()


@pytest.fixture
def console(lab: "Lab") -> Iterator[Console]:
    """A console whose agent is `app@lab`, with sessions that are over at once; it knows the robot."""

    async def begin() -> Console:
        sessions = Sessions(PasswordHash.of(PASSWORD), lasts=0.0, pause=0.0)
        return await Console(lab.app, ConsoleSettings.load(), ConsoleInputs(), sessions=sessions).__aenter__()

    console = lab.do(begin())
    lab.until(lambda: any(robot.description for robot in console.robots.robots.values()))
    yield console
    lab.do(console.__aexit__())
