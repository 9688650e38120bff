"""The camera of a running emulator: real processes, real pictures."""

import http.client
import io
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import configs
from cameras import open_source
from p2os import Command, encode_command, encode_frame
from p2os.accessories import vcc4
from p2os.accessories.vcc4 import Code
from p2os_emu.camera.camera_process import CameraModel, CameraProcess
from p2os_emu.camera.image_format import read_format
from p2os_emu.camera.news import SceneMoment
from p2os_emu.program import emulator
from p2os_emu.world.sight import SceneChanges
from p2os_emu.world.view import View
from tests.waiting import end_of, patience

WORLD = """
[[walls]]
from_m = [6.0, -4.0]
to_m = [6.0, 4.0]
[[objects]]
name = "post"
at_m = [3.0, 0.0]
size_m = [0.4, 0.4, 1.0]
mass_kg = 5.0
colour = "red"
"""
FIT = ("--robot", "p3dx-sh:happy", "--fit", "ptz:vcc4,camera:96x72@30")
LIMIT = 15.0


@pytest.fixture
def world(tmp_path: Path) -> str:
    path = tmp_path / "room.toml"
    path.write_text(WORLD)
    return str(path)


def picture(url: str) -> NDArray[np.uint8]:
    at = urlsplit(url)
    connection = http.client.HTTPConnection(at.hostname or "", at.port, timeout=patience(LIMIT))
    connection.request("GET", "/image")
    with connection.getresponse() as answer:
        data = answer.read()
    connection.close()
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))


def red_column(url: str) -> float | None:
    """The middle of what is red; None where nothing is."""
    red, green, blue = np.moveaxis(picture(url).astype(int), 2, 0)
    columns = np.nonzero((red > 60) & (red > 2 * green) & (red > 2 * blue))[1]
    return float(columns.mean()) if len(columns) > 5 else None


def camera_pid(emulator_pid: int) -> int:
    """The only child of an emulator."""
    return int(Path(f"/proc/{emulator_pid}/task/{emulator_pid}/children").read_text().split()[0])


def is_running(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:  # it has ended
        return False
    return state != "Z"


def test_picture_follows_the_head_and_the_end_of_the_emulator_ends_the_camera(
    world: str, until: Callable[..., None]
) -> None:
    with emulator(*FIT, "--world", world) as robots:
        url = robots.robots[0]["camera_url"]
        assert url is not None
        assert url.startswith("http://127.0.0.1:")
        assert picture(url).shape == (72, 96, 3)
        straight = red_column(url)
        assert straight is not None
        assert straight == pytest.approx(48, abs=2)
        with Path(robots.port).open("wb", buffering=0) as port:
            for sync in range(3):
                port.write(encode_frame(bytes([sync])))
            port.write(encode_command(Command.OPEN))
            for request in (
                vcc4.encode_command(Code.POWER, vcc4.ON),
                vcc4.encode_command(Code.CONTROL_MODE, vcc4.HOST_CONTROL),
                vcc4.encode_command(Code.MOVE, (-89, 0)),
            ):  # 10 degrees to the left
                port.write(encode_command(Command.TTY2, request))
            until(lambda: (red_column(url) or 0.0) > straight + 15)
        pid = camera_pid(robots.process.pid)
        robots.process.kill()
        robots.process.wait()
        until(lambda: not is_running(pid))


def test_camera_that_dies_is_said_once_and_the_robot_goes_on(world: str, until: Callable[..., None]) -> None:
    command = [sys.executable, "-m", "p2os_emu", *FIT, "--world", world, "--duration", "3", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        os.kill(camera_pid(process.pid), signal.SIGKILL)
        _, complaints = end_of(process, LIMIT)
    assert process.returncode == 0
    about_cameras = [line for line in complaints.splitlines() if "the machine is too busy" not in line]
    assert about_cameras == ["p2os-emu: the camera of happy has ended; the robot goes on without it"]


def test_camera_has_the_port_that_follows_from_its_robots_name_and_another_where_that_is_taken() -> None:
    name = f"eye-{os.getpid()}"
    with closing(camera_of(name)) as first, closing(camera_of(name)) as second:
        assert first.url != second.url
    with closing(camera_of(name)) as again:
        assert again.url == first.url


def test_camera_is_told_what_is_new_only_while_somebody_looks(until: Callable[..., None]) -> None:
    view = View(0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    with closing(camera_of(f"idle-{os.getpid()}")) as camera:

        def wants_news() -> bool:
            return camera.wants_news

        assert wants_news(), "it knows nothing yet"
        until(lambda: camera.tell(SceneMoment(SceneChanges(), view, 0.0)))
        assert camera.listen()
        assert not wants_news()

        def is_watched() -> bool:
            assert camera.listen()
            return camera.is_watched

        at = urlsplit(camera.url)
        with closing(http.client.HTTPConnection(at.hostname or "", at.port, timeout=patience(LIMIT))) as connection:
            connection.request("GET", "/video")
            with connection.getresponse():
                until(is_watched)
                assert (camera.is_newly_watched, wants_news()) == (True, True)
                assert camera.tell(SceneMoment(SceneChanges(), view, 0.0))
                assert (camera.is_newly_watched, wants_news()) == (False, True)
        until(lambda: not is_watched())


def test_each_picture_of_a_stream_tells_when_the_world_was_like_that(world: str) -> None:
    last = time.time()
    with emulator(*FIT, "--world", world) as robots, closing(open_source(robots.robots[0]["camera_url"])) as source:
        for _ in range(3):
            taken = source.read().taken
            assert taken is not None
            assert last < taken <= time.time()
            last = taken


def test_first_picture_of_a_late_viewer_shows_where_the_robot_is_now(world: str) -> None:
    with emulator(*FIT, "--world", world) as robots:
        url = robots.robots[0]["camera_url"]
        straight = red_column(url)
        assert straight is not None
        robots.ask("pause")
        robots.ask("pose", heading=-0.2)
        turned = red_column(url)
        assert turned is not None
        assert turned < straight - 10


def camera_of(name: str) -> CameraProcess:
    return CameraProcess(name, read_format("64x48@5"), configs.load(CameraModel, "accessories", "camera"))


def test_ctrl_c_in_the_terminal_ends_emulator_and_camera_without_a_word(world: str) -> None:
    command = [sys.executable, "-m", "p2os_emu", *FIT, "--world", world, "--json"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        camera = camera_pid(process.pid)
        os.killpg(process.pid, signal.SIGINT)
        said, complaints = end_of(process, LIMIT)
    assert (process.returncode, said, complaints) == (0, "", "")
    assert not is_running(camera)
