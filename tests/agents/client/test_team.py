"""A team as a student uses it: robots found, elements read and moved, and what one is told when something is wrong."""

import asyncio
import math
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any

import numpy as np
import pytest

from agents import Failed, NotThere, Refused, Robot, RobotError, Stopped, Team, TimedOut
from agents.client import discovery
from agents.client.readings import OtherReading
from agents.platform import Agent, AgentName, agree, request
from bus import MemoryBus, keys, messages
from bus import Refused as BusRefused
from tests.agents.client.conftest import LASER, BasePart, Part, World
from tests.waiting import wait_until


def test_robots_are_found_by_what_they_have(team: Team) -> None:
    assert [robot.name for robot in team.robots()] == ["grumpy", "happy"]
    assert [robot.name for robot in team.robots(having="laser")] == ["happy"]
    assert [robot.name for robot in team.robots(having=("laser", "base"))] == ["happy"]
    assert team.robots(having="arm") == []


def test_robots_come_in_the_order_of_the_alphabet_whatever_they_have(world: World, team: Team) -> None:
    world.run(world.container.start(Part("arm@max")))
    wait_until(lambda: len(team.robots()) == 3, "max is seen")
    assert [robot.name for robot in team.robots()] == ["grumpy", "happy", "max"]


def test_a_robot_tells_what_it_has(team: Team) -> None:
    happy = team.robot("happy")
    assert happy.elements == ["base", "laser"]
    assert happy.has("laser")
    assert not happy.has("arm")
    assert team.robot("happy") is happy


def test_any_robot_will_do(team: Team) -> None:
    assert team.robot().name == "grumpy"
    assert team.robot(having="laser").name == "happy"
    with pytest.raises(NotThere, match="no robot has arm; there are grumpy and happy"):
        team.robot(having="arm")


def test_a_robot_that_comes_late_is_waited_for(world: World, team: Team) -> None:
    with world.team() as team:
        late = threading.Timer(0.1, lambda: world.add(BasePart("base@doc")))
        late.start()
        assert team.robot("doc").name == "doc"
        late.join()


class JustJoined(MemoryBus):
    """Is not connected to all yet."""

    @property
    def has_met_all(self) -> bool:
        return False


def test_a_robot_that_the_bus_has_not_met_yet_is_waited_for_longer(world: World) -> None:
    with Team(JustJoined(world.network)) as team:
        late = threading.Timer(3 * discovery.MEETING_TIME, lambda: world.add(BasePart("base@doc")))
        late.start()
        assert team.robot("doc").name == "doc"
        late.join()


def stop(world: World, agent: str, team: Team) -> None:
    """Stop an agent, and wait until the team has noticed."""
    name = AgentName.parse(agent)
    world.run(world.container.stop(name))
    wait_until(lambda: not team._discovery.sees(name), f"{agent} is missed")


def test_a_robot_that_was_there_a_moment_ago_is_waited_for_while_it_restarts(world: World, team: Team) -> None:
    assert team.robot("grumpy").base.pose().x == 0.0
    stop(world, "base@grumpy", team)
    back = threading.Timer(3 * discovery.MEETING_TIME, lambda: world.add(BasePart("base@grumpy")))
    back.start()
    assert team.robot("grumpy").base.move(1.0).x == 1.0
    back.join()


def test_an_element_that_was_there_a_moment_ago_is_waited_for_while_it_restarts(world: World, team: Team) -> None:
    happy = team.robot("happy")
    stop(world, "laser@happy", team)
    back = threading.Timer(3 * discovery.MEETING_TIME, lambda: world.add(Part("laser@happy", LASER)))
    back.start()
    assert happy.laser.nearest() == 0.7
    back.join()


