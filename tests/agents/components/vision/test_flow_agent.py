"""flow@ROBOT: flow by columns, with and without rotation, and time to contact, in a drawn room with known depths."""

import asyncio
import json
from math import atan2, cos, pi, sin
from typing import Any

import numpy as np
import pytest

from agents.components.vision.flow_agent import FlowAgent
from agents.components.vision.flow_inputs import LONGEST, CameraMotion, HeadingHistory
from agents.platform import Ending
from benchmarks.vision_drawing import Camera, Room
from bus import Sample, keys, messages
from bus.messages import Odometry, Point, Pose, PoseWithCovariance, TwistWithCovariance
from tests.agents.components.vision.desk import PERIOD, START, Desk, desk, jpeg
from vision.image import Image, Pixels

CAMERA = Camera(160, 120)
DT = PERIOD / 1e9
KNOWN = {"field_of_view": CAMERA.view}


def play(story: Any, **properties: Any) -> None:
    async def run() -> None:
        async with desk(FlowAgent("flow@happy", properties)) as at:
            await story(at)

    asyncio.run(run())


def tell_heading(at: Desk, number: int, angle: float, rate: float) -> None:
    """Publish odometry of the moment of an image."""
    place = Pose(position=Point(0.0, 0.0, 0.0), orientation=messages.quaternion(angle))
    pose = PoseWithCovariance(pose=place, covariance=np.zeros(36))
    twist = TwistWithCovariance(twist=messages.twist(0.3, rate), covariance=np.zeros(36))
    head = messages.header(START + number * PERIOD, "happy/odom")
    at.bus.put(keys.ODOM.key("happy"), Odometry(header=head, child_frame_id="happy/base_link", pose=pose, twist=twist))


async def drive(
    at: Desk, frames: int, speed: float = 0.5, turn: float = 0.0, has_odometry: bool = True
) -> tuple[list[dict[str, Any]], list[float]]:
    """Drive towards the wall of a room, m/s and rad/s; returns the results, and the true times of the last image, s."""
    room, results = Room(7), at.hear("happy/agents/flow/results")
    await at.until(lambda: at.is_watched)
    x, y, heading = 3.0, 0.0, 0.0
    true: list[float] = []
    for frame in range(frames):
        if has_odometry:
            tell_heading(at, frame, heading, turn)
        at.show(Image.of(room.image(CAMERA, x, y, heading)).encode())
        await at.until(lambda: len(results) == at.shown)
        bearings = results[-1].decoded().get("bearings") or ()
        true = [room.depth(x, y, heading, bearing) / max(speed, 1e-9) for bearing in bearings]
        x, y = x + speed * DT * cos(heading + turn * DT / 2), y + speed * DT * sin(heading + turn * DT / 2)
        heading += turn * DT
    return [sample.decoded() for sample in results], true


async def show(at: Desk, pixels: Pixels, results: list[Sample]) -> None:
    """Show an image, and wait for its result."""
    count = len(results)
    at.show(Image.of(pixels).encode())
    await at.until(lambda: len(results) > count)


def error(result: dict[str, Any], true: list[float]) -> float:
    """The median of the relative errors of times from 1 to 8 s."""
    pairs = zip(result["times"], true, strict=True)
    errors = [abs(found - right) / right for found, right in pairs if found is not None and 1.0 <= right <= 8.0]
    assert len(errors) >= 8
    return float(np.median(errors))


@pytest.mark.parametrize(("turn", "has_odometry"), [(0.0, True), (0.2, True), (0.2, False)])
def test_times_to_contact_come_without_speed_and_distance(turn: float, has_odometry: bool) -> None:
    async def story(at: Desk) -> None:
        results, true = await drive(at, 12, turn=turn, has_odometry=has_odometry)
        assert results[0]["interval"] is None
        last = results[-1]
        assert error(last, true) < 0.3
        assert last["rotation"] == ("odometry" if has_odometry else "flow")
        assert last["yaw"] == pytest.approx(turn * last["interval"], abs=0.01)
        assert (last["age"], last["trouble"]) == (pytest.approx(0.25 - 11 * DT), None)
        assert len(last["flow"]) == len(last["rates"]) == 16

    play(story, **KNOWN)


def test_rotation_is_in_the_flow_and_not_in_the_translation() -> None:
    async def story(at: Desk) -> None:
        results, _ = await drive(at, 4, speed=0.0, turn=0.3)
        focal = CAMERA.focal
        for flow, translation in zip(results[-1]["flow"][4:12], results[-1]["translation"][4:12], strict=True):
            assert flow[0] == pytest.approx(0.3 * focal, rel=0.15)  # px/s to the right as the camera turns left
            assert abs(translation[0]) < 0.1 * 0.3 * focal

    play(story, **KNOWN)


def test_a_camera_that_is_metres_away_from_the_axle_is_refused() -> None:
    async def story(at: Desk) -> None:
        assert "up to 2 m before or behind the axle, not 3 m" in (await at.ask("configure", ahead=3.0)).why
        assert (await at.value("configure", ahead=-0.2))["ahead"] == -0.2

    play(story, **KNOWN)


