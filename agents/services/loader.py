"""The loader: it starts applications as agents, restarts them, and ends them.

Each gets a container of its own, a process that the team's host (`acromovi up`) starts for it, so that a program which
blocks or crashes affects no other. The monitor restarts an agent that fails in its container, the host restarts a
process that ends, and the loader restarts the application in it.

Loaded applications are recorded only in the directory, by the properties of their agents, so a loader that is restarted
knows them all.
"""

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar

from agents.client.application import SERVICE as APPLICATION
from agents.client.program import ProgramNotValid
from agents.client.team import PLATFORM
from agents.platform import Agent, AgentName, Directory, NameNotValid, OneShot, agree, request
from agents.platform.container.context import AgentEnd
from agents.platform.errors import in_words
from agents.platform.names import ALL_CONTAINERS, ContainerName
from agents.services.loaded import KIND, check
from agents.services.restarts import Restarts
from bus import BusError, NoAnswer, Refused
from bus.aio import hand_over
from bus.bus import Closeable

SERVICE = "loading"
MEETING_TIME = 0.3  # s in which a new session learns the present containers
PROCESS_TIME = 20.0  # s for the start of a container on a busy machine
START_TIME = 35.0  # s for an application to start; a container's own limit for a setup is 30 s
ANSWER_TIME = 3.0  # s for anything else
LAST_WORDS = 0.5  # s for a container to answer an order to stop an agent
CALM = 0.1  # s in which an agent comes back with its container, as after a cut line
LOOKS_BACK = (1.0, 3.0)  # s after which it looks again for whom it has loaded, on a machine that has much to do
MANY = 64  # reports that wait


@dataclass(slots=True)
class _Load:
    """One application. has_begun: whether it has ever been at work. why: the latest error."""

    name: AgentName
    program: str
    arguments: dict[str, Any]
    container: str
    sha256: str = ""
    has_begun: bool = False
    why: str = ""

    def properties(self, loader: AgentName) -> dict[str, Any]:
        """The properties of its agent."""
        sha256 = {"sha256": self.sha256} if self.sha256 else {}
        return {"program": self.program, "arguments": self.arguments, "loader": str(loader), **sha256}


@dataclass(slots=True)
class _Containers:
    """The containers that are present, by name; `changed` is set, and replaced, when one appears."""

    there: dict[str, ContainerName] = field(default_factory=dict)
    changed: asyncio.Event = field(default_factory=asyncio.Event)

    async def wait_for(self, name: str, within: float) -> ContainerName:
        """Return a container, once it is present.

        Raises:
            TimeoutError: It has not appeared.
        """
        async with asyncio.timeout(within):
            while name not in self.there:
                await self.changed.wait()
        return self.there[name]


