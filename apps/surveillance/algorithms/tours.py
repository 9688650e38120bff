"""Tours through rooms: which order takes the least time, what another room adds, and the best patrol found offline.

Times are a table: s from each place to each other, a visit included; the diagonal is the time of a visit without a way.
A robot that drives the same tour again and again neglects each of its rooms for as long as the tour takes: its period.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import exp, inf
from random import Random

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_ROUNDING = 1e-9  # s
_COOLING = 0.999  # of the temperature in one step of the search


def period(order: Sequence[int], times: Floats) -> float:
    """Time of a tour through rooms in this order and back to the first, s; 0 without rooms."""
    if not order:
        return 0.0
    if len(order) == 1:
        return float(times[order[0], order[0]])
    return float(sum(times[a, b] for a, b in pairwise((*order, order[0]))))


def with_room(order: Sequence[int], room: int, times: Floats) -> list[int]:
    """Return the tour with another room where it adds the least time."""
    choices = [[*order[:at], room, *order[at:]] for at in range(1, len(order) + 1)] or [[room]]
    return min(choices, key=lambda each: period(each, times))


def best_tour(rooms: Sequence[int], times: Floats) -> list[int]:
    """Return a short tour through rooms: cheapest insertion, then reversed parts and moved rooms while that helps."""
    order: list[int] = []
    for room in rooms:
        order = with_room(order, room, times)
    return improved(order, times)


def improved(order: Sequence[int], times: Floats) -> list[int]:
    """Return the tour after all exchanges of two ways (2-opt) and moves of one room that make it shorter."""
    best, length = list(order), period(order, times)
    is_better = True
    while is_better:
        is_better = False
        for changed in _neighbours(best):
            changed_length = period(changed, times)
            if changed_length < length - _ROUNDING:
                best, length, is_better = changed, changed_length, True
                break
    return best


def _neighbours(order: list[int]) -> list[list[int]]:
    count, found = len(order), []
    for first in range(1, count - 1):
        for last in range(first + 1, count):
            found.append([*order[:first], *reversed(order[first : last + 1]), *order[last + 1 :]])
    for at in range(count):
        rest = [*order[:at], *order[at + 1 :]]
        found += [[*rest[:to], order[at], *rest[to:]] for to in range(1, count - 1) if to != at]
    return found


def entered(order: Sequence[int], to_rooms: Sequence[float], neglect: Sequence[float], times: Floats) -> list[int]:
    """Return the tour from the room and in the sense in which the longest neglect of the first round is shortest.

    Args:
        order: The tour.
        to_rooms: s from where the robot is to each room, a visit included; shape (rooms of the table,).
        neglect: s since the last visit of each room, likewise.
        times: Table.
    """
    best, least = list(order), (inf, inf)
    for sense in (list(order), list(reversed(order))):
        for at in range(len(sense)):
            turned = sense[at:] + sense[:at]
            when, worst = to_rooms[turned[0]], neglect[turned[0]] + to_rooms[turned[0]]
            for a, b in pairwise(turned):
                when += times[a, b]
                worst = max(worst, neglect[b] + when)
            if (worst, to_rooms[turned[0]]) < least:
                best, least = turned, (worst, to_rooms[turned[0]])
    return best


def longest_period(tours: Sequence[Sequence[int]], times: Floats) -> float:
    """The longest neglect of a patrol in which each robot drives its own tour, s."""
    return max((period(each, times) for each in tours), default=0.0)


def best_cyclic_patrol(times: Floats, robots: int, seed: int, steps: int = 4000) -> tuple[float, list[list[int]]]:
    """Search the cyclic patrol with the shortest longest neglect.

    Two kinds are searched: each robot has a tour of its own, by simulated annealing over who visits which room; and all
    robots drive one tour through all rooms, evenly apart. Source: Y. Chevaleyre, Theoretical analysis of the
    multi-agent patrolling problem, IAT 2004.

    Args:
        times: Table of all rooms.
        robots: How many.
        seed: Of the search.
        steps: Of the search.
    Returns:
        The longest neglect, s, and the tours; the tour of all robots is the only one where it is better.
    """
    rooms = list(range(len(times)))
    together = best_tour(rooms, times)
    rng = Random(seed)
    tours = [best_tour(rooms[robot::robots], times) for robot in range(robots)]
    worst = longest_period(tours, times)
    best, found = worst, [list(each) for each in tours]
    temperature = 0.1 * worst
    for _ in range(steps if robots > 1 else 0):
        temperature *= _COOLING
        changed = _changed(tours, rng, times)
        reached = longest_period(changed, times)
        if reached <= worst or rng.random() < exp((worst - reached) / max(temperature, _ROUNDING)):
            tours, worst = changed, reached
        if worst < best - _ROUNDING:
            best, found = worst, [list(each) for each in tours]
    evenly = period(together, times) / robots
    return (evenly, [together]) if evenly < best else (best, found)


def _changed(tours: Sequence[list[int]], rng: Random, times: Floats) -> list[list[int]]:
    """Return the tours after one room has gone to another robot, or two rooms have changed places."""
    giver, taker = rng.sample(range(len(tours)), 2)
    changed = [list(each) for each in tours]
    if not changed[giver]:
        return changed
    given = rng.choice(changed[giver])
    changed[giver].remove(given)
    if changed[taker] and rng.random() < 0.5:
        back = rng.choice(changed[taker])
        changed[taker].remove(back)
        changed[giver] = with_room(changed[giver], back, times)
    changed[taker] = with_room(changed[taker], given, times)
    return [improved(tour, times) if at in (giver, taker) else tour for at, tour in enumerate(changed)]
