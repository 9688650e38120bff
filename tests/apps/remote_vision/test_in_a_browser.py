"""The page in Chromium, on an emulated team: what is drawn, who steers, and what happens when something dies."""

import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from http.client import HTTPConnection
from math import inf
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser

from bus import keys
from tests.acromovi.team.running import RunningTeam, running
from tests.apps.remote_vision.viewer import Viewer
from tests.apps.web.browsing import children, chromium, frozen, needs_chromium, serving
from tests.waiting import exit_code, wait_until

pytestmark = needs_chromium
TEAM = """\
world = "office"
gateways = "separate"

[[robots]]
name = "happy"
model = "peoplebot-sh"
fit = ["ptz:vcc4", "camera:160x120@5"]
at_m = [2.0, 2.0]
"""
LONG_STEP = """\
[control]
step = 5.0
"""
"""A key turns the head from one end to the other, which takes 2.2 s: long enough for something to die meanwhile."""
LOOK = 0.05  # s
NO_MOTION = 2.0  # s after a key was pressed, in which a head that nothing keeps begins to turn
LEFT, RIGHT = 1.7, -1.7  # rad, the ends of the head


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    file = tmp_path_factory.mktemp("team") / "team.toml"
    file.write_text(TEAM)
    with running(str(file)) as team:
        yield team


@pytest.fixture(scope="module")
def served(
    team: RunningTeam, tmp_path_factory: pytest.TempPathFactory
) -> "Iterator[tuple[subprocess.Popen[str], str]]":
    settings = tmp_path_factory.mktemp("settings") / "mine.toml"
    settings.write_text(LONG_STEP)
    command = "remote-vision", "happy", "--port", "0", "--bus", team.profile, "--settings", str(settings)
    with serving(*command) as served:
        yield served


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def viewer(browser: Browser, served: "tuple[subprocess.Popen[str], str]") -> Iterator[Viewer]:
    viewer = Viewer(browser, served[1])
    yield viewer
    viewer.close()


def head(team: RunningTeam) -> dict[str, Any]:
    """The true state of the head, a moment later: what is asked again and again is not to load the machine."""
    time.sleep(LOOK)
    return dict(team.emulator().ask("truth", robot="happy")["robots"]["happy"]["camera_head"])


def pan(team: RunningTeam) -> float:
    """Where the head really looks, rad."""
    return float(head(team)["pan"])


def holder(team: RunningTeam) -> str:
    """Who has the lease on the head; empty for nobody."""
    time.sleep(LOOK)
    lease = team.bus.query(keys.LEASE_STATE.key("happy"), {})[0].value
    return str((lease["elements"].get("ptz") or {}).get("holder") or "")


def turn(
    team: RunningTeam, viewer: Viewer, act: Callable[[], None], is_there: Callable[[float], bool], what: str
) -> None:
    """Do what turns the head, and again until it is where it is to be.

    A machine that halts for a moment ends a motion, and for a longer moment the control.
    """
    acted_at = -inf

    def arrives() -> bool:
        nonlocal acted_at
        state = head(team)
        if not is_there(state["pan"]) and not state["moving"] and time.monotonic() - acted_at > NO_MOTION:
            viewer.take_control()
            act()
            acted_at = time.monotonic()
        return is_there(state["pan"])

    viewer.wait(arrives, what)


def look_straight_ahead(team: RunningTeam, viewer: Viewer) -> None:
    turn(team, viewer, lambda: viewer.key("c"), lambda pan: abs(pan) < 0.02, "the head looks straight ahead")


def sweep(team: RunningTeam, viewer: Viewer) -> None:
    """Take control, turn the head to the right end, and let it begin to turn to the left end."""

    def has_the_lease() -> bool:
        viewer.take_control()  # again, if the page still shows control that it has lost
        return holder(team).startswith("remote-vision-")

    viewer.wait(has_the_lease, "the page has the lease")
    said = viewer.page.get_by_text("head at pan -9").first

    def is_there(pan: float) -> bool:
        return pan < RIGHT + 0.02 and said.is_visible()

    turn(team, viewer, lambda: viewer.key("ArrowRight"), is_there, "the head looks to the right, and the page says so")
    turn(team, viewer, lambda: viewer.key("ArrowLeft"), lambda pan: pan > RIGHT + 0.1, "the head turns")


def stops_early(team: RunningTeam) -> None:
    """Wait until the head stands, which must be before it has arrived."""
    wait_until(lambda: not head(team)["moving"], "the head stands")
    assert pan(team) < LEFT - 0.1


def test_images_are_drawn_live_and_nothing_is_loaded_from_elsewhere(viewer: Viewer, tmp_path: Path) -> None:
    drawn = viewer.until_drawn(count=5)
    stamps = [each["stamp"] for each in drawn]
    assert stamps == sorted(set(stamps))
    assert "age" in viewer.page.locator(".rv-age").first.inner_text()
    own = urlsplit(viewer.page.url).netloc
    assert {urlsplit(url).netloc for url in viewer.requested if not url.startswith(("data:", "blob:"))} == {own}
    with viewer.page.expect_download() as download:
        viewer.press("Save image")
    assert download.value.suggested_filename.startswith("happy-image-")
    download.value.save_as(tmp_path / "image.jpg")
    assert (tmp_path / "image.jpg").read_bytes().startswith(b"\xff\xd8")