def test_a_robot_or_an_element_that_does_not_come_back_is_named_with_when_it_left(
    world: World, team: Team, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(discovery, "RETURN_TIME", 0.4)
    stop(world, "laser@happy", team)
    with pytest.raises(NotThere, match=r"happy has lost its laser \d+ s ago; it has base"):
        _ = team.robot("happy").laser
    stop(world, "base@grumpy", team)
    with pytest.raises(NotThere, match=r"the robot 'grumpy' left \d+ s ago and has not come back; there is happy"):
        team.robot("grumpy")
    stop(world, "base@happy", team)
    with pytest.raises(NotThere, match=r"the robot 'happy' left \d+ s ago and has not come back; no robot is there"):
        team.robot("happy")


@pytest.mark.parametrize("wanted", [{"name": "doc"}, {"having": "arm"}, {"name": "happy", "having": "arm"}], ids=str)
def test_how_long_a_robot_is_waited_for_can_be_said(world: World, team: Team, wanted: dict[str, str]) -> None:
    comes = f"{wanted.get('having', 'base')}@{wanted.get('name', 'doc')}"
    with pytest.raises(NotThere):
        team.robot(within=0.0, **wanted)
    late = threading.Timer(3 * discovery.MEETING_TIME, lambda: world.add(Part(comes)))
    late.start()
    assert team.robot(within=60.0, **wanted).name == AgentName.parse(comes).platform
    late.join()


def test_a_time_to_wait_that_is_none_is_a_robot_error(team: Team) -> None:
    with pytest.raises(RobotError, match="within must be a time of 0 s or more, not -1"):
        team.robot("happy", within=-1.0)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("hapy", "there is no robot 'hapy'; did you mean 'happy'? There are grumpy and happy"),
        ("doc", "there is no robot 'doc'; there are grumpy and happy"),
    ],
)
def test_who_asks_for_a_robot_that_is_not_there_is_told_which_are(team: Team, name: str, told: str) -> None:
    with pytest.raises(NotThere) as caught:
        team.robot(name)
    assert str(caught.value) == told


def test_who_has_no_robots_at_all_is_told_how_to_start_some() -> None:
    with Team(MemoryBus()) as team:
        with pytest.raises(NotThere, match="there is no robot 'happy', nor any other: start a team with `acromovi up"):
            team.robot("happy")
        with pytest.raises(NotThere, match="there is no robot: start a team with `acromovi up"):
            team.robot()
        assert team.robots() == []


def test_who_asks_for_an_element_that_is_not_there_is_told_which_are(team: Team) -> None:
    with pytest.raises(NotThere) as caught:
        _ = team.robot("happy").gripper
    assert str(caught.value) == "happy has no gripper; it has base and laser"
    with pytest.raises(NotThere, match="grumpy has no laser; it has base"):
        team.robot("grumpy", having="laser")


def test_a_name_that_can_name_no_robot_is_a_robot_error(team: Team) -> None:
    with pytest.raises(RobotError, match="cannot name a robot"):
        team.robot("a robot")
    with pytest.raises(RobotError, match="a robot's name is a text, not 7"):
        team.robot(7)  # type: ignore[arg-type]  # the mistake under test
    with pytest.raises(RobotError, match="cannot be a part of an agent's name"):
        team.robot("happy").element("an element")
    with pytest.raises(RobotError, match="names no agent; a name is written like base@happy"):
        team.ask("happy", "read")


def test_numbers_may_be_those_of_numpy(team: Team) -> None:
    half: Any = np.float32(0.5)  # to mypy these are neither floats nor integers
    one: Any = np.int64(1)
    base = team.robot("happy").base
    assert base.move(half).x == 0.5
    assert base.move(one).x == 1.5
    assert team.ask("base@happy", "move", distance=half)["x"] == 2.0
    base.drive(half / 2)


def test_readings_have_types_and_what_is_not_seen_is_far(world: World, team: Team) -> None:
    laser = team.robot("happy").laser
    assert laser.nearest() == 0.7
    assert laser.read().ranges == (2.0, math.inf, 0.7)
    assert laser.read().within(0.5, -0.5) == math.inf
    assert laser.read().within(0.5, -1.5) == 2.0
    world.agent("laser@happy").result.update(nearest=None, bearing=None)
    assert laser.nearest() == math.inf
    assert math.isnan(laser.read().bearing)


def test_what_cannot_be_read_is_told(world: World, team: Team) -> None:
    del world.agent("laser@happy").result["ranges"]
    with pytest.raises(RobotError, match="what laser@happy says cannot be read: KeyError: 'ranges'"):
        team.robot("happy").laser.nearest()


