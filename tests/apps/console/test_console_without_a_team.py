"""The console in Chromium before a team is there, behind a password, and with a robot of hostile words."""

import asyncio
import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest
from playwright.sync_api import Browser

from agents.platform import Agent, AgentName, Container
from apps.web.access import PasswordHash
from bus import ZenohBus, keys
from bus.acromovi_msgs import RobotState
from bus.messages import NS_PER_S, header, quaternion
from bus.ros_msgs import (
    Header,
    Odometry,
    Point,
    Pose,
    PoseWithCovariance,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from tests.acromovi.team.private_bus import private_bus
from tests.apps.console.browsing import ConsoleTab, console
from tests.apps.remote_vision.browser import chromium, needs_chromium
from tests.waiting import wait_until

pytestmark = needs_chromium
HOST = "127.0.0.2"  # of this computer, but not the address for which no password is asked
PASSWORD = "correct horse"
NAME = "<img-src=x-onerror=pwned()>"
WORDS = "<img src=x onerror='window.pwned=1'><script>window.pwned=1</script>"


class Navigation(Agent):
    """A navigation that notes its goals."""

    def __init__(self, robot: str) -> None:
        super().__init__(AgentName("user_interface", robot))
        self.goals: list[dict[str, object]] = []
        self.answer("go", self.go)
        self.answer("picture", self.picture)

    async def go(self, x: float, y: float, heading: float | None = None) -> dict[str, str]:
        self.goals.append({"x": x, "y": y, "heading": heading})
        return {"mission": "m1"}

    async def picture(self) -> dict[str, object]:
        return {"mission": WORDS, "state": "active", "why": WORDS, "doors": [WORDS]}


class OddRobot:
    """A robot on the bus whose name, faults and missions would do harm as HTML."""

    def __init__(self, profile: str) -> None:
        self.navigation = Navigation(NAME)
        self._profile, self._is_over = profile, threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._live()))
        self._thread.start()

    def end(self) -> None:
        self._is_over.set()
        self._thread.join()

    async def _live(self) -> None:
        with ZenohBus.open(self._profile) as bus:
            bus.serve(keys.DESCRIPTION.key(NAME), lambda arguments: {"model": WORDS, "elements": [{"name": WORDS}]})
            bus.serve(keys.LEASE_STATE.key(NAME), lambda arguments: {"holder": WORDS, "elements": {}})
            bus.declare_alive(keys.ALIVE.key(NAME))
            async with Container(bus, "odd") as container:
                await container.start(self.navigation)
                while not self._is_over.is_set():
                    stamp = header(int(time.time() * NS_PER_S), "odom")
                    state = RobotState(
                        stamp, "connected", motors=True, estop=False, sonar=False, flags=0, faults=[WORDS]
                    )
                    bus.put(keys.STATE.key(NAME), state)
                    bus.put(keys.ODOM.key(NAME), _odometry(stamp))
                    event = {
                        "time": time.time(),
                        "what": f"{WORDS} has failed",
                        "about": f"{WORDS}@x",
                        "level": "error",
                    }
                    bus.put("x/agents/monitor/results", event)
                    await asyncio.sleep(0.1)


def _odometry(stamp: Header) -> Odometry:
    """Standing at x 2 m, facing y."""
    zero, covariance = Vector3(0.0, 0.0, 0.0), np.zeros(36)
    pose = PoseWithCovariance(Pose(Point(2.0, 0.0, 0.0), quaternion(1.5708)), covariance)
    return Odometry(stamp, "base_link", pose, TwistWithCovariance(Twist(zero, zero), covariance))


@pytest.fixture(scope="module")
def profile() -> str:
    return private_bus()


@pytest.fixture(scope="module")
def address(profile: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    file = tmp_path_factory.mktemp("access") / "password"
    PasswordHash.of(PASSWORD).write(file)
    with console(profile, "--host", HOST, "--password-file", str(file)) as (_, address):
        yield address


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as browser:
        yield browser


def log_in(tab: ConsoleTab, password: str) -> None:
    tab.page.get_by_label("Password of the console").fill(password)
    tab.press("Log in")


def test_nobody_comes_in_without_the_password_and_a_session_that_ends_ends_its_pages(
    browser: Browser, address: str
) -> None:
    tab = ConsoleTab(browser, address, "/robot")
    log_in(tab, "wrong horse")
    tab.sees("This is not the password.")
    log_in(tab, PASSWORD)
    tab.sees("no robot is on the bus yet")
    other = tab.context.new_page()
    other.goto(address)
    other.get_by_text("No robot is on the bus yet;").first.wait_for()
    tab.press("Log out")
    other.get_by_label("Password of the console").wait_for()
    tab.close()


def test_hostile_words_are_shown_as_text_and_a_robot_is_sent_by_a_click(
    browser: Browser, address: str, profile: str
) -> None:
    robot = OddRobot(profile)
    try:
        tab = ConsoleTab(browser, address)
        log_in(tab, PASSWORD)
        tab.sees(NAME)
        tab.page.locator(".c-map").focus()
        tab.page.keyboard.press("n")
        tab.sees("is shown in its own frame")
        tab.page.get_by_role("switch", name="Send by a click").click()
        tab.page.wait_for_function("document.querySelector('.c-map canvas.c-aim')")
        tab.page.mouse.click(*tab.page.evaluate("document.querySelector('.c-map').toScreen(2.5, 1.0)"))
        wait_until(lambda: robot.navigation.goals, "the goal has come")
        (goal,) = robot.navigation.goals
        assert goal == {"x": pytest.approx(2.5, abs=0.05), "y": pytest.approx(1.0, abs=0.05), "heading": None}
        for path in ("/timeline", "/robot/" + NAME.replace("<", "%3C").replace(">", "%3E")):
            tab.go(path)
            tab.sees("<script>window.pwned=1</script>")
        assert not tab.page.evaluate("window.pwned")
        assert tab.page.locator("img").count() == 0
        assert tab.errors == []
        tab.close()
    finally:
        robot.end()
