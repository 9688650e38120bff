"""What all components have in common: reading, sending, passing on commands, and what is said when that is in vain."""

from collections.abc import Callable
from typing import Any

import pytest

from agents.components.all_components import COMPONENTS, component_for
from agents.components.generic import Generic
from agents.platform import Ending
from bus import Refused, Sample, keys
from bus.aio import query
from bus.messages import NS_PER_S, Bumpers, header
from tests.agents.components.bench import Bench

MakeBench = Callable[..., Bench]

WITH_A_CLASS = {
    *(
        "base",
        "sonar",
        "laser",
        "bumpers",
        "ir",
        "battery",
        "io",
        "gripper",
        "arm",
        "ptz",
        "camera",
        "sound",
        "joystick",
    ),
    "encoders",
}


@pytest.fixture
def bench(make_bench: MakeBench) -> Bench:
    return make_bench("bumpers")


def touch(*front: bool, at: float = 100.0) -> Bumpers:
    return Bumpers(header(round(at * NS_PER_S), "happy/base_link"), front=front)


def test_these_elements_have_a_component_of_their_own() -> None:
    assert COMPONENTS.keys() == WITH_A_CLASS


@pytest.mark.parametrize("element", ["compass", "gyro", "servos", "lcd", "power", "charger", "no-one-knows"])
def test_any_other_element_is_served_all_the_same(element: str) -> None:
    assert component_for(element) is Generic


@pytest.mark.parametrize("element", [*sorted(WITH_A_CLASS), "no-one-knows"])
def test_it_is_found_as_a_component_and_by_the_name_of_its_element(make_bench: MakeBench, element: str) -> None:
    bench = make_bench(element, model="p3dx-sh")
    described = bench.component.describe()
    assert {element, "component"} <= set(described["services"])
    assert described["robot"] == "happy"
    assert described["properties"] == {"model": "p3dx-sh"}
    assert "read" in described["requests"]


class TestReading:
    def test_the_latest_message_is_read_though_nobody_listened(self, bench: Bench) -> None:
        bench.say(keys.BUMPERS, touch(True))
        bench.say(keys.BUMPERS, touch(False, True, at=101.5))
        result = bench.value()
        assert (result["stamp"], result["front"]) == (101.5, [False, True])

    def test_the_first_is_waited_for(self, bench: Bench) -> None:
        bench.loop.call_later(1.5, bench.robot.put, keys.BUMPERS.key("happy"), touch(True))
        assert bench.value()["front"] == [True]
        assert bench.loop.time() == pytest.approx(1.5, abs=0.05)

    def test_where_none_comes_the_wait_ends(self, bench: Bench) -> None:
        outcome = bench.ask()
        assert outcome.ending is Ending.FAILED
        assert outcome.why == "bumpers@happy has heard nothing yet"
        assert bench.loop.time() == pytest.approx(2.0, abs=0.05)

    @pytest.mark.parametrize("is_heard", [False, True])
    def test_what_is_stale_is_not_told(self, bench: Bench, is_heard: bool) -> None:
        if is_heard:
            bench.results()
        bench.say(keys.BUMPERS, touch(True))
        bench.run(3.19)
        outcome = bench.ask()
        assert outcome.ending is Ending.FAILED
        assert outcome.why == "bumpers@happy has heard nothing for 3.2 s"

    def test_the_same_may_be_read_twice(self, bench: Bench) -> None:
        bench.say(keys.BUMPERS, touch(True))
        assert bench.value() == bench.value()