def test_an_element_without_a_class_of_its_own_is_read_all_the_same(world: World, team: Team) -> None:
    world.add(Part("gyro@happy", {"rate": 0.1}))
    gyro = team.robot("happy").element("gyro")
    reading = gyro.read()
    assert isinstance(reading, OtherReading)
    assert reading["rate"] == 0.1
    assert gyro.ask("read") == {"stamp": 1.0, "rate": 0.1}


def test_a_base_moves_and_says_where_it_is(team: Team) -> None:
    base = team.robot("happy").base
    base.move(1.0)
    end = base.turn(math.pi / 2)
    assert (end.x, end.heading) == (1.0, math.pi / 2)
    assert base.pose() == end


@pytest.mark.parametrize(
    ("distance", "error", "told"),
    [
        (101.0, Refused, "base@happy refuses move: 100 m at a time are enough"),
        (-1.0, Failed, "base@happy could not move: the robot is stalled"),
    ],
)
def test_what_is_not_done_is_an_error_that_says_why(
    team: Team, distance: float, error: type[Exception], told: str
) -> None:
    with pytest.raises(RobotError) as caught:
        team.robot("happy").base.move(distance)
    assert type(caught.value) is error
    assert str(caught.value) == told


def test_a_request_that_is_not_known_is_refused(team: Team) -> None:
    with pytest.raises(Refused, match="does not understand fly: there is no request 'fly' here"):
        team.robot("happy").base.ask("fly")


def test_arguments_without_a_json_form_are_a_robot_error(team: Team) -> None:
    with pytest.raises(RobotError, match="JSON"):
        team.robot("happy").base.ask("move", distance=math.inf)


def test_an_agent_that_goes_is_not_there(world: World, team: Team) -> None:
    laser = team.robot("happy").laser
    world.run(world.container.stop("laser@happy"))
    with pytest.raises(NotThere, match="nobody answers as laser@happy"):
        laser.read()


def test_patience_ends(team: Team) -> None:
    with pytest.raises(TimedOut, match=r"within 0\.05 s"):
        team.robot("happy").base.ask("move", distance=99.0, within=0.05)


def test_any_agent_can_be_asked(team: Team) -> None:
    assert team.ask("laser@happy", "read")["nearest"] == 0.7


def test_results_are_watched_as_they_come_and_the_newest_wins(world: World, team: Team) -> None:
    laser = world.agent("laser@happy")

    def publish(nearest: float) -> None:
        world.loop.call_soon_threadsafe(laser.publish, {**laser.result, "nearest": nearest})

    readings = team.robot("happy").laser.watch()
    threading.Timer(0.1, publish, [0.5]).start()
    assert next(readings).nearest == 0.5
    for nearest in (0.4, 0.3, 0.2):
        publish(nearest)
    world.run(asyncio.sleep(0.1))
    assert next(readings).nearest == 0.2


def test_a_stream_that_falls_silent_or_ends_is_told(world: World, team: Team) -> None:
    laser = team.robot("happy").laser
    with pytest.raises(TimedOut, match="laser@happy has sent nothing"):
        next(laser.watch(within=0.05))
    world.run(world.container.stop("laser@happy"))
    with pytest.raises(NotThere):
        next(laser.watch(within=0.05))


def test_driving_goes_on_until_it_is_stopped(world: World, team: Team) -> None:
    wheels: BasePart = world.agent("base@happy")
    base = team.robot("happy").base
    base.drive(0.2, 0.1)
    team.sleep(0.5)
    wait_until(lambda: wheels.velocities[:3] == [(0.2, 0.1)] * 3)
    base.drive(0.1)
    wait_until(lambda: (0.1, 0.0) in wheels.velocities)
    base.stop()
    assert "stop" in wheels.asked
    wait_until(lambda: wheels.velocities[-1:] == [(0.0, 0.0)])


def test_driving_that_is_refused_says_why(world: World, team: Team) -> None:
    wheels: BasePart = world.agent("base@happy")
    base = team.robot("happy").base
    base.drive(0.2)
    wheels.token = "another's"
    with pytest.raises(Refused, match="happy refuses to drive: somebody else holds the lease"):
        base.drive(0.2)
    wait_until(lambda: wheels.velocities[-1:] == [(0.0, 0.0)])


