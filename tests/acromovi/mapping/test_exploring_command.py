"""`acromovi map build --explore` as a process: it sends a robot on, and nothing moves by it once it is dead or frozen.

Agents with the names of the robot's play mapping and navigation. A robot is sent by missions of the navigation, which
end by themselves; so what is to be shown of a dead explorer is that no further mission comes, and of one that is asked
to end that it cancels the last.
"""

import asyncio
import json
import os
import signal
import sys
import uuid
from argparse import ArgumentParser
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from math import cos
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acromovi.mapping import build
from agents.components.mapping.mapping_tools import grid_message
from agents.platform import Agent, Container, request
from bus import keys
from bus.session import ZenohBus
from geometry import Pose2D
from maps.occupancy import OccupancyGrid
from tests.live_team import ROOT
from tests.waiting import waiting

GRID_PERIOD = 0.2  # s


class PlayedMapping(Agent):
    """mapping@happy: a room with two openings, and a robot in its middle."""

    def __init__(self) -> None:
        super().__init__("mapping@happy")
        self.ended = 0

    async def setup(self) -> None:
        cells = np.full((60, 60), -1, np.int8)
        cells[10:50, 10:50] = 100
        cells[12:48, 12:48] = 0
        cells[25:35, 48:50] = cells[25:35, 10:12] = 0
        self._grid = OccupancyGrid(cells, 0.1, Pose2D(-3.0, -3.0))
        self.every(GRID_PERIOD, self._show)

    async def _show(self) -> None:
        self.bus.put(keys.MAP.key("happy"), grid_message(self._grid, 0))

    @request("start")
    async def start(self) -> dict[str, Any]:
        """Begin."""
        return self._state(True)

    @request("state")
    async def tell(self) -> dict[str, Any]:
        """How far it is."""
        return self._state(True)

    @request("stop")
    async def stop(self) -> dict[str, Any]:
        """End."""
        self.ended += 1
        return self._state(False)

    def _state(self, building: bool) -> dict[str, Any]:
        return {"building": building, "pose": [0.0, 0.0, 0.0], "odom": [1.0, 0.0, 0.0], "trouble": None}


class PlayedInterface(Agent):
    """user_interface@happy: missions that end as the test says."""

    services = ("navigation",)

    def __init__(self) -> None:
        super().__init__("user_interface@happy")
        self.goals: list[tuple[float, float, float]] = []
        self.cancelled = 0
        self.standing = "active"

    @request("go")
    async def go(self, x: float, y: float, heading: float, tolerance: float | None = None) -> dict[str, Any]:
        """Drive."""
        self.goals.append((x, y, heading))
        self.standing = "active"
        return {"mission": f"mission {len(self.goals)}"}

    @request("state")
    async def tell(self) -> dict[str, Any]:
        """How the mission stands."""
        return {"mission": f"mission {len(self.goals)}", "state": self.standing}

    @request("cancel")
    async def cancel(self) -> dict[str, Any]:
        """End it."""
        self.cancelled += 1
        return {"mission": f"mission {len(self.goals)}"}


class Played:
    """The agents of happy, and the command beside them."""

    def __init__(self, profile: str) -> None:
        self.mapping = PlayedMapping()
        self.interface = PlayedInterface()
        self.profile = profile

    async def begin(self) -> asyncio.subprocess.Process:
        """Start the command, and wait for its first mission."""
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "acromovi", "map", "build", "happy", "--explore", "--json", "--bus", self.profile),
            cwd=ROOT,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
        )
        await self.until(lambda: self.interface.goals or process.returncode is not None)
        return process

    async def until(self, condition: Callable[[], object]) -> None:
        async with waiting():
            while not condition():
                await asyncio.sleep(0.02)


@asynccontextmanager
async def played() -> AsyncIterator[Played]:
    profile = f"local:explore-{uuid.uuid4().hex[:12]}"
    at = Played(profile)
    with ZenohBus.open(profile) as bus:
        async with Container(bus, "happy") as container:
            assert await container.start(at.mapping)
            assert await container.start(at.interface)
            yield at


def play(story: Callable[[Played], Awaitable[None]]) -> None:
    async def run() -> None:
        async with played() as at:
            await story(at)

    asyncio.run(run())


def test_a_robot_is_sent_to_openings_by_its_odometry_until_it_has_seen_them() -> None:
    async def story(at: Played) -> None:
        process = await at.begin()
        while process.returncode is None:
            at.interface.standing = "done"
            await asyncio.sleep(0.05)
        out, err = await process.communicate()
        assert process.returncode == 0, err.decode()
        lines = [json.loads(line) for line in out.decode().splitlines()]
        assert lines[-1] == {"ended": "explored"}
        assert at.mapping.ended == 1
        sides = {(round(x), round(cos(heading))) for x, _, heading in at.interface.goals}
        assert sides == {(-3, -1), (1, 1)}, "odom is 1 m to the right of map, and it looks out of each opening"

    play(story)


def test_a_robot_explores_on_though_no_picture_can_be_drawn_which_is_reported_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(build, "PICTURE_PERIOD", 0.0)
    (tmp_path / ".live.png.part.png").mkdir()
    parser, run = ArgumentParser(), build.COMMAND.run
    assert run is not None
    build.COMMAND.add_arguments(parser)

    async def story(at: Played) -> None:
        words = ["happy", "--explore", "--picture", str(tmp_path / "live.png"), "--bus", at.profile]
        building = asyncio.create_task(asyncio.to_thread(run, parser.parse_args(words)))
        while not building.done():
            at.interface.standing = "done"
            await asyncio.sleep(0.05)
        assert await building == 0
        assert at.mapping.ended == 1

    play(story)
    err = capsys.readouterr().err
    assert err.startswith(f"acromovi map build: {tmp_path}/live.png cannot be drawn: ")
    assert err.count("\n") == 1


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_no_mission_comes_from_an_explorer_that_is_dead_or_frozen(number: signal.Signals) -> None:
    async def story(at: Played) -> None:
        process = await at.begin()
        os.kill(process.pid, number)
        try:
            await asyncio.sleep(0.5)  # what was on its way
            count = len(at.interface.goals)
            at.interface.standing = "done"
            await asyncio.sleep(3.0)  # three looks of an explorer that lives
            assert len(at.interface.goals) == count
        finally:
            if process.returncode is None:
                process.kill()
            await process.communicate()

    play(story)


def test_an_explorer_that_is_asked_to_end_cancels_the_mission_and_says_so_in_its_last_line() -> None:
    async def story(at: Played) -> None:
        process = await at.begin()
        process.send_signal(signal.SIGINT)
        out, err = await process.communicate()
        assert process.returncode == 130, err.decode()
        assert json.loads(out.splitlines()[-1]) == {"ended": "interrupted"}
        assert at.interface.cancelled == 1
        assert at.mapping.ended == 1

    play(story)


def test_an_explorer_ends_when_another_program_cancels_the_mission() -> None:
    async def story(at: Played) -> None:
        process = await at.begin()
        at.interface.standing = "cancelled"
        _, err = await process.communicate()
        assert process.returncode == 1
        assert "another program has cancelled the mission of happy" in err.decode()
        assert len(at.interface.goals) == 1

    play(story)
