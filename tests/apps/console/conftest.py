"""A robot with its agents under one virtual clock, as the tests of the components have it, and a console of it."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from apps.console.program import Console, ConsoleInputs
from apps.console.settings import ConsoleSettings
from tests.agents.components.conftest import loop as loop
from tests.agents.components.conftest import make_lab as make_lab

if TYPE_CHECKING:
    from tests.agents.components.conftest import Lab, MakeLab


@pytest.fixture
def lab(make_lab: "MakeLab") -> "Lab":
    return make_lab()


@pytest.fixture
def console(lab: "Lab") -> Iterator[Console]:
    """A console whose agent is `app@lab`; it knows the robot."""

    async def begin() -> Console:
        return await Console(lab.app, ConsoleSettings.load(), ConsoleInputs()).__aenter__()

    console = lab.do(begin())
    lab.until(lambda: any(robot.description for robot in console.robots.robots.values()))
    yield console
    lab.do(console.__aexit__())
