"""The monitor in virtual time: what it tells of a team, and whom it brings back."""

from typing import Any

import pytest

from agents.platform import FAIL_AGENT, Agent, AgentName, Ending, Kinds, request
from agents.services.monitor import Monitor
from bus import MemoryBus
from bus.aio import query
from bus.messages import DiagnosticArray, DiagnosticStatus, decode, header
from tests.agents.services.worlds import TEAM, Robot, World, hear

MONITOR = AgentName("monitor", TEAM)
WORKER = AgentName("worker", "shop")


class Worker(Agent):
    """Fails when told to, and in its setup for as long as it is broken."""

    broken = False
    births = 0

    async def setup(self) -> None:
        Worker.births += 1
        if Worker.broken:
            raise RuntimeError("a wheel is missing")

    @request("fail")
    async def fail(self) -> None:
        async def raise_it() -> None:
            raise RuntimeError("over a stone")

        self.add(raise_it, FAIL_AGENT)


class Workers(Kinds):
    """Where workers are found, which are no part of the platform."""

    def find(self, kind: str) -> type[Agent]:
        assert kind.endswith(":Worker")
        return Worker


class Watched:
    """A monitor in a world, and what it tells."""

    def __init__(self, world: World, **properties: Any) -> None:
        self.world = world
        self.events = hear(world, MONITOR.results_key)
        self.monitor = Monitor(MONITOR, properties)
        world.run(world.services.start(self.monitor))
        world.pass_time(2.0)
        self.events.clear()

    def told(self, about: str | None = None) -> list[tuple[str, str]]:
        return [(event["level"], event["what"]) for event in self.events if about in (None, event["about"])]

    def sentences(self) -> str:
        return "\n".join(event["what"] for event in self.events)


@pytest.fixture(autouse=True)
def workers() -> None:
    Worker.broken, Worker.births = False, 0


def test_who_comes_and_goes_is_told_at_once_and_remembered(world: World) -> None:
    watched = Watched(world)
    shop = world.container("shop", kinds=Workers())
    world.run(shop.start(Worker(WORKER)))
    world.pass_time(0.05)
    shop.bus.close()
    world.pass_time(0.05)
    assert watched.told() == [
        ("ok", "worker@shop has come"),
        ("ok", "the container shop has come"),
        ("error", "worker@shop has gone"),
        ("error", "the container shop has gone"),
    ]
    remembered = world.ask(MONITOR, "events", last=2).value()
    assert remembered == watched.events[-2:]
    assert set(remembered[0]) == {"time", "what", "about", "level"}
    world.run(shop.close())


def test_a_monitor_that_begins_tells_how_many_are_there_and_not_that_they_have_come(world: World) -> None:
    Robot(world)
    events = hear(world, MONITOR.results_key)
    world.run(world.services.start(Monitor(MONITOR)))
    world.pass_time(2.0)
    assert [event["what"] for event in events] == [
        "monitor@team watches 1 robot (happy), 2 containers and 2 agents",
    ]


def test_who_puts_one_question_is_no_news(world: World) -> None:
    watched = Watched(world)
    passing = world.container("ask-1f3a5b")
    world.run(passing.start(Agent(AgentName("ask-1f3a5b", "terminal"))))
    assert "ask-" not in str(world.ask(MONITOR, "status").value())
    world.run(passing.close())
    world.pass_time(5.0)
    assert watched.told() == []


def test_who_is_stopped_on_purpose_is_not_missed(world: World) -> None:
    watched = Watched(world)
    shop = world.container("shop", kinds=Workers())
    world.run(shop.start(Worker(WORKER)))
    world.run(shop.stop(WORKER))
    world.pass_time(60.0)
    world.run(shop.start(Worker(WORKER)))
    world.run(shop.close())
    world.pass_time(60.0)
    assert "error" not in {event["level"] for event in watched.events}
    assert watched.told("worker@shop")[-1] == ("ok", "worker@shop has been stopped")
    assert watched.told("shop")[-1] == ("ok", "the container shop has been closed")
    assert Worker.births == 2


