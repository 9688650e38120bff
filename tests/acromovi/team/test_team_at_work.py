"""How a team comes up and what it says, with processes that are none, in virtual time."""

import asyncio
import json
import re
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Protocol

import pytest

from acromovi.team.host_control import HostControl
from acromovi.team.identities import TeamOptions
from acromovi.team.plan import TeamPlan
from acromovi.team.team import STARTING_TIME, TeamAtWork, TeamFailed, TeamTimedOut
from agents.platform.names import AgentName
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, MemoryNetwork
from configs.team_file import GatewayProcesses, TeamFile, TeamRobot
from tests.acromovi.team.conftest import Pretence
from tests.waiting import DEADLINE

HAPPY = TeamRobot("happy", "p3dx-sh", fit=("laser",))
DOC = TeamRobot("doc", "p3dx-sh")
EMULATOR, SERVICES = "the emulator", "the container of services"
SHARED = "the gateway of the emulated robots"
PATROL = "the container patrol-apps"


class Stage:
    """A team whose processes are played by the test."""

    def __init__(
        self, folder: Path, pretence: Pretence, robots: tuple[TeamRobot, ...], gateways: GatewayProcesses
    ) -> None:
        self.pretence = pretence
        self.told: list[str] = []
        self.complaints: list[str] = []
        self.network = MemoryNetwork()
        self.bus = MemoryBus(self.network)
        team = TeamPlan("dwarfs", "dwarfs.toml", TeamFile(robots, gateways=gateways))
        self.team = TeamAtWork(
            team,
            TeamOptions(),
            folder,
            pretence.start,
            MemoryBus(self.network),
            self.told.append,
            self.complaints.append,
        )

    def serving(self) -> list[str]:
        """The lines about robots that serve."""
        return [line for line in self.told if " serves after " in line]

    async def says(self, name: str, **words: object) -> None:
        """Let a program say something once it is there."""
        for _ in range(int(DEADLINE)):
            if name in self.pretence.names():
                break
            await asyncio.sleep(0.1)
        self.pretence.of(name).say(json.dumps(words))

    async def emulator_is_ready(self, *names: str) -> None:
        robots = [{"name": name, "port": f"/dev/{name}"} for name in names]
        await self.says(EMULATOR, robots=robots, control="/tmp/control")

    async def serves(self, robot: str, *agents: str) -> None:
        """Let a robot's gateway connect, its container serve, and its agents live."""
        await self.says(f"the gateway of {robot}", event="connected")
        await self.says(f"the container of {robot}", container=robot)
        for agent in agents:
            self.bus.declare_alive(AgentName(agent, robot).alive_key)


Scene = Callable[[Stage], Awaitable[None]]


class Play(Protocol):
    """Plays a scene with a team of these robots."""

    def __call__(
        self, scene: Scene, robots: tuple[TeamRobot, ...], gateways: GatewayProcesses = GatewayProcesses.SEPARATE
    ) -> None: ...


@pytest.fixture
def play(loop: VirtualTimeLoop, tmp_path: Path, pretence: Pretence) -> Play:
    """Plays a scene with a team of these robots."""

    def run(
        scene: Scene, robots: tuple[TeamRobot, ...], gateways: GatewayProcesses = GatewayProcesses.SEPARATE
    ) -> None:
        async def main() -> None:
            stage = Stage(tmp_path, pretence, robots, gateways)
            with stage.team:
                stage.team.begin()
                try:
                    await scene(stage)
                finally:
                    await stage.team.supervisor.end()

        loop.run_until_complete(main())

    return run


