"""The page Agents without a browser: tree and search, forms, messages, drafts, values."""

import asyncio
from collections.abc import Coroutine
from contextlib import suppress
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.platform import Agent, AgentName, AgentState, Container, ContainerName, Description, Directory, request
from agents.platform.containers import ContainerReport, ListedAgent, order, read, reports
from agents.platform.conversations.any_message import converse
from agents.platform.virtual_time import VirtualTimeLoop
from agents.sniffer.captured import Unreadable
from apps.console.agent_control import why_not_ask, why_not_control
from apps.console.agent_panels.inside import inside_rows
from apps.console.agent_panels.leases import record_rows
from apps.console.agent_tree import has_words, tree_of
from apps.console.agent_watch import AgentWatch, WatchedAgent
from apps.console.composing import DraftNotValid, draft_of
from apps.console.data_view import table_of, text_of
from apps.console.request_form import FieldNotValid, FormField, arguments_of, entries_of, fields_of
from apps.console.sniffer_feed import MessageLog, message_row
from apps.console.visits import Visit
from bus import MemoryBus, MemoryNetwork, NotAllowed
from tests.acromovi.sniffer.talking import A_TALK

BASE, SONAR = AgentName("base", "happy"), AgentName("sonar", "max")
HAPPY, MAX = ContainerName("happy", "happy"), ContainerName("max", "max")
AGENTS = {
    "base@happy": WatchedAgent(
        BASE,
        "active",
        "agents.components.base:BaseAgent",
        HAPPY,
        Description(BASE, AgentState.ACTIVE, "happy", ("base",), ("move", "turn"), {"colour": "red", "wheels": 2}),
    ),
    "sonar@max": WatchedAgent(SONAR, "suspended", "agents.components.sensors:SonarAgent", MAX),
}
REPORTS = [
    ContainerReport(HAPPY, "lab", 7, (ListedAgent(BASE, "active", ""),)),
    ContainerReport(MAX, "lab", 8, (ListedAgent(SONAR, "suspended", ""),)),
]


def found(search: str) -> list[str]:
    """The agents that the tree shows."""
    tree = tree_of(REPORTS, [ContainerName("frozen", "max")], AGENTS, search)
    return [agent["name"] for site in tree for container in site["containers"] for agent in container["agents"]]


def test_the_tree_has_sites_containers_and_agents_and_names_a_container_that_does_not_answer() -> None:
    tree = tree_of(REPORTS, [ContainerName("frozen", "max")], AGENTS)
    assert [site["site"] for site in tree] == ["happy", "max"]
    assert [(row["name"], row["answers"]) for row in tree[1]["containers"]] == [("frozen", False), ("max", True)]
    assert tree[0]["containers"][0]["agents"][0]["properties"] == {"colour": "red", "wheels": "2"}


def test_an_agent_that_moves_and_is_in_two_reports_is_shown_once() -> None:
    reports = [ContainerReport(HAPPY, "lab", 7, (ListedAgent(SONAR, "suspended", ""),)), REPORTS[1]]
    tree = tree_of(reports, [], AGENTS)
    agents = [(row["name"], each["name"]) for site in tree for row in site["containers"] for each in row["agents"]]
    assert agents == [("max", "sonar@max")]


@pytest.mark.parametrize(
    ("search", "names"),
    [
        ("", ["base@happy", "sonar@max"]),
        ("SONAR", ["sonar@max"]),
        ("turn", ["base@happy"]),
        ("service=base colour=red", ["base@happy"]),
        ("wheels=2", ["base@happy"]),
        ("wheels=3", []),
        ("state=susp", ["sonar@max"]),
        ("colour=", []),
    ],
)
def test_a_search_finds_names_services_requests_states_and_properties(search: str, names: list[str]) -> None:
    assert found(search) == names


@given(st.text())
def test_any_text_can_be_searched_for(text: str) -> None:
    assert isinstance(has_words(AGENTS["base@happy"], text.split()), bool)


def run(work: Coroutine[Any, Any, Any]) -> Any:
    """Do something in virtual time."""
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        return runner.run(work)


class Painter(Agent):
    """An agent for forms."""

    @request("paint")
    async def paint(self, colour: str, coats: int = 1, thickness: float | None = None, dry: bool = False) -> str:
        """Paint a wall."""
        return f"{coats} x {colour}"


