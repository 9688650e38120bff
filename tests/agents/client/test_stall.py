"""When the flags of wheels say that a robot is stalled."""

import pytest

from agents.client.driving import Stall


def flags(text: str, period: float = 0.1) -> list[bool]:
    """What a stall says of flags, `#` for a set one, that come every `period` s."""
    stall = Stall()
    return [stall.hear(flag == "#", number * period) for number, flag in enumerate(text)]


@pytest.mark.parametrize(
    "text",
    [
        "..........",
        ".##.......",  # once, as a robot starts
        "####",
        ".##" + 25 * "." + "##",  # two that have nothing to do with each other
    ],
)
def test_a_short_stall_is_none(text: str) -> None:
    assert not any(flags(text))


@pytest.mark.parametrize("text", ["#######", "##.....##", "##..........##", ".#.....#"])
def test_a_stall_that_lasts_or_comes_again_is_one(text: str) -> None:
    assert flags(text)[-1]


def test_while_no_flag_is_set_nothing_is_stalled() -> None:
    assert flags("#######..")[-3:] == [True, False, False]
