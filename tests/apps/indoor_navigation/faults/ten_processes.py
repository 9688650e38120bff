"""A robot in a house with its navigation, each component as alone as in a process of its own, in virtual time.

Each has an event loop, a container and a place on the bus of its own, so that it can be killed or frozen alone. One
that goes on after it was frozen finds that time has passed, and what was said to it meanwhile.
"""

from collections.abc import Awaitable, Callable, Mapping
from math import hypot
from typing import Any, TypeVar

from acromovi.lockstep import Lockstep
from agents.platform import Agent, Container, Kinds, Outcome, Report
from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.component import query_key
from apps.indoor_navigation.wiring import ComponentSpec, load_wiring
from bus import BusError, MemoryBus, Refused, Sample, Subscription, keys
from bus.messages import decode, encode
from geometry import Pose2D
from p2os_emu.emulator import STEP
from p2os_emu.world import WorldSpec

T = TypeVar("T")

ROBOT = "happy"
FACE = f"user_interface@{ROBOT}"
SLICE = 2 * STEP  # s in which each process runs after the other
CONNECTING = 3.0  # s in which a robot is connected and its sensors have been heard
LONG = 1000.0  # s


class FreezableBus(MemoryBus):
    """A participant that answers nothing while it is frozen.

    is_frozen: whether. shift: m, by which odometry that it hears is off.
    """

    is_frozen = False
    shift = 0.0

    def subscribe(self, key_expr: str, on_sample: Callable[[Sample], None], *, urgent: bool = False) -> Subscription:
        """Hear odometry as it is falsified, and anything else as it is."""

        def hear_odometry(sample: Sample) -> None:
            message = decode(sample.type_name, sample.payload)
            message.pose.pose.position.x += self.shift
            on_sample(Sample(sample.key, encode(message), sample.encoding, sample.attachment))

        is_odometry = key_expr == keys.ODOM.key(ROBOT)
        return super().subscribe(key_expr, hear_odometry if is_odometry else on_sample, urgent=urgent)

    def serve(
        self, key: str, answer: Callable[[dict[str, Any]], dict[str, Any] | bytes], *, urgent: bool = False
    ) -> Subscription:
        """Answer queries while not frozen."""

        def answer_if_awake(arguments: dict[str, Any]) -> dict[str, Any] | bytes:
            if self.is_frozen:
                raise Refused("nobody answers")
            return answer(arguments)

        return super().serve(key, answer_if_awake, urgent=urgent)


class Process:
    """One process with one agent."""

    def __init__(self, bus: FreezableBus, name: str, report: Callable[[Report], None], wall_time: Callable[[], float]):
        self.loop = VirtualTimeLoop()
        self.bus = bus
        self._container = self.do(self._live(name, report, wall_time))
        self._slept = 0.0

    async def _live(self, name: str, report: Callable[[Report], None], wall_time: Callable[[], float]) -> Container:
        return Container(self.bus, name, report, wall_time)

    def start(self, agent: Agent) -> None:
        """Let the agent live here."""
        assert self.do(self._container.start(agent))

    def do(self, work: Awaitable[T]) -> T:
        """Let this process alone come to the end of something."""

        async def done() -> T:
            return await work

        return self.loop.run_until_complete(done())

    def step(self) -> None:
        """Let a slice of time pass."""
        if self.bus.is_frozen:
            self._slept += SLICE
        else:
            self.loop.run_for(SLICE)

    def freeze(self) -> None:
        """Do nothing from now on, and say nothing."""
        self.bus.is_frozen = True

    def thaw(self) -> None:
        """Go on: time has passed."""
        self.bus.is_frozen = False
        self.loop.pass_time(self._slept)
        self._slept = 0.0

    def die(self) -> None:
        """Be gone from the bus without a word."""
        self.bus.close()
        self.do(self._container.close())
        self.loop.close()