def test_a_watch_lists_what_a_container_hosts_and_an_order_suspends_an_agent() -> None:
    network = MemoryNetwork()

    async def act() -> tuple[Any, ...]:
        with MemoryBus(network) as bus, MemoryBus(network) as outside, Directory(outside) as directory:
            async with Container(bus, "yard", platform="team") as container:
                await container.start(Painter("painter@team"))
                with AgentWatch(outside, directory) as watch:
                    await watch.refresh()
                    before = watch.agents["painter@team"]
                    await order(outside, before.container, "suspend", name="painter@team")
                    await watch.refresh(soon=True)
                    told = await read(outside, before.container, "interface", name="painter@team")
                    return before, watch.agents["painter@team"], told, await reports(outside), watch.silent

    before, after, told, listed, silent = run(act())
    assert (before.state, after.state) == ("active", "suspended")
    assert before.description.requests == ("paint",)
    assert [each.container.name for each in listed] == ["yard"]
    assert silent == []
    fields = fields_of(told["requests"][0])
    assert [(each.name, each.widget, each.is_required) for each in fields] == [
        ("colour", "text", True),
        ("coats", "number", False),
        ("thickness", "number", False),
        ("dry", "choice", False),
    ]
    assert fields[1].hint == "int, default 1"
    entered = {"colour": "red", "coats": " 2 ", "thickness": "", "dry": None}
    assert arguments_of(fields, entered) == {"colour": "red", "coats": 2}


@pytest.mark.parametrize(
    ("parameter", "entered", "why"),
    [
        ({"name": "x", "type": "float"}, "", r"x is needed \(float, needed\)"),
        ({"name": "x", "type": "float"}, "far", "x is a number, not 'far'"),
        ({"name": "x", "type": "float"}, "inf", "x is a finite number, not inf"),
        ({"name": "n", "type": "int"}, "1.5", "n is a whole number, not '1.5'"),
        ({"name": "way", "type": "Literal['in', 'out']"}, "up", "way is one of in, out, not up"),
        ({"name": "table", "type": "Mapping[str, Any]"}, "{", "table is a JSON value"),
    ],
)
def test_a_field_that_cannot_be_sent_tells_what_is_expected(parameter: Any, entered: str, why: str) -> None:
    with pytest.raises(FieldNotValid, match=why):
        arguments_of([FormField.of(parameter)], {parameter["name"]: entered})


@given(st.text(), st.text())
def test_any_type_and_text_give_a_value_or_a_reason(kind: str, text: str) -> None:
    field = FormField.of({"name": "x", "type": kind})
    with suppress(FieldNotValid):  # the reason
        assert "x" in arguments_of([field], {"x": text}) or not text.strip()


def test_messages_are_numbered_and_a_browser_that_slept_gets_the_newest_only() -> None:
    log = MessageLog(kept=5)
    for message in A_TALK:
        log.add(message)
    rows, left_out = log.after(0, most=3)
    assert ([number for number, _ in rows], left_out) == ([4, 5, 6], 3)
    assert log.after(6) == ([], 0)
    assert log.after(99)[0][0][0] == 2, "a number of an earlier console"
    assert log.find(1) is None
    assert log.find(6) is A_TALK[5]


def test_a_row_for_the_browser_is_short_and_shows_what_was_not_done_and_what_cannot_be_read() -> None:
    row = message_row(5, A_TALK[4])
    assert row[2:5] == ["base@happy", ["app-1@lab"], "failure"]
    assert row[7:] == ["the wheels are stalled", True]
    assert message_row(1, Unreadable(0.0, "yard", 3, "no JSON"))[4] == "unreadable"


def test_a_draft_needs_a_performative_receivers_and_json() -> None:
    draft = draft_of({"performative": "cfp", "receivers": "a@x, b@x a@x", "content": '{"a": 1}', "reply_by": "3"})
    assert [str(each) for each in draft.receivers] == ["a@x", "b@x"]
    assert (draft.content, draft.reply_by, draft.begins_conversation) == ({"a": 1}, 3.0, True)
    for wrong, why in [
        ({"performative": "requst", "receivers": "a@x"}, "did you mean request"),
        ({"performative": "inform", "receivers": " "}, "needs a receiver"),
        ({"performative": "inform", "receivers": "a"}, "names no agent"),
        ({"performative": "inform", "receivers": "a@x", "content": "hello"}, 'a text is written "hello"'),
        ({"performative": "inform", "receivers": "a@x", "reply_by": "-1"}, "more than 0 s"),
    ]:
        with pytest.raises(DraftNotValid, match=why):
            draft_of(wrong)


