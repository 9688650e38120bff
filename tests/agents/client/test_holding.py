"""Leases in a program's hands: an arbiter's, or the gateway's own where no arbiter lives."""

import asyncio
import threading
from collections.abc import Iterator
from concurrent.futures import Future
from typing import Any

import pytest

from agents import Failed, LeaseLost, Refused, Team
from agents.platform import Agent, AgentName, Outcome, agree, request
from agents.services.arbiter import Arbiter
from bus import Refused as No
from tests.agents.client.conftest import BasePart, Part, World
from tests.agents.services.lease_world import ARBITER, Gateway
from tests.waiting import wait_until

FOR_EVER = 99.0  # m


class LeasedBase(BasePart):
    """A base behind a gateway that heeds leases."""

    def __init__(self, gateway: Gateway) -> None:
        super().__init__("base@happy")
        self._gateway = gateway

    @request("move", agrees_itself=True)
    async def move(self, distance: float, speed: float = 0.3, token: str = "") -> dict[str, Any]:
        if not self._gateway.moves("base", token):
            raise No("somebody else holds the lease on the base")
        self.asked.append(("move", distance))
        agree()
        while distance == FOR_EVER and self._gateway.moves("base", token):
            await asyncio.sleep(0.01)
        if distance == FOR_EVER:
            raise No("stopped: the lease has passed on")
        return self.result

    def _drive(self, given: dict[str, Any]) -> dict[str, Any]:
        if not self._gateway.moves("base", given.get("token", "")):
            raise No("somebody else holds the lease on the base")
        return {"accepted": True}


class GripperPart(Part):
    """A gripper that remembers with which token it was stopped."""

    @request("stop")
    def stop(self, token: str = "") -> dict[str, Any]:
        self.asked.append(token)
        return self.result


class LeasedWorld(World):
    """A world with a gateway that gives leases."""

    def __init__(self) -> None:
        super().__init__()
        self.gateway = Gateway(self.loop, self.network, "happy")


@pytest.fixture
def world() -> Iterator[LeasedWorld]:
    world = LeasedWorld()
    living = asyncio.run_coroutine_threadsafe(world.gateway.live(), world.loop)
    world.add(LeasedBase(world.gateway))
    world.add(GripperPart("gripper@happy"))
    yield world
    living.cancel()
    world.close()


@pytest.fixture
def gateway(world: LeasedWorld) -> Gateway:
    return world.gateway


@pytest.fixture(params=["an arbiter", "the gateway alone"])
def either(request: pytest.FixtureRequest, world: World) -> None:
    """Leases are given by an arbiter, or where there is none."""
    if request.param == "an arbiter":
        world.add(Arbiter(ARBITER))


@pytest.fixture
def chief(world: World) -> Agent:
    """Somebody of higher priority, and an arbiter."""
    world.add(Arbiter(ARBITER))
    chief: Agent = world.add(Agent(AgentName("chief", "lab")))
    return chief


def take_over(world: World, chief: Agent, notice: float) -> "Future[Outcome]":
    """Let the chief ask for the base."""
    wish = chief.request(ARBITER, "lease", element="base@happy", priority=5, notice=notice)
    return asyncio.run_coroutine_threadsafe(wish, world.loop)


@pytest.mark.usefixtures("either")
def test_who_holds_the_lease_moves_and_nobody_else(world: World, gateway: Gateway) -> None:
    with world.team() as team, world.team() as other:
        base, same = team.robot("happy").base, other.robot("happy").base
        with base.lease() as lease:
            base.move(1.0)
            base.drive(0.1)
            with pytest.raises(Refused, match="somebody else holds the lease"):
                same.move(1.0)
            with pytest.raises(Refused, match=r"no lease on base@happy: refused: app-\w+@apps holds"), same.lease():
                pass
        assert not lease.is_held
        same.move(1.0)


@pytest.mark.usefixtures("either")
def test_lease_is_renewed_in_the_background(team: Team) -> None:
    base = team.robot("happy").base
    with base.lease(seconds=2.0) as lease:
        team.sleep(3.0)
        assert lease.is_held
        base.move(1.0)


@pytest.mark.usefixtures("either")
def test_ctrl_c_gives_the_lease_back(team: Team, gateway: Gateway) -> None:
    base = team.robot("happy").base

    def interrupted() -> None:
        with base.lease():
            assert not gateway.moves("base", "")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert gateway.moves("base", "")


