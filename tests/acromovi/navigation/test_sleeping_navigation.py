"""The navigation of the kinematic robot in real processes: it sleeps without a mission, and a goal wakes it."""

import subprocess
import sys
from collections.abc import Iterator

import pytest

from acromovi.navigation.components import RunningNavigation
from apps.indoor_navigation.component import push_key
from apps.indoor_navigation.data import RobotOdometry
from apps.indoor_navigation.parameters import WIRING
from bus import ZenohBus
from bus.messages import decode_json
from tests.acromovi.team.private_bus import private_bus
from tests.acromovi.team.running import ROOT
from tests.waiting import patience, wait_until

ROBOT = "happy"


@pytest.fixture(scope="module", params=["file", "one"])
def bus(request: pytest.FixtureRequest) -> Iterator[ZenohBus]:
    """The bus of a navigation in the processes of the wiring, or in one."""
    profile = private_bus()
    wiring = str(WIRING.with_name("wiring-kinematic.toml"))
    words = ["navigate", "up", ROBOT, "--json", "--wiring", wiring, "--processes", request.param, "--bus", profile]
    process = subprocess.Popen(
        [sys.executable, "-m", "acromovi", *words], cwd=ROOT, stdout=subprocess.PIPE, text=True, start_new_session=True
    )
    with process, ZenohBus.open(profile) as bus:
        assert process.stdout is not None
        try:
            assert process.stdout.readline(), "the navigation has not come up"
            yield bus
        finally:
            process.terminate()


def awake(bus: ZenohBus) -> set[str]:
    """The components that are awake; one that does not run is awake, too."""
    told = RunningNavigation(bus, ROBOT).descriptions()
    return {str(each["name"]) for each in told if each["awake"]} | {"missing" for _ in range(10 - len(told))}


def test_all_sleep_without_a_mission_and_a_goal_wakes_them(bus: ZenohBus) -> None:
    wait_until(lambda: not awake(bus), "all components sleep")
    running = RunningNavigation(bus, ROBOT)
    mission = running.ask("go", x=0.5, y=0.0)["mission"]
    assert running.ask("wait", patience(), mission=mission)["state"] == "done"
    wait_until(lambda: not awake(bus), "all components sleep again")


def test_who_watches_the_odometry_gets_it_and_wakes_the_base_alone(bus: ZenohBus) -> None:
    wait_until(lambda: not awake(bus), "all components sleep")
    heard: list[float] = []
    key = push_key(ROBOT, "robot_base_server", RobotOdometry)
    with bus.subscribe(key, lambda sample: heard.append(decode_json(sample.payload)["stamp"])):
        wait_until(lambda: len(heard) > 3, "odometry is published")
        assert awake(bus) == {f"robot_base_server@{ROBOT}"}
