"""The token of a lease travels from every request that moves something to the gateway."""

from collections.abc import Callable
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
    if name not in ANY_TIME.get(element, {"read"})
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
