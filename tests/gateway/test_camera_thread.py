"""A camera's thread and state, with sources that the test makes."""

import threading
import time
from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
import pytest

from bus import keys
from bus.messages import decode, encode
from cameras.errors import CameraLost
from cameras.multipart import CameraPicture
from cameras.source import PATIENCE, CameraSource
from configs.camera_calibration import CameraCalibration
from gateway.cables.camera_thread import CameraState, CameraThread
from gateway.elements.adapter import RobotContext
from gateway.elements.camera.adapter import CameraAdapter
from gateway.events import Event, PictureTaken
from gateway.settings import CameraSettings, Settings
from tests.waiting import patience
from vision.camera_model import PinholeModel

JPEG = bytes.fromhex("FF D8  FF C0 00 0B 08 00 78 00 A0 01 11 00  FF D9")  # 160 by 120


class Pictures:
    """A source of some pictures, which then waits until it is interrupted."""

    def __init__(self, *pictures: bytes, taken: float | None = None) -> None:
        self._pictures = [CameraPicture(each, taken) for each in pictures]
        self._is_over = threading.Event()

    def read(self) -> CameraPicture:
        if self._pictures:
            return self._pictures.pop(0)
        self._is_over.wait(patience())
        raise CameraLost("it was interrupted")

    def interrupt(self) -> None:
        self._is_over.set()

    def close(self) -> None:
        self.interrupt()


class Robot:
    """Takes what a thread brings to the bus."""

    def __init__(self, has_listeners: bool = True) -> None:
        self.events: list[Event] = []
        self.stamps: list[int] = []  # ns
        self.is_heard = has_listeners

    def is_wanted(self) -> bool:
        return self.is_heard

    def publish(self, events: Sequence[Event], stamp_ns: int) -> None:
        self.events += events
        self.stamps += [stamp_ns] * len(events)


def joined(open_camera: Callable[[str], CameraSource], has_listeners: bool = True) -> tuple[CameraThread, Robot]:
    thread, robot = CameraThread("somewhere", open_camera), Robot(has_listeners)
    thread.join(robot.publish, robot.is_wanted)
    thread.start()
    return thread, robot


def test_pictures_reach_the_bus_as_they_are_and_what_is_none_is_counted(until: Callable[..., None]) -> None:
    thread, robot = joined(lambda where: Pictures(JPEG, b"no picture", JPEG[:-1]))
    until(lambda: thread.driver.damaged["picture"] == 2)
    assert robot.events == [PictureTaken(JPEG, 160, 120)]
    assert (thread.driver.size, thread.driver.is_connected, thread.driver.faults()) == ((160, 120), True, ())
    thread.close()
    assert not any(each.name == "camera" for each in threading.enumerate())


@pytest.mark.parametrize("late", [0.0, 0.7, 40.0])
def test_a_picture_has_the_time_when_its_camera_took_it_however_late_it_comes(
    late: float, until: Callable[..., None]
) -> None:
    taken = time.time() - late
    thread, robot = joined(lambda where: Pictures(JPEG, taken=taken))
    until(lambda: robot.stamps)
    assert robot.stamps == [pytest.approx(taken * 1e9, abs=1e6)]
    thread.close()


@pytest.mark.parametrize("taken", [None, 4711.5, -1.0, 4e9])
def test_a_picture_has_the_time_when_it_came_where_the_camera_does_not_tell_when_that_was(
    taken: float | None, until: Callable[..., None]
) -> None:
    before = time.time_ns()
    thread, robot = joined(lambda where: Pictures(JPEG, taken=taken))
    until(lambda: robot.stamps)
    assert before <= robot.stamps[0] <= time.time_ns()
    thread.close()


def test_camera_that_is_not_there_is_a_fault_and_tried_again(until: Callable[..., None]) -> None:
    tries = 0

    def open_camera(where: str) -> CameraSource:
        nonlocal tries
        tries += 1
        if tries == 1:
            raise CameraLost("nobody answers")
        return Pictures(JPEG)

    thread, robot = joined(open_camera)
    until(lambda: not thread.driver.is_connected and "nobody answers" in thread.driver.faults()[0])
    until(lambda: thread.driver.is_connected)
    assert len(robot.events) == 1
    thread.close()


class Stream:
    """A source that gives pictures without end. opened, closed: how often one was."""

    opened = closed = 0

    def __init__(self) -> None:
        type(self).opened += 1

    def read(self) -> CameraPicture:
        time.sleep(0.005)
        return CameraPicture(JPEG)

    def interrupt(self) -> None:
        """It ends by itself."""

    def close(self) -> None:
        type(self).closed += 1


