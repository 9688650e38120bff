"""motion@ROBOT: what moves in front of a standing camera, and nothing while the camera itself moves."""

import asyncio
from typing import Any

import numpy as np

from agents.components.vision.motion_agent import MotionAgent
from bus import keys, messages
from bus.messages import PanTiltZoom
from tests.agents.components.vision.desk import PERIOD, START, Desk, desk


def scene(left: int | None = None) -> np.ndarray:
    """A grey pattern, with a bright square of 20 px at some place."""
    image = np.full((120, 160, 3), 90, np.uint8)
    image[:, ::20] = 130
    if left is not None:
        image[40:60, left : left + 20] = 230
    return image


def play(story: Any) -> None:
    async def run() -> None:
        async with desk(MotionAgent("motion@happy", {"emulated": True})) as at:
            await story(at)

    asyncio.run(run())


async def results(at: Desk, *images: np.ndarray) -> list[dict[str, Any]]:
    """The result of each image, which is shown after that of the one before."""
    heard = at.hear("happy/agents/motion/results")
    await at.until(lambda: at.is_watched)
    found = []
    for image in images:
        heard.clear()
        at.show(image)
        await at.until(lambda: heard)
        found.append(heard[-1].decoded())
    return found


def test_what_moves_is_a_blob_where_it_is_and_what_stands_is_none() -> None:
    async def story(at: Desk) -> None:
        first, second, third = await results(at, scene(), scene(), scene(60))
        assert not first["settled"]
        assert second["settled"]
        assert second["blobs"] == []
        (blob,) = third["blobs"]
        assert abs(blob["x"] - 69.5) < 2.0
        assert abs(blob["y"] - 49.5) < 2.0
        assert 300 < blob["area"] < 550
        assert blob["left"] <= 61
        assert blob["right"] >= 78

    play(story)


def test_nothing_is_tracked_while_the_head_turns_and_it_begins_anew_afterwards() -> None:
    async def story(at: Desk) -> None:
        head = at.bus.publisher(keys.PTZ.key("happy"), keys.PTZ.type_name)

        def turn(is_moving: bool) -> None:
            head.put(PanTiltZoom(messages.header(START + at.shown * PERIOD, "happy/ptz"), 0.1, 0.0, 1.0, is_moving))

        await results(at, scene(), scene())
        turn(True)
        (moving,) = await results(at, scene(60))
        assert moving["blobs"] == []
        assert "the camera moves" in moving["trouble"]
        turn(False)
        _, anew, settled = await results(at, scene(60), scene(60), scene(60))
        assert anew["trouble"] is None
        assert settled["settled"]
        assert settled["blobs"] == []

    play(story)


def test_an_image_after_a_long_pause_is_not_compared_with_an_old_background() -> None:
    async def story(at: Desk) -> None:
        await results(at, scene(), scene())
        at.shown += 100
        (late,) = await results(at, scene(60))
        assert not late["settled"]
        assert late["blobs"] == []

    play(story)
