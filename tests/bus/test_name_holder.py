"""A name that one program has is refused to another, which is told who has it."""

from contextlib import closing
from typing import Any

import pytest

from bus import Bus, MemoryBus, MemoryNetwork, MessageError, NameTaken, Refused, TimedOut
from bus.name_holder import BusProgram, check_name_free

KEY = "happy/description"
MINE, OTHER = BusProgram(1, "lab", "mine", 100.0), BusProgram(2, "lab", "other", 99.0)


@pytest.fixture
def network() -> MemoryNetwork:
    return MemoryNetwork()


@pytest.fixture
def asker(network: MemoryNetwork) -> Bus:
    return MemoryBus(network)


def tells(network: MemoryNetwork, description: dict[str, Any]) -> Bus:
    """A participant that says this of itself."""
    holder = MemoryBus(network)
    holder.serve(KEY, lambda given: description)
    return holder


def test_a_name_that_nobody_has_is_free(asker: Bus) -> None:
    check_name_free(asker, "happy", KEY)


def test_who_has_a_name_is_told_with_its_process_and_machine(network: MemoryNetwork, asker: Bus) -> None:
    with closing(tells(network, OTHER.told())), pytest.raises(NameTaken) as caught:
        check_name_free(asker, "happy", KEY)
    assert str(caught.value) == "happy is on this bus already, in process 2 on lab"
    check_name_free(asker, "happy", KEY)  # now that the other has ended
    assert str(BusProgram.here()).endswith(" on this machine")


@pytest.mark.parametrize("description", [{}, {"process": "x"}, {**OTHER.told(), "since": None}])
def test_a_holder_that_does_not_tell_who_it_is_has_the_name_all_the_same(
    network: MemoryNetwork, asker: Bus, description: dict[str, Any]
) -> None:
    with closing(tells(network, description)), pytest.raises(NameTaken, match="does not tell which it is"):
        check_name_free(asker, "happy", KEY)


@pytest.mark.parametrize("error", [Refused("not now"), MessageError("a reply is not JSON")])
def test_a_holder_that_answers_something_else_has_the_name_all_the_same(error: Exception) -> None:
    class Odd:
        """A bus on which somebody answers what is no description."""

        def query(self, key_expr: str, timeout: float) -> Any:
            raise error

    with pytest.raises(NameTaken, match="does not tell which it is"):
        check_name_free(Odd(), "happy", KEY)  # type: ignore[arg-type]  # the one method that is used


def test_of_two_that_took_a_name_together_the_later_one_leaves(network: MemoryNetwork, asker: Bus) -> None:
    with closing(tells(network, MINE.told())):
        check_name_free(asker, "happy", KEY, MINE)
        with closing(tells(network, OTHER.told())):
            with pytest.raises(NameTaken, match="process 2"):
                check_name_free(asker, "happy", KEY, MINE)
            check_name_free(asker, "happy", KEY, OTHER)


def test_one_that_is_there_and_does_not_answer_is_waited_for(asker: Bus) -> None:
    class Silent:
        """A bus on which somebody does not answer, a few times."""

        def query(self, key_expr: str, timeout: float) -> Any:
            if silent:
                silent.pop()
                raise TimedOut("late")
            return asker.query(key_expr)

    holder: Any = Silent()  # it has the one method that is used
    silent = [1, 1]
    check_name_free(holder, "happy", KEY)
    assert not silent
    silent = [1, 1, 1]
    with pytest.raises(NameTaken, match="in a program that does not answer"):
        check_name_free(holder, "happy", KEY)
    silent = [1, 1, 1]
    check_name_free(holder, "happy", KEY, MINE)
    assert len(silent) == 2, "a program that was frozen while it asked keeps its name"