def test_operations_are_shown_beside_the_image_and_wrong_parameters_are_told(viewer: Viewer) -> None:
    viewer.choose("Operation or saved chain", "canny")
    viewer.sees("canny: shown")
    viewer.until_drawn("canny")
    viewer.press("Add a step")
    viewer.sees("after grey, canny")
    viewer.choose("Operation or saved chain", "dilation")
    viewer.until_drawn("dilation")
    viewer.press("Remove steps")
    viewer.choose("Operation or saved chain", "convolution")
    viewer.until_drawn("convolution")
    viewer.page.get_by_label("kernel").fill("[[1, 2], [3]]")
    viewer.sees("row 2 of kernel has 1 numbers")
    viewer.choose("Operation or saved chain", "histogram")
    viewer.until_drawn("histogram")


def test_a_channel_is_trained_by_dragging_and_its_blobs_are_laid_over(viewer: Viewer) -> None:
    viewer.until_drawn(count=1)
    viewer.page.get_by_role("checkbox", name="Colour blobs").click()
    viewer.page.get_by_role("switch").click()
    viewer.page.mouse.move(*viewer.place(0.45, 0.85))
    viewer.page.mouse.down()
    viewer.page.mouse.move(*viewer.place(0.6, 0.95), steps=3)
    viewer.page.mouse.up()
    viewer.sees("channel 1 trained")
    viewer.sees("trained: 1")
    viewer.page.get_by_role("switch").click()  # the pointer steers again


def test_one_viewer_steers_and_another_sees_who(
    team: RunningTeam, viewer: Viewer, browser: Browser, served: "tuple[subprocess.Popen[str], str]"
) -> None:
    other = Viewer(browser, served[1])
    viewer.until_drawn(count=1)

    def is_seen() -> bool:
        viewer.take_control()  # again: a browser that a busy machine held up for 3 s has lost it
        take = other.page.get_by_role("button", name="Take control", exact=True)
        return bool(other.page.get_by_text("steers.").count()) and take.is_disabled()

    viewer.wait(is_seen, "the other page shows who steers")

    def click_at_the_right_edge() -> None:
        viewer.take_control()
        look_straight_ahead(team, viewer)
        viewer.page.mouse.click(*viewer.place(0.99, 0.5))

    is_centred = "what was at the right edge is centred"
    turn(team, viewer, click_at_the_right_edge, lambda pan: abs(pan + 0.41) < 0.03, is_centred)
    look_straight_ahead(team, viewer)
    viewer.release_control()
    other.sees("Nobody steers from here.")
    other.close()


def test_a_page_of_another_origin_is_refused(served: "tuple[subprocess.Popen[str], str]") -> None:
    where = urlsplit(served[1])
    for path in ("/images/x/original", "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"):
        connection = HTTPConnection(where.netloc)
        headers = {"Upgrade": "websocket", "Connection": "Upgrade", "Origin": "http://evil.example"}
        connection.request(
            "GET",
            path,
            headers={**headers, "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA=="},
        )
        assert connection.getresponse().status == 403
        connection.close()


def test_a_browser_that_freezes_or_is_closed_stops_the_head(
    team: RunningTeam, viewer: Viewer, browser: Browser, served: "tuple[subprocess.Popen[str], str]"
) -> None:
    sweep(team, viewer)
    with frozen(*children("--type=renderer")):
        stops_early(team)
        wait_until(lambda: not holder(team), "the lease is released")
    viewer.reload()
    viewer.sees("Nobody steers from here.")
    second = Viewer(browser, served[1])
    second.until_drawn(count=1)
    sweep(team, second)
    second.close()
    stops_early(team)


def test_a_camera_that_freezes_is_told_and_returns(team: RunningTeam, viewer: Viewer) -> None:
    viewer.until_drawn(count=1)
    (camera,) = children("p2os_emu.camera", team.process.pid)
    with frozen(camera):
        viewer.sees("OLD IMAGE")
        viewer.sees("no image has come from happy")
    viewer.until_drawn()
    viewer.page.get_by_text("OLD IMAGE").wait_for(state="hidden")


def test_a_robot_that_goes_and_agents_that_restart_are_told_and_return(team: RunningTeam, viewer: Viewer) -> None:
    viewer.choose("Operation or saved chain", "median")
    viewer.until_drawn("median")

    def is_told() -> bool:
        for gateway in children("--name\0happy", team.process.pid):  # again, if it was back before the page told
            os.kill(gateway, signal.SIGKILL)
        return bool(viewer.page.get_by_text("returns by itself").count())

    viewer.wait(is_told, "the page tells that the robot has gone")
    viewer.until_drawn("happy")
    viewer.until_drawn("median")


def test_a_program_that_freezes_or_is_killed_stops_the_head(
    team: RunningTeam, viewer: Viewer, served: "tuple[subprocess.Popen[str], str]"
) -> None:
    process, _ = served
    viewer.until_drawn(count=1)
    sweep(team, viewer)
    with frozen(process.pid):
        stops_early(team)
        viewer.sees("OLD IMAGE")
    viewer.until_drawn(count=1)
    sweep(team, viewer)
    process.kill()
    stops_early(team)
    assert exit_code(process) == -signal.SIGKILL
    viewer.sees("the connection to acromovi remote-vision is lost")
