from collections.abc import Callable, Iterator
from math import copysign, sqrt
from typing import Any

import pytest

import configs
from p2os.robot_model import RobotModel
from p2os_emu.world import STEP, RobotBody, World, WorldSpec

MakeWorld = Callable[..., World]
Roll = Callable[[World, RobotBody, float, float], None]


@pytest.fixture
def model() -> Callable[[str], RobotModel]:
    """Robot models by name."""
    return lambda name: configs.load(RobotModel, "robots", name)


@pytest.fixture
def make_world() -> Iterator[MakeWorld]:
    """Worlds that are closed when the test ends; perfect unless the test says otherwise."""
    worlds: list[World] = []

    def make(spec: WorldSpec | None = None, **options: Any) -> World:
        worlds.append(World(spec or WorldSpec("floor"), **{"perfect": True, **options}))
        return worlds[-1]

    yield make
    for world in worlds:
        world.close()


@pytest.fixture
def roll() -> Roll:
    """Roll both rims by distances (m) of one size, as encoders see it: 0.3 m/s2 up to 0.5 m/s and back to rest."""

    def roll(world: World, body: RobotBody, left: float, right: float) -> None:
        begin = body.state
        speed = 0.0
        for _ in range(3600):
            state = body.state
            to_go = abs(left) - abs(state.left_travel - begin.left_travel)
            speed = max(0.0, min(speed + 0.3 * STEP, 0.5, sqrt(2 * 0.3 * max(to_go, 0.0)), to_go / STEP))
            body.drive(copysign(speed, left), copysign(speed, right))
            world.step()
            if to_go < 1e-4 and abs(state.left_velocity) < 1e-3:
                break
        else:
            raise AssertionError("the wheels did not get there in 30 s")
        body.drive(0.0, 0.0)
        for _ in range(60):
            world.step()

    return roll
