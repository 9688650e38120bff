"""Emulator, gateway and bus as programs, with a laser on a port of its own."""

from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acromovi.children import emulator, gateway
from bus import Bus, NoAnswer, Sample, keys, messages
from tests.waiting import wait_until

WALL_ON_THE_LEFT = """\
about = "a wall 2 m to the left, and a reflector ahead"
starts = [{ at_m = [0.0, 0.0] }]
[[walls]]
name = "left"
from_m = [-5.0, 2.05]
to_m = [5.0, 2.05]
[[furniture]]
name = "mark"
at_m = [3.0, 0.0]
size_m = [0.2, 0.4, 1.0]
reflector = true
"""


class Watcher:
    """Hears one robot's scans, state and diagnostics."""

    def __init__(self, bus: Bus, name: str) -> None:
        self.scans: list[Any] = []
        self.state: Any = None
        self._bus = bus
        self._name = name
        bus.subscribe(keys.SCAN.key(name), lambda sample: self.scans.append(self._decode(sample)))
        bus.subscribe(keys.STATE.key(name), self._on_state)

    @property
    def elements(self) -> dict[str, Any]:
        """By name, as the robot describes them now."""
        try:
            (reply,) = self._bus.query(keys.DESCRIPTION.key(self._name), {})
        except NoAnswer:
            return {}
        return {element["name"]: element for element in reply.value["elements"]}

    def _on_state(self, sample: Sample) -> None:
        self.state = self._decode(sample)

    def _decode(self, sample: Sample) -> Any:
        return messages.decode(sample.type_name, sample.payload)


@pytest.mark.parametrize(("model", "way"), [("p3dx-sh", "pty"), ("powerbot-sh", "tcp")], ids=["upright", "flipped"])
def test_what_stands_on_the_left_shows_on_the_left(name: str, bus: Bus, model: str, way: str, tmp_path: Path) -> None:
    world = tmp_path / "left.toml"
    world.write_text(WALL_ON_THE_LEFT)
    robot = ("--robot", f"{model}:{name}", "--fit", "laser", "--world", str(world), "--perfect")
    with emulator(*robot, *(["--tcp", "0"] if way == "tcp" else [])) as robots:
        watcher = Watcher(bus, name)
        with gateway(robots.port, "--laser", robots.robots[0]["laser_port"], "--quiet"):
            wait_until(lambda: len(watcher.scans) > 3)
            laser = watcher.elements["laser"]
            scan = watcher.scans[-1]
            bearings = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
            left = scan.ranges[np.argmin(np.abs(bearings - np.pi / 2))]
            assert left == pytest.approx(2.0, abs=0.01)
            assert np.all(np.isinf(scan.ranges[bearings < -0.2]))
            ahead = np.argmin(np.abs(bearings))
            assert scan.ranges[ahead] == pytest.approx(2.9 - laser["geometry"]["x"], abs=0.01)
            assert scan.intensities[ahead] > 0
            assert np.all(scan.intensities[bearings > 0.3] == 0)
            assert laser["streams"] == [f"{name}/scan"]


def test_a_laser_that_goes_is_said_and_one_that_comes_back_is_taken_up(name: str, bus: Bus, tmp_path: Path) -> None:
    cable = tmp_path / "cable"
    robot = ("--robot", f"p3dx-sh:{name}", "--fit", "laser", "--world", "empty", "--pty", str(cable))
    watcher = Watcher(bus, name)
    with ExitStack() as stack:
        first = stack.enter_context(emulator(*robot))
        stack.enter_context(gateway(str(cable), "--laser", f"{cable}-laser", "--quiet"))
        wait_until(lambda: bool(watcher.scans) and "laser" in watcher.elements)
        for link in (cable, cable.with_name("cable-laser")):
            link.unlink()  # names go with their adapters; left behind, they would lead to whoever gets the number next
        first.process.kill()
        first.process.wait()
        wait_until(lambda: "the laser's port is gone" in watcher.state.faults)
        assert "laser" not in watcher.elements
        count = len(watcher.scans)
        stack.enter_context(emulator(*robot))
        wait_until(lambda: len(watcher.scans) > count + 3)
        assert "laser" in watcher.elements
