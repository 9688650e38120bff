"""What applications show of robots on maps."""

import asyncio
from typing import Any

import pytest

from apps.console.overlays import OverlayWatch
from bus import MemoryBus, MemoryNetwork

NOW = 100.0


def shown(told: dict[str, Any], later: float = 0.0) -> list[dict[str, Any]]:
    """What is drawn of an overlay, some s after it came."""

    async def act() -> list[dict[str, Any]]:
        network, clock = MemoryNetwork(), [NOW]
        with MemoryBus(network) as bus, OverlayWatch(MemoryBus(network), lambda: clock[0]) as watch:
            bus.put("happy/overlay/following", told)
            await asyncio.sleep(0.0)
            clock[0] += later
            return watch.overlays

    return asyncio.run(act())


def test_an_overlay_is_drawn_until_it_is_old() -> None:
    told = {"frame": "odom", "words": "gap 0.8 m", "points": [[1.0, 2.0]], "lines": [[0.0, 0.0, 1.0, 2.0]]}
    assert shown(told) == [{"robot": "happy", "application": "following", **told}]
    assert shown(told, later=5.0) == []


@pytest.mark.parametrize(
    "told", [{}, {"frame": "map", "points": 3, "lines": [[1]]}, {"points": [["x", 1], [True, 2], [None, 1], [1, 2, 3]]}]
)
def test_malformed_shapes_are_left_out(told: dict[str, Any]) -> None:
    (overlay,) = shown(told)
    assert (overlay["frame"], overlay["points"], overlay["lines"]) == ("base_link", [], [])
