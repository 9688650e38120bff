"""A token for each element: there while the robot has it, whatever becomes of the cable meanwhile."""

from collections.abc import Callable, Iterator

import pytest

from acromovi.lockstep import Lockstep
from bus import MemoryBus, keys
from gateway.robot_on_bus import ElementTokens
from p2os_emu.world import load_world

PLAIN = {"base", "battery", "io", "sonar", "sound", "servos"}


class Shown:
    """The elements whose tokens stand, and all that came and went."""

    def __init__(self, lockstep: Lockstep) -> None:
        self.elements: set[str] = set()
        self.changes: list[tuple[str, bool]] = []
        lockstep.bus().watch_alive(keys.ELEMENT_ALIVE.key("happy"), self._change)

    def _change(self, key: str, is_alive: bool) -> None:
        element = key.split("/")[2]
        self.changes.append((element, is_alive))
        (self.elements.add if is_alive else self.elements.discard)(element)


@pytest.fixture
def make_lockstep() -> Iterator[Callable[[str], Lockstep]]:
    made: list[Lockstep] = []

    def make(fit: str) -> Lockstep:
        made.append(Lockstep(load_world("empty"), {"happy": "p3dx-sh"}, fits={"happy": fit}, perfect=True))
        return made[-1]

    yield make
    for lockstep in made:
        lockstep.close()


def described(lockstep: Lockstep) -> set[str]:
    (answer,) = lockstep.bus().query("happy/description")
    return {element["name"] for element in answer.value["elements"]}


def test_the_tokens_are_those_of_the_elements_that_are_described(make_lockstep: Callable[[str], Lockstep]) -> None:
    lockstep = make_lockstep("gripper,laser,gyro:controller,ptz")
    shown = Shown(lockstep)
    lockstep.run_until(lambda: "laser" in shown.elements and "ptz" in shown.elements, 15.0)
    assert shown.elements >= PLAIN | {"gripper", "gyro"}
    assert shown.elements == described(lockstep)
    assert len(shown.changes) == len(shown.elements)  # each came once


def test_no_token_comes_before_the_robot_takes_orders(make_lockstep: Callable[[str], Lockstep]) -> None:
    lockstep = make_lockstep("no-laser")
    shown = Shown(lockstep)
    lockstep.run_until(lambda: bool(shown.elements), 5.0)
    lockstep.bus().query(keys.DRIVE.key("happy"), {"linear": 0.1, "angular": 0.0})  # raises if it is refused


def test_a_laser_that_is_unplugged_goes_and_comes_back_with_its_cable(make_lockstep: Callable[[str], Lockstep]) -> None:
    lockstep = make_lockstep("laser")
    shown = Shown(lockstep)
    lockstep.run_until(lambda: "laser" in shown.elements, 15.0)
    cut = lockstep.fault("line-cut:cable=laser")
    lockstep.run_until(lambda: "laser" not in shown.elements, 5.0)
    assert shown.elements == described(lockstep) >= PLAIN
    lockstep.clear(cut)
    lockstep.run_until(lambda: "laser" in shown.elements, 15.0)


def test_a_robot_whose_cable_is_cut_keeps_its_elements(make_lockstep: Callable[[str], Lockstep]) -> None:
    lockstep = make_lockstep("gripper,compass")
    shown = Shown(lockstep)
    lockstep.run_until(lambda: {"gripper", "compass"} <= shown.elements, 5.0)
    lockstep.run(1.0)
    shown.changes.clear()
    lockstep.fault("line-cut@0+3")
    lockstep.run(8.0)
    assert shown.changes == []


def test_all_tokens_go_with_the_gateway() -> None:
    bus = MemoryBus()
    seen: list[tuple[str, bool]] = []
    MemoryBus(bus.network).watch_alive("**", lambda key, is_alive: seen.append((key, is_alive)))
    with ElementTokens("happy", bus) as tokens:
        tokens.follow(["base", "laser", "base"])
        tokens.follow(["base", "laser"])
        assert seen == [("happy/elements/base/alive", True), ("happy/elements/laser/alive", True)]
    assert {key for key, is_alive in seen if not is_alive} == {key for key, _ in seen}