def test_camera_is_open_only_while_somebody_on_the_bus_wants_its_pictures(
    monkeypatch: pytest.MonkeyPatch, until: Callable[..., None]
) -> None:
    monkeypatch.setattr("cameras.reader.LINGER", 0.05)

    class Camera(Stream):
        pass

    thread, robot = joined(lambda where: Camera(), has_listeners=False)
    until(lambda: Camera.closed == 1)
    assert len(robot.events) == 1, "a look whether it is there"
    until(lambda: thread.driver.is_resting)
    assert (thread.driver.is_connected, thread.driver.size, thread.driver.faults()) == (True, (160, 120), ())
    robot.is_heard = True
    until(lambda: len(robot.events) > 10)
    assert (Camera.opened, Camera.closed, thread.driver.is_resting) == (2, 1, False)
    robot.is_heard = False
    until(lambda: Camera.closed == 2)
    until(lambda: thread.driver.is_resting)
    thread.close()


def test_camera_that_goes_while_nobody_looks_is_missed_and_found_again(
    monkeypatch: pytest.MonkeyPatch, until: Callable[..., None]
) -> None:
    for name in ("CHECK", "RETRY"):
        monkeypatch.setattr(f"cameras.reader.{name}", 0.02)
    is_there = True

    def open_camera(where: str) -> CameraSource:
        if not is_there:
            raise CameraLost("nobody answers")
        return Stream()

    thread, _ = joined(open_camera, has_listeners=False)
    until(lambda: thread.driver.is_connected)
    is_there = False
    until(lambda: not thread.driver.is_connected)
    assert "nobody answers" in thread.driver.faults()[0]
    is_there = True
    until(lambda: thread.driver.is_connected)
    thread.close()


def test_camera_that_rests_is_connected_until_it_is_missed() -> None:
    now = 5.0
    state = CameraState(lambda: now)

    def is_connected() -> bool:
        return state.is_connected

    state.rest()
    assert not is_connected(), "it was never there"
    state.take((160, 120))
    state.rest()
    now += 10 * PATIENCE
    assert is_connected()
    state.lose("nobody answers")
    assert not is_connected()


def test_camera_that_stalls_is_a_fault_even_while_its_thread_hangs() -> None:
    now = 5.0
    state = CameraState(lambda: now)
    assert state.faults() == ("the camera gives no pictures: it has not been opened yet",)
    state.take((160, 120))
    assert state.faults() == ()
    now += PATIENCE
    assert state.faults() == ("the camera gives no pictures: none has come for 3 s",)
    state.lose("it hung up")
    state.lose("nobody answers")
    assert dict(state.lost) == {"it hung up": 1}  # the second time it was not there to be lost
    assert state.faults() == ("the camera gives no pictures: nobody answers",)


def test_a_calibrated_camera_is_described_with_its_model_and_publishes_it_with_each_picture() -> None:
    thread = CameraThread("somewhere")
    thread.driver.take((160, 120))
    known = CameraCalibration(160, 120, 150.0, 151.0, 79.0, 60.0, (-0.2, 0.1, 0.01, 0.02, 0.0), 0.3)
    settings = Settings(camera=CameraSettings(calibration=known))
    # The casts stand for the parts of a robot that a camera's adapter does not use.
    adapter = CameraAdapter(RobotContext("happy", cast(Any, None), settings, cast(Any, None)), thread)
    messages = dict(adapter.messages(PictureTaken(JPEG, 160, 120), 1_500_000_000))
    info = decode(keys.CAMERA_INFO.type_name, encode(messages[keys.CAMERA_INFO]))
    assert (info.width, info.height, info.distortion_model) == (160, 120, "plumb_bob")
    image = cast(Any, messages[keys.CAMERA])  # the type depends on the topic
    assert info.header.stamp == image.header.stamp
    assert info.d.tolist() == list(known.distortion)
    assert info.k.reshape(3, 3).tolist() == [[150.0, 0.0, 79.0], [0.0, 151.0, 60.0], [0.0, 0.0, 1.0]]
    assert info.p.reshape(3, 4)[:, :3].tolist() == info.k.reshape(3, 3).tolist()
    assert info.r.reshape(3, 3).tolist() == np.eye(3).tolist()
    model = PinholeModel.from_dict(adapter.describe()["model"])
    assert model == PinholeModel(160, 120, 150.0, 151.0, 79.0, 60.0, *known.distortion)
    assert [topic for topic, _ in adapter.messages(PictureTaken(JPEG, 320, 240), 0)] == [keys.CAMERA]


def test_face_publishes_the_jpeg_and_describes_its_size() -> None:
    thread = CameraThread("somewhere")
    thread.driver.take((160, 120))
    settings = Settings(camera=CameraSettings(field_of_view_rad=0.8))
    # The casts stand for the parts of a robot that a camera's adapter does not use.
    adapter = CameraAdapter(RobotContext("happy", cast(Any, None), settings, cast(Any, None)), thread)
    [(topic, message)] = adapter.messages(PictureTaken(JPEG, 160, 120), 1_500_000_000)
    assert topic is keys.CAMERA
    image = cast(Any, message)  # the type depends on the topic
    assert (image.format, image.header.frame_id, image.header.stamp.nanosec) == ("jpeg", "happy/camera", 500_000_000)
    assert np.asarray(image.data).tobytes() == JPEG
    assert adapter.describe() == {"size": (160, 120), "field_of_view": 0.8}
    adapter.halt(0.0)  # moves nothing, and needs nobody