def test_who_has_moved_is_missed_when_it_goes_where_it_lives_now(world: World) -> None:
    watched = Watched(world)
    shop, hall = (world.container(name, kinds=Workers()) for name in ("shop", "hall"))
    world.run(hall.start(Agent(AgentName("porter", "hall"))))
    world.run(shop.start(Worker(WORKER)))
    order = {"do": "move", "name": str(WORKER), "to": "hall"}
    world.run(query(world.lab.bus, shop.called.control_key, order, 60.0))
    world.pass_time(1.0)
    assert watched.told("worker@shop") == [("ok", "worker@shop has come"), ("ok", "worker@shop has been moved")]
    hall.bus.close()
    world.pass_time(1.0)
    assert watched.told("worker@shop")[-1] == ("error", "worker@shop has gone")
    for container in (shop, hall):
        world.run(container.close())


def test_an_agent_that_fails_is_started_again_by_its_container(world: World) -> None:
    watched = Watched(world)
    shop = world.container("shop", kinds=Workers())
    world.run(shop.start(Worker(WORKER, {"size": 3})))
    world.ask(WORKER, "fail")
    world.pass_time(1.0)
    assert ("warning", "worker@shop has failed; attempt 1 to start it again in 0.2 s") in watched.told()
    assert watched.told()[-1][1] in ("worker@shop has come", "worker@shop has been started again")
    assert shop.agent(WORKER).properties == {"size": 3}
    assert world.ask(MONITOR, "policy", agent="worker@shop").value()["attempted"] == 1
    world.run(shop.close())


def test_an_agent_that_cannot_be_started_again_is_given_up_with_growing_pauses(world: World) -> None:
    watched = Watched(world, restart={"worker": {"attempts": 3, "first": 1.0}})
    shop = world.container("shop", kinds=Workers())
    world.run(shop.start(Worker(WORKER, {"size": 3})))
    Worker.broken = True
    world.ask(WORKER, "fail")
    world.pass_time(100.0)
    attempts = [event["time"] for event in watched.events if "attempt" in event["what"]]
    assert [later - attempts[0] for later in attempts] == pytest.approx([0.0, 1.0, 3.0], abs=0.1)
    level, last = watched.told("worker@shop")[-1]
    assert level == "error"
    kind = "tests.agents.services.test_monitor:Worker"
    advice = f"correct it, and: acromovi agent start worker@shop {kind} size=3 --in shop"
    assert last.endswith(f"RuntimeError: a wheel is missing, and is given up; {advice}")
    assert Worker.births == 4
    world.run(shop.close())


def test_an_agent_that_flaps_is_given_up_too(world: World) -> None:
    watched = Watched(world, restart={"*": {"attempts": 3, "first": 0.5}})
    shop = world.container("shop", kinds=Workers())
    world.run(shop.start(Worker(WORKER)))
    while world.ask(WORKER, "fail").ending is not Ending.DIED:
        world.pass_time(10.0)
    assert Worker.births == 4
    assert "is given up" in watched.sentences()
    world.run(shop.close())


@pytest.mark.parametrize(("platform", "births"), [("happy", 1), (TEAM, 6)])
def test_who_has_not_begun_is_left_to_whoever_started_it_unless_it_is_the_teams_own(
    world: World, platform: str, births: int
) -> None:
    watched = Watched(world)
    shop = world.container("shop", kinds=Workers())
    Worker.broken = True
    world.run(shop.start(Worker(AgentName("worker", platform))))
    world.pass_time(60.0)
    assert Worker.births == births
    assert "its setup failed (RuntimeError: a wheel is missing)" in watched.sentences()
    assert ("is given up" in watched.sentences()) == (platform == TEAM)
    world.run(shop.close())


class Host:
    """`acromovi up` as it looks from the bus."""

    def __init__(self, world: World, pid: int, container: str = "shop") -> None:
        self.pid = pid
        self.container = container
        self.restarted: list[str] = []
        MemoryBus(world.network).serve(f"{TEAM}/host/control", self.answer)

    def answer(self, asked: dict[str, Any]) -> dict[str, Any]:
        if asked["do"] == "restart":
            self.restarted.append(asked["container"])
            return {"restarting": asked["container"]}
        row = {"container": self.container, "state": "running", "pid": self.pid, "why": "ended by SIGKILL"}
        return {"team": TEAM, "processes": [{"container": None, "state": "running"}, row]}


