"""A token of a lease that has ended moves nothing, neither when the base is free nor when somebody else has it."""

from collections.abc import Iterator
from typing import Any

import pytest

from agents.platform import Ending
from agents.platform.virtual_time import VirtualTimeLoop
from p2os_emu.world import load_world
from tests.agents.components.conftest import ROBOT, Lab

MOTIONS: dict[str, dict[str, Any]] = {
    "move": {"distance": 1.0},
    "drive": {"linear": 0.3},
    "go_to": {"x": 1.0, "y": 0.0},
    "turn": {"angle": 1.0},
    "heading": {"heading": 1.0},
}


@pytest.fixture
def lab(loop: VirtualTimeLoop) -> Iterator[Lab]:
    lab = Lab(loop, load_world("empty"), "p3dx-sh", fit="", perfect=True)
    lab.until(lambda: "base" in lab.elements)
    lab.run(1.0)  # the motors are on
    yield lab
    lab.close()


def take(lab: Lab, holder: str, seconds: float) -> str:
    """The token of a new lease on the base."""
    wish = {"do": "take", "holder": holder, "priority": 0, "seconds": seconds, "element": "base"}
    (answer,) = lab.bus.query(f"{ROBOT}/lease", wish)
    return str(answer.value["token"])


def all_are_refused(lab: Lab, token: str, why: str) -> None:
    """Try every motion."""
    for name, arguments in MOTIONS.items():
        outcome = lab.ask("base", name, token=token, **arguments)
        assert outcome.ending is Ending.REFUSED
        assert why in outcome.why


def test_a_token_of_the_past_is_refused_in_every_motion_and_the_robot_stands(lab: Lab) -> None:
    stale = take(lab, "early", 1.0)
    lab.run(1.5)
    start = lab.lockstep.truth(ROBOT)
    all_are_refused(lab, stale, "the token is of a lease that has ended; take the lease again")
    fresh = take(lab, "late", 60.0)
    all_are_refused(lab, stale, "late holds the lease")
    lab.run(1.0)
    end = lab.lockstep.truth(ROBOT)
    assert (end.x, end.y) == pytest.approx((start.x, start.y), abs=0.002)
    assert lab.ask("base", "move", token=fresh, distance=0.1).is_done
