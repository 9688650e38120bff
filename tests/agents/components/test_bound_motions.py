"""Motions are bound to whoever asked for them, and to the agent that carries them out."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from itertools import count, pairwise
from typing import Any

import pytest

from agents.platform import AclMessage, AgentName, Performative
from agents.platform.virtual_time import VirtualTimeLoop
from bus import Answer, MemoryBus, Subscription, keys
from bus.heartbeat import LONGEST_PERIOD, PERIOD, SILENCE
from bus.messages import Gripper, Twist, decode, header
from tests.agents.components.bench import ROBOT, Bench, odometry


class Initiator:
    """A program that asks an agent for a motion, and beats as long as it is alive; its token stays in any case."""

    def __init__(self, bench: Bench, has_heartbeat: bool = True) -> None:
        self.name = AgentName("tour", "lab")
        self.is_alive = True
        self.answers: list[AclMessage] = []
        self._bench = bench
        self._bus = MemoryBus(bench.robot.network)
        self._bus.declare_alive(self.name.alive_key)
        self._has_heartbeat = has_heartbeat

    def ask(self, request: str, **arguments: Any) -> Subscription:
        message = AclMessage(
            performative=Performative.REQUEST,
            sender=self.name,
            receivers=(self._bench.component.name,),
            content={"action": request, "arguments": arguments},
            conversation_id=f"conversation {request}",
            x_heartbeat=self.name.heartbeat_key if self._has_heartbeat else "",
        )
        return self._bus.ask(
            self._bench.component.name.acl_key, message.to_dict(), self._hear, lambda error: None, timeout=600.0
        )

    def run(self, seconds: float, each: Any = lambda: None) -> None:
        """Let time pass, and beat meanwhile."""
        for _ in range(round(seconds / LONGEST_PERIOD)):
            if self.is_alive and self._has_heartbeat:
                self._bus.put(self.name.heartbeat_key, {})
            each()
            self._bench.run(LONGEST_PERIOD)

    def _hear(self, answer: Answer) -> None:
        self.answers.append(AclMessage.from_dict(answer.value))


@pytest.fixture
def base(loop: VirtualTimeLoop) -> Iterator[Bench]:
    with ExitStack() as stack:
        bench = Bench(loop, "base")
        stack.callback(bench.close)
        bench.robot.serve(keys.LEASE.key(ROBOT), lambda given: {"holder": None, "elements": {}})
        bench.obey_all()
        bench.robot.serve("never/asked", lambda given: {})
        bench.say(keys.ODOM, odometry())
        yield bench


def rolling(bench: Bench) -> Callable[[], None]:
    """Odometry of a robot that gets on."""
    steps = count()
    return lambda: bench.say(keys.ODOM, odometry(x=0.05 * next(steps)))


def velocities(bench: Bench) -> list[float]:
    heard: list[float] = []

    def hear(sample: Any) -> None:
        twist: Twist = decode(keys.CMD_VEL.type_name, sample.payload)
        heard.append(twist.linear.x)

    MemoryBus(bench.robot.network).subscribe(keys.CMD_VEL.key(ROBOT), hear)
    return heard


def beats(bench: Bench) -> list[float]:
    heard: list[float] = []
    key = bench.component.name.heartbeat_key
    MemoryBus(bench.robot.network).subscribe(key, lambda sample: heard.append(bench.loop.time()))
    return heard


def test_an_agents_heartbeat_beats_while_it_has_the_wheels_moved_and_not_longer(base: Bench) -> None:
    heard = beats(base)
    initiator = Initiator(base)
    initiator.ask("go_to", x=5.0, y=0.0)
    initiator.run(2.0, lambda: base.say(keys.ODOM, odometry()))
    assert len(heard) >= 2.0 / PERIOD - 2
    assert max(later - earlier for earlier, later in pairwise(heard)) < LONGEST_PERIOD
    initiator.is_alive = False
    initiator.run(2.0, lambda: base.say(keys.ODOM, odometry()))
    beaten = len(heard)
    initiator.run(2.0)
    assert len(heard) == beaten


def test_the_wheels_stop_when_who_asked_freezes_although_its_token_stays(base: Bench) -> None:
    sent = velocities(base)
    roll = rolling(base)
    initiator = Initiator(base)
    initiator.ask("go_to", x=50.0, y=0.0)
    initiator.run(2.0, roll)
    assert sent[-1] > 0.0
    initiator.is_alive = False
    initiator.run(SILENCE + LONGEST_PERIOD, roll)
    assert sent[-1] == 0.0
    assert initiator.answers[-1].performative is Performative.FAILURE
    assert "has been silent for 0.5 s" in initiator.answers[-1].content["why"]


def test_who_beats_is_served_to_the_end(base: Bench) -> None:
    roll = rolling(base)
    initiator = Initiator(base)
    initiator.ask("drive", linear=0.2, seconds=8.0)
    initiator.run(12.0, roll)
    assert initiator.answers[-1].performative is Performative.INFORM


def test_who_has_no_heartbeat_is_served_for_a_short_time_only(base: Bench) -> None:
    sent = velocities(base)
    roll = rolling(base)
    initiator = Initiator(base, has_heartbeat=False)
    initiator.ask("go_to", x=50.0, y=0.0)
    initiator.run(4.0, roll)
    assert sent[-1] > 0.0
    initiator.run(6.0, roll)
    assert sent[-1] == 0.0
    assert "has no heartbeat" in initiator.answers[-1].content["why"]


def test_a_key_that_is_no_heartbeat_is_refused(base: Bench) -> None:
    initiator = Initiator(base)
    message_key = base.component.name.acl_key
    message = AclMessage(
        performative=Performative.REQUEST,
        sender=initiator.name,
        receivers=(base.component.name,),
        content={"action": "drive", "arguments": {"linear": 0.1}},
        x_heartbeat="happy/odom",
    )
    MemoryBus(base.robot.network).ask(message_key, message.to_dict(), initiator._hear, lambda error: None)
    base.run(0.1)
    assert initiator.answers[-1].performative is Performative.REFUSE
    assert "/heartbeat" in initiator.answers[-1].content["why"]


def gripper(moving: bool) -> Gripper:
    return Gripper(header(0, ""), True, False, False, moving, False, False, False, False, False, False, False)


@pytest.fixture
def hand(loop: VirtualTimeLoop) -> Iterator[Bench]:
    bench = Bench(loop, "gripper")
    bench.robot.serve(keys.LEASE.key(ROBOT), lambda given: {"holder": None, "elements": {}})
    bench.obey(keys.GRIP)
    yield bench
    bench.close()


def test_a_gripper_stops_when_who_asked_freezes(hand: Bench) -> None:
    initiator = Initiator(hand)
    initiator.ask("close")
    initiator.run(1.0, lambda: hand.say(keys.GRIPPER, gripper(moving=True)))
    assert [given["do"] for _, given in hand.obeyed] == ["close"]
    initiator.is_alive = False
    initiator.run(SILENCE + 2 * LONGEST_PERIOD, lambda: hand.say(keys.GRIPPER, gripper(moving=True)))
    assert [given["do"] for _, given in hand.obeyed] == ["close", "stop"]


def test_an_agent_sees_to_a_motion_for_whose_end_nobody_waits(hand: Bench) -> None:
    heard = beats(hand)
    hand.say(keys.GRIPPER, gripper(moving=False))
    hand.value("close", wait=False)
    begun = len(heard)
    for _ in range(10):
        hand.say(keys.GRIPPER, gripper(moving=True))
        hand.run(0.2)
    assert len(heard) > begun + 10
