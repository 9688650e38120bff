"""What the pages share: results that return with their agent, and a watch over controllers that never ends."""

import asyncio
from collections.abc import Awaitable, Callable

import pytest

from agents.platform import Agent, Container, Report, request
from apps.remote_vision.program import RemoteVision
from apps.remote_vision.settings import RemoteVisionSettings
from apps.remote_vision.viewing import ORIGINAL, RESULT
from bus import MemoryBus
from tests.waiting import waiting


class FakeVision(Agent):
    """Gives each chain a stream, and counts how often it was asked."""

    asked = 0

    @request("stream")
    async def stream(self, chain: list[dict[str, str]]) -> dict[str, str]:
        FakeVision.asked += 1
        return {"key": f"happy/agents/vision/results/{chain[0]['operation']}"}


def play(story: Callable[[RemoteVision, Container, list[Report]], Awaitable[None]]) -> None:
    async def run() -> None:
        bus, reports = MemoryBus(), list[Report]()
        async with Container(bus, "happy") as robot, Container(MemoryBus(bus.network), "page", reports.append) as home:
            agent = Agent("page@apps")
            assert await home.start(agent)
            async with RemoteVision(agent, RemoteVisionSettings.load()) as program:
                await story(program, robot, reports)

    asyncio.run(run())


async def until(condition: Callable[[], object]) -> None:
    async with waiting():
        while not condition():
            await asyncio.sleep(0.01)


def test_the_stream_of_a_result_is_requested_again_when_nothing_comes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("apps.remote_vision.program._RETURN", 0.1)

    async def story(program: RemoteVision, robot: Container, _: list[Report]) -> None:
        assert await robot.start(FakeVision("vision@happy"))
        await until(lambda: program.team.has("happy", "vision"))
        viewing = program.begin_viewing("happy", "here")
        viewing.sockets = 1
        await program.show_result(viewing, "grey", [{"operation": "grey"}])
        assert viewing.keys[RESULT] == "happy/agents/vision/results/grey"
        assert viewing.outcomes[0][1] == "grey: shown"
        asked = FakeVision.asked
        await until(lambda: FakeVision.asked > asked)
        program.choose_camera(viewing, "doc")
        assert viewing.keys == {ORIGINAL: "doc/camera/image/compressed"}

    play(story)


def test_what_an_agent_cannot_be_asked_is_an_outcome_in_words() -> None:
    async def story(program: RemoteVision, robot: Container, _: list[Report]) -> None:
        viewing = program.begin_viewing("happy", "here")
        await program.show_result(viewing, "convolution", [{"operation": "convolution", "kernel": "1" * 400_000}])
        assert viewing.outcomes[0][1].startswith("convolution: ")
        assert RESULT not in viewing.keys

    play(story)


def test_an_error_does_not_end_the_watch_over_a_controller(monkeypatch: pytest.MonkeyPatch) -> None:
    async def story(program: RemoteVision, robot: Container, reports: list[Report]) -> None:
        head, looks = program.head("happy"), list[float]()

        async def check(now: float) -> None:
            looks.append(now)
            raise RuntimeError("unexpected")

        monkeypatch.setattr(head, "check", check)
        await until(lambda: len(looks) > 2)
        assert "the controller of the head of happy" in reports[0].what

    play(story)
