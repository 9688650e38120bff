"""How often a robot goes aside for somebody, and asks them to let it pass."""

from apps.indoor_navigation.algorithms.planning.waiting import (
    FARTHER,
    FIRST_REQUEST,
    MIN_INTERVAL,
    MakingWay,
    Waiting,
    WayRequests,
)

WAITING = Waiting("something is in the way", 0.0, 9.0)


def made_way(times: int, travelled: float) -> MakingWay:
    """A robot that may go aside twice, and has gone aside so often at one place."""
    making_way = MakingWay(2)
    for number in range(times):
        making_way.begin(WAITING, travelled)
        making_way.end(number * MIN_INTERVAL)
    return making_way


def test_a_robot_goes_aside_so_often_in_one_neighbourhood_and_anew_in_another() -> None:
    late = 10 * MIN_INTERVAL
    assert made_way(1, 3.0).is_worth(late, 3.0)
    assert not made_way(2, 3.0).is_worth(late, 3.0 + FARTHER)
    again = made_way(2, 3.0)
    assert again.is_worth(late, 3.1 + FARTHER)
    again.begin(WAITING, 3.1 + FARTHER)
    again.end(late)
    assert again.is_worth(2 * late, 3.1 + FARTHER), "the second of two"


def test_between_two_times_it_drives_on() -> None:
    making_way = made_way(1, 0.0)
    assert not making_way.is_worth(0.9 * MIN_INTERVAL, 20.0)
    assert making_way.is_worth(MIN_INTERVAL, 20.0)


def asked(requests: WayRequests, begin: float, end: float) -> list[float]:
    """When a robot asks that looks every 0.5 s while it waits, s."""
    requests.begin(begin)
    times = [begin + 0.5 * step for step in range(round((end - begin) / 0.5))]
    return [time for time in times if requests.is_due(time)]


def test_a_robot_asks_so_often_while_it_waits() -> None:
    assert asked(WayRequests(4.0, 3), 10.0, 60.0) == [10.0 + FIRST_REQUEST, 15.0, 19.0]
    assert asked(WayRequests(4.0, 0), 10.0, 60.0) == []


def test_a_robot_that_waits_again_and_again_does_not_ask_more_often() -> None:
    requests = WayRequests(4.0, 3)
    assert [time for begin in range(10, 30, 2) for time in asked(requests, begin, begin + 2.0)] == [11, 15, 19, 23, 27]
