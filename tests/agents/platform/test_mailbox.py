"""A mailbox keeps order, is bounded, and gives each receiver what it wants."""

import asyncio
import threading
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.platform import AclMessage, AgentName, Mailbox, Performative, Template
from agents.platform.virtual_time import VirtualTimeLoop

ANN, BOB = AgentName("ann", "lab"), AgentName("bob", "lab")


def message(sender: AgentName = ANN, performative: Performative = Performative.INFORM, **fields: Any) -> AclMessage:
    return AclMessage(performative=performative, sender=sender, **fields)


def test_messages_are_taken_in_the_order_of_their_arrival() -> None:
    box = Mailbox()
    for number in range(5):
        box.deliver(message(content=number))
    assert [(taken := box.take()) and taken.content for _ in range(5)] == list(range(5))
    assert box.take() is None


@given(
    st.lists(st.tuples(st.sampled_from([ANN, BOB]), st.sampled_from(Performative)), max_size=20),
    st.lists(st.sampled_from([ANN, BOB, None]), max_size=20),
)
def test_messages_of_one_sender_keep_their_order_whatever_is_taken(
    sent: list[tuple[AgentName, Performative]], wishes: list[AgentName | None]
) -> None:
    box = Mailbox(share=1.0)
    for number, (sender, performative) in enumerate(sent):
        box.deliver(message(sender, performative, content=number))
    wanted = [Template.of(sender=sender) for sender in wishes] + [Template.of()] * len(sent)
    taken = [got for template in wanted if (got := box.take(template)) is not None]
    assert len(taken) == len(sent)
    for sender in (ANN, BOB):
        numbers = [got.content for got in taken if got.sender == sender]
        assert numbers == sorted(numbers)


def test_a_template_wants_what_all_its_fields_say() -> None:
    template = Template.of(
        Performative.AGREE,
        Performative.REFUSE,
        sender=ANN,
        conversation="c",
        protocol="p",
        ontology="o",
        in_reply_to="r",
    )
    fields = {"conversation_id": "c", "protocol": "p", "ontology": "o", "in_reply_to": "r"}
    assert template.matches(message(ANN, Performative.AGREE, **fields))
    assert template.matches(message(ANN, Performative.REFUSE, **fields))
    assert not template.matches(message(ANN, Performative.INFORM, **fields))
    assert not template.matches(message(BOB, Performative.AGREE, **fields))
    for name in fields:
        assert not template.matches(message(ANN, Performative.AGREE, **{**fields, name: "other"}))
    assert Template.of().matches(message())
    assert str(template) == "agree|refuse sender=ann@lab conversation_id=c protocol=p ontology=o in_reply_to=r"


def test_templates_combine() -> None:
    ann, inform = Template.of(sender=ANN), Template.of(Performative.INFORM)
    cases = [message(ANN), message(BOB), message(ANN, Performative.AGREE), message(BOB, Performative.AGREE)]
    assert [(ann & inform).matches(case) for case in cases] == [True, False, False, False]
    assert [(ann | inform).matches(case) for case in cases] == [True, True, True, False]
    assert [(~ann).matches(case) for case in cases] == [False, True, False, True]
    assert str(ann & ~inform) == "(sender=ann@lab and not inform)"


def test_a_flood_is_dropped_and_counted_and_leaves_room_for_others() -> None:
    box = Mailbox(capacity=10, share=0.6)
    assert sum(box.deliver(message(ANN)) for _ in range(1000)) == 6
    assert sum(box.deliver(message(BOB)) for _ in range(1000)) == 4
    assert (box.state.waiting, box.state.delivered, box.state.dropped) == (10, 10, 1990)
    box.take(Template.of(sender=ANN))
    assert box.deliver(message(ANN))


def test_a_flood_of_large_messages_is_bounded_by_their_bytes() -> None:
    box = Mailbox(room=10_000, share=0.6)
    assert sum(box.deliver(message(ANN), 1000) for _ in range(100)) == 6
    assert sum(box.deliver(message(BOB), 1000) for _ in range(100)) == 4
    while box.take() is not None:
        pass
    assert box.deliver(message(ANN), 6000)


def test_a_receiver_waits_for_what_it_wants(loop: VirtualTimeLoop) -> None:
    box = Mailbox()
    receiving = loop.create_task(box.receive(Template.of(sender=BOB)))
    loop.run_for(1.0)
    box.deliver(message(ANN))
    loop.run_for(1.0)
    assert not receiving.done()
    box.deliver(message(BOB, content=1))
    loop.run_for(0.0)
    assert receiving.result().content == 1
    assert box.state.waiting == 1


def test_receivers_of_the_same_are_served_one_message_each(loop: VirtualTimeLoop) -> None:
    box = Mailbox()
    receiving = [loop.create_task(box.receive()) for _ in range(3)]
    loop.run_for(1.0)
    for number in range(2):
        box.deliver(message(content=number))
    loop.run_for(1.0)
    assert sorted(task.result().content for task in receiving if task.done()) == [0, 1]
    box.deliver(message(content=2))
    loop.run_for(1.0)
    assert all(task.done() for task in receiving)


@pytest.mark.parametrize("cancelled_first", [True, False])
def test_a_receiver_that_is_cancelled_loses_no_message(loop: VirtualTimeLoop, cancelled_first: bool) -> None:
    box = Mailbox()
    receiving = loop.create_task(box.receive())
    loop.run_for(1.0)
    if cancelled_first:
        receiving.cancel()
    box.deliver(message(content=1))
    receiving.cancel()
    loop.run_for(1.0)
    assert receiving.cancelled()
    assert box.take() == message(content=1)


def test_what_another_thread_delivers_wakes_the_receiver() -> None:
    box = Mailbox()

    async def main() -> list[int]:
        threading.Thread(target=lambda: [box.deliver(message(content=number)) for number in range(100)]).start()
        return [(await box.receive()).content for _ in range(100)]

    assert asyncio.run(main()) == list(range(100))
