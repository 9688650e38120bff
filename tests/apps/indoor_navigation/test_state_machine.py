"""The state machine for components: a table, and whoever says what happens."""

import pytest

from apps.indoor_navigation.state_machine import Change, StateMachine, from_each

TABLE = {
    ("shut", "push"): "open",
    ("open", "pull"): "shut",
    ("open", "push"): "open",
    **from_each(("shut", "open"), "kick", "broken"),
}


def test_an_event_leads_to_the_state_of_the_table() -> None:
    door = StateMachine(TABLE, "shut")
    assert door.happens("push", now=3.0, why="somebody comes") == "open"
    assert (door.state, door.since, door.why) == ("open", 3.0, "somebody comes")


def test_an_event_that_changes_nothing_keeps_since_and_why() -> None:
    changes: list[Change[str, str]] = []
    door = StateMachine(TABLE, "shut", changes.append)
    door.happens("push", 3.0, "somebody comes")
    door.happens("push", 4.0, "once more")
    assert (door.since, door.why) == (3.0, "somebody comes")
    assert changes == [Change("shut", "push", "open", 3.0, "somebody comes")]


def test_an_event_that_leads_nowhere_is_told_and_changes_nothing() -> None:
    door = StateMachine(TABLE, "shut")
    door.happens("kick", 1.0)
    assert not door.knows("push")
    with pytest.raises(LookupError, match="the state 'broken' has no transition for 'push'"):
        door.happens("push", 2.0)
    assert (door.state, door.since) == ("broken", 1.0)
