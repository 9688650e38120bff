"""The patrol of the surveillance in the console: rooms, tours and alarms with pictures, of whatever is published."""

import asyncio
import base64
from collections.abc import Mapping
from typing import Any

import pytest

from apps.console.patrol import Patrol, PatrolWatch
from apps.console.placing import FramePlaces
from bus import MemoryBus, MemoryNetwork
from geometry import Pose2D

NOW = 1000.0
PICTURE = {"format": "jpeg", "width": 2, "height": 2, "data": base64.b64encode(b"image").decode()}
ROOM = {"x": 2.0, "y": 1.0, "robot": "happy", "neglect": 12.5, "longest": 30.0, "visits": 3}
ALARM = {"number": 4, "ago": 5.0, "seen_ago": 0.2, "robot": "happy", "sensor": "laser", "x": 1.0, "y": 2.0}
STATE = {
    "stamp": NOW,
    "robots": {"happy": {"does": "drives to Lab", "rooms": ["Lab", "Hall"]}},
    "rooms": {"Lab": ROOM, "Hall": {**ROOM, "x": 5.0, "robot": None}},
    "longest": 30.0,
    "alarms": [{**ALARM, "room": "Lab", "follower": "doc", "may_be": []}],
}


def picture(stamp: float, **changed: Any) -> dict[str, Any]:
    """An alarm of a robot, with its picture."""
    return {"event": "alarm", "stamp": stamp, "intruder": 1, "picture": {**PICTURE, **changed}}


def shown(*published: tuple[str, Any], later: float = 0.0) -> Patrol | None:
    """What is shown of results, some s after they came."""

    async def act() -> Patrol | None:
        network, clock = MemoryNetwork(), [NOW]
        with MemoryBus(network) as bus, PatrolWatch(MemoryBus(network), lambda: clock[0]) as watch:
            for key, told in published:
                bus.put(key, told)
            await asyncio.sleep(0.0)
            clock[0] += later
            return watch.patrol

    return asyncio.run(act())


MANAGER, HAPPY, DOC = "apps/agents/patrol_manager/results", "happy/agents/patrol/results", "doc/agents/patrol/results"


def test_a_patrol_is_shown_with_its_rooms_tours_and_alarms_until_it_is_old() -> None:
    patrol = shown((MANAGER, STATE))
    assert patrol is not None
    assert [(room.name, room.robot, room.neglect) for room in patrol.rooms] == [
        ("Lab", "happy", 12.5),
        ("Hall", "", 12.5),
    ]
    (alarm,) = patrol.alarms
    assert (alarm.number, alarm.at, alarm.room, alarm.follower, alarm.is_seen) == (4, NOW - 5.0, "Lab", "doc", True)
    assert patrol.does == {"happy": "drives to Lab"}
    places = FramePlaces({"happy": (1.0, 0.0, 0.0)})
    places.locate("happy", "office.map", Pose2D(0.5, 0.0, 0.0))
    assert patrol.layout(places) == {
        "tours": [["happy", [[2.5, 1.0], [5.5, 1.0]]]],
        "alarms": [[1.5, 2.0, 4, True]],
    }
    assert shown((MANAGER, STATE), later=10.0) is None


def test_an_alarm_has_the_picture_of_its_robot_and_time() -> None:
    other = base64.b64encode(b"other").decode()
    patrol = shown(
        (DOC, picture(NOW - 5.0, data=other)),
        (HAPPY, picture(NOW - 300.0, data=other)),
        (HAPPY, picture(NOW - 4.0)),
        (MANAGER, STATE),
    )
    assert patrol is not None
    assert patrol.alarms[0].picture == f"data:image/jpeg;base64,{PICTURE['data']}"


@pytest.mark.parametrize(
    "changed", [{"format": "svg+xml"}, {"data": 'x" onerror="alert(1)'}, {"data": 5}, {"data": "A" * 2_000_000}]
)
def test_what_is_no_image_is_not_shown(changed: Mapping[str, Any]) -> None:
    patrol = shown((HAPPY, picture(NOW - 5.0, **changed)), (MANAGER, STATE))
    assert patrol is not None
    assert patrol.alarms[0].picture == ""


@pytest.mark.parametrize(
    "told",
    [
        {},
        {"rooms": [], "robots": 3, "alarms": {}, "stamp": None, "longest": "long"},
        {
            "stamp": NOW,
            "rooms": {"Lab": {"x": "far"}, "Hall": None},
            "robots": {"happy": {"rooms": "all"}, "doc": 1},
            "alarms": [1, {"number": True}, {**ALARM, "ago": "long"}],
        },
    ],
)
def test_what_is_malformed_is_left_out(told: dict[str, Any]) -> None:
    patrol = shown((MANAGER, told))
    assert patrol is not None
    assert (patrol.rooms, patrol.alarms, patrol.tours) == ((), (), {})
    assert patrol.layout(FramePlaces({})) == {"tours": [], "alarms": []}
