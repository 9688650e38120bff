"""How the end of a motion is seen, in virtual time: reports are words that the test says."""

import asyncio
from collections.abc import Coroutine
from typing import Any

import pytest

from agents.components.motions import HOLD, PAUSE, SILENCE, TIME_TO_START, MotionGoal, Motions, Phase
from agents.platform.virtual_time import VirtualTimeLoop
from bus import Refused

PERIOD = 0.1  # s between two reports
LONGEST = 10.0


def judge(report: str) -> Phase:
    return Phase(report)


def goal(what: str = "arm move", parts: str = "1", within: float = LONGEST) -> MotionGoal[str]:
    return MotionGoal(what, parts, judge, within)


def play(*stretches: tuple[str, float], motions: Motions[str], motion: Coroutine[Any, Any, str]) -> tuple[float, str]:
    """Follow a motion through stretches of equal reports; return how long it took and how it ended."""

    async def run() -> tuple[float, str]:
        loop = asyncio.get_running_loop()
        following = asyncio.ensure_future(motion)
        ended_at: list[float] = []
        following.add_done_callback(lambda _: ended_at.append(loop.time()))
        await asyncio.sleep(0)
        for report, seconds in stretches:
            for _ in range(round(seconds / PERIOD)):
                if report:
                    motions.hear(report)
                await asyncio.sleep(PERIOD)
        try:
            said = await following
        except Refused as err:
            said = err.why
        return ended_at[0], said

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        return runner.run(run())


@pytest.fixture
def motions() -> Motions[str]:
    return Motions()


def test_motion_ends_when_the_goal_has_been_reported_for_a_moment(motions: Motions[str]) -> None:
    took, said = play(("moving", 1.0), ("arrived", 2.0), motions=motions, motion=motions.follow(goal()))
    assert said == "arrived"
    assert 1.0 + HOLD <= took <= 1.0 + HOLD + PERIOD


def test_goal_that_was_reported_before_the_motion_began_is_not_believed(motions: Motions[str]) -> None:
    took, _ = play(
        ("arrived", HOLD - PERIOD), ("moving", 1.0), ("arrived", 2.0), motions=motions, motion=motions.follow(goal())
    )
    assert took > 1.0 + HOLD


def test_motion_that_stops_elsewhere_has_failed_soon(motions: Motions[str]) -> None:
    took, said = play(("moving", 1.0), ("resting", 2.0), motions=motions, motion=motions.follow(goal()))
    assert said == "arm move has stopped on its way"
    assert took < 1.0 + PAUSE + 2 * PERIOD


def test_motion_is_given_time_to_begin(motions: Motions[str]) -> None:
    _, said = play(("resting", 1.0), ("moving", 1.0), ("arrived", 1.0), motions=motions, motion=motions.follow(goal()))
    assert said == "arrived"
    took, said = play(("resting", 5.0), motions=motions, motion=motions.follow(goal()))
    assert said == "arm move does not begin"
    assert took == pytest.approx(TIME_TO_START, abs=PERIOD)


def test_motion_that_goes_on_and_on_has_failed(motions: Motions[str]) -> None:
    took, said = play(("moving", 20.0), motions=motions, motion=motions.follow(goal()))
    assert said == "arm move has not ended within 10 s"
    assert took == pytest.approx(LONGEST)


def test_motion_of_which_nothing_is_heard_any_more_has_failed(motions: Motions[str]) -> None:
    took, said = play(("moving", 1.0), ("", 9.0), motions=motions, motion=motions.follow(goal()))
    assert said == "nothing has been heard for 3.0 s during arm move"
    assert took == pytest.approx(1.0 - PERIOD + SILENCE)


def test_failure_says_why_as_far_as_is_known() -> None:
    motions: Motions[str] = Motions(lambda: "the e-stop is latched")
    _, said = play(("moving", 1.0), ("resting", 2.0), motions=motions, motion=motions.follow(goal()))
    assert said == "arm move has stopped on its way: the e-stop is latched"


def test_newer_motion_of_the_same_part_takes_the_place_of_the_older(motions: Motions[str]) -> None:
    async def both() -> str:
        older = asyncio.ensure_future(motions.follow(goal("arm move", "12")))
        other = asyncio.ensure_future(motions.follow(goal("arm reach", "3")))
        await asyncio.sleep(1.0)
        newer = await motions.follow(goal("arm home", "23"))
        assert other.exception() is not None
        return f"{newer}; {older.exception()}"

    _, said = play(("moving", 2.0), ("arrived", 2.0), motions=motions, motion=both())
    assert said == "arrived; arm home took the place of arm move"


def test_motion_that_is_cancelled_is_forgotten(motions: Motions[str]) -> None:
    async def cancelled() -> str:
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(motions.follow(goal()), 0.5)
        return await motions.follow(goal("arm home"))

    took, said = play(("moving", 1.0), ("arrived", 2.0), motions=motions, motion=cancelled())
    assert said == "arrived"
    assert took == pytest.approx(1.0 + HOLD, abs=2 * PERIOD)
