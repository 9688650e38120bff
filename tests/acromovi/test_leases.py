"""`acromovi leases`: what gateways and arbiter say, for people and programs."""

import asyncio
import io

import pytest

from acromovi.known_agents import KnownAgents
from acromovi.leases import named, show
from agents.services.arbiter import Arbiter
from agents.services.gateway_leases import held_leases
from bus import MemoryBus, Refused
from tests.agents.client.conftest import World
from tests.agents.services.lease_world import ARBITER

FREE = {"holder": None, "priority": 0, "expires_in": None}
MINE = {"holder": "app@lab", "priority": 2, "expires_in": 1.25}


def test_leases_of_all_robots_are_listed_in_order() -> None:
    with MemoryBus() as bus:
        bus.serve("happy/lease/state", lambda arguments: {**FREE, "elements": {"gripper": MINE, "base": MINE}})
        bus.serve("doc/lease/state", lambda arguments: {**MINE, "elements": {}})
        bus.serve("max/lease/state", lambda arguments: {**FREE, "elements": {}})
        found = asyncio.run(held_leases(bus))[0]
    assert [row["element"] for row in found] == ["base@happy", "doc", "gripper@happy"]
    assert found[1] == {"element": "doc", "holder": "app@lab", "priority": 2, "expires_in": 1.25}


def test_where_no_robot_is_nothing_is_listed() -> None:
    with MemoryBus() as bus:
        assert asyncio.run(held_leases(bus))[0] == []


def test_leases_on_names_are_those_that_arbiters_know(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agents.services.arbiter.TIME_TO_RETURN", 0.0)
    world = World()
    try:
        world.add(Arbiter(ARBITER))
        bus = MemoryBus(world.network)
        with bus, world.team() as team, team.lease("doorway", priority=3), KnownAgents(bus) as known:
            known.meet()
            (row,) = named(bus, known)
    finally:
        world.close()
    assert (row["element"], row["priority"]) == ("name:doorway", 3)
    assert row["holder"].endswith("@apps")
    assert 0.0 < row["expires_in"] <= 3.0


def test_gateway_that_says_no_is_told_and_the_others_are_listed() -> None:
    def refuse(arguments: object) -> dict[str, object]:
        raise Refused("not today")

    with MemoryBus() as bus:
        bus.serve("doc/lease/state", refuse)
        bus.serve("happy/lease/state", lambda arguments: {**MINE, "elements": {}})
        found, left_out = asyncio.run(held_leases(bus))
    assert [row["element"] for row in found] == ["happy"]
    assert left_out.startswith("somebody is left out: ")


def test_list_and_record_are_for_people_too() -> None:
    granted = {"time": 0.0, "event": "granted", "element": "doc", "holder": "app@lab", "priority": 2, "seconds": 3.0}
    shown = io.StringIO()
    show({"leases": [{"element": "doc", **MINE}], "audit": [granted]}, shown)
    lines = shown.getvalue().splitlines()
    assert lines[:2] == ["ELEMENT  HOLDER   PRIORITY  EXPIRES IN", "doc      app@lab  2         1.2 s"]
    assert lines[4].split()[1:] == ["granted", "doc", "app@lab", "2", "seconds", "3.0"]
    shown = io.StringIO()
    show({"leases": []}, shown)
    assert shown.getvalue().startswith("nobody holds a lease")
