"""Processes that end unasked are started again, in virtual time."""

import asyncio
from itertools import pairwise

import pytest

from acromovi.team.plan import PlannedProcess, ProcessKind
from acromovi.team.supervisor import DELAYS, GRACE, HEALTHY_AFTER, Hear, ProcessState, Supervisor
from agents.platform.virtual_time import VirtualTimeLoop
from tests.acromovi.team.conftest import Diary, Pretence, PretendedChild

HAPPY = PlannedProcess("the container of happy", ProcessKind.AGENTS, ("true",), ("happy",), container="happy")


def test_process_that_ends_is_started_again_at_once(loop: VirtualTimeLoop, pretence: Pretence, diary: Diary) -> None:
    async def main() -> None:
        supervisor = Supervisor(pretence.start, diary)
        entry = supervisor.begin(HAPPY)
        await asyncio.sleep(1.0)
        pretence.children[0].complain("out of memory")
        pretence.children[0].end(1)
        await asyncio.sleep(0.01)
        assert (len(pretence.children), entry.state, entry.restarts) == (2, ProcessState.RUNNING, 1)
        assert entry.why == "out of memory"
        assert entry.as_json()["pid"] == pretence.children[1].pid
        await supervisor.end()

    loop.run_until_complete(main())


def test_process_that_ends_again_and_again_is_started_more_and_more_seldom(
    loop: VirtualTimeLoop, pretence: Pretence, diary: Diary
) -> None:
    async def main() -> list[float]:
        supervisor = Supervisor(pretence.start, diary)
        supervisor.begin(HAPPY)
        starts = []
        for number in range(len(DELAYS) + 2):
            while len(pretence.children) <= number:
                await asyncio.sleep(0.05)
            starts.append(loop.time())
            pretence.children[-1].end(1)
        await supervisor.end()
        return [later - earlier for earlier, later in pairwise(starts)]

    pauses = loop.run_until_complete(main())
    assert pauses == pytest.approx([*DELAYS, DELAYS[-1]], abs=0.1)


def test_process_that_lived_long_enough_is_started_again_at_once(
    loop: VirtualTimeLoop, pretence: Pretence, diary: Diary
) -> None:
    async def main() -> None:
        supervisor = Supervisor(pretence.start, diary)
        entry = supervisor.begin(HAPPY)
        for number in range(5):
            await asyncio.sleep(HEALTHY_AFTER + 1)
            pretence.children[number].end(1)
            await asyncio.sleep(0.01)
            assert len(pretence.children) == number + 2
        assert (entry.ends, entry.restarts) == (1, 5)
        await supervisor.end()

    loop.run_until_complete(main())


@pytest.mark.parametrize(("ignores", "how"), [(False, "ended by SIGTERM"), (True, "ended by SIGKILL")])
def test_process_is_started_again_when_told_whether_or_not_it_listens(
    loop: VirtualTimeLoop, diary: Diary, ignores: bool, how: str
) -> None:
    async def main() -> None:
        pretence = Pretence(ignores)
        supervisor = Supervisor(pretence.start, diary)
        entry = supervisor.begin(HAPPY)
        await asyncio.sleep(1.0)
        await supervisor.restart(entry)
        await asyncio.sleep(GRACE)
        assert (len(pretence.children), entry.why) == (2, how)
        await supervisor.end()

    loop.run_until_complete(main())


def test_nothing_is_started_again_once_the_end_has_begun(
    loop: VirtualTimeLoop, pretence: Pretence, diary: Diary
) -> None:
    async def main() -> None:
        supervisor = Supervisor(pretence.start, diary)
        supervisor.begin(HAPPY)
        supervisor.begin(PlannedProcess("the emulator", ProcessKind.EMULATOR, ("true",)))
        await asyncio.sleep(1.0)
        supervisor.rest()
        pretence.children[0].end(0)
        await asyncio.sleep(60.0)
        await supervisor.end()
        assert (len(pretence.children), diary.ends) == (2, [])
        assert {entry.state for entry in supervisor.table} == {ProcessState.ENDED}

    loop.run_until_complete(main())


def test_end_while_a_process_waits_for_its_turn_does_not_wait_for_it(
    loop: VirtualTimeLoop, pretence: Pretence, diary: Diary
) -> None:
    async def main() -> float:
        supervisor = Supervisor(pretence.start, diary)
        entry = supervisor.begin(HAPPY)
        for number in range(4):
            while len(pretence.children) <= number:
                await asyncio.sleep(0.05)
            pretence.children[-1].end(1)
        await asyncio.sleep(0.01)
        assert entry.state is ProcessState.WAITING
        begun = loop.time()
        await supervisor.end()
        return loop.time() - begun

    assert loop.run_until_complete(main()) == 0.0


def test_process_that_is_just_being_started_ends_with_the_others(
    loop: VirtualTimeLoop, pretence: Pretence, diary: Diary
) -> None:
    async def start_slowly(program: PlannedProcess, heard: Hear, complained: Hear) -> PretendedChild:
        await asyncio.sleep(1.0)
        return await pretence.start(program, heard, complained)

    async def main() -> None:
        supervisor = Supervisor(start_slowly, diary)
        entry = supervisor.begin(HAPPY)
        await asyncio.sleep(0.5)
        await supervisor.end()
        assert await pretence.children[0].wait() == -9
        assert (len(pretence.children), entry.state) == (1, ProcessState.ENDED)

    loop.run_until_complete(main())


@pytest.mark.parametrize(("code", "how"), [(-9, "ended by SIGKILL"), (3, "ended with exit code 3")])
def test_exit_codes_are_told_in_words(
    loop: VirtualTimeLoop, pretence: Pretence, diary: Diary, code: int, how: str
) -> None:
    async def main() -> None:
        supervisor = Supervisor(pretence.start, diary)
        entry = supervisor.begin(HAPPY)
        await asyncio.sleep(1.0)
        pretence.children[0].end(code)
        await asyncio.sleep(0.01)
        assert entry.why == how
        await supervisor.end()

    loop.run_until_complete(main())


@pytest.mark.parametrize("ignores", [False, True])
def test_process_that_is_retired_ends_for_good(loop: VirtualTimeLoop, diary: Diary, ignores: bool) -> None:
    pretence = Pretence(ignores)

    async def main() -> None:
        supervisor = Supervisor(pretence.start, diary)
        entry = supervisor.begin(HAPPY)
        await asyncio.sleep(1.0)
        await supervisor.retire(entry)
        await asyncio.sleep(60.0)
        assert (len(pretence.children), supervisor.table, diary.ends) == (1, [], [])
        assert await pretence.children[0].wait() == (-9 if ignores else -15)
        supervisor.begin(HAPPY)
        await asyncio.sleep(1.0)
        assert len(pretence.children) == 2
        await supervisor.end()

    loop.run_until_complete(main())


def test_process_that_waits_for_its_next_start_can_be_retired(
    loop: VirtualTimeLoop, pretence: Pretence, diary: Diary
) -> None:
    async def main() -> None:
        supervisor = Supervisor(pretence.start, diary)
        entry = supervisor.begin(HAPPY)
        for number in range(4):
            while len(pretence.children) <= number:
                await asyncio.sleep(0.05)
            pretence.children[number].end(1)
        await asyncio.sleep(0.1)
        assert entry.state is ProcessState.WAITING
        await supervisor.retire(entry)
        await asyncio.sleep(60.0)
        assert len(pretence.children) == 4
        await supervisor.end()

    loop.run_until_complete(main())