def test_a_composed_request_is_answered_with_all_replies() -> None:
    network = MemoryNetwork()

    async def act() -> list[str]:
        with MemoryBus(network) as bus:
            async with Container(bus, "yard", platform="team") as container:
                me = Agent("me@team")
                await container.start(Painter("painter@team"))
                await container.start(me)
                content = '{"action": "paint", "arguments": {"colour": "<b>"}}'
                draft = draft_of({"performative": "request", "receivers": "painter@team", "content": content})
                replies = converse(me, draft.message(me), draft.receivers[0], 5.0)
                return [f"{reply['performative']} {reply.get('content')}" async for reply in replies]

    assert run(act())[-1] == "inform 1 x <b>"


def test_values_are_tables_where_they_are_lists_of_objects_or_objects() -> None:
    assert table_of({"x": 1.23456789, "on": True}) == (["Name", "Value"], [["x", "1.23457"], ["on", "true"]])
    assert table_of({"stamp": 1795648454.6963995}) == (["Name", "Value"], [["stamp", "1795648454.696"]])
    assert table_of([{"a": 1}, {"b": None, "a": "<i>"}]) == (["a", "b"], [["1", ""], ["<i>", ""]])
    assert table_of([1, 2]) is table_of("text") is table_of({}) is None
    assert text_of("x" * 30_000).endswith("more characters")


def test_the_inside_of_an_agent_is_rows_of_text() -> None:
    head = {"performative": "inform", "sender": "a@x", "protocol": "", "content": '"<b>"'}
    rows = inside_rows(
        {
            "mailbox": {"oldest": [head]},
            "behaviours": [{"name": "step", "kind": "Ticker", "failures": 1, "policy": "Restart"}],
            "streams": [],
            "in_flight": [{**head, "agreed": True}],
        }
    )
    assert rows["Mailbox"] == [["inform", "a@x", "", '"<b>"']]
    assert rows["Behaviours"] == [["step", "Ticker", "1", "Restart"]]
    assert rows["Conversations that it answers"][0][-1] == "yes"


NONSENSE: list[dict[str, Any]] = [{}, {"host": "lab", "process": 1, "agents": [{"name": "<b>"}]}]


class ViewersBus(MemoryBus):
    """A bus on which only looking is allowed."""

    def check_may_query(self, key_expr: str) -> None:
        """Refuse what is not a description."""
        raise NotAllowed(f"the role viewer does not permit {key_expr}")


def test_the_role_on_the_bus_decides_what_a_page_may_do() -> None:
    def why_not(bus: MemoryBus, look_only: str) -> tuple[str, str]:
        console: Any = SimpleNamespace(agent=SimpleNamespace(bus=bus))
        visit = Visit("ticket", "page 1", look_only=look_only)
        return why_not_control(console, visit, HAPPY), why_not_ask(console, visit, BASE)

    with MemoryBus() as bus, ViewersBus() as viewer:
        assert why_not(bus, "") == ("", "")
        assert why_not(bus, "this is a recording") == ("this is a recording",) * 2
        assert why_not(viewer, "")[0] == "the role viewer does not permit happy/containers/happy/control"
        assert why_not(viewer, "")[1] == "the role viewer does not permit happy/agents/base/acl"


def test_a_container_that_answers_nonsense_is_left_out_and_its_token_tells_that_it_is_there() -> None:
    def serve(bus: MemoryBus, key: str, nonsense: dict[str, Any]) -> None:
        bus.serve(key, lambda arguments: nonsense)

    async def act() -> tuple[list[str], list[str]]:
        with MemoryBus() as bus, Directory(bus) as directory, AgentWatch(bus, directory) as watch:
            for number, nonsense in enumerate(NONSENSE):
                called = ContainerName(f"c{number}", "team")
                bus.declare_alive(called.alive_key)
                serve(bus, called.description_key, nonsense)
            await watch.refresh()
            return list(watch.reports), [each.name for each in watch.silent]

    assert run(act()) == ([], ["c0", "c1"])


def test_an_interface_and_a_record_of_a_foreign_program_may_hold_anything() -> None:
    good = {"name": "paint", "doc": "", "parameters": []}
    bad = [1, {}, {"name": "x", "doc": "", "parameters": [1]}, {"name": "y", "doc": "", "parameters": [{"name": 2}]}]
    assert list(entries_of({"requests": [*bad, good], "answers": 7}, ("requests", "answers"))) == ["request paint"]
    assert record_rows([3, {"time": "now", "event": "granted", "why": "<b>"}]) == [
        ["?", "granted", "", "", "", "why <b>"]
    ]
    assert record_rows(None) == []