class Wall:
    """Stall flags of happy's wheels, as its gateway publishes them ten times a second."""

    def __init__(self, world: World) -> None:
        self._wheels: BasePart = world.agent("base@happy")
        self._wheels.every(0.1, self._publish)
        self.is_there = True

    def _publish(self) -> None:
        linear = self._wheels.velocities[-1][0] if self._wheels.velocities else 0.0
        flag = self.is_there and linear > 0.0
        bumpers = messages.Bumpers(messages.header(0, "happy/base_link"), [], [], stall_left=flag, stall_right=flag)
        self._wheels.bus.put("happy/bumpers", bumpers)


def test_driving_that_is_stalled_stops_and_says_so(world: World, team: Team) -> None:
    wheels: BasePart = world.agent("base@happy")
    world.run(_in_loop(lambda: Wall(world)))
    base = team.robot("happy").base
    base.drive(0.2)

    def drive_on() -> None:
        for _ in team.every(0.1):
            base.drive(0.2)

    with pytest.raises(Failed, match=r"^happy is stalled and was stopped: something blocks it at 0.2 m/s, 0 rad/s; "):
        drive_on()
    wait_until(lambda: wheels.velocities[-1:] == [(0.0, 0.0)])
    base.drive(-0.1)
    wait_until(lambda: wheels.velocities[-1:] == [(-0.1, 0.0)])


def test_a_program_that_drives_away_from_what_stalls_it_is_obeyed(world: World, team: Team) -> None:
    wheels: BasePart = world.agent("base@happy")
    world.run(_in_loop(lambda: Wall(world)))
    base = team.robot("happy").base
    base.drive(0.2)
    for _ in team.every(0.1):
        if wheels.velocities[-1:] == [(0.0, 0.0)]:
            break
    base.drive(-0.1)
    wait_until(lambda: wheels.velocities[-1:] == [(-0.1, 0.0)])


async def _in_loop(make: Callable[[], object]) -> None:
    make()


def test_who_was_refused_does_not_stop_what_another_drives(world: World) -> None:
    wheels: BasePart = world.agent("base@happy")
    wheels.token = "another's"
    with world.team() as team:
        with pytest.raises(Refused):
            team.robot("happy").base.drive(0.2)
        with pytest.raises(Refused):
            team.robot("happy").base.move(101.0)
    assert "stop" not in wheels.asked
    assert not wheels.velocities


