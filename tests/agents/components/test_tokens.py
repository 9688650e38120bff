"""The token of a lease travels from every request that moves something to the gateway."""

from collections.abc import Callable, Generator
from typing import Any

import pytest

from agents.components.all_components import COMPONENTS
from bus import keys
from tests.agents.components.bench import Bench, odometry
from tests.agents.components.page import requests_of

ANY_TIME: dict[str, set[str]] = {"base": {"read", "stop", "estop"}}
"""Requests of elements that move which need no lease: anyone may look, and anyone may stop a robot."""
MOVERS = ("base", "gripper", "arm", "ptz", "joystick")
GIVEN: dict[str, Any] = {
    "linear": 0.2,
    "distance": 1.0,
    "angle": 1.0,
    "heading": 1.0,
    "x": 1.0,
    "y": 1.0,
    "on": True,
    "joints": {"1": 0.5},
}
REQUESTS = [
    (element, name)
    for element in MOVERS
    for name in requests_of(element, COMPONENTS[element])
    if name not in ANY_TIME.get(element, {"read"}) and (element, name) != ("arm", "reach")  # below: it moves joints
]


@pytest.mark.parametrize(("element", "name"), REQUESTS)
def test_a_request_that_moves_something_passes_its_token_on(
    make_bench: Callable[..., Bench], element: str, name: str
) -> None:
    bench = make_bench(element)
    bench.obey_all()
    bench.say(keys.ODOM, odometry())
    function = requests_of(element, COMPONENTS[element])[name]
    takes = function.__code__.co_varnames[: function.__code__.co_argcount]
    given = {key: value for key, value in GIVEN.items() if key in takes}
    asking = bench.loop.create_task(bench.app.request(bench.component.name, name, token="t-7", **given))
    bench.run(1.0)
    asking.cancel()
    bench.run()
    assert bench.obeyed
    assert {arguments.get("token") for _, arguments in bench.obeyed} == {"t-7"}


def test_an_arm_reaches_with_the_token_of_the_request(
    make_bench: Callable[..., Bench], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The joints that it works out are moved as by a request to move them."""
    bench, tokens = make_bench("arm"), []

    async def read() -> dict[str, Any]:
        return {"joints": {}}

    async def move_joints(joints: object, speed: object, wait: object, token: str) -> dict[str, Any]:
        tokens.append(token)
        return {"joints": {}}

    class Kinematics:
        def reaching(
            self, point: object, present: object, pitch: object, yaw: object
        ) -> Generator[None, None, list[float]]:
            yield
            return [0.5]

        def forward(self, angles: object) -> tuple[float, float, float]:
            return 0.4, 0.0, 0.4

    monkeypatch.setattr(bench.component, "read", read)
    monkeypatch.setattr(bench.component, "move_joints", move_joints)
    monkeypatch.setattr(type(bench.component), "_kinematics", Kinematics())
    assert bench.value("reach", x=0.4, y=0.0, z=0.4, token="t-7")["tip"] == [0.4, 0.0, 0.4]
    assert tokens == ["t-7"]