class TestResults:
    def test_every_message_is_sent_as_a_result(self, bench: Bench) -> None:
        heard = bench.results()
        for number in range(5):
            bench.say(keys.BUMPERS, touch(True, at=100.0 + number))
        assert [result["stamp"] for result in heard] == [100.0, 101.0, 102.0, 103.0, 104.0]
        assert heard[-1] == bench.value()

    def test_what_nobody_wants_to_know_is_never_decoded(self, bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
        decoded: list[str] = []
        monkeypatch.setattr("bus.messages.decode", lambda *given: decoded.append(given[0]))
        for _ in range(3):
            bench.say(keys.BUMPERS, touch(True))
        assert decoded == []


class TestNonsense:
    """A stranger may put anything on a robot's keys."""

    @pytest.mark.parametrize("is_heard", [False, True])
    def test_bytes_that_are_no_message_are_left_out(self, bench: Bench, is_heard: bool) -> None:
        if is_heard:
            bench.results()
        bench.say(keys.BUMPERS, touch(True))
        bench.robot.deliver(Sample(keys.BUMPERS.key("happy"), b"??", f"application/cdr;{keys.BUMPERS.type_name}"))
        bench.run()
        if is_heard:
            assert bench.value()["front"] == [True]
            assert "a message is left out" in bench.reports[0]
        else:
            assert "cannot read what it hears" in bench.ask().why

    @pytest.mark.parametrize("is_heard", [False, True])
    def test_garbage_keeps_no_reading_fresh(self, bench: Bench, is_heard: bool) -> None:
        if is_heard:
            bench.results()
        bench.say(keys.BUMPERS, touch(True))
        bench.value()
        bench.run(60.0)
        bench.robot.deliver(Sample(keys.BUMPERS.key("happy"), b"??", f"application/cdr;{keys.BUMPERS.type_name}"))
        bench.run()
        bench.ask()
        assert bench.ask().why == "bumpers@happy has heard nothing for 60.0 s"

    @pytest.mark.parametrize("is_heard", [False, True])
    def test_a_message_of_another_kind_is_left_out_and_reported(self, bench: Bench, is_heard: bool) -> None:
        if is_heard:
            bench.results()
        bench.say(keys.BUMPERS, touch(True))
        bench.say(keys.BUMPERS, {"front": "none of your business"})
        assert bench.value()["front"] == [True]
        assert "carries acromovi_msgs/msg/Bumpers, not application/json" in bench.reports[0]
        bench.say(keys.BUMPERS, touch(False))
        assert bench.value()["front"] == [False]


class TestCommands:
    def test_a_command_comes_as_it_was_asked(self, make_bench: MakeBench) -> None:
        bench = make_bench("joystick")
        bench.obey(keys.JOYDRIVE)
        bench.value("drive", on=True)
        bench.value("drive", on=False, token="happy-7")
        assert bench.obeyed == [
            ("command/joystick", {"on": True}),
            ("command/joystick", {"on": False, "token": "happy-7"}),
        ]

    def test_the_gateways_no_is_the_refusal(self, make_bench: MakeBench) -> None:
        bench = make_bench("joystick")
        bench.obey(keys.JOYDRIVE, refusal="me holds the lease on the base")
        outcome = bench.ask("drive", on=True)
        assert (outcome.ending, outcome.agreed) == (Ending.REFUSED, False)
        assert outcome.why == "me holds the lease on the base"

    def test_where_there_is_no_gateway_that_is_said(self, make_bench: MakeBench) -> None:
        outcome = make_bench("joystick").ask("drive", on=True)
        assert outcome.ending is Ending.REFUSED
        assert outcome.why == "nobody drives happy; see whether its p2os-gateway runs"

    def test_a_gateway_that_does_not_answer_is_a_failure(self, make_bench: MakeBench) -> None:
        bench = make_bench("joystick")
        bench.robot.converse(keys.JOYDRIVE.key("happy"), lambda *conversation: None)
        asking = bench.loop.create_task(bench.app.request("joystick@happy", "drive", on=True))
        bench.run(2.1)
        bench.robot.network.let_pass(2.1)
        bench.run(0.1)
        assert asking.result().ending is Ending.FAILED
        assert asking.result().why == "the gateway of happy has not answered within 2 s"


NONSENSE: list[tuple[str, str, dict[str, Any]]] = [
    ("base", "move", {}),
    ("base", "move", {"distance": "far"}),
    ("base", "move", {"distance": 1.0, "speed": -0.1}),
    ("base", "turn", {"angle": None}),
    ("base", "heading", {"heading": [0.0]}),
    ("base", "drive", {"linear": 0.2, "seconds": 0.0}),
    ("base", "drive", {"linear": 0.2, "seconds": -1.0}),
    ("base", "drive", {"linear": True}),
    ("base", "go_to", {"x": 1.0}),
    ("base", "go_to", {"x": 1.0, "y": 0.0, "heading": "north"}),
    ("base", "enable", {"on": 1}),
    ("base", "estop", {}),
    ("base", "dance", {}),
    ("sonar", "power", {"on": "yes"}),
    ("io", "output", {"mask": 1}),
    ("io", "output", {"mask": 1.5, "value": 1}),
    ("sound", "play", {}),
    ("sound", "play", {"notes": [[60, 0.2]], "number": 3}),
    ("sound", "mute", {"on": "now"}),
    ("joystick", "drive", {}),
    ("gripper", "open", {"wide": True}),
    ("gripper", "up", {"wait": "long"}),
    ("ptz", "stop", {"now": True}),
    ("camera", "picture", {"of": "me"}),
    ("laser", "read", {"beams": 3}),
]


@pytest.mark.parametrize(("element", "name", "arguments"), NONSENSE)
def test_what_makes_no_sense_reaches_no_gateway(
    make_bench: MakeBench, element: str, name: str, arguments: dict[str, Any]
) -> None:
    bench = make_bench(element)
    bench.obey_all()
    outcome = bench.ask(name, **arguments)
    assert outcome.ending in (Ending.REFUSED, Ending.NOT_UNDERSTOOD)
    assert outcome.why
    assert bench.obeyed == []
    assert bench.reports == []


class TestLooking:
    """Who may look, and not ask, queries the key of the results."""

    def test_gives_the_latest_result(self, bench: Bench) -> None:
        bench.say(keys.BUMPERS, touch(True))
        (answer,) = bench.do(query(bench.robot, bench.component.name.results_key, None, 5.0))
        assert answer.value == bench.ask().result

    def test_is_refused_where_there_is_none(self, bench: Bench) -> None:
        with pytest.raises(Refused, match="bumpers@happy has heard nothing yet"):
            bench.do(query(bench.robot, bench.component.name.results_key, None, 5.0))

    def test_is_refused_while_the_agent_rests(self, bench: Bench) -> None:
        bench.say(keys.BUMPERS, touch(True))
        bench.component.suspend()
        with pytest.raises(Refused, match="bumpers@happy is suspended"):
            bench.do(query(bench.robot, bench.component.name.results_key, None, 5.0))
