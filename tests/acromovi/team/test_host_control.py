"""What a team's host answers on the bus."""

import asyncio

import pytest

from acromovi.team.host_control import HostControl, alive_key, control_key
from acromovi.team.plan import Program, Stage
from acromovi.team.supervisor import Entry, Supervisor
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, MemoryNetwork, NoAnswer, Refused
from tests.acromovi.team.conftest import Diary, Pretence

HAPPY = Program("the container of happy", Stage.AGENTS, ("true",), "happy", container="happy")
EMULATOR = Program("the emulator", Stage.EMULATOR, ("true",))


def test_host_tells_its_table_and_has_a_container_started_again(
    loop: VirtualTimeLoop, pretence: Pretence, diary: Diary
) -> None:
    async def main() -> None:
        network = MemoryNetwork()
        asker, again = MemoryBus(network), list[Entry]()
        supervisor = Supervisor(pretence.start, diary)
        with HostControl(MemoryBus(network), "dwarfs", supervisor, again.append):
            for program in (EMULATOR, HAPPY):
                supervisor.begin(program)
            await asyncio.sleep(0.1)
            (answer,) = asker.query(control_key("dwarfs"), {"do": "status"})
            assert answer.value["team"] == "dwarfs"
            emulator, happy = answer.value["processes"]
            assert (emulator["name"], emulator["container"], emulator["restarts"]) == ("the emulator", None, 0)
            assert (happy["container"], happy["state"], happy["pid"]) == ("happy", "running", 101)
            (answer,) = asker.query(control_key("dwarfs"), {"do": "restart", "container": "happy"})
            assert answer.value == {"restarting": "happy"}
            assert [entry.program for entry in again] == [HAPPY]
        with pytest.raises(NoAnswer):
            asker.query(control_key("dwarfs"), {"do": "status"})
        await supervisor.end()

    loop.run_until_complete(main())


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        ({"do": "restart", "container": "hapy"}, "no container 'hapy' in dwarfs; did you mean 'happy'"),
        ({"do": "restart", "container": "zzz"}, "they are happy"),
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
        control = HostControl(MemoryBus(), "dwarfs", supervisor, lambda entry: None)
        with pytest.raises(Refused, match=why):
            control.answer(asked)
        await supervisor.end()

    loop.run_until_complete(main())


def test_token_shows_that_a_team_is_up(loop: VirtualTimeLoop, pretence: Pretence, diary: Diary) -> None:
    network, seen = MemoryNetwork(), []
    MemoryBus(network).watch_alive(alive_key("dwarfs"), lambda key, is_there: seen.append(is_there))

    async def main() -> None:
        HostControl(MemoryBus(network), "dwarfs", Supervisor(pretence.start, diary), lambda entry: None).close()

    loop.run_until_complete(main())
    assert seen == [True, False]
