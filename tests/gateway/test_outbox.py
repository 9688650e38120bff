import pytest

from gateway.outbox import MOST_AHEAD, PACE, Outbox


@pytest.fixture
def outbox() -> Outbox:
    return Outbox()


def drain(outbox: Outbox, now: float = 0.0) -> list[bytes]:
    """Everything that waits, in the order in which it leaves."""
    frames = []
    while outbox.deadline < 1e9:
        now = max(now, outbox.deadline)
        frames.append(outbox.due(now))
    return frames


def test_requests_leave_after_whatever_moves_the_robot(outbox: Outbox) -> None:
    outbox.ask("config", b"config")
    outbox.ask("gripper", b"gripper")
    outbox.put("vel", b"vel")
    outbox.put_first("stop", b"stop")
    assert drain(outbox) == [b"stop", b"vel", b"config", b"gripper"]


def test_request_of_a_kind_that_still_waits_is_replaced_in_its_place(outbox: Outbox) -> None:
    outbox.ask("lcd", b"old")
    outbox.ask("config", b"config")
    outbox.ask("lcd", b"new")
    assert drain(outbox) == [b"new", b"config"]


def test_stream_of_speeds_that_never_ends_lets_a_request_pass_now_and_then(outbox: Outbox) -> None:
    outbox.ask("first", b"first")
    outbox.ask("second", b"second")
    sent = []
    for turn in range(4 * MOST_AHEAD):
        outbox.put("vel", b"vel")
        sent.append(outbox.due(turn * 2 * PACE))
    assert sent.index(b"first") == MOST_AHEAD
    assert sent.index(b"second") == 2 * MOST_AHEAD + 1


def test_stop_leaves_at_once_though_the_line_is_still_busy_with_a_request(outbox: Outbox) -> None:
    outbox.baud = 9600
    outbox.ask("config", b"x" * 200)
    outbox.due(0.0)
    outbox.put_first("stop", b"stop")
    assert outbox.due(0.001) == b"stop"


def test_what_was_dropped_or_cleared_does_not_leave(outbox: Outbox) -> None:
    outbox.ask("gripper", b"gripper")
    outbox.drop("gripper")
    assert drain(outbox) == []
    outbox.ask("gripper", b"gripper")
    outbox.put("vel", b"vel")
    outbox.clear()
    assert drain(outbox) == []