@pytest.mark.parametrize("is_frozen", [True, False])
def test_a_frozen_container_is_started_anew_by_its_host_and_a_dead_one_is_left_to_it(
    world: World, is_frozen: bool
) -> None:
    watched = Watched(world)
    shop = world.container("shop", kinds=Workers())
    world.run(shop.start(Worker(WORKER)))
    world.pass_time(1.0)
    process = world.run(world.console.query("shop/containers/shop/control", {"do": "list"}))["process"]
    host = Host(world, process if is_frozen else process + 1)  # the other is its successor, which begins already
    shop.bus.close()
    world.pass_time(5.0)
    assert host.restarted == (["shop"] if is_frozen else [])
    assert ("is frozen" in watched.sentences()) == is_frozen
    assert ("the container shop ended by SIGKILL; its host starts it again" in watched.sentences()) == (not is_frozen)
    world.run(shop.close())


def test_a_container_that_is_back_soon_is_told_of_with_its_end(world: World) -> None:
    watched = Watched(world)
    shop = world.container("shop")
    world.loop.call_soon(shop.show)
    world.pass_time(1.0)
    Host(world, pid=1)
    shop.bus.close()
    world.pass_time(0.5)
    again = world.container("shop")
    world.loop.call_soon(again.show)
    world.pass_time(2.0)
    assert watched.told("shop")[-1] == ("ok", "the container shop ended by SIGKILL; its host has started it again")
    for container in (shop, again):
        world.run(container.close())


def test_a_container_that_nobody_hosts_is_told_of_and_left_alone(world: World) -> None:
    watched = Watched(world)
    host = Host(world, 1, container="another")
    shop = world.container("shop", kinds=Workers())
    world.run(shop.start(Worker(WORKER)))
    world.pass_time(1.0)
    shop.bus.close()
    world.pass_time(5.0)
    assert host.restarted == []
    assert watched.told("shop")[-1] == ("error", "the container shop has gone")
    world.run(shop.close())


def test_streams_that_fall_silent_are_told_of_and_so_is_their_return(world: World) -> None:
    watched = Watched(world)
    robot = Robot(world)
    robot.flow(20.0)
    assert {event["level"] for event in watched.events} == {"ok"}
    robot.silent.add("sonar")
    robot.flow(3.0)
    level, what = watched.told("happy")[-1]
    assert (level, what.split(" for ")[0]) == ("error", "happy/sonar has been silent")
    assert world.ask(MONITOR, "status", robot="happy").value()["level"] == "error"
    robot.silent.clear()
    robot.flow(10.0)
    assert watched.told("happy")[-1] == ("ok", "happy/sonar flows")
    status = world.ask(MONITOR, "status", robot="happy").value()
    assert status["level"] == "ok"
    assert status["standings"]["happy/odom"]["usual"] == pytest.approx(10.0, rel=0.1)
    assert "happy/agents/base/results" in status["standings"]
    assert "happy/agents/sonar/results" not in status["standings"]


def test_a_silence_with_a_reason_is_told_of_once(world: World) -> None:
    watched = Watched(world)
    robot = Robot(world)
    robot.flow(20.0)
    robot.sonar = False
    robot.silent = {"sonar"}
    robot.say_state()
    robot.flow(20.0)
    standing = world.ask(MONITOR, "status").value()["standings"]["happy/sonar"]
    assert (standing["level"], standing["what"]) == ("ok", "happy/sonar rests, for a reason that has been told")
    robot.connection, robot.faults, robot.silent = "disconnected", ["the robot is not connected"], {"sonar", "odom"}
    robot.say_state()
    robot.flow(20.0)
    robot.connection, robot.faults, robot.sonar, robot.silent = "connected", [], True, set()
    robot.say_state()
    robot.flow(20.0)
    assert [what for _, what in watched.told("happy")][-2:] == [
        "happy: the robot is not connected",
        "happy: all is well again",
    ]


def test_a_gateway_that_goes_takes_its_streams_with_it(world: World) -> None:
    watched = Watched(world)
    robot = Robot(world)
    robot.flow(10.0)
    robot.loses("sonar")
    robot.flow(10.0)
    assert "happy/sonar" not in world.ask(MONITOR, "status").value()["standings"]
    robot.bus.close()
    world.pass_time(60.0)
    assert watched.told("happy")[-2:] == [
        ("warning", "happy has lost its sonar"),
        ("error", "the gateway of happy has gone"),
    ]
    refused = world.ask(MONITOR, "status", robot="happy")
    assert (refused.ending, refused.why) == (
        Ending.REFUSED,
        "there is no robot 'happy' at this moment; there are: none",
    )


