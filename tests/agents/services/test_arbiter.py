"""The arbiter and its record, in virtual time, on the gateway's own leases."""

import asyncio
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from agents.platform import AclMessage, Agent, AgentName, Container, Ending, Outcome, Performative
from agents.platform.conversations.request_dispatcher import MOST_REQUESTS
from agents.platform.virtual_time import VirtualTimeLoop
from agents.services.arbiter import Arbiter
from agents.services.audit import MEMORY, REFUSALS_A_SECOND
from agents.services.leases import ONTOLOGY
from bus import MemoryBus
from tests.agents.services.lease_world import ARBITER, LeaseWorld


@pytest.fixture
def world() -> Iterator[LeaseWorld]:
    loop = VirtualTimeLoop()
    world = LeaseWorld(loop)
    world.arbiter()
    yield world
    world.close()
    loop.close()
    assert world.reports == []


def news(agent: Agent) -> list[dict[str, Any]]:
    """What an arbiter has told an agent, oldest first."""
    return [message.content for message in agent.mailbox.messages() if message.ontology == ONTOLOGY]


def test_lease_gives_a_token_that_moves_the_element_and_ends_by_release(world: LeaseWorld) -> None:
    app = world.holder("app")
    given = world.ask(app, "lease", element="base@happy", priority=2, seconds=4.0).value()
    assert (given["element"], given["priority"], given["seconds"]) == ("base@happy", 2, 4.0)
    assert world.gateway.moves("base", given["token"])
    assert not world.gateway.moves("base", "")
    assert world.gateway.moves("gripper", "")
    (row,) = world.ask(app, "leases").value()
    assert (row["element"], row["holder"], row["priority"]) == ("base@happy", "app@lab", 2)
    assert given["token"] not in str(row)
    assert given["lease"] not in str(row)
    assert world.ask(app, "release", lease=given["lease"]).is_done
    assert world.gateway.moves("base", "")
    assert world.ask(app, "leases").value() == []
    assert world.events(app) == ["granted", "released"]


def test_second_application_that_grabs_the_base_is_refused_and_told_who_has_it(world: LeaseWorld) -> None:
    first, second = world.holder("first"), world.holder("second")

    async def both() -> list[Outcome]:
        return await asyncio.gather(*(app.request(ARBITER, "lease", element="base@happy") for app in (first, second)))

    outcomes = world.do(both())
    assert sorted(outcome.ending for outcome in outcomes) == [Ending.DONE, Ending.REFUSED]
    (refused,) = [outcome for outcome in outcomes if not outcome.is_done]
    assert "holds base@happy or is about to, priority 0" in refused.why


def test_lease_lasts_while_it_is_renewed_and_then_expires_with_a_word(world: LeaseWorld) -> None:
    app = world.holder("app")
    given = world.ask(app, "lease", element="base@happy", seconds=1.0).value()
    for _ in range(5):
        world.run(0.8)
        assert world.ask(app, "renew", lease=given["lease"]).is_done
    assert world.gateway.moves("base", given["token"])
    world.run(1.1)
    assert not world.gateway.moves("base", given["token"])
    assert [each["event"] for each in news(app)] == ["expired"]
    assert world.ask(app, "renew", lease=given["lease"]).ending is Ending.REFUSED
    assert world.events(app) == ["granted", "renewed", "expired"]
    assert [name for _, name in world.gateway.stopped] == ["base", "base"]  # as it was taken, and as it ended


def test_lease_that_is_renewed_past_the_arbiter_runs_on(world: LeaseWorld) -> None:
    app = world.holder("app")
    given = world.ask(app, "lease", element="base@happy", seconds=1.0).value()
    world.run(0.9)
    world.do(app.query("happy/lease", {"do": "renew", "token": given["token"], "seconds": 3.0}))
    world.run(2.0)
    assert [row["holder"] for row in world.ask(app, "leases").value()] == ["app@lab"]
    assert world.ask(app, "release", lease=given["lease"]).is_done
    assert world.events(app) == ["granted", "released"]


