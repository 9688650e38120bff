"""The door of an agent that moves, where the bus's threads and the event loop meet."""

import threading
from typing import Any

from agents.platform.container.delivery_gate import DeliveryGate
from bus import Conversation, Sample
from tests.waiting import patience, wait_until


class Silent(Conversation):
    """Says nothing; ended when it was closed."""

    def __init__(self) -> None:
        self.ended = False

    def reply(self, value: dict[str, Any]) -> None:
        raise AssertionError("nobody answers here")

    def refuse(self, why: str) -> None:
        raise AssertionError("nobody answers here")

    def close(self) -> None:
        self.ended = True


def test_a_conversation_that_is_just_being_begun_counts_as_begun_before_the_door_shuts() -> None:
    at_it, go_on, is_shut = threading.Event(), threading.Event(), threading.Event()
    begun: list[dict[str, Any]] = []

    def begin(message: dict[str, Any], conversation: Conversation) -> None:
        at_it.set()
        assert go_on.wait(patience())
        begun.append(message)

    door = DeliveryGate(lambda payload: None, begin)
    entering = threading.Thread(target=door.caller, args=({"number": 1}, Silent()))
    entering.start()
    assert at_it.wait(patience())

    def shut() -> None:
        door.keep_callers()
        assert begun == [{"number": 1}]
        is_shut.set()

    shutting = threading.Thread(target=shut)
    shutting.start()
    wait_until(lambda: door._keeps_callers, "the door is being shut")
    door.caller({"number": 2}, Silent())
    assert not is_shut.is_set()
    go_on.set()
    for thread in (entering, shutting):
        thread.join()
    assert is_shut.is_set()
    assert [caller.message for caller in door.kept()[1]] == [{"number": 2}]


def test_what_comes_through_both_doors_comes_in_once_and_in_order() -> None:
    taken: list[bytes] = []
    begun: list[dict[str, Any]] = []
    door = DeliveryGate(taken.append, lambda message, conversation: begun.append(message))
    door.wait_for_the_rest()
    for number in (2, 3):
        door.queued(Sample("k", b"%d" % number, attachment=bytes([number])))
    first, again, late = Silent(), Silent(), Silent()
    opening = {"conversation_id": "c", "sender": "a@b"}
    door.caller(opening, first)
    door.caller(opening, again)
    assert (first.ended, again.ended) == (False, True)
    other = DeliveryGate(taken.append, lambda message, conversation: None)
    other.keep_letters()
    for number in (1, 2):
        other.queued(Sample("k", b"%d" % number, attachment=bytes([number])))
    door.bring(other.waiting())
    door.open()
    door.queued(Sample("k", b"3", attachment=bytes([3])))
    door.caller(opening, late)
    assert taken == [b"1", b"2", b"3"]
    assert begun == [opening]
    assert late.ended
    door.forget()
    door.queued(Sample("k", b"3", attachment=bytes([3])))
    assert taken[3:] == [b"3"], "labels are forgotten when the other door is no more"
