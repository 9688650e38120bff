"""The state of a team: its robots, containers and agents, and the events when they appear, disappear or report errors.

No bus, no clock: the monitor passes on what it receives.
"""

from collections import Counter, defaultdict, deque
from collections.abc import Iterable
from dataclasses import dataclass

from agents.platform import AgentName, NameNotValid
from agents.platform.container.context import AgentEnd
from agents.platform.names import PASSER_BY, ContainerName
from agents.services.events import Level, Standing
from agents.services.streams import StreamPulses, Tell
from bus import keys
from bus.messages import DiagnosticArray, DiagnosticStatus, RobotState

CROWD = 20  # agents of one platform that come or go at once, from which on they are told of in one event
LATE = 100  # of those that went last, the word of their container that it was on purpose may come late
CONNECTED = "connected"
ON_PURPOSE = frozenset({AgentEnd.STOPPED, AgentEnd.CLOSED, AgentEnd.MOVED})


@dataclass(frozen=True, slots=True)
class ElementName:
    """The name of an element of a robot, such as its laser."""

    element: str
    robot: str


@dataclass(frozen=True, slots=True)
class RobotName:
    """The name of a robot."""

    robot: str


Named = AgentName | ContainerName | ElementName | RobotName


class Watching:
    """The present knowledge of a team.

    robots: states by name, for robots with a gateway; None until a state was received.
    streams: the states of the steady streams.
    """

    def __init__(self, tell: Tell) -> None:
        """Start without knowledge; `tell` is called with each event."""
        self.robots: dict[str, RobotState | None] = {}
        self.streams = StreamPulses(tell)
        self._tell = tell
        self._present: set[Named] = set()  # without the robots
        self._closing: set[Named] = set()  # told to end on purpose, and not gone yet
        self._missed: deque[Named] = deque(maxlen=LATE)  # gone, and nobody has told why
        self._levels: dict[str, tuple[int, str]] = {}  # by the names of the statuses of gateways

    @property
    def agents(self) -> list[AgentName]:
        """Those that are present."""
        return sorted(name for name in self._present if isinstance(name, AgentName))

    @property
    def containers(self) -> list[ContainerName]:
        """Those that are present."""
        return sorted(name for name in self._present if isinstance(name, ContainerName))

    def is_there(self, name: Named) -> bool:
        """Return whether an agent, a container or an element is present."""
        return name in self._present

    def changed(self, tokens: Iterable[tuple[str, bool]], is_beginning: bool = False) -> list[tuple[Named, bool]]:
        """Take tokens that have appeared and disappeared at the same time; return the changes.

        In the beginning those who are there are not told of one by one: they have not just come.
        """
        named = [(_named(key), is_alive) for key, is_alive in tokens]
        news = [(name, is_alive) for name, is_alive in named if name is not None and self._enter(name, is_alive)]
        told = [(name, is_alive) for name, is_alive in news if not (is_beginning and is_alive)]
        self._tell_of_agents([(name, is_alive) for name, is_alive in told if isinstance(name, AgentName)])
        for name, is_alive in told:
            match name:
                case ContainerName():
                    self._tell_of_container(name, is_alive)
                case ElementName():
                    self._tell_of_element(name, is_alive)
                case RobotName():
                    level = Level.OK if is_alive else Level.ERROR
                    self._tell(name.robot, f"the gateway of {name.robot} has {_MOVED[is_alive]}", level)
        return news

    def ended(self, who: AgentName | ContainerName, how: str) -> None:
        """Take a container's report that it, or one of its agents, ends: stopped, closed, moved or failed."""
        if how not in ON_PURPOSE:
            return
        if who in self._missed:  # its token was faster
            self._missed.remove(who)
            self._tell(who, f"{who} has been {how}", Level.OK)
        elif how == AgentEnd.MOVED:  # it lives on, and may be missed later
            self._tell(who, f"{who} has been moved", Level.OK)
        else:
            self._closing.add(who)

    def complained(self, agent: str, what: str, error: object) -> None:
        """Take a container's report of an error of one of its agents."""
        self._tell(agent, f"{agent}: {what}" + (f" ({error})" if error else ""), Level.WARNING)

    def state(self, robot: str, state: RobotState) -> None:
        """Take the state of a robot."""
        if robot not in self.robots:
            return  # its gateway has gone meanwhile, or is a stranger's
        before, self.robots[robot] = self.robots[robot], state
        known = set(before.faults) if before else set()
        for fault in state.faults:
            if fault not in known:
                self._tell(robot, f"{robot}: {fault}", Level.WARNING)
        if before and known and not state.faults:
            self._tell(robot, f"{robot}: all is well again", Level.OK)

    def diagnosed(self, array: DiagnosticArray) -> None:
        """Take a gateway's diagnostics of cables and elements; the robot as a whole is in its state."""
        for status in array.status:
            if status.name.endswith(": robot"):
                continue
            about = status.name.partition(":")[0]
            state = self.robots.get(about)
            if state is not None and status.message in state.faults:
                continue  # its state has told that
            told = self._levels.get(status.name, (DiagnosticStatus.OK, ""))
            self._levels[status.name] = (status.level, status.message)
            if status.level != told[0] or (status.level != DiagnosticStatus.OK and status.message != told[1]):
                self._tell(about, f"{status.name}: {status.message}", _LEVELS.get(status.level, Level.ERROR))

    def judge(self, now: float) -> None:
        """Update the states of all streams, periodically."""
        self.streams.judge(now, self._is_excused)

    def standings(self, now: float, robot: str | None = None) -> list[Standing]:
        """Return the states of all robots, containers and streams, or of those of one robot."""
        population = Counter(name.platform for name in self._present if isinstance(name, AgentName))
        robots = [_robot_standing(name, state) for name, state in sorted(self.robots.items()) if robot in (None, name)]
        containers = [
            Standing(f"container {container}", what="it lives", values={"agents": population[container.platform]})
            for container in self.containers
            if robot in (None, container.platform)
        ]
        return [*robots, *containers, *self.streams.standings(now, robot)]

    def population(self) -> str:
        """Return the numbers of robots, containers and agents, as text."""
        names = ", ".join(sorted(self.robots))
        robots = f"{_counted(len(self.robots), 'robot')} ({names})" if names else "no robots"
        containers, agents = _counted(len(self.containers), "container"), _counted(len(self.agents), "agent")
        return f"{robots}, {containers} and {agents}"

    def _enter(self, name: Named, is_alive: bool) -> bool:
        """Note who appeared or disappeared; return whether that is new."""
        if isinstance(name, RobotName):
            return self._enter_robot(name.robot, is_alive)
        if (name in self._present) == is_alive:
            return False
        (self._present.add if is_alive else self._present.discard)(name)
        return True

    def _enter_robot(self, robot: str, is_alive: bool) -> bool:
        if (robot in self.robots) == is_alive:
            return False
        if is_alive:
            self.robots[robot] = None
        else:
            del self.robots[robot]
            self._levels = {name: told for name, told in self._levels.items() if name.partition(":")[0] != robot}
        return True

    def _tell_of_agents(self, news: list[tuple[AgentName, bool]]) -> None:
        crowds: defaultdict[tuple[str, bool, bool], list[AgentName]] = defaultdict(list)
        for agent, is_alive in news:
            crowds[agent.platform, is_alive, not is_alive and self._was_closing(agent)].append(agent)
        for (platform, is_alive, is_closing), agents in crowds.items():
            what = "been stopped" if is_closing else _MOVED[is_alive]
            level = Level.OK if is_alive or is_closing else Level.ERROR
            if len(agents) < CROWD:
                for agent in agents:
                    self._tell(agent, f"{agent} has {what}", level)
            else:
                some = ", ".join(agent.local for agent in agents[:5])
                self._tell(platform, f"{len(agents)} agents of {platform} have {what}: {some}, ...", level)

    def _tell_of_container(self, container: ContainerName, is_alive: bool) -> None:
        if not is_alive and self._was_closing(container):
            self._tell(container, f"the container {container} has been closed", Level.OK)
        else:
            level = Level.OK if is_alive else Level.ERROR
            self._tell(container, f"the container {container} has {_MOVED[is_alive]}", level)

    def _was_closing(self, name: Named) -> bool:
        """Return whether one that has gone was stopped on purpose."""
        if name in self._closing:
            self._closing.remove(name)
            return True
        self._missed.append(name)
        return False

    def _tell_of_element(self, name: ElementName, is_alive: bool) -> None:
        if is_alive:
            self._tell(name.robot, f"{name.robot} has shown its {name.element}", Level.OK)
        elif name.robot in self.robots:  # else its gateway has gone, which is news enough
            self._tell(name.robot, f"{name.robot} has lost its {name.element}", Level.WARNING)

    def _is_excused(self, key: str) -> bool:
        """Return whether a stream has a known reason to be silent."""
        robot, suffix = keys.split(key)
        state = self.robots.get(robot)
        if state is None or state.connection != CONNECTED:
            return suffix != keys.STATE.suffix or robot not in self.robots
        element = suffix
        if suffix.startswith("agents/"):
            agent = AgentName.of_key(key)
            if agent not in self._present:
                return True
            element = agent.local
        return element == keys.SONAR.suffix and not state.sonar


_MOVED = {True: "come", False: "gone"}
_LEVELS = {DiagnosticStatus.OK: Level.OK, DiagnosticStatus.WARN: Level.WARNING}


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _robot_standing(robot: str, state: RobotState | None) -> Standing:
    if state is None:
        return Standing(robot, Level.WARNING, "nothing has been heard of its state yet")
    if state.connection != CONNECTED:
        return Standing(robot, Level.ERROR, f"the robot is {state.connection}")
    level = Level.WARNING if state.faults else Level.OK
    return Standing(
        robot, level, "; ".join(state.faults) or "all is well", {"motors": state.motors, "estop": state.estop}
    )


def _named(key: str) -> Named | None:
    """Return the owner of a token; None for foreign tokens, and for agents that live for one query."""
    try:
        match key.split("/"):
            case [_, "agents" | "containers", name, "alive"] if name.startswith(PASSER_BY):
                return None
            case [robot, "alive"]:
                return RobotName(robot)
            case [robot, "elements", element, "alive"]:
                return ElementName(element, robot)
            case [_, "agents", _, "alive"]:
                return AgentName.of_key(key)
            case [_, "containers", _, "alive"]:
                return ContainerName.of_key(key)
    except NameNotValid:
        pass  # a stranger's token
    return None
