"""What explains a motion that did not reach its goal."""

from agents.components.troubles import RECENT, Troubles

LOW = "the battery is low, below 11.5 V"
FAILED = "the gripper reports an error of its paddles or its lift"


def test_new_fault_is_a_reason_and_an_old_one_is_not() -> None:
    troubles = Troubles("gripper")
    troubles.hear_faults([LOW], 0.0)
    troubles.hear_faults([LOW, "the e-stop is latched"], 100.0)
    assert troubles.reasons(101.0) == "the e-stop is latched"
    assert troubles.reasons(101.0 + RECENT) == ""


def test_old_fault_of_the_element_itself_is_a_reason() -> None:
    troubles = Troubles("gripper")
    troubles.hear_faults([LOW, FAILED], 0.0)
    assert troubles.reasons(100.0) == FAILED


def test_lease_that_changes_hands_is_a_reason() -> None:
    troubles = Troubles("gripper")
    troubles.hear_lease({"holder": None, "elements": {}}, 0.0)
    assert troubles.reasons(0.0) == ""
    troubles.hear_lease({"holder": None, "elements": {"gripper": {"holder": "app-1@team"}}}, 1.0)
    troubles.hear_lease({"holder": None, "elements": {"arm": {"holder": "app-2@team"}}}, 2.0)
    assert troubles.reasons(2.0) == "the lease passed to app-1@team; app-1@team's lease ended"


def test_first_word_of_a_lease_is_no_change() -> None:
    troubles = Troubles("gripper")
    troubles.hear_lease({"holder": "somebody", "priority": 0, "expires_in": 1.0}, 0.0)
    assert troubles.reasons(0.0) == ""
