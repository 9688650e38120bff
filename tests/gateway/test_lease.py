import itertools
from collections.abc import Callable

import pytest

from gateway.errors import CommandRefused
from gateway.lease import Lease


@pytest.fixture
def lease() -> Lease:
    return Lease(map("token-{}".format, itertools.count(1)).__next__)


def refused(call: Callable[[], object]) -> str:
    with pytest.raises(CommandRefused) as caught:
        call()
    return str(caught.value)


def test_anyone_may_command_a_free_robot_and_only_the_holder_a_leased_one(lease: Lease) -> None:
    lease.check("")
    token = lease.take("arbiter", 0, 5.0, 0.0)
    lease.check(token)
    assert "arbiter holds the lease" in refused(lambda: lease.check(""))
    assert "arbiter holds the lease" in refused(lambda: lease.check("guess"))


def test_lease_ends_when_nobody_renews_it_and_its_token_never_counts_again(lease: Lease) -> None:
    token = lease.take("arbiter", 0, 2.0, 0.0)
    lease.renew(token, None, 1.5)
    assert not lease.expire(3.4)
    assert lease.expire(3.5)
    assert not lease.expire(3.6)
    assert "has ended" in refused(lambda: lease.check(token))
    assert "does not hold" in refused(lambda: lease.renew(token, None, 3.6))
    lease.check("")


def test_higher_priority_takes_the_lease_and_an_equal_one_waits(lease: Lease) -> None:
    first = lease.take("wanderer", 1, 5.0, 0.0)
    assert "wanderer holds the lease" in refused(lambda: lease.take("other", 1, 5.0, 0.0))
    second = lease.take("rescuer", 2, 5.0, 0.0)
    assert "rescuer" in refused(lambda: lease.check(first))
    lease.check(second)


def test_release_frees_the_robot_and_needs_the_token(lease: Lease) -> None:
    token = lease.take("arbiter", 0, 5.0, 0.0)
    assert "does not hold" in refused(lambda: lease.release("guess"))
    lease.release(token)
    assert lease.state(1.0) == {"holder": None, "priority": 0, "expires_in": None}
    lease.take("next", 0, 5.0, 1.0)


@pytest.mark.parametrize("seconds", [0.0, -1.0, 61.0, float("nan"), float("inf")])
def test_lease_lasts_a_reasonable_while(lease: Lease, seconds: float) -> None:
    assert "is not possible" in refused(lambda: lease.take("arbiter", 0, seconds, 0.0))


def test_state_never_shows_the_token(lease: Lease) -> None:
    token = lease.take("arbiter", 3, 5.0, 0.0)
    assert lease.state(1.0) == {"holder": "arbiter", "priority": 3, "expires_in": 4.0}
    assert token not in str(lease.state(1.0))


def test_holder_must_have_a_name(lease: Lease) -> None:
    assert "who you are" in refused(lambda: lease.take("", 0, 5.0, 0.0))