def test_higher_priority_warns_the_holder_and_takes_over_after_the_notice(world: LeaseWorld) -> None:
    low, high = world.holder("low"), world.holder("high")
    old = world.ask(low, "lease", element="base@happy", priority=1).value()
    assert world.ask(high, "lease", element="base@happy", priority=1).ending is Ending.REFUSED
    asking = world.loop.create_task(high.request(ARBITER, "lease", element="base@happy", priority=2, notice=0.5))
    world.run(0.4)
    assert news(low) == [
        {"lease": old["lease"], "element": "base@happy", "event": "preempted", "within": 0.5, "by": "high@lab"}
    ]
    assert world.gateway.moves("base", old["token"])
    world.run(0.2)
    new = asking.result().value()
    assert world.gateway.moves("base", new["token"])
    assert not world.gateway.moves("base", old["token"])
    assert [each["within"] for each in news(low)] == [0.5, 0.0]
    assert world.events(high) == ["granted", "refused", "warned", "preempted", "granted"]


def test_holder_that_lets_go_within_the_notice_is_not_waited_for(world: LeaseWorld) -> None:
    low, high = world.holder("low"), world.holder("high")
    old = world.ask(low, "lease", element="base@happy").value()
    asking = world.loop.create_task(high.request(ARBITER, "lease", element="base@happy", priority=2, notice=5.0))
    world.run(0.2)
    world.ask(low, "release", lease=old["lease"])
    world.run(0.1)
    assert asking.result().is_done


def test_who_waits_is_outbid_by_a_still_higher_priority(world: LeaseWorld) -> None:
    low, high, highest = world.holder("low"), world.holder("high"), world.holder("highest")
    world.ask(low, "lease", element="base@happy")
    waiting = world.loop.create_task(high.request(ARBITER, "lease", element="base@happy", priority=2, notice=2.0))
    world.run(0.5)
    assert world.ask(highest, "lease", element="base@happy", priority=3, notice=0.1).is_done
    assert waiting.result().ending is Ending.REFUSED
    assert "highest@lab asks for it" in waiting.result().why


def test_lease_on_the_whole_robot_takes_the_place_of_those_on_its_elements(world: LeaseWorld) -> None:
    driver, gripping, chief = world.holder("driver"), world.holder("gripping"), world.holder("chief")
    base = world.ask(driver, "lease", element="base@happy").value()
    grip = world.ask(gripping, "lease", element="gripper@happy").value()
    whole = world.ask(chief, "lease", element="happy", priority=1, notice=0.2).value()
    assert world.gateway.moves("base", whole["token"])
    assert not any(world.gateway.moves("base", each["token"]) for each in (base, grip))
    assert news(driver)[-1]["event"] == news(gripping)[-1]["event"] == "preempted"
    assert [row["element"] for row in world.ask(chief, "leases").value()] == ["happy"]


def test_holder_that_dies_is_stopped_at_once(world: LeaseWorld) -> None:
    app, other = world.holder("app"), world.holder("other")
    given = world.ask(app, "lease", element="base@happy", seconds=60.0).value()
    world.run(1.0)
    world.kill(app)
    died = world.loop.time()
    world.run(0.01)
    stopped_at, what = world.gateway.stopped[-1]
    assert what == "base"
    assert stopped_at == pytest.approx(died, abs=0.01)
    assert not world.gateway.moves("base", given["token"])
    assert world.events(other) == ["granted", "died"]
    assert world.ask(other, "lease", element="base@happy").is_done


