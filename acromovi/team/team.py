"""A running team: emulator, gateways and containers, started in the order of their dependencies."""

import asyncio
import json
from collections.abc import Callable, Coroutine, Sequence
from pathlib import Path
from typing import Any

from acromovi.team.causes import Causes, plain
from acromovi.team.host_control import HostControl
from acromovi.team.identities import TeamOptions
from acromovi.team.plan import PlannedProcess, ProcessKind, TeamPlan, TeamProcesses
from acromovi.team.processes import StartQueue
from acromovi.team.progress import ProgressLines
from acromovi.team.readiness import PATIENCE, Readiness
from acromovi.team.supervisor import ProcessRow, Start, Supervisor
from agents.platform.directory import Directory
from agents.platform.names import AgentName
from bus import Bus
from bus.aio import hand_over
from bus.bus import Closeable
from bus.secure import WARNING
from configs.team_file import TeamRobot

STARTING_TIME = 60.0  # s in which all must serve unless the command line says otherwise, on a small computer too
MOST_ENDS = 3  # of one process while the team comes up; more of the same will not help
TICK = 0.1  # s


class TeamFailed(Exception):
    """A team has not come up; the message says why in one sentence."""


class TeamTimedOut(TeamFailed):
    """A team has not come up in time; the message has a line with the cause for each robot that is missing."""