def test_sparse_flow_has_vectors_and_times_too() -> None:
    async def story(at: Desk) -> None:
        options = {"method": "sparse", "columns": 8, "vectors": True, "ahead": 0.1}
        assert await at.value("configure", **options) == options
        assert json.loads(json.dumps(at.agent.pack())) == options
        results, true = await drive(at, 3, speed=1.0)
        last = results[-1]
        known = [(found, right) for found, right in zip(last["times"], true, strict=True) if found is not None]
        assert len(known) >= 3
        assert np.median([abs(found - right) / right for found, right in known]) < 0.4
        x, y, right, down = np.array(last["vectors"]).T
        assert len(x) > 30
        assert np.corrcoef(x - 79.5, right)[0, 1] > 0.7, "away from the focus of expansion"
        assert np.corrcoef(y - 59.5, down)[0, 1] > 0.7

    play(story, **KNOWN)


@pytest.mark.parametrize("method", ["dense", "sparse"])
def test_without_a_camera_model_there_is_flow_and_a_reason_why_there_are_no_times(method: str) -> None:
    async def story(at: Desk) -> None:
        await at.value("configure", method=method)
        results, _ = await drive(at, 3, speed=0.0, turn=0.3)
        last = results[-1]
        assert sum(flow is not None and flow[0] > 30.0 for flow in last["flow"]) >= 8
        assert (last["bearings"], last["translation"]) == (None, None)
        assert set(last["times"]) == {None}
        assert "the field of view of the camera is not known" in last["trouble"]

    play(story)


def test_latest_result_is_read_after_two_images_and_the_camera_is_given_up_later(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("agents.components.vision.flow_agent.LINGER", 0.3)

    async def story(at: Desk) -> None:
        room = Room(7)
        asking = asyncio.ensure_future(at.ask("read"))
        await at.until(lambda: at.is_watched)
        while not asking.done():
            at.show(Image.of(room.image(CAMERA, at.shown * 0.05, 0.0, 0.0)).encode())
            await asyncio.sleep(0.05)
        assert (await asking).value()["interval"] == pytest.approx(DT, abs=1.0)
        await at.until(lambda: not at.is_watched)

    play(story, **KNOWN)


def test_frozen_and_black_images_give_no_times() -> None:
    async def story(at: Desk) -> None:
        results = at.hear("happy/agents/flow/results")
        await at.until(lambda: at.is_watched)
        image = Image.of(Room(7).image(CAMERA, 0.0, 0.0, 0.0)).encode()
        pictures: list[Pixels | bytes] = [image] * 11
        for picture in (*pictures, np.zeros((120, 160), np.uint8), jpeg(np.zeros((120, 160), np.uint8))[:-5]):
            at.show(picture)
            await at.until(lambda: len(results) == at.shown)
        frozen, black, torn = (sample.decoded() for sample in results[-3:])
        assert "may be frozen" in frozen["trouble"]
        assert "black" in black["trouble"]
        assert "truncated" in torn["trouble"]
        assert set(frozen["times"]) == {None}

    play(story, **KNOWN)


def test_images_of_another_size_and_after_a_gap_begin_anew() -> None:
    async def story(at: Desk) -> None:
        results = at.hear("happy/agents/flow/results")
        await at.until(lambda: at.is_watched)
        room = Room(7)
        for camera, skipped in ((CAMERA, 0), (CAMERA, 0), (Camera(80, 60), 0), (Camera(80, 60), 20), (CAMERA, 0)):
            at.shown += skipped
            await show(at, room.image(camera, at.shown * 0.03, 0.0, 0.0), results)
        decoded = [sample.decoded() for sample in results]
        assert [each["interval"] is None for each in decoded] == [True, False, True, True, True]
        troubles = [each["trouble"] for each in decoded]
        assert troubles[3] == "they are 2.1 s apart, and flow needs more than 1 a second"
        assert set(troubles[:3] + troubles[4:]) == {None}
        await show(at, np.full((8, 8), 99, np.uint8), results)
        assert "optical flow needs images of at least 16 x 16 px" in results[-1].decoded()["trouble"]

    play(story, **KNOWN)


def test_wrong_options_are_refused_and_a_missing_camera_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FlowAgent, "first_within", 0.1)

    async def story(at: Desk) -> None:
        assert "dense or sparse, not 'thick'" in (await at.ask("configure", method="thick")).why
        assert "1 to 80 columns, not 0" in (await at.ask("configure", columns=0)).why
        outcome = await at.ask("read")
        assert outcome.ending is Ending.FAILED
        assert "two images that can be compared: is the camera of happy there?" in outcome.why

    play(story)


def test_a_camera_before_the_axle_is_carried_sideways_in_turns() -> None:
    motion = CameraMotion(0.02, speed=0.2, turn=0.4)
    assert motion.way(0.1, 0.25) == pytest.approx((0.02, 0.01))
    assert motion.slip(0.25) == pytest.approx(atan2(0.1, 0.2))
    assert CameraMotion(0.02, turn=0.4).slip(0.25) == 0.0, "a turn on the spot has no direction of travel"


def test_headings_between_and_shortly_after_odometry_are_known_across_a_full_turn() -> None:
    history = HeadingHistory()
    for number in range(10):
        history.add(number * 0.1, pi - 0.25 + number * 0.1 - (2 * pi if number > 2 else 0.0), 1.0)
    assert history.turned(0.05, 0.85) == pytest.approx(0.8)
    assert history.turned(0.85, 0.9 + LONGEST / 2) == pytest.approx(0.05 + LONGEST / 2)
    assert history.turned(-0.1, 0.5) is None
    assert history.turned(0.5, 0.9 + 2 * LONGEST) is None
    history.add(9.9, 0.0, 0.0)
    assert history.turned(0.85, 5.0) is None, "odometry was missing"
    history.add(0.3, 1.0, 0.0)
    assert history.turned(0.1, 0.35) is None, "its clock has begun anew"