def test_holder_that_dies_while_the_arbiter_ends_keeps_what_expires(
    world: LeaseWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    app, arbiter = world.holder("app"), world.agent(ARBITER)
    given = world.ask(app, "lease", element="base@happy", seconds=2.0).value()
    finish = arbiter.finish

    async def finish_while_it_dies() -> None:
        await finish()
        world.kill(app)
        await asyncio.sleep(0.1)

    monkeypatch.setattr(arbiter, "finish", finish_while_it_dies)
    world.do(world.end(ARBITER))
    assert world.gateway.moves("base", given["token"])
    world.run(2.5)
    assert not world.gateway.moves("base", given["token"])


@pytest.mark.parametrize("when", [0.0, 0.2])
def test_who_dies_while_it_waits_takes_nothing_from_the_holder(world: LeaseWorld, when: float) -> None:
    low, high = world.holder("low"), world.holder("high")
    old = world.ask(low, "lease", element="base@happy").value()
    asking = world.loop.create_task(high.request(ARBITER, "lease", element="base@happy", priority=2))
    world.run(when)
    world.kill(high)
    world.run(1.0)
    asking.cancel()
    assert world.gateway.moves("base", old["token"])


def test_who_gives_up_while_it_waits_takes_nothing_from_the_holder(world: LeaseWorld) -> None:
    low, high = world.holder("low"), world.holder("high")
    old = world.ask(low, "lease", element="base@happy").value()
    asking = high.request(ARBITER, "lease", element="base@happy", priority=2, notice=1.0, reply_within=0.5)
    assert not world.do(asking).is_done
    world.run(1.0)
    assert world.gateway.moves("base", old["token"])


def test_gateway_that_was_restarted_has_lost_the_lease_and_its_holder_is_told(world: LeaseWorld) -> None:
    app = world.holder("app")
    given = world.ask(app, "lease", element="base@happy").value()
    world.gateway.kill()
    world.run(0.2)
    renewed = world.ask(app, "renew", lease=given["lease"])
    assert renewed.ending is Ending.FAILED
    assert "the gateway of happy does not answer" in renewed.why
    assert news(app) == []  # it may come back as it was: a cable of the network was out
    world.gateway.start()
    world.run(0.2)
    assert [each["event"] for each in news(app)] == ["lost"]
    assert world.ask(app, "lease", element="base@happy").is_done
    assert world.events(app) == ["granted", "lost", "granted"]


def test_lease_that_is_taken_past_the_arbiter_is_lost_and_its_holder_told(world: LeaseWorld) -> None:
    app = world.holder("app")
    world.ask(app, "lease", element="base@happy")
    taken = {"do": "take", "holder": "a person", "priority": 9, "seconds": 5.0, "element": "base"}
    world.do(app.query("happy/lease", taken))
    world.run(0.1)
    assert [each["event"] for each in news(app)] == ["lost"]
    refused = world.ask(app, "lease", element="base@happy", priority=9)
    assert "a person holds the lease on the base" in refused.why


def test_arbiter_that_was_restarted_gives_nothing_twice(world: LeaseWorld) -> None:
    app, other = world.holder("app"), world.holder("other")
    given = world.ask(app, "lease", element="base@happy", seconds=3.0).value()
    second = AgentName("arbiter-2", "team")
    world.arbiter(second)
    refused = world.ask(other, "lease", arbiter=second, element="base@happy")
    assert "app@lab holds the lease on the base" in refused.why
    world.run(2.0)
    same = {"lease": given["lease"], "token": given["token"], "element": "base@happy"}
    assert not world.ask(other, "renew", arbiter=second, **same).is_done  # it is another's
    assert world.ask(app, "renew", arbiter=second, seconds=3.0, **same).is_done
    world.run(2.0)
    assert world.gateway.moves("base", given["token"])
    assert [row["holder"] for row in world.ask(other, "leases", arbiter=second).value()] == ["app@lab"]


def test_of_two_arbiters_one_is_refused_by_the_gateway_or_takes_over_by_priority(world: LeaseWorld) -> None:
    second = AgentName("arbiter-2", "team")
    world.arbiter(second)
    app, other = world.holder("app"), world.holder("other")
    old = world.ask(app, "lease", element="base@happy", priority=1).value()
    assert not world.ask(other, "lease", arbiter=second, element="base@happy", priority=1).is_done
    new = world.ask(other, "lease", arbiter=second, element="base@happy", priority=2, notice=0.3).value()
    world.run(0.2)
    assert not world.gateway.moves("base", old["token"])
    assert world.gateway.moves("base", new["token"])
    assert [each["event"] for each in news(app)] == ["preempted", "lost"]
    assert world.ask(app, "leases").value() == []


def test_name_that_nobody_bears_gets_no_lease(world: LeaseWorld) -> None:
    app = world.holder("app")
    app.name = AgentName("ghost", "lab")  # as a liar would write it
    refused = world.ask(app, "lease", element="base@happy")
    assert "no agent ghost@lab lives" in refused.why
    assert world.gateway.moves("base", "")


def test_forged_sender_can_neither_renew_nor_release_nor_get_anothers_token(world: LeaseWorld) -> None:
    app, liar = world.holder("app"), world.holder("liar")
    given = world.ask(app, "lease", element="base@happy", priority=1).value()
    liar.name = app.name
    for name in ("renew", "release"):
        assert "no lease of this id" in world.ask(liar, name, lease="guess").why
    assert not world.ask(liar, "lease", element="base@happy", priority=1).is_done
    liar.name = AgentName("liar", "lab")
    assert "no lease of this id" in world.ask(liar, "release", lease=given["lease"]).why  # nor with a stolen id
    assert world.gateway.moves("base", given["token"])


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ({"element": "base@"}, "a lease is on an element such as base@happy"),
        ({"element": "b" * 300}, "is longer than any name"),
        ({"element": "a/b"}, "a lease is on an element such as base@happy"),
        ({"element": "sonar@happy"}, "there is no lease on 'sonar'; what moves is base, gripper"),
        ({"element": "base@nobody"}, "the gateway of nobody does not answer"),
        ({"element": "base@happy", "seconds": 0.0}, "seconds 0 is not within 0.1 and 60"),
        ({"element": "base@happy", "seconds": 1e9}, "seconds 1e+09 is not within"),
        ({"element": "base@happy", "notice": -1.0}, "notice -1 is not within"),
        ({"element": "base@happy", "priority": 10**18}, "priority 1e+18 is not within"),
        ({"element": "base@happy", "priority": 1.5}, "takes priority as int"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_sentence(world: LeaseWorld, arguments: dict[str, Any], why: str) -> None:
    outcome = world.ask(world.holder("app"), "lease", **arguments)
    assert outcome.ending in (Ending.REFUSED, Ending.NOT_UNDERSTOOD)
    assert why in outcome.why


def test_flood_of_wishes_is_refused_and_neither_robs_the_holder_nor_fills_the_record(world: LeaseWorld) -> None:
    app, flood = world.holder("app"), world.holder("flood")
    given = world.ask(app, "lease", element="base@happy", priority=1, seconds=2.0).value()

    async def many() -> list[Outcome]:
        wishes = (flood.request(ARBITER, "lease", element="base@happy") for _ in range(3 * MOST_REQUESTS))
        return await asyncio.gather(*wishes)

    for _ in range(3):
        assert not any(outcome.is_done for outcome in world.do(many()))
        world.run(0.5)
        assert world.ask(app, "renew", lease=given["lease"]).is_done
    rows = world.ask(app, "audit", last=MEMORY).value()
    assert len([row for row in rows if row["event"] == "refused"]) <= 3 * REFUSALS_A_SECOND
    assert any(row.get("left_out", 0) > 50 for row in rows)


def test_record_is_streamed_and_appended_to_a_file_as_lines(tmp_path: Path) -> None:
    loop = VirtualTimeLoop()
    world = LeaseWorld(loop)
    file = tmp_path / "audit.jsonl"
    world.arbiter(properties={"audit_file": str(file)})
    app = world.holder("app")
    heard: list[Any] = []
    app.bus.subscribe(ARBITER.results_key, lambda sample: heard.append(json.loads(sample.payload)))
    given = world.ask(app, "lease", element="base@happy", priority=3).value()
    world.ask(app, "release", lease=given["lease"])
    rows = [json.loads(line) for line in file.read_text().splitlines()]
    assert rows == heard == world.ask(app, "audit").value()
    assert [(row["event"], row["holder"], row["element"], row["priority"]) for row in rows] == [
        ("granted", "app@lab", "base@happy", 3),
        ("released", "app@lab", "base@happy", 3),
    ]
    assert given["token"] not in file.read_text()
    world.close()
    loop.close()


def test_record_that_cannot_be_written_keeps_the_arbiter_from_beginning(loop: VirtualTimeLoop, tmp_path: Path) -> None:
    reports: list[str] = []

    async def main() -> bool:
        with MemoryBus() as bus:
            async with Container(bus, "c", lambda report: reports.append(str(report.error))) as container:
                return await container.start(Arbiter(ARBITER, {"audit_file": str(tmp_path / "no" / "file")}))

    assert not loop.run_until_complete(main())
    assert "give another audit_file" in reports[0]
    assert len(reports) == 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a disk that is full")
def test_record_whose_disk_is_full_is_reported_once_and_leases_go_on(world: LeaseWorld) -> None:
    second = AgentName("arbiter-2", "team")
    world.arbiter(second, {"audit_file": "/dev/full"})
    app = world.holder("app")
    given = world.ask(app, "lease", arbiter=second, element="base@happy").value()
    assert world.ask(app, "release", arbiter=second, lease=given["lease"]).is_done
    assert [row["event"] for row in world.ask(app, "audit", arbiter=second).value()] == ["granted", "released"]
    (report,) = world.reports
    assert "the audit is written down no more" in report
    world.reports.clear()


@pytest.fixture
def loop() -> Iterator[VirtualTimeLoop]:
    loop = VirtualTimeLoop()
    yield loop
    loop.close()


def test_who_gives_up_while_the_gateway_is_at_it_leaves_nothing_leased(world: LeaseWorld) -> None:
    app = world.holder("app")
    world.gateway.delay = 0.2
    asking = world.begin_asking(app, "lease", element="base@happy")
    world.run(0.3)  # the gateway was asked who holds it, and is now asked for it
    assert not world.do(asking.cancel()).is_done
    assert not world.gateway.moves("base", "")
    world.run(0.5)
    assert world.gateway.moves("base", "")


def test_who_is_killed_while_the_gateway_is_at_it_leaves_nothing_leased(world: LeaseWorld) -> None:
    app = world.holder("app")
    world.gateway.delay = 0.2
    asking = world.begin_asking(app, "lease", element="base@happy", seconds=60.0)
    world.run(0.3)
    world.kill(app)
    world.run(1.0)
    assert world.gateway.moves("base", "")
    world.run(20.0)
    assert not world.do(asking.outcome()).is_done


def test_arbiter_killed_while_the_gateway_is_at_it_leaves_what_expires(world: LeaseWorld) -> None:
    app = world.holder("app")
    world.gateway.delay = 0.2
    asking = world.begin_asking(app, "lease", element="base@happy", seconds=3.0)
    world.run(0.3)
    world.kill_named(ARBITER)
    world.run(0.3)
    assert not world.gateway.moves("base", "")
    assert world.do(asking.outcome()).ending is Ending.DIED
    world.run(3.0)
    assert world.gateway.moves("base", "")
    world.reports.clear()  # it died at work


def test_inform_of_an_arbiter_is_a_proper_message(world: LeaseWorld) -> None:
    app = world.holder("app")
    given = world.ask(app, "lease", element="base@happy", seconds=0.5).value()
    world.run(1.0)
    (message,) = app.mailbox.messages()
    assert isinstance(message, AclMessage)
    assert (message.performative, message.sender, message.conversation_id) == (
        Performative.INFORM,
        ARBITER,
        given["lease"],
    )


def test_news_that_were_on_their_way_when_the_arbiter_ended_change_nothing(world: LeaseWorld) -> None:
    """A team that is ended dies all at once: agents and gateways go and come while the arbiter is taken down."""
    app = world.holder("app")
    world.ask(app, "lease", element="base@happy", seconds=60.0).value()
    ending = world.agent(ARBITER)
    assert isinstance(ending, Arbiter)
    world.do(world.end(ARBITER))
    told: list[Any] = []
    app.bus.subscribe(f"{ARBITER.platform}/agents/{ARBITER.local}/results", told.append)
    ending._on_life(app.name, False)
    ending._on_robot("happy/alive", True)
    world.run(1.0)
    assert told == []