class TeamAtWork(Closeable):
    """Starts a team and reports its progress.

    control: the emulator's control socket, once it is there.
    """

    def __init__(
        self,
        team: TeamPlan,
        choices: TeamOptions,
        folder: Path,
        start: Start,
        bus: Bus,
        tell: Callable[[str], None],
        complain: Callable[[str], None],
    ) -> None:
        """Prepare, and watch the tokens on the bus.

        Args:
            team: Which.
            choices: Of the command line.
            folder: For ports, control socket and settings.
            start: Starts a program.
            bus: Where the team is.
            tell: Says what happens, in one line.
            complain: Says what goes wrong, in one line.
        """
        self.control: str | None = None
        self.console: str | None = None
        self._has_console = choices.console is not None
        self._team = team
        self._processes = TeamProcesses(team, choices, folder)
        self._tell = tell
        self._complain = complain
        self._loop = asyncio.get_running_loop()
        self._begun = self._loop.time()
        self._failure: str | None = None
        self._serves = False
        self._said: dict[str, str] = {}
        self._readiness = Readiness(team.robots)
        self._lines = ProgressLines(self._readiness, len(team.robots), tell, self._begun)
        self._reports: dict[str, str] = {}  # the last one of each program by its name, and of a gateway by its robot
        self._ports: dict[str, dict[str, Any]] = {}  # of the emulated robots
        self._lost: set[str] = set()  # and that they are lost
        self._under_way: set[asyncio.Future[None]] = set()  # what others have asked for
        self.supervisor = Supervisor(start, self)
        self._queue = StartQueue(self.supervisor.begin)
        self._open: Sequence[Closeable] = (
            Directory(bus, self._on_agent),
            HostControl(bus, team.name, self.supervisor, self),
        )

    def begin(self) -> None:
        """Start the first processes; the others follow as soon as they can."""
        robots = f"{len(self._team.robots)} robot{'s' if len(self._team.robots) > 1 else ''}"
        self._tell(f"starting {robots} of {self._team.name}: {', '.join(robot.name for robot in self._team.robots)}")
        self._processes.write_settings()
        if self._team.emulated:
            self._queue.add(self._processes.emulator())
        for robot in self._team.robots:
            if not robot.is_emulated:
                self._queue.add(self._processes.gateway(robot, {}))

    async def come_up(self, within: float = STARTING_TIME) -> list[str]:
        """Wait until all serve.

        All are the emulated robots, and those real ones that are there: whose port there is and who answer on it within
        `PATIENCE`. The others are served whenever they come.

        Args:
            within: s in which all must serve.
        Returns:
            The robots that serve.
        Raises:
            TeamFailed: One of them never will.
            TeamTimedOut: They do not serve in time.
        """
        while True:
            now = self._loop.time()
            self._add_services()
            serving = self._readiness.serving(now)
            if self._failure is not None:
                raise TeamFailed(self._failure)
            late = [robot for robot in self._team.robots if robot.name not in serving and self._is_due(robot, now)]
            self._lines.look(serving, [robot.name for robot in late], now)
            has_console = self.console is not None or not self._has_console
            if not late and self._readiness.services_serve and has_console:
                self._serves = True
                return serving
            if now - self._begun > within:
                raise TeamTimedOut(self._why_late(serving, within))
            await asyncio.sleep(TICK)

    def close(self) -> None:
        """Stop watching."""
        for each in self._open:
            each.close()

    # What the processes do, as the supervisor tells it.

    def heard(self, program: PlannedProcess, line: str) -> None:
        """A line of standard output: JSON, from all of ours."""
        try:
            said = json.loads(line)
        except ValueError:
            said = None
        self._queue.has_started(program)
        match program.stage, said:
            case ProcessKind.EMULATOR, {"robots": list(robots), "control": control}:
                self._emulator_is_there(robots, control)
            case ProcessKind.GATEWAY, {"event": str(event)}:
                self._gateway_said(program, event, said)
            case ProcessKind.AGENTS, {"container": str(name)}:
                self._readiness.container(name, True)
            case ProcessKind.AGENTS, {"console": str(address)}:
                if self._serves:
                    self._tell(f"the console is at {address}")
                self.console = address
            case _:
                self._tell(f"{program.name}: {line}")

    def complained(self, program: PlannedProcess, line: str) -> None:
        """A line of standard error, said once while it stays the same; not what this program itself has printed."""
        if line.startswith(WARNING):
            return
        if line.strip():
            self._reports[program.name] = plain(line.strip())
        if line.strip() and self._said.get(program.name) != line:
            self._said[program.name] = line
            if self._serves or program.stage is not ProcessKind.EMULATOR:  # before that it is the reason of the failure
                self._complain(f"{program.name}: {plain(line)}")

    def ended(self, entry: ProcessRow) -> None:
        """A process has ended unasked."""
        program = entry.program
        self._queue.has_started(program)
        if program.container:
            self._readiness.container(program.container, False)
        if not self._serves and (program.stage is ProcessKind.EMULATOR or self._has_failed(entry)):
            self._failure = f"{program.name}: {plain(entry.why)}" if program.robot else plain(entry.why)
        elif entry.ends == 1 or self._said.get(program.name) != entry.why or entry.why.startswith("ended "):
            self._complain(f"{program.name} {self._as_end(entry)}; it is started again")
            self._said[program.name] = entry.why

    def _as_end(self, entry: ProcessRow) -> str:
        """How a process ended, as the end of a sentence that begins with its name; not what it just said."""
        if entry.why.startswith("ended "):
            return entry.why
        return "ended" if self._said.get(entry.program.name) == entry.why else f"ended ({plain(entry.why)})"

    def _has_failed(self, entry: ProcessRow) -> bool:
        robots = [robot.name for robot in self._team.emulated]
        return entry.ends >= MOST_ENDS and (not entry.program.robot or entry.program.robot in robots)

    def _emulator_is_there(self, robots: Sequence[dict[str, Any]], control: str) -> None:
        self.control = control
        self._ports = {each["name"]: each for each in robots}
        for program in self._processes.gateways(self._ports):
            self._queue.add(program)  # once: after a new start of the emulator they find its ports again

    def _add_agents(self, robot: str) -> None:
        self._queue.add(self._processes.container(robot))
        if any(each.name == robot and each.navigation for each in self._team.robots):
            for program in self._processes.navigation(robot):
                self._queue.add(program)

    def _gateway_said(self, program: PlannedProcess, event: str, said: dict[str, Any]) -> None:
        robot = program.robot or str(said.get("robot"))
        if isinstance(said.get("reason"), str):
            self._reports[robot] = said["reason"]
        match event:
            case "connected":
                self._reports.pop(robot, None)
                self._readiness.connected(robot, self._loop.time())
                self._add_agents(robot)
                self._tell_of_return(robot)
            case "ended":  # of a shared one, which does not serve this robot again
                (own,) = (each for each in self._team.robots if each.name == robot)
                self._queue.add(self._processes.gateway(own, self._ports[robot]))
            case "waiting":
                self._complain(f"{robot} is not there yet: waiting for {said.get('port')}")
            case "lost":
                self._readiness.lost(robot)
                if robot in self._lines.told:  # before that it is still coming
                    self._lost.add(robot)
                    self._tell(f"{robot} is lost: {said.get('reason')}")
            case "element lost" if robot in self._lines.told:
                self._tell(f"{robot} has lost its {said.get('element')}")
            case "element found" if robot in self._lines.told:
                self._tell(f"{robot} has its {said.get('element')}")

    # While it comes up.

    def _add_services(self) -> None:
        """The team's own agents come last: what they look after should be there."""
        if self._may_have_services:
            self._queue.add(self._processes.services())
            if self._has_console:
                self._queue.add(self._processes.console(self.control))

    @property
    def _may_have_services(self) -> bool:
        return all(self._readiness[robot.name].is_connected for robot in self._team.emulated)

    def _is_due(self, robot: TeamRobot, now: float) -> bool:
        """Whether the team waits for this robot."""
        if robot.is_emulated or self._readiness[robot.name].is_in_touch:
            return True
        is_there = "://" in robot.port or Path(robot.port).exists()
        return is_there and now - self._begun < PATIENCE

    def _why_late(self, serving: Sequence[str], within: float) -> str:
        """The cause for each robot that is missing, a line each; those that are not waited for included."""
        causes = Causes(self.supervisor.table, self._reports)
        away = [robot for robot in self._team.robots if robot.name not in serving]
        lines = [f"{robot.name}: {causes.of(robot, self._readiness[robot.name])}" for robot in away]
        if not self._readiness.services_serve and self._may_have_services:
            lines.append(f"the team's own agents: {causes.of_services()}")
        if self._has_console and self.console is None:
            lines.append(f"the console: {self._reports.get('the console', 'it does not serve yet')}")
        return "\n  ".join([f"{self._team.name} is not complete after {within:g} s (--timeout):", *lines])

    def _tell_of_return(self, robot: str) -> None:
        if robot in self._lost:
            self._lost.remove(robot)
            self._tell(f"{robot} is back")
        elif self._serves and robot not in self._lines.told:
            self._lines.told.add(robot)
            self._tell(f"{robot} has come")

    # On the bus's thread.

    def _on_agent(self, name: AgentName, is_there: bool) -> None:
        def note() -> None:
            self._readiness.agent(name.platform, name.local, is_there, self._loop.time())

        hand_over(self._loop, note)

    def restart(self, entry: ProcessRow) -> None:
        """Schedule the restart of a process."""
        hand_over(self._loop, self._do, self.supervisor.restart, entry)

    def start(self, container: str) -> None:
        """Schedule the start of an extra container.

        Raises:
            KeyNotValid: Its name cannot be that of a container.
        """
        hand_over(self._loop, self._start, self._processes.extra(container))

    def retire(self, entry: ProcessRow) -> None:
        """Schedule the end of a process."""
        hand_over(self._loop, self._do, self.supervisor.retire, entry)

    def _start(self, program: PlannedProcess) -> None:
        if self.supervisor.container(program.container) is None:  # it may have been asked for twice
            self.supervisor.begin(program)

    def _do(self, work: Callable[[ProcessRow], Coroutine[Any, Any, None]], entry: ProcessRow) -> None:
        task = asyncio.ensure_future(work(entry))
        self._under_way.add(task)
        task.add_done_callback(self._under_way.discard)