def test_what_a_gateway_says_of_its_cables_is_told_when_it_changes(world: World) -> None:
    watched = Watched(world)
    bus = MemoryBus(world.network)

    def say(level: int, message: str) -> None:
        status = DiagnosticStatus(level=level, name="happy: laser", message=message, hardware_id="", values=[])
        bus.put("happy/diagnostics", DiagnosticArray(header=header(0, ""), status=[status]))
        world.pass_time(1.0)

    for level, message in [(0, "all is well"), (2, "no answer"), (2, "no answer"), (0, "all is well")]:
        say(level, message)
    assert watched.told("happy") == [("error", "happy: laser: no answer"), ("ok", "happy: laser: all is well")]


def test_what_a_robots_state_has_told_is_not_told_again_for_its_cable(world: World) -> None:
    watched = Watched(world)
    robot = Robot(world)
    robot.flow(1.0)
    robot.faults = ["the laser does not answer"]
    robot.say_state()
    status = DiagnosticStatus(
        level=2, name="happy: laser", message="the laser does not answer", hardware_id="", values=[]
    )
    MemoryBus(world.network).put("happy/diagnostics", DiagnosticArray(header=header(0, ""), status=[status]))
    robot.flow(1.0)
    assert [what for _, what in watched.told("happy")][-1:] == ["happy: the laser does not answer"]


def test_ros_sees_how_all_stand_once_a_second(world: World) -> None:
    Watched(world)
    heard: list[DiagnosticArray] = []
    bus = MemoryBus(world.network)
    bus.subscribe("team/diagnostics", lambda sample: heard.append(decode(sample.type_name, sample.payload)))
    robot = Robot(world)
    robot.faults = ["the battery is low, below 11.5 V"]
    robot.flow(5.0)
    assert len(heard) == 5
    levels = {status.name: (status.level, status.message) for status in heard[-1].status}
    assert levels["team: happy"] == (1, "the battery is low, below 11.5 V")
    assert levels["team: container services"] == (0, "it lives")
    assert "team: happy/odom" in levels


def test_a_thousand_agents_that_go_at_once_are_one_event(world: World) -> None:
    watched = Watched(world)
    shop = world.container("shop", kinds=Workers())
    for number in range(1000):
        world.run(shop.start(Agent(AgentName(f"a{number}", "shop"))))
    world.pass_time(1.0)
    watched.events.clear()
    shop.bus.close()
    world.pass_time(0.1)
    assert [level for level, _ in watched.told()] == ["error", "error"]
    assert watched.told("shop")[0][1].startswith("1000 agents of shop have gone: a0, a1, ")
    world.run(shop.close())


def test_rules_that_cannot_be_read_stop_the_monitor_with_a_sentence(world: World) -> None:
    monitor = Monitor(MONITOR, {"restart": {"*": {"tries": 3}}})
    assert not world.run(world.services.start(monitor))
    assert "the restart rules of monitor@team for '*': unknown key tries" in str(world.reports[-1].error)


def test_the_policy_can_be_asked(world: World) -> None:
    Watched(world, restart={"camera": {"attempts": 0}})
    rules = world.ask(MONITOR, "policy").value()["rules"]
    assert rules["camera"]["attempts"] == 0
    assert rules["*"]["attempts"] == 5
    assert world.ask(MONITOR, "policy", agent="camera@happy").value()["attempts"] == 0
    assert world.ask(MONITOR, "policy", agent="camera").ending is Ending.REFUSED


def test_nonsense_on_the_keys_it_hears_is_survived(world: World) -> None:
    watched = Watched(world)
    bus = MemoryBus(world.network)
    bus.declare_alive("ab/agents/@/alive")
    bus.put("x/containers/y/reports", {"agent": "nobody", "ended": "failed"})
    bus.put("x/containers/y/reports", {"agent": "w@x", "ended": "failed", "kind": 5})
    bus.put("x/containers/y/reports", {"agent": 7})
    bus.put("happy/state", {"connection": 3})
    bus.put("happy/diagnostics", {"status": "fine"})
    world.pass_time(30.0)
    assert world.ask(MONITOR, "events").is_done
    assert "given up" not in watched.sentences()
