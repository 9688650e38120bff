"""What a team's host answers on the bus."""

import asyncio
from dataclasses import replace

import pytest

from acromovi.team.host_control import MOST_EXTRAS, HostControl
from acromovi.team.plan import PlannedProcess, ProcessKind
from acromovi.team.supervisor import ProcessRow, Supervisor
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, MemoryNetwork, NoAnswer, Refused
from tests.acromovi.team.conftest import Diary, Pretence

NAME = "patrol-apps"
PATROL = PlannedProcess("the container patrol-apps", ProcessKind.AGENTS, ("true",), container=NAME, is_extra=True)
HAPPY = PlannedProcess("the container of happy", ProcessKind.AGENTS, ("true",), ("happy",), container="happy")
EMULATOR = PlannedProcess("the emulator", ProcessKind.EMULATOR, ("true",))


class PretendedHands:
    """Notes what it is to do."""

    def __init__(self) -> None:
        self.done: list[tuple[str, object]] = []

    def restart(self, entry: ProcessRow) -> None:
        self.done.append(("restart", entry.program))

    def start(self, container: str) -> None:
        self.done.append(("start", container))

    def retire(self, entry: ProcessRow) -> None:
        self.done.append(("retire", entry.program))


def test_host_tells_its_table_and_has_a_container_started_again(
    loop: VirtualTimeLoop, pretence: Pretence, diary: Diary
) -> None:
    async def main() -> None:
        network = MemoryNetwork()
        asker, hands = MemoryBus(network), PretendedHands()
        supervisor = Supervisor(pretence.start, diary)
        with HostControl(MemoryBus(network), "dwarfs", supervisor, hands):
            for program in (EMULATOR, HAPPY):
                supervisor.begin(program)
            await asyncio.sleep(0.1)
            (answer,) = asker.query(HostControl.key("dwarfs"), {"do": "status"})
            assert answer.value["team"] == "dwarfs"
            emulator, happy = answer.value["processes"]
            assert (emulator["name"], emulator["container"], emulator["restarts"]) == ("the emulator", None, 0)
            assert (happy["container"], happy["state"], happy["pid"]) == ("happy", "running", 101)
            (answer,) = asker.query(HostControl.key("dwarfs"), {"do": "restart", "container": "happy"})
            assert answer.value == {"restarting": "happy"}
            assert hands.done == [("restart", HAPPY)]
        with pytest.raises(NoAnswer):
            asker.query(HostControl.key("dwarfs"), {"do": "status"})
        await supervisor.end()

    loop.run_until_complete(main())


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        ({"do": "restart", "container": "hapy"}, "no container 'hapy' in dwarfs; did you mean 'happy'"),
        ({"do": "restart", "container": "zzz"}, "they are happy"),
        ({"do": "start", "container": "happy"}, "the container of happy is one of dwarfs itself; take another name"),
        ({"do": "end", "container": "happy"}, "the container of happy is one of dwarfs itself, and ends with it"),
        ({"do": "end", "container": "patrol"}, "no container 'patrol' in dwarfs"),
        ({"do": "dance"}, '{"do": "status"}'),
        ({}, '{"do": "status"}'),
    ],
)
def test_host_refuses_what_it_cannot_do_in_one_sentence(
    loop: VirtualTimeLoop, pretence: Pretence, diary: Diary, asked: dict[str, str], why: str
) -> None:
    async def main() -> None:
        supervisor = Supervisor(pretence.start, diary)
        supervisor.begin(HAPPY)
        control = HostControl(MemoryBus(), "dwarfs", supervisor, PretendedHands())
        with pytest.raises(Refused, match=why):
            control.answer(asked)
        await supervisor.end()

    loop.run_until_complete(main())


def test_host_has_containers_that_are_asked_for_and_no_more_than_it_can_hold(
    loop: VirtualTimeLoop, pretence: Pretence, diary: Diary
) -> None:
    async def main() -> None:
        supervisor, hands = Supervisor(pretence.start, diary), PretendedHands()
        control = HostControl(MemoryBus(), "dwarfs", supervisor, hands)
        assert control.answer({"do": "start", "container": NAME}) == {"starting": NAME}
        supervisor.begin(PATROL)
        assert control.answer({"do": "start", "container": NAME}) == {"starting": NAME}
        assert control.answer({"do": "end", "container": NAME}) == {"ending": NAME}
        assert hands.done == [("start", NAME), ("retire", PATROL)]
        for number in range(1, MOST_EXTRAS):
            supervisor.begin(replace(PATROL, name=f"another {number}", container=f"another-{number}"))
        with pytest.raises(Refused, match="has 32 containers for applications, and starts no more"):
            control.answer({"do": "start", "container": "one-more"})
        await supervisor.end()

    loop.run_until_complete(main())


def test_token_shows_that_a_team_is_up(loop: VirtualTimeLoop, pretence: Pretence, diary: Diary) -> None:
    network, seen = MemoryNetwork(), []
    MemoryBus(network).watch_alive(HostControl.alive_key("dwarfs"), lambda key, is_there: seen.append(is_there))

    async def main() -> None:
        HostControl(MemoryBus(network), "dwarfs", Supervisor(pretence.start, diary), PretendedHands()).close()

    loop.run_until_complete(main())
    assert seen == [True, False]
