"""Agents in one container, on a bus in memory and in virtual time: life, streams, requests and what goes wrong."""

import asyncio
from collections.abc import Callable, Coroutine, Iterator
from typing import Any

import pytest

from agents.platform import (
    AclMessage,
    Agent,
    AgentError,
    AgentName,
    AgentState,
    AlreadyThere,
    Container,
    Ending,
    IllegalTransition,
    OneShot,
    Outcome,
    Performative,
    Report,
    RequestNotDone,
    Template,
    UnknownAgent,
    agree,
    asker,
    every,
    on,
    request,
)
from agents.platform.conversations.request_dispatcher import MOST_REQUESTS
from agents.platform.schedule import FAIL_AGENT
from agents.platform.virtual_time import VirtualTimeLoop
from bus import Conversation, MemoryBus, MemoryNetwork, NoAnswer, Refused, Sample
from bus.messages import twist

BASE, CONSOLE = AgentName("base", "happy"), AgentName("console", "lab")


class Base(Agent):
    """Drives, as far as these tests are concerned."""

    services = ("drive",)

    def __init__(self, name: AgentName | str = BASE) -> None:
        super().__init__(name)
        self.beats: list[float] = []
        self.heard: list[Any] = []
        self.steps: list[str] = []

    async def setup(self) -> None:
        self.steps.append("setup")

    async def take_down(self) -> None:
        self.steps.append("take down")

    @every(1.0)
    async def beat(self) -> None:
        self.beats.append(asyncio.get_running_loop().time())

    @on("cmd_vel")
    async def follow(self, message: Any) -> None:
        self.heard.append(message)
        await asyncio.sleep(0.1)

    @request("drive")
    async def drive(self, distance: float, speed: float = 0.5) -> dict[str, float]:
        if speed > 1.0:
            raise Refused("speed is at most 1 m/s")
        await asyncio.sleep(distance / speed)
        if distance > 100.0:
            raise Refused("the battery is empty")
        return {"driven": distance}

    @request("look")
    def look(self) -> str:
        return "all clear"

    @request("break")
    async def break_down(self) -> None:
        raise KeyError("cog")

    @request("infinite")
    async def infinite(self) -> float:
        return float("inf")

    @request("ponder", agrees_itself=True)
    async def ponder(self, answer: bool) -> bool:
        await asyncio.sleep(1.0)
        if not answer:
            raise Refused("having pondered it, no")
        agree()
        await asyncio.sleep(1.0)
        return answer