@pytest.mark.usefixtures("either")
def test_end_of_the_team_gives_the_lease_back(world: World, gateway: Gateway) -> None:
    with world.team() as team:
        block = team.robot("happy").base.lease()
        block.__enter__()
        assert not gateway.moves("base", "")
    assert gateway.moves("base", "")
    block.__exit__(None, None, None)


def test_notice_is_seen_and_no_motion_begins_any_more(world: World, team: Team, chief: Agent) -> None:
    base = team.robot("happy").base
    with base.lease() as lease:
        assert lease.wanted_by == ""
        taking = take_over(world, chief, 5.0)
        wait_until(lambda: lease.wanted_by == "chief@lab")
        assert lease.is_held
        with pytest.raises(LeaseLost, match="chief@lab is about to take the lease on base@happy; leave the block"):
            base.move(1.0)
        with pytest.raises(LeaseLost):
            base.drive(0.1)
    assert taking.result(4.0).is_done  # before the notice is over
    with pytest.raises(Refused, match="somebody else holds the lease"):
        base.move(1.0)


def test_motion_under_way_ends_with_the_lease(world: World, team: Team, chief: Agent) -> None:
    base = team.robot("happy").base
    wheels: LeasedBase = world.agent("base@happy")

    def take() -> None:
        wait_until(lambda: wheels.asked)
        take_over(world, chief, 0.1)

    thread = threading.Thread(target=take)
    with base.lease() as lease:
        thread.start()
        with pytest.raises(LeaseLost) as caught:
            base.move(FOR_EVER)
        assert isinstance(caught.value.__cause__, Failed)
        wait_until(lambda: not lease.is_held)
        with pytest.raises(LeaseLost, match="the lease on base@happy is lost: preempted by chief@lab"):
            base.move(1.0)
    thread.join()
    assert "stop" not in wheels.asked  # what moves now is the chief's


def test_driving_ends_with_the_lease_and_stops_nobody_else(world: World, team: Team, chief: Agent) -> None:
    base = team.robot("happy").base
    wheels: LeasedBase = world.agent("base@happy")
    with base.lease() as lease:
        base.drive(0.2)
        assert take_over(world, chief, 0.1).result(5.0).is_done
        wait_until(lambda: not lease.is_held)
        team.sleep(0.3)
        driven = len(wheels.velocities)
        team.sleep(0.3)
        assert len(wheels.velocities) == driven
    assert "stop" not in wheels.asked


@pytest.mark.usefixtures("either")
def test_lease_that_the_gateway_has_forgotten_is_lost(team: Team, gateway: Gateway) -> None:
    base = team.robot("happy").base
    with base.lease(seconds=0.6) as lease:
        gateway.kill()
        gateway.start()
        wait_until(lambda: not lease.is_held)
        with pytest.raises(LeaseLost, match="the lease on base@happy is lost: lost by"):
            base.move(1.0)


@pytest.mark.usefixtures("either")
def test_who_holds_the_lease_stops_with_its_token(world: World, team: Team) -> None:
    gripper = team.robot("happy").gripper
    with gripper.lease() as lease:
        gripper.stop()
        assert world.agent("gripper@happy").asked == [lease.token]
    gripper.stop()
    assert world.agent("gripper@happy").asked[1:] == [""]


def test_a_name_is_held_during_a_block(world: LeasedWorld, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agents.services.arbiter.TIME_TO_RETURN", 0.1)
    world.add(Arbiter(ARBITER))
    with world.team() as first, world.team() as second:
        with first.lease("doorway") as lease:
            assert lease.is_held
            refused = pytest.raises(
                Refused, match=r"^no lease on name:doorway: refused: app-.*@apps holds name:doorway"
            )
            with refused, second.lease("doorway"):
                pass
            with second.lease("doorway", priority=1):
                wait_until(lambda: not lease.is_held)
                with pytest.raises(LeaseLost, match="the lease on name:doorway is lost"):
                    _ = lease.token
        with second.lease("doorway"):
            pass


@pytest.mark.parametrize("name", ["", "base@happy", "a\nb"])
def test_what_cannot_be_a_name_is_told(world: LeasedWorld, name: str) -> None:
    refused = pytest.raises(Refused, match="names nothing to lease; write name:doorway")
    with world.team() as team, refused, team.lease(name):
        pass


def test_a_name_needs_an_arbiter(world: LeasedWorld) -> None:
    refused = pytest.raises(Refused, match="no arbiter is there to give name:doorway: start a team")
    with world.team() as team, refused, team.lease("doorway"):
        pass
