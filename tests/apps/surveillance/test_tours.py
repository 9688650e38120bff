"""Tours and bids: which order is short, what a room adds, what a trade gains, and the best patrol found offline."""

from itertools import permutations
from math import inf
from random import Random

import numpy as np
import pytest

from apps.surveillance.algorithms.floor import PatrolFloor, travel_times
from apps.surveillance.algorithms.neglect import NeglectLedger
from apps.surveillance.algorithms.room_plan import RoomPlan
from apps.surveillance.algorithms.tours import best_cyclic_patrol, best_tour, entered, longest_period, period
from apps.surveillance.settings import SurveillanceSettings
from geometry import Cairn, Pose2D, Segment
from maps.building_map import BuildingMap
from tests.apps.surveillance.building import ROOMS, building_map, floor

PATROL = SurveillanceSettings.load().patrol


def scattered(count: int, seed: int) -> np.ndarray:
    """Times between random places, s, 5 s a visit."""
    rng = Random(seed)
    places = np.array([(rng.uniform(0, 20), rng.uniform(0, 20)) for _ in range(count)])
    return travel_times(np.hypot(*(places[:, None] - places).transpose(2, 0, 1)), 0.5, 5.0)


def plan() -> RoomPlan:
    return RoomPlan(ROOMS, floor(), PATROL)


@pytest.mark.parametrize("seed", range(5))
def test_a_tour_is_nearly_as_short_as_the_shortest_of_all_orders(seed: int) -> None:
    times = scattered(7, seed)
    shortest = min(period((0, *order), times) for order in permutations(range(1, 7)))
    assert period(best_tour(range(7), times), times) <= 1.05 * shortest


@pytest.mark.parametrize("seed", range(3))
def test_the_best_patrol_is_as_good_as_the_best_of_all_divisions_of_six_rooms(seed: int) -> None:
    times = scattered(6, seed)
    divisions = [
        [[room for room in range(6) if number >> room & 1], [room for room in range(6) if not number >> room & 1]]
        for number in range(32)
    ]
    best = min(longest_period([best_tour(each, times) for each in division], times) for division in divisions)
    found, tours = best_cyclic_patrol(times, 2, seed)
    assert found <= best + 1e-6
    assert sorted(room for tour in tours for room in tour) == list(range(6))


def test_a_robot_enters_its_tour_where_the_longest_neglect_becomes_shortest() -> None:
    times = np.full((3, 3), 10.0)
    assert entered([0, 1, 2], [10.0, 10.0, 10.0], [0.0, 5.0, 60.0], times)[0] == 2
    assert entered([0, 1, 2], [1.0, 10.0, 10.0], [0.0, 0.0, 0.0], times)[0] == 0  # the nearest one


def test_ways_lead_through_doors_and_not_through_walls() -> None:
    straight = 3.4  # m from South to North, through the door in between
    assert floor().length(ROOMS["South"], ROOMS["North"]) == pytest.approx(straight, rel=0.1)
    assert floor().length(ROOMS["South"], ROOMS["East"]) > 4.3
    way = floor().way(ROOMS["South"], ROOMS["Far"])
    assert way is not None
    assert way[-1] == ROOMS["Far"]
    assert floor().length(ROOMS["South"], (20.0, 1.0)) == inf


def test_forbidden_lines_and_areas_are_walls() -> None:
    line = Cairn("ForbiddenLine", Pose2D(), "", Segment(1.0, 3.0, 2.6, 3.0))
    barred = PatrolFloor(building_map().with_places(line), 0.25)
    assert barred.length(ROOMS["South"], ROOMS["North"]) == inf
    area = Cairn("ForbiddenArea", Pose2D(), "", Segment(5.0, 4.0, 7.0, 5.6))
    assert not PatrolFloor(building_map().with_places(area), 0.25).is_clear(ROOMS["Far"])


def test_a_map_without_walls_has_no_floor() -> None:
    with pytest.raises(ValueError, match="empty"):
        PatrolFloor(BuildingMap(), 0.25)


def test_a_robot_bids_for_the_room_that_makes_its_tour_least_long_and_trades_when_both_gain() -> None:
    happy, doc = plan(), plan()
    bid = happy.bid(ROOMS, ROOMS["South"], 0.0)
    assert bid is not None
    assert bid.room == "South"
    for room in ("South", "Far"):
        happy.take(room, ROOMS["South"], 0.0, 0.0, is_seen=True)
    for room in ("North", "East"):
        doc.take(room, ROOMS["East"], 0.0, 0.0, is_seen=True)
    trade = doc.trade(happy.order, ROOMS["East"], 0.0)
    assert trade is not None
    assert {trade.room, trade.back} in ({"Far", "North"}, {"South", "East"})
    assert max(trade.mine, trade.theirs) < max(happy.period, doc.period)


def test_a_room_that_is_not_reached_twice_is_given_back_and_not_taken_again_for_a_while() -> None:
    happy = plan()
    for room in ("South", "North"):
        happy.take(room, ROOMS["South"], 0.0, 0.0, is_seen=True)
    assert not happy.missed("North", 10.0)
    happy.visited("South", 20.0)
    assert happy.missed("North", 30.0)
    assert happy.order == ("South",)
    assert happy.bid(["North"], ROOMS["South"], 40.0) is None
    assert happy.bid(["North"], ROOMS["South"], 31.0 + PATROL.barred_s) is not None


def test_a_robot_that_reaches_none_of_its_rooms_is_stuck() -> None:
    happy = plan()
    for room in ROOMS:
        happy.take(room, ROOMS["South"], 0.0, 0.0, is_seen=True)
    happy.missed("South", 1.0)
    assert not happy.is_stuck
    happy.missed("North", 2.0)
    assert happy.is_stuck


def test_neglect_is_the_time_since_the_last_visit_of_any_robot() -> None:
    ledger = NeglectLedger(ROOMS, 100.0)
    ledger.visit("South", "happy", 110.0)
    ledger.visit("South", "doc", 150.0)
    ledger.visit("Attic", "doc", 150.0)
    assert ledger.neglect(160.0)["South"] == 10.0
    assert ledger.neglect(160.0)["Far"] == 60.0
    assert ledger.longest(160.0)["South"] == 40.0
    assert [ledger.count(room) for room in ("South", "Far", "Attic")] == [2, 0, 0]