class Bench:
    """Two containers that meet in memory, a base in one and a console in the other."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self.loop = loop
        self.network = MemoryNetwork()
        self.reports: list[Report] = []
        self.robot = Container(MemoryBus(self.network), "happy", self.reports.append, loop.time)
        self.lab = Container(MemoryBus(self.network), "lab", self.reports.append, loop.time)
        self.base = Base()
        self.console = Agent(CONSOLE)
        self.run(self.robot.start(self.base))
        self.run(self.lab.start(self.console))

    def run(self, work: Coroutine[Any, Any, Any]) -> Any:
        return self.loop.run_until_complete(work)

    def ask(self, name: str, /, **arguments: Any) -> Outcome:
        outcome: Outcome = self.run(self.console.request(BASE, name, **arguments))
        return outcome

    def begin(self, name: str, /, **arguments: Any) -> "asyncio.Task[Outcome]":
        return self.loop.create_task(self.console.request(BASE, name, **arguments))


@pytest.fixture
def bench(loop: VirtualTimeLoop) -> Iterator[Bench]:
    bench = Bench(loop)
    yield bench
    bench.run(bench.robot.close())
    bench.run(bench.lab.close())
    assert not asyncio.all_tasks(loop), "something is left behind"


def test_results_reach_whoever_listens_to_them(bench: Bench) -> None:
    heard: list[dict[str, Any]] = []

    async def hear(result: dict[str, Any]) -> None:
        heard.append(result)

    async def listen() -> None:
        bench.console.listen(BASE.results_key, hear)

    bench.run(listen())
    for x in (1.0, 2.0):
        bench.base.publish({"x": x})
        bench.loop.run_for(0.1)
    assert heard == [{"x": 1.0}, {"x": 2.0}]


def test_who_listens_to_many_keys_can_tell_them_apart(bench: Bench) -> None:
    heard: list[tuple[str, Any]] = []

    async def hear(key: str, message: dict[str, Any]) -> None:
        heard.append((key, message["x"]))

    async def listen() -> None:
        bench.console.listen("*/note", hear, keep=2, keyed=True)

    bench.run(listen())
    for number, robot in enumerate(("happy", "dopey")):
        bench.lab.bus.put(f"{robot}/note", {"x": number})
    bench.loop.run_for(0.1)
    assert heard == [("happy/note", 0), ("dopey/note", 1)]


@pytest.mark.parametrize(
    ("error", "why"),
    [
        (Refused(""), "Refused"),
        (TimeoutError(), "broken failed with a timeout"),
        (ValueError(), "broken failed with ValueError"),
        (ValueError("no"), "broken failed with ValueError: no"),
        (NoAnswer(" "), "broken failed with a timeout"),
    ],
)
def test_a_reason_is_never_empty(bench: Bench, error: Exception, why: str) -> None:
    def fail() -> None:
        raise error

    bench.base.answer("broken", fail)
    assert bench.ask("broken").why == why


def test_who_gives_no_reason_has_that_said() -> None:
    refusal = AclMessage(performative=Performative.REFUSE, sender=BASE, receivers=(CONSOLE,), content={"why": " "})
    assert refusal.why == "no reason is given"


def test_a_handler_can_tell_who_asks(bench: Bench) -> None:
    bench.base.answer("who", lambda: str(asker()))
    assert bench.ask("who").value() == str(CONSOLE)


def test_an_agent_lives_from_setup_to_take_down(bench: Bench) -> None:
    states = [bench.base.state]
    bench.loop.run_for(3.5)
    bench.run(bench.robot.stop("base@happy"))
    bench.loop.run_for(3.0)
    assert bench.base.beats == pytest.approx([1.0, 2.0, 3.0])
    assert bench.base.steps == ["setup", "take down"]
    assert [*states, bench.base.state] == [AgentState.ACTIVE, AgentState.DELETED]
    with pytest.raises(UnknownAgent, match="no agent base@happy lives in happy"):
        bench.robot.agent(BASE)


def test_a_name_serves_once_in_a_container_and_again_after_its_end(bench: Bench) -> None:
    with pytest.raises(AlreadyThere):
        bench.run(bench.robot.start(Base()))
    bench.run(bench.robot.stop(BASE))
    assert bench.run(bench.robot.start(Base()))


def test_an_agent_without_a_home_says_so() -> None:
    with pytest.raises(AgentError, match="lives in no container"):
        Base().describe()


def test_a_suspended_agent_rests_and_refuses_and_keeps_its_messages(bench: Bench) -> None:
    bench.robot.suspend(BASE)
    with pytest.raises(IllegalTransition):
        bench.robot.suspend(BASE)
    bench.console.send(AclMessage(performative=Performative.INFORM, sender=CONSOLE, receivers=(BASE,)))
    bench.loop.run_for(5.0)
    assert bench.base.beats == []
    assert bench.ask("look") == Outcome(Ending.REFUSED, why="base@happy is suspended")
    bench.robot.resume(BASE)
    bench.loop.run_for(2.0)
    assert len(bench.base.beats) >= 2
    assert bench.base.mailbox.take() is not None


@pytest.mark.parametrize("what", ["message", "request"])
def test_an_agent_that_waits_is_woken_by_what_comes(bench: Bench, what: str) -> None:
    bench.base.wait()
    bench.loop.run_for(5.0)
    assert (bench.base.state, bench.base.beats) == (AgentState.WAITING, [])
    if what == "message":
        bench.console.send(AclMessage(performative=Performative.INFORM, sender=CONSOLE, receivers=(BASE,)))
    else:
        assert bench.ask("look").is_done
    bench.loop.run_for(1.5)
    assert bench.base.state is AgentState.ACTIVE
    assert bench.base.beats


def test_an_agent_may_end_itself(bench: Bench) -> None:
    async def enough() -> None:
        bench.base.delete()
        await asyncio.sleep(1000.0)

    async def begin() -> None:
        bench.base.add(enough)

    bench.run(begin())
    bench.loop.run_for(1.0)
    assert bench.base.steps == ["setup", "take down"]


def test_an_agent_whose_setup_raises_is_reported_and_hurts_no_other(bench: Bench) -> None:
    class Broken(Agent):
        async def setup(self) -> None:
            raise OSError("no such camera")

    assert not bench.run(bench.robot.start(Broken("camera@happy")))
    assert [(str(report.agent), report.what, str(report.error)) for report in bench.reports] == [
        ("camera@happy", "its setup failed", "no such camera")
    ]
    assert [agent.name for agent in bench.robot.agents] == [BASE]
    assert bench.ask("look").is_done


def test_an_agent_that_is_being_set_up_refuses(bench: Bench) -> None:
    class Late(Base):
        async def setup(self) -> None:
            await asyncio.sleep(5.0)

    starting = bench.loop.create_task(bench.robot.start(Late("late@happy")))
    bench.loop.run_for(1.0)
    outcome = bench.run(bench.console.request("late@happy", "look"))
    assert outcome == Outcome(Ending.REFUSED, why="late@happy is initiated")
    bench.loop.run_for(5.0)
    assert starting.result()


def test_an_agent_that_is_stopped_during_its_setup_leaves_nothing_behind(bench: Bench) -> None:
    class Late(Base):
        async def setup(self) -> None:
            await asyncio.sleep(5.0)

    starting = bench.loop.create_task(bench.robot.start(Late("late@happy")))
    bench.loop.run_for(1.0)
    bench.run(bench.robot.stop("late@happy"))
    bench.loop.run_for(5.0)
    assert not starting.result()
    assert [agent.name for agent in bench.robot.agents] == [BASE]


def test_a_setup_that_never_ends_is_given_up(bench: Bench) -> None:
    class Slow(Agent):
        async def setup(self) -> None:
            await asyncio.sleep(1e6)

    assert not bench.run(bench.robot.start(Slow("slow@happy")))
    assert bench.reports[0].what == "its setup failed"


@pytest.mark.parametrize("steps", range(4))
def test_a_container_closes_whatever_agent_is_just_ending_by_itself(loop: VirtualTimeLoop, steps: int) -> None:
    async def main() -> None:
        container = Container(MemoryBus(), "yard", wall_time=loop.time)
        agent = Agent(AgentName("one", "yard"))
        await container.start(agent)
        container.end(agent.name)
        for _ in range(steps):
            await asyncio.sleep(0.0)
        await container.close()
        assert container.agents == []

    loop.run_until_complete(main())


def test_a_take_down_that_raises_or_never_ends_is_reported(bench: Bench) -> None:
    class Broken(Agent):
        async def take_down(self) -> None:
            raise OSError("stuck")

    class Slow(Agent):
        async def take_down(self) -> None:
            await asyncio.sleep(1e6)

    for agent in (Broken("broken@happy"), Slow("slow@happy")):
        bench.run(bench.robot.start(agent))
        bench.run(bench.robot.stop(agent.name))
        assert agent.state is AgentState.DELETED
    assert [report.what for report in bench.reports] == ["its take-down failed"] * 2
    assert bench.loop.time() < 10.0


def test_a_behaviour_that_raises_is_reported_and_may_end_its_agent(bench: Bench) -> None:
    async def fail() -> None:
        raise ValueError("bad")

    async def begin() -> None:
        bench.base.add(OneShot(fail, "small thing"))
        bench.base.add(OneShot(fail, "vital thing"), FAIL_AGENT)

    bench.run(begin())
    bench.loop.run_for(1.0)
    assert [report.what for report in bench.reports] == [
        "small thing failed: dropped",
        "vital thing failed: its agent ends",
    ]
    assert bench.base.state is AgentState.DELETED


def test_a_stream_is_heard_decoded_and_what_grows_old_is_left_out(bench: Bench) -> None:
    bus = MemoryBus(bench.network)
    for number in range(10):
        bus.put("happy/cmd_vel", twist(float(number), 0.0))
    bench.loop.run_for(1.0)
    bus.put("happy/cmd_vel", {"json": True})
    bench.loop.run_for(1.0)
    bus.put("other/cmd_vel", twist(5.0, 0.0))
    bench.loop.run_for(1.0)
    assert bench.base.heard == [twist(9.0, 0.0), {"json": True}]


def test_a_sample_that_is_no_message_is_reported_and_the_next_is_heard(bench: Bench) -> None:
    bus = MemoryBus(bench.network)
    bus.put("happy/cmd_vel", {"n": 1})
    bench.loop.run_for(1.0)
    bus.deliver(Sample("happy/cmd_vel", b"\xff", "text/plain"))
    bench.loop.run_for(1.0)
    bus.put("happy/cmd_vel", {"n": 2})
    bench.loop.run_for(1.0)
    assert bench.base.heard == [{"n": 1}, {"n": 2}]
    assert [report.what for report in bench.reports] == ["a sample on happy/cmd_vel is left out"]


def test_a_request_is_agreed_to_and_done(bench: Bench) -> None:
    assert bench.ask("drive", distance=2.0) == Outcome(Ending.DONE, {"driven": 2.0}, agreed=True)
    assert bench.loop.time() == pytest.approx(4.0)
    assert bench.ask("look").value() == "all clear"


def test_requests_are_answered_at_the_same_time(bench: Bench) -> None:
    both = [bench.begin("drive", distance=1.0, speed=1.0) for _ in range(2)]
    bench.loop.run_for(1.1)
    assert all(one.result().is_done for one in both)


def test_a_refusal_before_the_first_wait_is_a_refuse_and_later_a_failure(bench: Bench) -> None:
    assert bench.ask("drive", distance=1.0, speed=2.0) == Outcome(Ending.REFUSED, why="speed is at most 1 m/s")
    late = bench.ask("drive", distance=200.0, speed=1.0, reply_within=1000.0)
    assert late == Outcome(Ending.FAILED, why="the battery is empty", agreed=True)
    with pytest.raises(RequestNotDone, match="failed: the battery is empty"):
        late.value()
    assert bench.reports == []


def test_a_handler_that_agrees_itself_may_take_its_time_to_refuse(bench: Bench) -> None:
    assert bench.ask("ponder", answer=False) == Outcome(Ending.REFUSED, why="having pondered it, no")
    assert bench.ask("ponder", answer=True) == Outcome(Ending.DONE, True, agreed=True)


def test_a_handler_that_raises_is_a_failure_and_is_reported(bench: Bench) -> None:
    outcome = bench.ask("break")
    assert (outcome.ending, outcome.why) == (Ending.FAILED, "break failed with KeyError: 'cog'")
    assert bench.ask("infinite").ending is Ending.FAILED
    assert [report.what for report in bench.reports] == [
        "the request break of console@lab failed",
        "the request infinite of console@lab failed",
    ]


@pytest.mark.parametrize(
    ("name", "arguments", "why"),
    [
        ("fly", {}, "there is no request 'fly' here; known: break, drive, infinite, look, ponder"),
        ("drive", {}, "drive needs distance (float)"),
        ("drive", {"distance": 1.0, "colour": "red"}, "drive does not take 'colour'; it takes distance, speed"),
        ("drive", {"distanc": 1.0}, "drive does not take 'distanc' (did you mean distance?); it takes distance, speed"),
        ("drvie", {"distance": 1.0}, "there is no request 'drvie' here (did you mean drive?); known: "),
        ("drive", {"distance": "far"}, "drive takes distance as float, not str"),
        ("drive", {"distance": True}, "drive takes distance as float, not bool"),
    ],
)
def test_a_request_that_does_not_fit_is_not_understood(
    bench: Bench, name: str, arguments: dict[str, Any], why: str
) -> None:
    outcome = bench.ask(name, **arguments)
    assert outcome.ending is Ending.NOT_UNDERSTOOD
    assert why in outcome.why


@pytest.mark.parametrize(
    "wrong",
    [
        {},
        {"performative": "requst", "sender": "a@b"},
        {"performative": "cfp", "sender": "a@b", "content": {"action": "look"}},
        {"performative": "request", "sender": "a@b"},
        {"performative": "request", "sender": "a@b", "content": {"action": "look"}, "ontology": "chess"},
        {"performative": "request", "sender": "a@b", "content": {"action": "look"}, "protocol": "fipa-query"},
        {"performative": "request", "sender": "a@b", "content": {"action": "look", "arguments": {}, "more": 1}},
    ],
)
def test_whatever_else_begins_a_conversation_is_not_understood(bench: Bench, wrong: dict[str, Any]) -> None:
    replies: list[dict[str, Any]] = []
    ends: list[object] = []
    MemoryBus(bench.network).ask(BASE.acl_key, wrong, lambda answer: replies.append(answer.value), ends.append)
    bench.loop.run_for(1.0)
    if "more" in wrong.get("content", {}):  # what is unknown beside it does no harm
        assert [reply["performative"] for reply in replies] == ["agree", "inform"]
    else:
        (reply,) = replies
        assert (reply["performative"], reply["sender"]) == ("not-understood", "base@happy")
        assert reply["content"]["why"]
    assert ends == [None]


def test_an_end_that_does_not_come_in_time_is_timed_out(bench: Bench) -> None:
    outcome = bench.ask("drive", distance=100.0, reply_within=3.0)
    assert outcome == Outcome(Ending.TIMED_OUT, why="base@happy has not come to an end within 3 s", agreed=True)
    assert bench.loop.time() == pytest.approx(3.0)


def test_nobody_of_the_name_is_a_peer_that_died(bench: Bench) -> None:
    outcome = bench.run(bench.console.request("arm@happy", "home"))
    assert outcome == Outcome(Ending.DIED, why="nobody answers as arm@happy")


def test_an_agent_that_ends_tells_those_who_wait_for_it(bench: Bench) -> None:
    asking = bench.begin("drive", distance=1000.0, reply_within=5000.0)
    bench.loop.run_for(1.0)
    bench.run(bench.robot.stop(BASE))
    assert bench.run(_result(asking)) == Outcome(Ending.FAILED, why="base@happy has ended", agreed=True)


def test_a_container_that_dies_ends_its_conversations(bench: Bench) -> None:
    asking = bench.begin("drive", distance=1000.0, reply_within=5000.0)
    bench.loop.run_for(1.0)
    bench.robot.bus.close()
    assert bench.run(_result(asking)) == Outcome(Ending.DIED, why="base@happy has gone before the end", agreed=True)


async def _result(asking: "asyncio.Task[Outcome]") -> Outcome:
    return await asking


def said(performative: Performative, **changes: Any) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """A reply of a peer that may be wrong in something."""

    def reply(asked: dict[str, Any]) -> dict[str, Any]:
        proper = AclMessage.from_dict(asked).reply(performative, {"why": "so"}, sender=BASE).to_dict()
        return {**proper, **changes}

    return reply


@pytest.mark.parametrize(
    ("replies", "ending"),
    [
        ([lambda asked: {}], Ending.NOT_UNDERSTOOD),
        ([said(Performative.PROPOSE)], Ending.NOT_UNDERSTOOD),
        ([said(Performative.AGREE), said(Performative.AGREE)], Ending.NOT_UNDERSTOOD),
        ([said(Performative.INFORM, conversation_id="another")], Ending.NOT_UNDERSTOOD),
        ([said(Performative.INFORM, sender="forged@happy")], Ending.NOT_UNDERSTOOD),
        ([said(Performative.NOT_UNDERSTOOD, conversation_id="another")], Ending.NOT_UNDERSTOOD),
        ([said(Performative.INFORM)], Ending.DONE),
        ([said(Performative.AGREE), said(Performative.FAILURE)], Ending.FAILED),
        ([said(Performative.AGREE)], Ending.DIED),
        ([said(Performative.REFUSE, content="because")], Ending.REFUSED),
        ([said(Performative.REFUSE, content=None)], Ending.REFUSED),
    ],
)
def test_whatever_a_peer_answers_there_is_one_outcome(bench: Bench, replies: list[Any], ending: Ending) -> None:
    bench.run(bench.robot.stop(BASE))

    def answer(asked: dict[str, Any], conversation: Conversation) -> None:
        with conversation:
            for reply in replies:
                conversation.reply(reply(asked))

    stranger = MemoryBus(bench.network)
    stranger.converse(BASE.acl_key, answer)
    outcome = bench.ask("drive")
    assert outcome.ending is ending
    assert bool(outcome.why) is not outcome.is_done


def test_an_error_reply_is_a_failure(bench: Bench) -> None:
    bench.run(bench.robot.stop(BASE))

    def refuse(asked: dict[str, Any]) -> dict[str, Any]:
        raise Refused("this is no agent")

    MemoryBus(bench.network).serve(BASE.acl_key, refuse)
    assert bench.ask("drive") == Outcome(Ending.FAILED, why="base@happy answers with an error: this is no agent")


def test_a_flood_of_requests_is_refused_beyond_a_bound_and_the_agent_serves_on(bench: Bench) -> None:
    asked = [bench.begin("drive", distance=1.0) for _ in range(MOST_REQUESTS + 50)]
    bench.loop.run_for(3.0)
    endings = [one.result().ending for one in asked]
    assert (endings.count(Ending.DONE), endings.count(Ending.REFUSED)) == (MOST_REQUESTS, 50)
    assert bench.ask("look").is_done


def test_messages_go_from_mailbox_to_mailbox_in_order(bench: Bench) -> None:
    for number in range(100):
        inform = AclMessage(performative=Performative.INFORM, sender=CONSOLE, receivers=(BASE,), content=number)
        bench.console.send(inform)

    async def receive() -> list[int]:
        return [(await bench.base.receive(Template.of(sender=CONSOLE))).content for _ in range(100)]

    assert bench.run(receive()) == list(range(100))


def test_a_message_that_is_none_is_counted_and_the_next_arrives(bench: Bench) -> None:
    bus = MemoryBus(bench.network)
    bus.put(BASE.acl_key, {"performative": "inform"})
    bus.put(BASE.acl_key, AclMessage(performative=Performative.INFORM, sender=CONSOLE).to_dict())
    assert bench.base.malformed == 1
    assert bench.base.mailbox.state.waiting == 1


def test_an_agent_queries_the_bus_without_holding_up_the_loop(bench: Bench) -> None:
    MemoryBus(bench.network).serve("happy/command/stop", lambda arguments: {"accepted": True})
    assert bench.run(bench.console.query("happy/command/stop")) == {"accepted": True}


def test_an_agent_describes_itself_while_it_lives(bench: Bench) -> None:
    bus = MemoryBus(bench.network)
    alive: list[tuple[str, bool]] = []
    bus.watch_alive("*/agents/*/alive", lambda key, is_alive: alive.append((key, is_alive)))
    (answer,) = bus.query(BASE.description_key)
    assert answer.value == {
        "name": "base@happy",
        "robot": "happy",
        "state": "active",
        "container": "happy",
        "services": ["drive"],
        "requests": ["break", "drive", "infinite", "look", "ponder"],
        "answers": [],
        "subscriptions": [],
        "proposals": [],
        "properties": {},
    }
    bench.run(bench.robot.stop(BASE))
    assert (BASE.alive_key, True) in alive
    assert alive[-1] == (BASE.alive_key, False)