class House:
    """One robot, its navigation, and a person. x and y of goals are in the world, m.

    reports: what went wrong in the components, in words.
    """

    def __init__(self, world: WorldSpec, model: str = "p2dx", *, seed: int = 0) -> None:
        self.reports: list[str] = []
        self.lockstep = Lockstep(world, {ROBOT: model}, fits={ROBOT: "laser"}, seed=seed, perfect=True)
        self.begin = self.lockstep.truth(ROBOT)
        self.processes: dict[str, Process] = {}
        self.bus = self._bus()
        self._parts = {part.local: part for part in load_wiring().parts}
        self.run(1.0)
        for local in self._parts:
            self.start(local)
        self._person = Agent("person@terminal")
        self.processes["person"] = self._process("person")
        self.processes["person"].start(self._person)
        self.run(CONNECTING)

    @property
    def components(self) -> list[str]:
        """The names of all components."""
        return list(self._parts)

    @property
    def pose(self) -> Pose2D:
        """Where the robot truly is."""
        return self.lockstep.truth(ROBOT)

    def run(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / SLICE)):
            self.lockstep.run(SLICE)
            for process in self.processes.values():
                process.step()

    def start(self, local: str) -> None:
        """Let a component live that does not; as it is when its program is started again."""
        part: ComponentSpec = self._parts[local]
        process = self._process(local)
        process.start(Kinds().find(part.kind)(part.agent(ROBOT), part.properties))
        self.processes[local] = process

    def kill(self, local: str) -> None:
        """The process of a component is killed."""
        self.processes.pop(local).die()

    def ask(self, request: str, **given: Any) -> Outcome:
        """A person's request to the navigation, and time until it is answered."""
        return self.until(self.begin_to_ask(request, **given))

    def begin_to_ask(self, request: str, **given: Any) -> "Asked":
        """Likewise, and no time passes."""
        asked = Asked()
        loop = self.processes["person"].loop

        async def ask() -> None:
            asked.outcome = await self._person.request(FACE, request, reply_within=LONG, **given)

        asked.task = loop.create_task(ask())
        return asked

    def until(self, asked: "Asked", limit: float = 200.0) -> Outcome:
        """Let time pass until a request has ended.

        Raises:
            TimeoutError: It has not within `limit` s.
        """
        deadline = self.lockstep.time + limit
        while asked.outcome is None:
            if self.lockstep.time > deadline:
                raise TimeoutError(f"no answer within {limit} s; {self.state()}")
            self.run(0.1)
        return asked.outcome

    def go(self, x: float, y: float) -> str:
        """Send the robot somewhere; the mission's name."""
        place = self.begin.locate(x, y)
        return str(self.ask("go", x=place[0], y=place[1]).value()["mission"])

    def end_of(self, mission: str, limit: float = 200.0) -> dict[str, Any]:
        """Wait until a mission has ended, and say how."""
        found: dict[str, Any] = self.until(self.begin_to_ask("wait", mission=mission), limit).value()
        return found

    def state(self) -> Mapping[str, Any]:
        """What path planning says; nothing where it is not there."""
        try:
            return self.bus.query(query_key(ROBOT, "path_planning", "state"))[0].value
        except BusError:
            return {}

    def apart(self, x: float, y: float) -> float:
        """How far the robot truly is from a place, m."""
        return hypot(self.pose.x - x, self.pose.y - y)

    def moved(self, seconds: float) -> float:
        """How far the robot comes within so many s from now on, m."""
        before = self.pose
        self.run(seconds)
        return self.apart(before.x, before.y)

    @property
    def touched(self) -> tuple[str, ...]:
        """What the robot has bumped into."""
        return tuple(touch.what for touch in self.lockstep.world.touches(ROBOT).last)

    def close(self) -> None:
        """End everything."""
        for process in self.processes.values():
            process.die()
        self.lockstep.close()

    def _process(self, local: str) -> Process:
        return Process(self._bus(), f"{ROBOT}-{local}", self._note, lambda: self.lockstep.time)

    def _bus(self) -> FreezableBus:
        bus = self.lockstep.bus()
        assert isinstance(bus, MemoryBus)
        return FreezableBus(bus.network)

    def _note(self, report: Report) -> None:
        self.reports.append(f"{self.lockstep.time:.1f} s {report.agent}: {report.what}: {report.error}")


class Asked:
    """A request under way. outcome: None until it has ended."""

    outcome: Outcome | None = None
    task: Any = None