def test_team_serves_when_every_robot_and_its_own_agents_do(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await stage.emulator_is_ready("happy", "doc")
        await stage.serves("happy", "base", "laser")
        await stage.serves("doc", "base")
        await asyncio.sleep(5.0)
        assert not coming_up.done()
        await stage.says(SERVICES, container="services")
        assert await coming_up == ["happy", "doc"]
        assert stage.team.control == "/tmp/control"
        assert [line.partition(" after ")[0] for line in stage.serving()] == ["happy serves", "doc serves"]
        assert stage.serving()[0].endswith(" s, 1 of 2: base, laser")
        assert stage.complaints == []

    play(scene, (HAPPY, DOC))


def test_lines_say_what_begins_who_is_ready_and_what_the_others_wait_for(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await asyncio.sleep(3.0)
        await stage.emulator_is_ready("happy", "doc")
        await stage.serves("doc", "base")
        await asyncio.sleep(3.0)
        await stage.says("the gateway of happy", event="connected")
        await asyncio.sleep(3.0)
        await stage.says("the container of happy", container="happy")
        stage.bus.declare_alive(AgentName("base", "happy").alive_key)
        await asyncio.sleep(3.0)
        stage.bus.declare_alive(AgentName("laser", "happy").alive_key)
        await asyncio.sleep(3.0)
        assert [re.sub(r"[\d.]+ s", "_ s", line) for line in stage.told] == [
            "starting 2 robots of dwarfs: happy, doc",
            "waiting for gateway (happy, doc)",
            "doc serves after _ s, 1 of 2: base",
            "waiting for gateway (happy)",
            "waiting for container (happy)",
            "waiting for laser (happy)",
            "happy serves after _ s, 2 of 2: base, laser",
            "waiting for the team's own agents",
        ]
        await stage.says(SERVICES, container="services")
        await coming_up

    play(scene, (HAPPY, DOC))


def test_a_line_that_stays_the_same_is_repeated_every_ten_seconds(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await asyncio.sleep(35.0)
        assert stage.told[1:] == ["waiting for gateway (happy)"] * 4
        coming_up.cancel()

    play(scene, (HAPPY,))


def test_emulator_comes_first_then_gateways_then_their_containers_then_the_teams_own(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await asyncio.sleep(1.0)
        assert stage.pretence.names() == [EMULATOR]
        await stage.emulator_is_ready("happy")
        await asyncio.sleep(1.0)
        assert stage.pretence.names()[1:] == ["the gateway of happy"]
        await stage.says("the gateway of happy", event="connected")
        await asyncio.sleep(1.0)
        assert stage.pretence.names()[2:] == ["the container of happy", SERVICES]
        coming_up.cancel()

    play(scene, (HAPPY,))


def test_part_that_never_shows_itself_is_told_and_waited_for_no_longer_than_patience(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await stage.emulator_is_ready("happy")
        await stage.serves("happy", "base")
        await stage.says(SERVICES, container="services")
        assert await coming_up == ["happy"]
        assert stage.serving()[0].endswith(": base, without laser")

    play(scene, (HAPPY,))


def test_real_robot_that_is_not_there_is_said_once_and_holds_nobody_up(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await stage.says("the gateway of iron", event="waiting", port="/dev/nowhere")
        await stage.emulator_is_ready("doc")
        await stage.serves("doc", "base")
        await stage.says(SERVICES, container="services")
        assert await coming_up == ["doc"]
        assert stage.complaints == ["iron is not there yet: waiting for /dev/nowhere"]
        await stage.serves("iron", "base")
        assert stage.told[-1] == "iron has come"
        assert "the container of iron" in stage.pretence.names()

    play(scene, (DOC, TeamRobot("iron", "p3dx", "/dev/nowhere")))


def test_real_robot_that_is_there_belongs_to_all(play: Play, tmp_path: Path) -> None:
    port = tmp_path / "ttyUSB0"
    port.touch()

    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await stage.says(SERVICES, container="services")
        await asyncio.sleep(5.0)
        assert not coming_up.done()
        await stage.serves("iron", "base")
        assert await coming_up == ["iron"]

    play(scene, (TeamRobot("iron", "p3dx", str(port)),))


def test_emulator_that_cannot_begin_ends_the_attempt_with_its_reason(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await asyncio.sleep(0.5)
        stage.pretence.of(EMULATOR).complain("p2os-emu: there is no world 'offfice'; did you mean office?")
        stage.pretence.of(EMULATOR).end(3)
        with pytest.raises(TeamFailed, match=r"^there is no world 'offfice'; did you mean office\?$"):
            await coming_up
        assert stage.complaints == []

    play(scene, (HAPPY,))


def test_gateway_that_ends_again_and_again_ends_the_attempt(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await stage.emulator_is_ready("happy")
        while not coming_up.done():
            await asyncio.sleep(1.0)
            if stage.pretence.names()[-1] == "the gateway of happy":
                stage.pretence.of("the gateway of happy").complain("p2os-gateway: no such model")
                stage.pretence.of("the gateway of happy").end(9)
        with pytest.raises(TeamFailed, match=r"^the gateway of happy: no such model$"):
            await coming_up

    play(scene, (HAPPY,))


async def late(stage: Stage, within: float = STARTING_TIME) -> list[str]:
    """The causes that are told when a team does not come up in time."""
    begun = asyncio.get_running_loop().time()
    with pytest.raises(TeamTimedOut, match=f"^dwarfs is not complete after {within:g} s") as caught:
        await stage.team.come_up(within)
    assert asyncio.get_running_loop().time() - begun < within + 1
    return str(caught.value).split("\n  ")[1:]


def test_team_that_is_not_complete_in_time_says_why_of_each_robot_that_is_missing(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(late(stage))
        await stage.emulator_is_ready("happy", "doc", "max", "sneezy")
        await stage.says("the gateway of happy", event="lost", reason="nobody answers on /dev/happy")
        await stage.serves("doc", "base")
        await stage.says("the gateway of max", event="connected")
        await stage.serves("sneezy")
        await asyncio.sleep(5.0)
        stage.pretence.of("the container of max").complain("acromovi container: the bus is slow")
        assert [re.sub(r"process \d+", "process _", cause) for cause in await coming_up] == [
            "happy: its gateway (process _) has lost the robot: nobody answers on /dev/happy",
            "max: its container (process _) does not answer: the bus is slow",
            "sneezy: its container has started no agent",
        ]

    play(scene, (HAPPY, DOC, TeamRobot("max", "powerbot"), TeamRobot("sneezy", "p3dx")))


def test_team_whose_emulator_reports_nothing_says_so(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        assert await late(stage, 5.0) == ["happy: the emulator (process 100) has not reported its ports"]

    play(scene, (HAPPY,))


def test_team_whose_real_robot_s_gateway_ends_says_how(play: Play, tmp_path: Path) -> None:
    port = tmp_path / "ttyUSB0"
    port.touch()

    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(late(stage, 5.0))
        await asyncio.sleep(0.5)
        stage.pretence.of("the gateway of iron").complain("p2os-gateway: no robot answers")
        stage.pretence.of("the gateway of iron").end(7)
        await stage.says(SERVICES, container="services")
        assert await coming_up == ["iron: its gateway ended: no robot answers"]

    play(scene, (TeamRobot("iron", "p3dx", str(port)),))


def test_causes_include_a_real_robot_that_is_not_waited_for(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(late(stage, 5.0))
        await stage.says("the gateway of iron", event="waiting", port="/dev/nowhere")
        assert await coming_up == [
            "doc: the emulator (process 100) has not reported its ports",
            "iron: there is no port /dev/nowhere; plug the robot in, or correct its port in the team's file",
        ]

    play(scene, (DOC, TeamRobot("iron", "p3dx", "/dev/nowhere")))


def test_team_whose_own_agents_do_not_serve_says_so(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(late(stage, 5.0))
        await stage.emulator_is_ready("doc")
        await stage.serves("doc", "base")
        assert await coming_up == ["the team's own agents: their container (process 103) does not answer"]

    play(scene, (DOC,))


def test_what_happens_to_a_team_at_work_is_told_and_goes_on(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await stage.emulator_is_ready("happy")
        await stage.serves("happy", "base", "laser")
        await stage.says(SERVICES, container="services")
        await coming_up
        stage.told.clear()
        await stage.says("the gateway of happy", event="element lost", element="laser")
        await stage.says("the gateway of happy", event="element found", element="laser")
        await stage.says("the gateway of happy", event="lost", reason="silence")
        await stage.says("the gateway of happy", event="connected")
        lines = ["happy has lost its laser", "happy has its laser", "happy is lost: silence", "happy is back"]
        assert stage.told == lines
        stage.pretence.of("the container of happy").end(-9)
        await asyncio.sleep(0.1)
        assert stage.complaints == ["the container of happy ended by SIGKILL; it is started again"]
        stage.pretence.of(EMULATOR).end(-11)
        await asyncio.sleep(0.1)
        await stage.emulator_is_ready("happy")
        await asyncio.sleep(1.0)
        assert stage.pretence.names().count("the gateway of happy") == 1

    play(scene, (HAPPY,))


def test_container_that_is_asked_for_comes_once_stays_and_ends_for_good(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await stage.emulator_is_ready("happy")
        await stage.serves("happy", "base", "laser")
        await stage.says(SERVICES, container="services")
        await coming_up
        for _ in range(2):
            stage.bus.query(HostControl.key("dwarfs"), {"do": "start", "container": "patrol-apps"})
        await asyncio.sleep(0.1)
        stage.pretence.of(PATROL).end(-9)
        await asyncio.sleep(0.1)
        assert stage.pretence.names().count(PATROL) == 2
        assert stage.complaints == ["the container patrol-apps ended by SIGKILL; it is started again"]
        stage.bus.query(HostControl.key("dwarfs"), {"do": "end", "container": "patrol-apps"})
        await asyncio.sleep(60.0)
        assert stage.pretence.names().count(PATROL) == 2
        assert len(stage.complaints) == 1
        assert await coming_up == ["happy"]

    play(scene, (HAPPY,))


def test_process_that_ends_again_for_the_same_reason_is_told_of_once(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        why = "p2os-gateway: /tmp is a directory"
        await asyncio.sleep(0.5)
        for number in range(4):
            while stage.pretence.names().count("the gateway of iron") <= number:
                await asyncio.sleep(0.5)
            stage.pretence.of("the gateway of iron").complain(why)
            stage.pretence.of("the gateway of iron").end(4)
        await asyncio.sleep(0.1)
        assert stage.complaints == [
            "the gateway of iron: /tmp is a directory",
            "the gateway of iron ended; it is started again",
        ]
        coming_up.cancel()

    play(scene, (TeamRobot("iron", "p3dx", "/tmp"),))


def test_robot_that_stumbles_while_it_comes_up_is_not_told_as_lost(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await stage.emulator_is_ready("happy")
        await stage.says("the gateway of happy", event="connected")
        await stage.says("the gateway of happy", event="lost", reason="silence")
        await stage.says("the gateway of happy", event="connected")
        await stage.says(SERVICES, container="services")
        await stage.serves("happy", "base", "laser")
        await coming_up
        assert [line.partition(" after ")[0] for line in stage.serving()] == ["happy serves"]

    play(scene, (HAPPY,))


def test_complaint_is_repeated_only_when_it_changes(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await stage.emulator_is_ready("happy")
        await asyncio.sleep(1.0)
        for line in ("no laser", "no laser", "", "no laser", "no arm"):
            stage.pretence.of("the gateway of happy").complain(line)
        assert stage.complaints == ["the gateway of happy: no laser", "the gateway of happy: no arm"]
        coming_up.cancel()

    play(scene, (HAPPY,))


def test_robots_of_a_shared_gateway_come_and_go_each_for_itself(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up())
        await stage.emulator_is_ready("happy", "doc")
        for robot, element in (("doc", "base"), ("happy", "laser")):
            await stage.says(SHARED, event="connected", robot=robot)
            await stage.says(f"the container of {robot}", container=robot)
            stage.bus.declare_alive(AgentName(element, robot).alive_key)
        await stage.says(SERVICES, container="services")
        assert await coming_up == ["happy", "doc"]
        await stage.says(SHARED, event="lost", robot="doc", reason="silence")
        await stage.says(SHARED, event="element lost", robot="happy", element="laser")
        await stage.says(SHARED, event="connected", robot="doc")
        assert stage.told[-3:] == ["doc is lost: silence", "happy has lost its laser", "doc is back"]
        assert [name for name in stage.pretence.names() if "gateway" in name] == [SHARED]

    play(scene, (HAPPY, DOC), GatewayProcesses.SHARED)


def test_robot_that_a_shared_gateway_gives_up_gets_one_of_its_own(play: Play) -> None:
    async def scene(stage: Stage) -> None:
        coming_up = asyncio.ensure_future(stage.team.come_up(within=20.0))
        await stage.emulator_is_ready("happy", "doc")
        await stage.says(SHARED, event="connected", robot="doc")
        await stage.says(SHARED, event="ended", robot="happy", reason="the name is taken", exit_code=4)
        await stage.says("the gateway of happy", event="no robot", robot="happy", reason="no robot answers")
        with pytest.raises(TeamTimedOut) as told:
            await coming_up
        assert "happy: its gateway (process " in str(told.value)
        assert "has not connected to the robot: no robot answers" in str(told.value)
        await stage.says("the gateway of happy", event="connected", robot="happy")
        assert [name for name in stage.pretence.names() if "gateway" in name] == [SHARED, "the gateway of happy"]

    play(scene, (HAPPY, DOC), GatewayProcesses.SHARED)
