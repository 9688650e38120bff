"""A recording in the console without a browser: what happened in it, and what is shown after a jump."""

import asyncio
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from apps.console.recorded_history import RecordedHistory
from apps.console.replay import Replay
from apps.console.robots import RobotWatch
from apps.indoor_navigation.component import push_key, send_key
from apps.indoor_navigation.data import Door, GoalPoint, LogMessage, PlannedWay, WorldCoord
from bus import MemoryBus, MemoryNetwork, keys
from bus.messages import NS_PER_S
from recorder.recorder import Recorder
from recorder.recording import McapRecording
from recorder.writer import RecordingWriter
from tests.apps.console.recordings import (
    DOOR,
    ESTOP_AT,
    GOAL,
    GOAL_AT,
    GONE_AT,
    LEASE_AT,
    PLAN_AT,
    THERE_AT,
    WAY_AT,
    recorded_drive,
)
from tests.recorder.recordings import START


@pytest.fixture
def recording(tmp_path: Path) -> Iterator[McapRecording]:
    with McapRecording.open([recorded_drive(tmp_path / "drive.mcap")]) as recording:
        yield recording


def test_the_history_has_events_at_their_times_and_paths_until_any_time(recording: McapRecording) -> None:
    history = RecordedHistory.of(recording)
    told = [(event.time - START / NS_PER_S, event.kind, event.about) for event in history.timeline.events]
    assert told == [
        (0.0, "connection", "happy"),
        (0.0, "connection", "max"),
        (LEASE_AT, "lease", "happy"),
        (ESTOP_AT, "e-stop", "happy"),
        (ESTOP_AT + 1.0, "e-stop", "happy"),
        (WAY_AT, "mission", "happy"),
        (WAY_AT, "mission", "happy"),
        (GONE_AT, "connection", "max"),
        (THERE_AT, "mission", "happy"),
    ]
    path = history.paths_until(START + 4 * NS_PER_S)["happy"]
    assert path[0] == (0.0, 0.0)
    assert path[-1] == pytest.approx((0.4, 0.2))
    assert keys.STATE.key("happy") in history.slow
    assert keys.ODOM.key("happy") not in history.slow


def test_the_history_has_the_missions_at_any_time(recording: McapRecording) -> None:
    history = RecordedHistory.of(recording)

    def mission(at: float) -> dict[str, Any]:
        return history.missions.at(START + round(at * NS_PER_S))["happy"]

    assert history.missions.at(START) == {}
    told = mission(GOAL_AT + 0.1)
    assert (told["goal"], told["route"], told["state"], told["mission"]) == ([*GOAL, None], [], "told", "m1")
    under_way = mission(WAY_AT + 0.1)
    assert under_way["route"] == [[0.6, 0.3], [1.2, 0.9], list(GOAL)]
    assert (under_way["goal"], under_way["state"], under_way["why"]) == ([*GOAL, None], "going", "the way leads ahead")
    planned = mission(PLAN_AT + 0.1)
    assert planned["route"] == pytest.approx(np.array([[0.6, 0.3], [1.2, 0.9], [*GOAL], [3.0, 1.5]]))
    assert planned["doors"] == [list(DOOR.values())]
    assert (planned["goal"], planned["state"]) == (under_way["goal"], under_way["state"])
    there = mission(THERE_AT + 0.1)
    assert there["doors"] == [list(DOOR.values())], "doors are known after the mission, too"
    assert (there["goal"], there["route"], there["state"], there["why"]) == (None, [], "done", "there, after 2.2 m")
    assert mission(GOAL_AT + 0.1) == told, "a jump back shows what was then"


