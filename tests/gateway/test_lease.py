import itertools
from collections.abc import Callable

import pytest

from gateway.errors import CommandRefused
from gateway.lease import ROBOT, Leases


@pytest.fixture
def leases() -> Leases:
    return Leases(map("token-{}".format, itertools.count(1)).__next__, ["base", "gripper"])


def refused(call: Callable[[], object]) -> str:
    with pytest.raises(CommandRefused) as caught:
        call()
    return str(caught.value)


def take(leases: Leases, holder: str, what: str = ROBOT, priority: int = 0, seconds: float = 5.0) -> str:
    return leases.take(what, holder, priority, seconds, 0.0)[1]


@pytest.mark.parametrize("what", ["base", ROBOT])
def test_anyone_may_command_what_is_free_and_only_the_holder_what_is_leased(leases: Leases, what: str) -> None:
    leases.check("base", "")
    token = take(leases, "arbiter", what)
    leases.check("base", token)
    assert f"arbiter holds the lease on the {what}" in refused(lambda: leases.check("base", ""))
    assert f"arbiter holds the lease on the {what}" in refused(lambda: leases.check("base", "guess"))


def test_lease_on_one_element_leaves_the_others_free(leases: Leases) -> None:
    token = take(leases, "me", "gripper")
    leases.check("base", "")
    leases.check("base", token)  # who holds something has no less right to what is free than others
    take(leases, "you", "base")
    assert "you holds" in refused(lambda: leases.check("base", token))


def test_lease_ends_when_nobody_renews_it_and_its_token_never_counts_again(leases: Leases) -> None:
    token = take(leases, "arbiter", "base", seconds=2.0)
    leases.renew(token, None, 1.5)
    assert leases.expire(3.4) == []
    assert leases.expire(3.5) == ["base"]
    assert leases.expire(3.6) == []
    assert "has ended" in refused(lambda: leases.check("base", token))
    assert "has ended" in refused(lambda: leases.check("gripper", token))
    assert "does not hold" in refused(lambda: leases.renew(token, None, 3.6))
    leases.check("base", "")


def test_higher_priority_takes_the_lease_and_an_equal_one_waits(leases: Leases) -> None:
    first = take(leases, "wanderer", priority=1)
    assert "wanderer holds the lease" in refused(lambda: take(leases, "other", priority=1))
    second = take(leases, "rescuer", priority=2)
    assert "rescuer" in refused(lambda: leases.check("base", first))
    leases.check("base", second)


def test_lease_on_the_robot_takes_the_place_of_those_on_elements_and_they_of_it(leases: Leases) -> None:
    base, gripper = take(leases, "driver", "base", 1), take(leases, "gripping", "gripper", 2)
    assert "gripping" in refused(lambda: take(leases, "all", ROBOT, 2))
    leases.check("base", base)  # a refused one changes nothing
    assert leases.take(ROBOT, "all", 3, 5.0, 0.0)[2] == [ROBOT]
    assert "all holds" in refused(lambda: leases.check("gripper", gripper))
    assert leases.take("base", "rescuer", 4, 5.0, 0.0)[2] == [ROBOT]  # all that the last holder had moved
    leases.check("gripper", "")
    assert leases.state(0.0)["holder"] is None


def test_release_frees_the_robot_and_needs_the_token(leases: Leases) -> None:
    token = take(leases, "arbiter")
    assert "does not hold" in refused(lambda: leases.release("guess"))
    leases.release(token)
    assert leases.state(1.0) == {"holder": None, "priority": 0, "expires_in": None, "elements": {}}
    take(leases, "next")


def test_empty_token_holds_nothing(leases: Leases) -> None:
    assert "does not hold" in refused(lambda: leases.release(""))
    assert "does not hold" in refused(lambda: leases.renew("", None, 0.0))


@pytest.mark.parametrize("seconds", [0.0, -1.0, 61.0, float("nan"), float("inf")])
def test_lease_lasts_a_reasonable_while(leases: Leases, seconds: float) -> None:
    held = take(leases, "before", "base")
    assert "is not possible" in refused(lambda: leases.take("base", "arbiter", 1, seconds, 0.0))
    leases.check("base", held)


def test_state_never_shows_a_token(leases: Leases) -> None:
    token = take(leases, "arbiter", priority=3)
    assert leases.state(1.0) == {"holder": "arbiter", "priority": 3, "expires_in": 4.0, "elements": {}}
    assert token not in str(leases.state(1.0))


def test_holder_must_have_a_name(leases: Leases) -> None:
    assert "send a name" in refused(lambda: take(leases, ""))


def test_only_what_moves_can_be_leased(leases: Leases) -> None:
    assert "what moves is base, gripper" in refused(lambda: take(leases, "me", "sonar"))