def test_driving_ends_when_the_program_makes_no_call_any_more(
    world: World, team: Team, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agents.client.loop_thread.ATTENTION", 0.2)
    wheels: BasePart = world.agent("base@happy")
    team.robot("happy").base.drive(0.2)
    wait_until(lambda: wheels.velocities[-1:] == [(0.0, 0.0)])


class Silent(Agent):
    """An element whose agent takes requests and does not answer."""

    @request("read")
    async def read(self) -> None:
        await asyncio.sleep(3600.0)


@contextmanager
def under_way(team: Team, call: Callable[[], object]) -> Iterator[None]:
    """A call of the program lasts as long as a block."""

    def run() -> None:
        with suppress(Stopped):  # that ends it, below
            call()

    calling = threading.Thread(target=run)
    calling.start()
    try:
        yield
    finally:
        team._thread.stop("enough")
        calling.join()


@pytest.mark.parametrize("wait", ["read", "ask", "watch"])
def test_driving_ends_while_the_program_waits_for_a_reading_that_does_not_come(
    world: World, monkeypatch: pytest.MonkeyPatch, wait: str
) -> None:
    monkeypatch.setattr("agents.client.loop_thread.ATTENTION", 0.2)
    wheels: BasePart = world.agent("base@happy")
    world.add(Silent("sonar@happy"))
    with world.team() as team:
        happy = team.robot("happy")
        sonar = happy.element("sonar")
        waits: dict[str, Callable[[], object]] = {
            "read": lambda: sonar.read(within=3600.0),
            "ask": lambda: sonar.ask("read", within=3600.0),
            "watch": lambda: next(sonar.watch(within=3600.0)),
        }

        happy.base.drive(0.2)
        with under_way(team, waits[wait]):
            wait_until(lambda: wheels.velocities[-1:] == [(0.0, 0.0)])


def test_driving_goes_on_while_readings_come(world: World, team: Team) -> None:
    wheels: BasePart = world.agent("base@happy")
    happy = team.robot("happy")
    happy.base.drive(0.2)
    while len(wheels.velocities) < 15:  # for longer than a program may be without a call
        happy.laser.read()
    assert set(wheels.velocities) == {(0.2, 0.0)}


@pytest.mark.parametrize("wait", ["sleep", "every", "move"])
def test_driving_goes_on_while_the_program_sleeps_or_moves_something(
    world: World, monkeypatch: pytest.MonkeyPatch, wait: str
) -> None:
    monkeypatch.setattr("agents.client.loop_thread.ATTENTION", 0.2)
    wheels: BasePart = world.agent("base@happy")
    with world.team() as team:
        grumpy = team.robot("grumpy")
        waits: dict[str, Callable[[], object]] = {
            "sleep": lambda: team.sleep(3600.0),
            "every": lambda: list(team.every(3600.0)),
            "move": lambda: grumpy.base.move(99.0),
        }

        with under_way(team, waits[wait]):
            team.robot("happy").base.drive(0.2)
            wait_until(lambda: len(wheels.velocities) >= 10)
            assert set(wheels.velocities) == {(0.2, 0.0)}


class Gateway:
    """The gateway of happy, in a program of its own. obeyed: commands with their arguments."""

    def __init__(self, world: World, refusal: str = "") -> None:
        self.obeyed: list[tuple[str, dict[str, Any]]] = []
        self._bus = MemoryBus(world.network)
        self._refusal = refusal
        for topic in (keys.STOP, keys.ESTOP):
            self._bus.serve(topic.key("happy"), partial(self._obey, topic.suffix))

    def _obey(self, command: str, given: dict[str, Any]) -> dict[str, Any]:
        if self._refusal:
            raise BusRefused(self._refusal)
        self.obeyed.append((command, given))
        return {"accepted": True}


@contextmanager
def frozen(world: World) -> Iterator[None]:
    """The container of the robots' agents answers nothing during a block."""
    thaw = threading.Event()
    world.loop.call_soon_threadsafe(thaw.wait)
    try:
        yield
    finally:
        thaw.set()


STOPS: list[tuple[Callable[[Robot], object], tuple[str, dict[str, Any]]]] = [
    (lambda robot: robot.base.stop(), ("command/stop", {})),
    (lambda robot: robot.stop(), ("command/stop", {})),
    (lambda robot: robot.base.estop(), ("command/estop", {"on": True})),
    (lambda robot: robot.base.estop(False), ("command/estop", {"on": False})),
]


@pytest.mark.parametrize(("order", "told"), STOPS)
def test_a_stop_reaches_the_gateway_when_the_agents_of_the_robot_do_not_answer(
    world: World, team: Team, order: Callable[[Robot], object], told: tuple[str, dict[str, Any]]
) -> None:
    gateway, happy = Gateway(world), team.robot("happy")
    assert happy.base.pose().x == 0.0
    with frozen(world):
        order(happy)
    assert gateway.obeyed == [told]


@pytest.mark.parametrize(("order", "told"), STOPS)
def test_a_stop_reaches_the_gateway_when_the_agents_of_the_robot_have_gone(
    world: World, team: Team, order: Callable[[Robot], object], told: tuple[str, dict[str, Any]]
) -> None:
    gateway, happy = Gateway(world), team.robot("happy")
    assert happy.base.pose().x == 0.0
    world.run(world.container.stop("base@happy"))
    order(happy)
    assert gateway.obeyed == [told]


def test_a_stop_that_neither_agent_nor_gateway_obeys_is_an_error(world: World, team: Team) -> None:
    Gateway(world, refusal="the robot is away")
    base = team.robot("happy").base
    world.run(world.container.stop("base@happy"))
    with pytest.raises(NotThere, match="nobody answers as base@happy"):
        base.stop()
    with pytest.raises(NotThere, match="nobody answers as base@happy"):
        base.estop()


class RollingBase(Agent):
    """A base that takes longer to stand than its agent may take to obey."""

    @request("stop", agrees_itself=True)
    async def stop(self) -> str:
        agree()
        await asyncio.sleep(0.5)
        return "stands"


def test_a_robot_that_rolls_after_a_stop_is_waited_for_and_stopped_once(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agents.client.movers.STOP_TIME", 0.2)
    gateway = Gateway(world)
    world.run(world.container.stop("base@happy"))
    world.add(RollingBase("base@happy"))
    with world.team() as team:
        team.robot("happy").base.stop()
    assert gateway.obeyed == []


def test_the_end_of_the_block_stops_what_drives(world: World) -> None:
    wheels: BasePart = world.agent("base@happy")
    with world.team() as team:
        team.robot("happy").base.drive(0.2)
        team.robot("grumpy").base.move(1.0)
    assert "stop" in wheels.asked
    wait_until(lambda: wheels.velocities[-1:] == [(0.0, 0.0)])
    assert "stop" not in world.agent("base@grumpy").asked  # it has ended by itself


def test_a_team_that_is_closed_says_so(team: Team) -> None:
    base = team.robot("happy").base
    team.close()
    team.close()
    with pytest.raises(RobotError, match="this team is closed; open another with `with Team"):
        base.move(1.0)


def test_a_team_cannot_be_used_in_its_own_loop(team: Team) -> None:
    async def wrong() -> None:
        team.robots()

    with pytest.raises(RobotError, match="cannot be used in a coroutine"):
        team._thread.call(wrong())


def test_who_is_stopped_stops_at_the_next_call_and_in_the_midst_of_one(world: World, team: Team) -> None:
    wheels: BasePart = world.agent("base@happy")
    base = team.robot("happy").base
    ends: list[Any] = []

    def go() -> None:
        try:
            base.move(99.0)
        except Stopped as stopped:
            ends.append(str(stopped))

    thread = threading.Thread(target=go)
    thread.start()
    wait_until(lambda: wheels.asked)
    team._thread.stop("enough")
    thread.join()
    assert ends == ["enough"]
    assert "stop" in wheels.asked
    with pytest.raises(Stopped):
        base.pose()


def test_a_call_that_begins_while_the_program_is_stopped_ends_too(team: Team, monkeypatch: pytest.MonkeyPatch) -> None:
    loop_thread = team._thread
    stopping = threading.Thread(target=loop_thread.stop, args=["enough"])
    submit = asyncio.run_coroutine_threadsafe
    ends: list[Any] = []

    def submit_as_it_is_stopped(work: Any, loop: asyncio.AbstractEventLoop) -> Any:
        future = submit(work, loop)
        stopping.start()
        stopping.join(0.3)  # long enough for `stop` to look at what is under way, if nothing keeps it from that
        return future

    def sleep() -> None:
        try:
            team.sleep(3600.0)
        except Stopped as stopped:
            ends.append(str(stopped))

    monkeypatch.setattr(asyncio, "run_coroutine_threadsafe", submit_as_it_is_stopped)
    sleeping = threading.Thread(target=sleep, daemon=True)
    sleeping.start()
    sleeping.join(20.0)
    monkeypatch.undo()
    assert ends == ["enough"]


def test_a_loop_keeps_its_beat_and_ends_when_the_program_is_to_end(team: Team) -> None:
    threading.Timer(0.3, team._thread.stop, ["enough"]).start()
    beats = list(team.every(0.05))
    assert 2 <= len(beats) <= 7
    assert beats == sorted(beats)


def test_a_program_that_is_suspended_waits_at_its_next_call(world: World, team: Team) -> None:
    beats: list[float] = []
    thread = threading.Thread(target=lambda: beats.extend(team.every(0.02)))
    team._thread.suspend()
    thread.start()
    team._thread.loop.call_soon_threadsafe(lambda: None)
    assert not beats
    team._thread.resume()
    world.run(asyncio.sleep(0.1))
    team._thread.stop("enough")
    thread.join()
    assert beats


def test_its_agent_is_in_the_directory_and_goes_with_it(world: World, team: Team) -> None:
    name: AgentName = team._thread.agent.name
    assert name.platform == "apps"
    assert team.ask(str(world.agent("laser@happy").name), "read")