def test_what_the_navigation_sends_is_recorded_and_found_again(tmp_path: Path) -> None:
    goal = GoalPoint("m1", 2.0, 1.0)
    path = tmp_path / "sent.mcap"
    network = MemoryNetwork()
    with MemoryBus(network) as robot, Recorder(MemoryBus(network), ["happy/**"], RecordingWriter(path, "test")):
        for receiver, sent in (
            ("path_planning", goal),
            ("goto", WorldCoord(1.0, 1, "go", 2.0, 1.0, path=(0.5, 0.5))),
            ("user_interface", LogMessage(1.0, "path_planning", "m1", "info", "going: the way leads ahead")),
        ):
            robot.put(send_key("happy", receiver, type(sent)), sent.to_json())
        plan = PlannedWay(1.0, "m1", (0.5, 0.5, 2.0, 1.0, 4.0, 1.0), (Door(**DOOR),))
        robot.put(push_key("happy", "path_planning", PlannedWay), plan.to_json())
    with McapRecording.open([path]) as recording:
        mission = RecordedHistory.of(recording).missions.at(recording.end_ns)["happy"]
    assert (mission["goal"], mission["route"]) == ([2.0, 1.0, None], [[0.5, 0.5], [2.0, 1.0], [4.0, 1.0]])
    assert mission["doors"] == [list(DOOR.values())]
    assert (mission["mission"], mission["state"]) == ("m1", "going")


def test_a_jump_shows_what_stood_there_and_a_paused_replay_holds_it(recording: McapRecording) -> None:
    network = MemoryNetwork()

    async def act() -> SimpleNamespace:
        with MemoryBus(network) as shown, MemoryBus(network) as seen, Replay(recording, shown) as replay:
            await replay.read_history()
            with RobotWatch(seen, lambda *event: None, replay.now) as watch:
                await replay.seek(3.5)
                playing = asyncio.ensure_future(replay.run())
                async with asyncio.timeout(5.0):
                    while not all(name in watch.robots and watch.robots[name].description for name in ("happy", "max")):
                        await asyncio.sleep(0.01)
                happy = watch.robots["happy"]
                max_is_there = watch.robots["max"].is_there
                first = happy.is_stopped, happy.holder("base"), happy.pose
                await replay.seek(7.0)
                async with asyncio.timeout(5.0):
                    while watch.robots["max"].is_there or happy.is_stopped:
                        await asyncio.sleep(0.01)
                playing.cancel()
                return SimpleNamespace(max_is_there=max_is_there, first=first, pose=happy.pose, at=replay.elapsed)

    found = asyncio.run(act())
    assert found.max_is_there
    assert found.first == (True, "anna@team", pytest.approx((0.35, 0.175, 0.0)))
    assert found.pose == pytest.approx((0.7, 0.35, 0.0))
    assert found.at == pytest.approx(7.0)


def test_after_a_jump_the_sonar_has_the_newest_range_of_each_disc(recording: McapRecording) -> None:
    heard: list[Any] = []

    async def act() -> None:
        with MemoryBus() as bus, Replay(recording, bus) as replay:
            bus.subscribe(keys.SONAR.key("happy"), lambda sample: heard.append(sample.decoded()))
            await replay.seek(5.0)

    asyncio.run(act())
    (message,) = heard
    assert sorted(round(row.range, 1) for row in message.ranges) == [4.7, 4.8, 4.9, 5.0]


def test_a_replay_is_played_to_its_end_and_then_from_its_beginning(recording: McapRecording) -> None:
    async def act() -> tuple[bool, bool, float]:
        with MemoryBus() as bus, Replay(recording, bus) as replay:
            replay.set_speed(16.0)
            await replay.seek(7.5)
            replay.play()
            playing = asyncio.ensure_future(replay.run())
            async with asyncio.timeout(5.0):
                while not replay.is_paused:
                    await asyncio.sleep(0.01)
            ended, at = replay.is_paused, replay.elapsed
            replay.play()
            began_again = replay.elapsed < at
            playing.cancel()
            return ended, began_again, at

    ended, began_again, at = asyncio.run(act())
    assert ended
    assert began_again
    assert at == pytest.approx(recording.duration)
    with MemoryBus() as bus, pytest.raises(ValueError, match="not offered"):
        asyncio.run(_faster(recording, bus))


async def _faster(recording: McapRecording, bus: MemoryBus) -> None:
    Replay(recording, bus).set_speed(3.0)
