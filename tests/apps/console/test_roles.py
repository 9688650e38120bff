"""The console with keys: what a viewer's permits, and an operator's."""

import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from bus import keys
from bus.acromovi_msgs import RobotState
from bus.messages import NS_PER_S, header
from tests.apps.console.browsing import console
from tests.bus.secure_site import MEMBERS, Site
from tests.waiting import wait_until


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    site = Site(Path(tmp_path_factory.mktemp("site")))
    for owner in (*MEMBERS, "router.lab"):
        site.make(owner)
    with site.routed():
        yield site


def stopped(address: str) -> dict[str, str]:
    """What the robots answer to the red button."""
    return dict(httpx.post(f"{address}stop", timeout=30.0).json()["robots"])


@pytest.mark.parametrize(
    ("owner", "answer", "words"),
    [
        ("viewer.vera", "a viewer may read everything", "permits looking only"),
        ("operator.anna", "stopped", "Take control"),
    ],
)
def test_the_role_decides_whether_robots_can_be_stopped_and_driven(
    site: Site, owner: str, answer: str, words: str
) -> None:
    told: list[object] = []

    def stop(arguments: dict[str, object]) -> dict[str, object]:
        told.append(arguments)
        return {}

    with site.open("robot.happy") as robot, console(site.profile(owner)) as (_, address):
        robot.serve(keys.DESCRIPTION.key("happy"), lambda arguments: {"elements": [{"name": "base"}, {"name": "arm"}]})
        robot.serve(keys.LEASE_STATE.key("happy"), lambda arguments: {"elements": {}})
        robot.serve(keys.ESTOP.key("happy"), stop)
        robot.declare_alive(keys.ALIVE.key("happy"))
        robot.put(
            keys.STATE.key("happy"),
            RobotState(header(int(time.time() * NS_PER_S), ""), "connected", True, False, False, 0, []),
        )
        wait_until(lambda: stopped(address), "the console sees the robot")
        assert stopped(address)["happy"].startswith(answer)
        assert bool(told) is (answer == "stopped")
        for path in ("", "timeline", "agents", "applications"):
            assert httpx.get(address + path, timeout=30.0).status_code == 200
        wait_until(lambda: words in httpx.get(f"{address}robot/happy", timeout=30.0).text, "the role is shown")
