"""The loader in virtual time: applications become agents, come back when their process has ended, and end when told."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from agents.client.program import ProgramNotValid
from agents.platform import Agent, AgentName, Container, Directory, Ending, Kinds, Outcome
from agents.platform.container.context import AgentEnd
from agents.services.loaded import KIND
from agents.services.loader import Loader
from bus import MemoryBus, Refused
from tests.agents.services.worlds import TEAM, World

LOADER = AgentName("loader", TEAM)
PATROL = AgentName("patrol", "apps")


class Application(Agent):
    """An application as it looks from outside; its setup fails for as long as it is broken."""

    services = ("application",)
    is_broken = False

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any]) -> None:
        super().__init__(name, properties)

    async def setup(self) -> None:
        if Application.is_broken:
            raise ProgramNotValid("patrol.py, line 3: '(' was never closed")


class Applications(Kinds):
    """Where they are found."""

    def find(self, kind: str) -> type[Agent]:
        assert kind == KIND
        return Application


class Host:
    """`acromovi up` as a loader sees it: has containers, which can be killed."""

    def __init__(self, world: World, folder: Path) -> None:
        self.world = world
        self.kinds = Applications([folder])
        self.containers: dict[str, Container] = {}
        self.ended: list[str] = []
        self._killed: list[Container] = []
        MemoryBus(world.network).serve(f"{TEAM}/host/control", self.answer)

    def answer(self, asked: dict[str, Any]) -> dict[str, Any]:
        name = asked["container"]
        if asked["do"] == "start":
            self.begin(name)
        elif name not in self.containers:
            raise Refused(f"there is no container {name!r}")
        else:
            self.ended.append(name)
            self.world.loop.create_task(self.containers.pop(name).close())
        return {}

    def begin(self, name: str) -> None:
        """As a process does that begins."""
        self.world.loop.call_later(1.0, self._show, name)

    def kill(self, name: str) -> None:
        """Its process dies, and another begins."""
        self._killed.append(self.containers.pop(name))
        self._killed[-1].bus.close()
        self.begin(name)

    def close(self) -> None:
        for container in (*self.containers.values(), *self._killed):
            self.world.run(container.close())

    def _show(self, name: str) -> None:
        self.containers[name] = self.world.container(name, kinds=self.kinds)
        self.containers[name].show()


class Loading:
    """A loader in a world with a host, and a folder in which patrol.py lies."""

    def __init__(self, world: World, folder: Path, properties: Mapping[str, Any] | None = None) -> None:
        Application.is_broken = False
        (folder / "patrol.py").write_text("def main(team): ...\n")
        self.world = world
        self.folder = folder
        self.properties = properties
        self.host = Host(world, folder)
        self.services = world.container("loading", TEAM, Kinds([folder]))
        self.begin()

    def begin(self) -> None:
        self.world.run(self.services.start(Loader(LOADER, self.properties)))

    def load(self, **arguments: Any) -> Outcome:
        return self.world.ask(LOADER, "load", **{"application": "patrol", **arguments})

    def loaded(self) -> dict[str, Any]:
        return {row["name"]: row for row in self.world.ask(LOADER, "loaded").value()}

    def lives(self, name: AgentName = PATROL) -> bool:
        with Directory(self.world.lab.bus) as directory:
            return directory.knows(name)

    def close(self) -> None:
        self.world.run(self.services.close())
        self.host.close()


@pytest.fixture
def loading(world: World, tmp_path: Path) -> Any:
    loading = Loading(world, tmp_path)
    yield loading
    loading.close()


def test_an_application_becomes_an_agent_in_a_process_of_its_own(loading: Loading) -> None:
    done = loading.load(arguments={"robot": "happy"}).value()
    assert done == {
        "name": "patrol@apps",
        "application": "patrol",
        "arguments": {"robot": "happy"},
        "container": "patrol-apps",
        "is_there": True,
        "why": None,
    }
    assert list(loading.host.containers) == ["patrol-apps"]
    agent = loading.host.containers["patrol-apps"].agent(PATROL)
    assert agent.properties == {"program": "patrol", "arguments": {"robot": "happy"}, "loader": str(LOADER)}
    assert loading.loaded() == {"patrol@apps": done}


def test_one_that_is_unloaded_ends_and_so_does_its_process(loading: Loading) -> None:
    loading.load(name="night@lab")
    assert loading.world.ask(LOADER, "unload", name="night@lab").value() == {"name": "night@lab"}
    assert loading.host.ended == ["night-lab"]
    assert loading.loaded() == {}
    again = loading.world.ask(LOADER, "unload", name="night@lab")
    assert (again.ending, again.why) == (Ending.REFUSED, "night@lab has not been loaded here; nothing has")


def test_one_that_is_stopped_by_somebody_or_ends_by_itself_is_not_missed(loading: Loading) -> None:
    loading.load()
    loading.world.run(loading.host.containers["patrol-apps"].stop(PATROL))
    loading.world.pass_time(60.0)
    assert loading.loaded() == {}
    assert loading.host.ended == ["patrol-apps"]


def test_one_whose_process_ends_is_started_again_in_the_next(loading: Loading) -> None:
    loading.load(arguments={"robot": "happy"})
    loading.host.kill("patrol-apps")
    loading.world.pass_time(0.5)
    assert not loading.loaded()["patrol@apps"]["is_there"]
    loading.world.pass_time(1.0)
    assert loading.loaded()["patrol@apps"]["is_there"]
    agent = loading.host.containers["patrol-apps"].agent(PATROL)
    assert agent.properties["arguments"] == {"robot": "happy"}


def test_one_that_ends_its_process_again_and_again_is_given_up(world: World, tmp_path: Path) -> None:
    loading = Loading(world, tmp_path, {"restart": {"*": {"attempts": 3}}})
    loading.load()
    for _ in range(4):
        loading.host.kill("patrol-apps")
        loading.world.pass_time(10.0)
    assert loading.loaded() == {}
    assert loading.host.ended == ["patrol-apps"]
    assert world.reports[-1].what == "patrol@apps is given up: its process ends again and again"
    loading.close()


def test_one_that_has_failed_is_replaced_when_it_is_loaded_again(loading: Loading) -> None:
    loading.load()
    loading.world.run(loading.host.containers["patrol-apps"].stop(PATROL, AgentEnd.FAILED))
    loading.world.pass_time(10.0)
    assert not loading.loaded()["patrol@apps"]["is_there"]
    assert loading.load(arguments={"robot": "doc"}).is_done
    assert loading.loaded()["patrol@apps"]["arguments"] == {"robot": "doc"}
    assert loading.lives()


def test_a_loader_that_is_started_again_knows_what_it_has_loaded(loading: Loading) -> None:
    loading.load(arguments={"robot": "happy"})
    loading.world.run(loading.services.stop(LOADER))
    loading.begin()
    assert loading.loaded()["patrol@apps"]["arguments"] == {"robot": "happy"}
    loading.host.kill("patrol-apps")
    loading.world.pass_time(3.0)
    assert loading.loaded()["patrol@apps"]["is_there"]


def test_one_that_cannot_be_loaded_is_told_of_and_leaves_nothing_behind(loading: Loading) -> None:
    Application.is_broken = True
    failed = loading.load()
    assert failed.ending is Ending.FAILED
    assert failed.why.endswith("patrol.py, line 3: '(' was never closed")
    assert (loading.loaded(), loading.host.ended) == ({}, ["patrol-apps"])
    Application.is_broken = False
    assert loading.load().is_done


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ({"application": "/etc/passwd.py"}, "'/etc/passwd.py' names no application"),
        ({"application": "../patrol"}, "'../patrol' names no application"),
        ({"application": "petrol"}, "there is no application 'petrol' there; copy petrol.py into {folder}"),
        ({"sha256": "0" * 64}, "{folder}/patrol.py there is another program than yours; copy yours there"),
        ({"arguments": [1]}, "arguments are like"),
        ({"name": "a b@c"}, "'a b' cannot be a part of an agent's name"),
        ({"into": "nowhere"}, "there is no container 'nowhere'; those that are there: lab, loading"),
        ({"name": str(LOADER)}, "there is an agent loader@team already"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_begun(
    loading: Loading, arguments: dict[str, Any], why: str
) -> None:
    refused = loading.load(**arguments)
    assert refused.ending is Ending.REFUSED
    assert why.format(folder=loading.folder) in refused.why
    assert (loading.loaded(), loading.host.containers) == ({}, {})


def test_one_can_be_loaded_into_a_container_that_is_there(loading: Loading) -> None:
    shop = loading.world.container("shop", kinds=Applications())
    loading.world.loop.call_soon(shop.show)
    loading.world.pass_time(0.1)
    assert loading.load(application="elsewhere", name="patrol", into="shop").value()["container"] == "shop"
    assert loading.world.ask(LOADER, "unload", name="patrol").is_done
    assert (shop.agents, loading.host.ended, loading.lives()) == ([], [], False)
    loading.world.run(shop.close())


def test_without_a_host_it_says_what_to_do(world: World, tmp_path: Path) -> None:
    (tmp_path / "patrol.py").touch()
    loading = world.container("loading", TEAM, Kinds([tmp_path]))
    world.run(loading.start(Loader(LOADER)))
    failed = world.ask(LOADER, "load", application="patrol")
    assert "team was not started by acromovi up, so say into which container" in failed.why
    world.run(loading.close())


def test_a_team_without_folders_takes_only_what_acromovi_brings(world: World) -> None:
    loading = world.container("loading", TEAM)
    world.run(loading.start(Loader(LOADER)))
    refused = world.ask(LOADER, "load", application="patrol")
    assert (refused.ending, refused.why) == (
        Ending.REFUSED,
        "there is no application 'patrol' there; it takes none but those that Acromovi brings, unless it is started "
        "with --apps FOLDER",
    )
    assert "acromovi up" in world.ask(LOADER, "load", application="wander").why
    world.run(loading.close())


def test_nonsense_on_the_keys_it_hears_is_survived(loading: Loading) -> None:
    bus = MemoryBus(loading.world.network)
    bus.declare_alive("x/containers/@/alive")
    for report in ({"agent": 7}, {"ended": "stopped"}, {"agent": "patrol@apps", "what": 3}):
        bus.put("x/containers/y/reports", report)
    assert loading.load().is_done
