"""A container is killed at every step of every protocol: the other side comes to one end, and nothing is left of it."""

import asyncio
import itertools
from collections.abc import Callable
from enum import StrEnum
from functools import partial

import pytest

from agents.platform import AclMessage, Ending
from agents.platform.schedule import Running
from agents.platform.virtual_time import VirtualTimeLoop
from tests.agents.faults.pair import Pair, Place
from tests.agents.faults.scripts import PATIENCE, SCRIPTS, Script

AT_ONCE = 0.1  # s
A_WHILE = 0.5  # s; shorter than any work, longer than any answer that is there at once


class Role(StrEnum):
    """Who is killed."""

    INITIATOR = "initiator"
    RESPONDER = "responder"


class Moment(StrEnum):
    """When, as seen from the word that is just being said."""

    BEFORE = "before"  # it is not said, or not heard
    AFTER = "after"  # it is the last that was said or heard
    LATER = "later"


class Killer:
    """Hears all that is said, and ends one of the two at one word.

    words: what the living have said. at: when it has struck, s of virtual time.
    """

    def __init__(
        self, pair: Pair, victim: Place, step: int, moment: Moment, strike: Callable[[Place], object] = Place.kill
    ) -> None:
        self.words: list[str] = []
        self.at: float | None = None
        self._loop, self._victim, self._step, self._moment, self._strike = pair.loop, victim, step, moment, strike
        for place in (pair.initiator, pair.responder):
            place.container.tap = partial(self._hear, place)

    def _hear(self, speaker: Place, message: AclMessage) -> None:
        if not speaker.is_alive or self.at is not None:
            return
        if len(self.words) == self._step:
            match self._moment:
                case Moment.BEFORE:
                    self._end()
                case Moment.AFTER:
                    self._loop.call_soon(self._end)
                case Moment.LATER:
                    self._loop.call_later(A_WHILE, self._end)
        if speaker.is_alive:
            self.words.append(str(message.performative))

    def _end(self) -> None:
        self.at = self._loop.time()
        self._strike(self._victim)


def stop(place: Place) -> None:
    """End an agent in order, soon."""
    place.agent.delete()


def nothing_is_left(pair: Pair, survivor: Place) -> bool:
    """Whether the survivor is at nothing, and waits for nothing."""
    agent = survivor.agent
    return not (agent.at_work or agent.in_flight or agent.behaviours or pair.network.queries)


def on_holder_death(pair: Pair, dead: Place) -> None:
    """End what a dead process does not do any more; what then runs is the survivor's."""
    pair.leave(dead)
    pair.loop.run_for(AT_ONCE)
    assert not asyncio.all_tasks(pair.loop)


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.name)
def test_undisturbed_each_protocol_runs_as_its_script_says(pair: Pair, script: Script) -> None:
    listener = Killer(pair, pair.responder, len(script.words), Moment.BEFORE)
    assert pair.run(script.begin(pair.initiator.agent, pair.responder.agent.name)) is script.ending
    pair.loop.run_for(AT_ONCE)
    assert tuple(listener.words) == script.words
    assert nothing_is_left(pair, pair.responder)


@pytest.mark.parametrize("moment", Moment)
@pytest.mark.parametrize(
    ("script", "step"),
    [pytest.param(script, step, id=f"{script.name}-{step}") for script in SCRIPTS for step in range(len(script.words))],
)
class TestKilledAtEveryStep:
    def test_who_asked_comes_to_one_end_when_who_answers_is_killed(
        self, pair: Pair, script: Script, step: int, moment: Moment
    ) -> None:
        dead, survivor = pair.responder, pair.initiator
        killer = Killer(pair, dead, step, moment)
        ending = pair.run(script.begin(survivor.agent, dead.agent.name))
        pair.loop.run_for(A_WHILE + AT_ONCE)
        assert killer.at is not None
        assert ending is (script.ending if len(killer.words) >= script.settled else Ending.DIED)
        assert pair.loop.time() <= killer.at + A_WHILE + 2 * AT_ONCE, "it has waited for more than the death"
        assert nothing_is_left(pair, survivor)
        on_holder_death(pair, dead)
        they_begin_anew(pair, script, survivor, pair.join(dead.agent.name))

    def test_who_answers_leaves_it_when_who_asked_is_killed(
        self, pair: Pair, script: Script, step: int, moment: Moment
    ) -> None:
        dead, survivor = pair.initiator, pair.responder
        killer = Killer(pair, dead, step, moment)
        asking = pair.begin(script.begin(dead.agent, survivor.agent.name))
        while killer.at is None:
            pair.loop.run_for(AT_ONCE)
        pair.loop.run_for(AT_ONCE)
        assert nothing_is_left(pair, survivor)
        asking.cancel()
        pair.loop.run_for(PATIENCE)  # of the dead, to whom its own death means nothing
        on_holder_death(pair, dead)
        they_begin_anew(pair, script, pair.join(dead.agent.name), survivor)


@pytest.mark.parametrize("role", Role)
@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.name)
def test_both_leave_it_when_one_of_them_is_stopped_at_any_step(
    loop: VirtualTimeLoop, script: Script, role: Role
) -> None:
    for step, moment in itertools.product(range(len(script.words)), Moment):
        pair = Pair(loop)
        killer = Killer(pair, pair.initiator if role is Role.INITIATOR else pair.responder, step, moment, stop)
        asking = pair.run(in_behaviour(pair, script))
        while killer.at is None:
            pair.loop.run_for(AT_ONCE)
        pair.loop.run_for(AT_ONCE)
        assert nothing_is_left(pair, pair.initiator)
        assert nothing_is_left(pair, pair.responder)
        if role is Role.RESPONDER:
            assert pair.run(asking.result()) in (script.ending, Ending.REFUSED, Ending.FAILED, Ending.DIED)
        assert pair.reports == []
        pair.end()


async def in_behaviour(pair: Pair, script: Script) -> Running:
    """Let the initiator do it as agents do it, so that it ends with its agent."""
    return pair.initiator.agent.add(lambda: script.begin(pair.initiator.agent, pair.responder.agent.name))


def they_begin_anew(pair: Pair, script: Script, initiator: Place, responder: Place) -> None:
    """The survivor serves and asks on, and talks with the other when that has come back."""
    for asked, asker in ((initiator, responder), (responder, initiator)):
        assert pair.run(asker.agent.request(asked.agent.name, "look")).is_done
    assert pair.run(script.begin(initiator.agent, responder.agent.name)) is script.ending
    pair.loop.run_for(AT_ONCE)
    assert nothing_is_left(pair, responder)
    assert pair.reports == []
