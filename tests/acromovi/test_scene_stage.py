"""What a scene says when something does not happen."""

from pathlib import Path
from typing import Any, cast

import pytest

from acromovi.children import EmulatedRobots
from acromovi.scenes.stage import SceneFailed, SceneStage
from bus import keys
from bus.memory import MemoryBus


class Emulator:
    """An emulator that keeps up, or has given something up."""

    def __init__(self, *degraded: str) -> None:
        self.degraded = list(degraded)

    def ask(self, do: str) -> dict[str, Any]:
        assert do == "truth"
        return {"degraded": self.degraded}


@pytest.mark.parametrize(
    ("degraded", "end"),
    [
        ((), "within 0.05 s"),
        (("camera images",), "the machine is too busy, and the emulator has given up camera images"),
        (("camera images", "people"), "given up camera images and people"),
    ],
)
def test_what_does_not_come_is_named_and_what_a_busy_emulator_has_given_up(
    tmp_path: Path, degraded: tuple[str, ...], end: str
) -> None:
    robots = cast(EmulatedRobots, Emulator(*degraded))
    stage = SceneStage("happy", robots, MemoryBus(), tmp_path, lambda line: None)
    try:
        with pytest.raises(SceneFailed, match=f"a picture did not come .*{end}$"):
            stage.see(keys.CAMERA, what="a picture", within=0.05)
    finally:
        stage.close()