class Loader(Agent):
    """Loads applications. Its property `restart` has the rules for those whose process has ended (`Restarts`)."""

    services: ClassVar[tuple[str, ...]] = (SERVICE,)

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._loads: dict[AgentName, _Load] = {}
        self._held_open: list[Closeable] = []

    async def setup(self) -> None:
        """Watch the containers, and find the applications that an earlier loader has loaded.

        Raises:
            ConfigError: The rules cannot be used.
        """
        loop = asyncio.get_running_loop()
        self._containers = _Containers()
        self._restarts = Restarts(self.properties.get("restart"), f"the restart rules of {self.name}")
        self._directory = Directory(self.bus)
        watching = self.bus.watch_alive(ALL_CONTAINERS, partial(hand_over, loop, self._follow_container))
        self._held_open += [self._directory, watching]
        self.listen("*/containers/*/reports", self._hear_report, keep=MANY)
        await asyncio.sleep(MEETING_TIME)
        await self._remember()
        for pause in LOOKS_BACK:
            self.add(OneShot(partial(self._remember, pause), "remember"))

    async def take_down(self) -> None:
        """Stop watching; the loaded applications continue."""
        for held in self._held_open:
            held.close()

    @request("load", agrees_itself=True)
    async def load(
        self, application: str, name: str = "", arguments: Any = None, into: str = "", sha256: str = ""
    ) -> dict[str, Any]:
        """Start an application as an agent: one in a folder of the team's host, or of Acromovi."""
        load = self._read(application, name, {} if arguments is None else arguments, into, sha256)
        before = self._loads.get(load.name)
        if self._directory.knows(load.name) or (before is not None and not before.has_begun):
            raise Refused(f"there is an agent {load.name} already; unload it, or give this one another name")
        agree()
        if before is not None and before.container != load.container:  # for example because it was given up
            await self._end_container(before)
        self._loads[load.name] = load
        try:
            if not into:
                await self._ask_host("start", load.container)
            await self._start(load, PROCESS_TIME)
        except Exception as err:
            await self._forget(load)
            raise Refused(
                err.why if isinstance(err, Refused) else f"{load.name} has not begun: {in_words(err)}"
            ) from err
        load.has_begun = True
        return self._row(load)

    @request("unload", agrees_itself=True)
    async def unload(self, name: str) -> dict[str, Any]:
        """End an application that was loaded."""
        load = self._loads.get(_agent_name(name))
        if load is None:
            known = ", ".join(map(str, sorted(self._loads))) or "nothing"
            raise Refused(f"{name} has not been loaded here; {known} has")
        agree()
        container = self._containers.there.get(load.container)
        if container is not None:
            with suppress(BusError, TimeoutError):  # it has ended, or its process ends now
                await self.query(container.control_key, {"do": "stop", "name": str(load.name)}, ANSWER_TIME)
        await self._forget(load)
        return {"name": str(load.name)}

    @request("loaded")
    async def loaded(self) -> list[dict[str, Any]]:
        """Return the loaded applications that have not been ended, whether each is at work, and its latest error."""
        return [self._row(load) for load in self._loads.values()]

    def _read(self, application: str, name: str, arguments: Any, into: str, sha256: str) -> _Load:
        if not isinstance(arguments, dict):
            raise Refused(f'arguments are like {{"robot": "happy"}}, not {arguments!r}')
        try:
            if not into:  # another container has its own folders
                check(application, self.home.folders, sha256)
        except ProgramNotValid as err:
            raise Refused(str(err)) from err
        if into and into not in self._containers.there:
            known = ", ".join(sorted(self._containers.there))
            raise Refused(f"there is no container {into!r}; those that are there: {known}")
        agent = _agent_name(name or application)
        return _Load(agent, application, arguments, into or _own_container(agent), sha256)

    def _row(self, load: _Load) -> dict[str, Any]:
        return {
            "name": str(load.name),
            "application": load.program,
            "arguments": load.arguments,
            "container": load.container,
            "is_there": self._directory.knows(load.name),
            "why": load.why or None,
        }

    async def _remember(self, after: float = 0.0) -> None:
        """Find in the directory what was loaded before this start."""
        await asyncio.sleep(after)
        for agent in await self._directory.search(APPLICATION, loader=str(self.name)):
            given = {"program": "", "arguments": {}, "sha256": "", **agent.properties}
            load = _Load(agent.name, given["program"], given["arguments"], agent.container, given["sha256"], True)
            self._loads.setdefault(agent.name, load)

    async def _start(self, load: _Load, within: float) -> None:
        """Start it in its container, as soon as that is present."""
        try:
            container = await self._containers.wait_for(load.container, within)
        except TimeoutError as err:
            raise Refused(f"the container {load.container} has not come within {within:g} s") from err
        order = {"do": "start", "name": str(load.name), "kind": KIND, "properties": load.properties(self.name)}
        await self.query(container.control_key, order, START_TIME)

    async def _start_again(self, load: _Load) -> None:
        """Start it in a container that has been restarted, by the rules."""
        await asyncio.sleep(CALM)
        if self._directory.knows(load.name):
            return
        now = asyncio.get_running_loop().time
        while (pause := self._restarts.failed(load.name, now())) is not None:
            await asyncio.sleep(pause)
            if self._loads.get(load.name) is not load or self._directory.knows(load.name):
                return
            self._restarts.attempted(load.name, now())
            load.why = ""
            try:
                await self._start(load, ANSWER_TIME)
            except Refused as err:
                load.why = err.why
            except (BusError, TimeoutError) as err:
                load.why = f"its container {load.container} does not answer: {in_words(err)}"
                return  # it begins again when that comes back
            else:
                return
        await self._forget(load)
        why = load.why or "its process ends again and again"
        self.home.report(self.name, f"{load.name} is given up: {why}", None)

    async def _let_go(self, load: _Load) -> None:
        """Stop supervising an application, which ends before its process does."""
        with suppress(TimeoutError):  # it has had its time to end
            async with asyncio.timeout(ANSWER_TIME):
                while self._directory.knows(load.name):
                    await asyncio.sleep(CALM)
        await asyncio.sleep(LAST_WORDS)
        await self._forget(load)

    async def _forget(self, load: _Load) -> None:
        if self._loads.get(load.name) is load:
            del self._loads[load.name]
            self._restarts.forget(load.name)
            await self._end_container(load)

    async def _end_container(self, load: _Load) -> None:
        """End the process of an application's own container."""
        if load.container == _own_container(load.name):
            with suppress(Refused, TimeoutError):  # it was never there, or whoever it is says so itself
                await self._ask_host("end", load.container)

    async def _ask_host(self, do: str, container: str) -> None:
        try:
            await self.query(f"{self.name.platform}/host/control", {"do": do, "container": container}, ANSWER_TIME)
        except NoAnswer as err:
            advice = "say into which container, such as one of: acromovi container workshop --apps FOLDER"
            raise Refused(f"{self.name.platform} was not started by acromovi up, so {advice}") from err

    def _follow_container(self, key: str, is_alive: bool) -> None:
        try:
            container = ContainerName.of_key(key)
        except NameNotValid:
            return  # a stranger's token
        if not is_alive:
            self._containers.there.pop(container.name, None)
            return
        self._containers.there[container.name] = container
        self._containers.changed.set()
        self._containers.changed = asyncio.Event()
        for load in self._loads.values():
            if load.container == container.name and load.has_begun:
                self.add(OneShot(partial(self._start_again, load), f"start {load.name} again"))

    async def _hear_report(self, report: dict[str, Any]) -> None:
        load = self._loads.get(_named_in(report))
        match report:
            case {"ended": AgentEnd.STOPPED | AgentEnd.MOVED} if load is not None and load.has_begun:
                self.add(OneShot(partial(self._let_go, load), f"let go of {load.name}"))
            case {"what": str(what), "error": str(error)} if load is not None:
                load.why = f"{what}: {error}"


def _agent_name(text: str) -> AgentName:
    """Return the name of an application's agent: `patrol` is `patrol@apps`.

    Raises:
        Refused: It is none.
    """
    try:
        return AgentName.parse(text if "@" in text else f"{text}@{PLATFORM}")
    except NameNotValid as err:
        raise Refused(str(err)) from err


def _own_container(agent: AgentName) -> str:
    return f"{agent.local}-{agent.platform}"


def _named_in(report: Mapping[str, Any]) -> AgentName:
    try:
        return AgentName.parse(str(report.get("agent")))
    except NameNotValid:
        return AgentName("nobody", "nowhere")
