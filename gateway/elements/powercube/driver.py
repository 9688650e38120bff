"""The driver of an arm of PowerCube modules on a cable of its own: bytes and time in, events and bytes out.

The modules are asked for state and position ten times a second, which also resets their watchdogs. After an
interruption of the gateway or the cable, the driver begins by stopping every module.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Any

from gateway.elements.arm.joint_limits import JointLimits
from gateway.elements.powercube.line import CubeLine, ModuleAnswer
from gateway.errors import CommandRefused
from gateway.events import ArmSeen, ElementFound, ElementLost, ElementSilent, Event
from p2os.accessories.arm_model import ArmModel
from p2os.accessories.powercube import (
    CubeCommand,
    CubeState,
    ModuleOutcome,
    ModuleParameter,
    ModuleRequest,
    MotionKind,
)

NAME = "arm"
PERIOD = 0.1
"""Seconds between two rounds of questions."""
PATIENCE = 1.0
"""Seconds without an answer of a module after which the arm is lost; and after which a search has failed."""
LONGEST_SILENCE = 0.5
"""Seconds between two calls, beyond which the driver distrusts itself."""
SLOWEST = 0.01
"""rad/s and m/s."""
REFUSAL_SHOWN = 5.0
"""Seconds for which a motion that a module refused counts among the faults."""
ROUNDS_AT_REST = 2
"""After which an arm that parks has arrived."""

STOP_MODULE = ModuleRequest(CubeCommand.MOVE, MotionKind.VELOCITY_ACKNOWLEDGED, 0.0)
FIGURES = (ModuleParameter.MINIMUM, ModuleParameter.MAXIMUM, ModuleParameter.MOST_VELOCITY)
WHY = {
    CubeState.LAGS: "could not follow",
    CubeState.SILENCE: "heard nothing from the gateway for too long",
    CubeState.ERROR: "reports an error",
    CubeState.HALTED: "was halted by a command",
}
"""What has halted a module, the most specific first."""
SWITCH_ON = 'send arm {"do": "power", "on": true}'


@dataclass(slots=True)
class _Module:
    """The state of one module.

    answered_at: s. state, position: as last heard. figures: what does not change. speed: rad/s or m/s, set last.
    """

    answered_at: float
    state: CubeState | None = None
    position: float | None = None
    figures: dict[int, float] = field(default_factory=dict)
    speed: float | None = None

    @property
    def is_known(self) -> bool:
        """All values are known that an order needs."""
        return self.state is not None and self.position is not None and len(self.figures) == len(FIGURES)

    def has(self, state: CubeState) -> bool:
        """Return whether it was in a state by its last answer."""
        return self.state is not None and state in self.state


class PowerCubeDriver:
    """One arm; an `ElementDriver`, and `ArmCommands`.

    model: of the arm. limits: of every joint, as the modules report, once the arm was found; the gripper's is the last.
    """

    def __init__(self, model: ArmModel, *, has_rate: bool = True) -> None:
        """Make ready to look for an arm.

        Args:
            model: Of the arm: how many joints there are before the gripper, and the rate of the line.
            has_rate: The port has a rate to set.
        Raises:
            ValueError: The model is of an arm without modules.
        """
        if model.cubes is None:
            raise ValueError(f"the arm {model.name!r} is not made of modules")
        self.model = model
        self.baud = model.cubes.baud if has_rate else 0
        self.deadline = inf
        self.has_port = False
        self.is_connected = False
        self.damaged: Counter[str] = Counter()
        self.lost: Counter[str] = Counter()
        self.limits: Sequence[JointLimits] = ()
        self._gripper = len(model.joints) + 1
        self._line = CubeLine(self.damaged)
        self._modules: dict[int, _Module] = {}
        self._unanswered: set[int] = set()  # in this round
        self._events: list[Event] = []
        self._last_run: float | None = None
        self._search_until = inf
        self._rounds_at_rest: int | None = None  # while it parks
        self._refusal = (-inf, "")

    # The port's side.

    @property
    def is_moving(self) -> bool:
        """A module moves, by its last answer."""
        return self.is_connected and any(module.has(CubeState.MOVING) for module in self._modules.values())

    @property
    def stopping_bytes(self) -> bytes:
        """The requests that stop every module."""
        return b"".join(STOP_MODULE.encode(number) for number in self._modules)

    @property
    def closing_bytes(self) -> bytes:
        """Empty: an arm that stands holds its position."""
        return b""

    def port_opened(self, now: float) -> None:
        """Begin: the port is open."""
        self._last_run = now
        self.has_port = True
        self._begin(now)

    def port_lost(self, reason: str, now: float) -> None:
        """Note that the port is lost, and why. `receive` reports what follows."""
        self._last_run = now
        self.has_port = False
        self._lose(reason)
        self.deadline = inf

    def receive(self, data: bytes, now: float) -> list[Event]:
        """Take bytes as read; none lets time pass. now: steady time, s."""
        if self._wake(now):
            data = b""  # of unknown age
        for heard in self._line.receive(data):
            if heard.module in self._modules:
                self._take(heard, self._modules[heard.module], now)
        if self.has_port and now >= self.deadline:
            self._begin_round(now)
        events = self._events[:]
        self._events.clear()
        return events

    def bytes_due(self, now: float) -> bytes:
        """Take what must be written now."""
        self._wake(now)
        return self._line.bytes_due() if self.has_port else b""

    # The bus's side.

    def faults(self) -> Sequence[str]:
        """Return what is wrong with the arm, a sentence each."""
        if not self.is_connected:
            return ["the arm does not answer" if self.has_port else "the arm's port is gone"]
        at, refusal = self._refusal
        is_news = self._last_run is not None and self._last_run - at < REFUSAL_SHOWN
        return [*self._halted(), *([refusal] if is_news else ())]

    def figures(self) -> Mapping[str, Any]:
        """Return the values for diagnostics, beside the counters."""
        return {"baud": self.baud, "unanswered orders": self._line.unanswered}

    def move(self, targets: Mapping[int, float], speed: float | None, now: float) -> None:
        """Send joints to their targets, rad (m), each turning one at `speed`, rad/s; at their fastest if None.

        Raises:
            CommandRefused: The arm does not answer, is halted, or does not know where it is.
        """
        self._check_ready(now)
        if not all(module.has(CubeState.HOMED) for module in self._modules.values()):
            raise CommandRefused('the arm does not know where its joints are; send arm {"do": "home"}')
        for joint, place in targets.items():
            number, module, limits = joint + 1, self._modules[joint + 1], self.limits[joint]
            pace = limits.fastest if speed is None or limits.slides else speed
            if module.speed != pace:
                module.speed = pace
                self._line.order(number, ModuleRequest(CubeCommand.SET, ModuleParameter.RAMP_VELOCITY, pace), now)
            self._line.order(number, ModuleRequest(CubeCommand.MOVE, MotionKind.RAMP_ACKNOWLEDGED, place), now)

    def home(self, now: float) -> None:
        """Send every joint to its zero, at the speed set last.

        Raises:
            CommandRefused: The arm does not answer, or is halted.
        """
        self._check_ready(now)
        self._line.drop_orders()
        self._order_all(ModuleRequest(CubeCommand.HOME), now)

    def park(self, now: float) -> None:
        """Send every joint to its zero, then put on the brakes.

        Raises:
            CommandRefused: As `home`.
        """
        self.home(now)
        self._rounds_at_rest = 0

    def duration(self, targets: Mapping[int, float] | None, speed: float | None) -> float:
        """Return the expected duration until the joints are at their targets, s; their zeros if None."""
        if targets is None:
            targets = dict.fromkeys(range(len(self.limits)), 0.0)
        times = []
        for joint, place in targets.items():
            limits, module = self.limits[joint], self._modules[joint + 1]
            pace = limits.fastest if speed is None or limits.slides else speed
            times.append(abs(place - (module.position or 0.0)) / pace)
        return max(times, default=0.0)

    def halt(self, now: float) -> None:
        """Let every joint stand where it is, as soon as its ramp lets it."""
        self._wake(now)
        self._rounds_at_rest = None
        self._line.drop_orders()
        for number, module in self._modules.items():
            if not module.has(CubeState.HALTED):
                self._line.order(number, STOP_MODULE, now)

    def switch(self, on: bool, now: float) -> None:
        """End what has halted the modules; or halt them at once, on their brakes.

        Raises:
            CommandRefused: The arm does not answer.
        """
        self._check_link(now)
        self._rounds_at_rest = None
        self._line.drop_orders()
        self._order_all(ModuleRequest(CubeCommand.RESET if on else CubeCommand.HALT), now)

    # Inside.

    def _wake(self, now: float) -> bool:
        """Detect that the last call is too long ago; return whether the connection begins again."""
        silence = 0.0 if self._last_run is None else now - self._last_run
        self._last_run = now
        if silence <= LONGEST_SILENCE or not self.has_port:
            return False
        self._lose("the gateway itself was frozen")
        self._begin(now)
        return True

    def _begin(self, now: float) -> None:
        self._line.clear()
        self._modules = {number: _Module(now) for number in range(1, self._gripper + 1)}
        self._search_until = now + PATIENCE
        self._rounds_at_rest = None
        for number in self._modules:
            self._line.ask(number, STOP_MODULE)
        self._begin_round(now)

    def _lose(self, reason: str) -> None:
        if self.is_connected:
            self.lost[reason] += 1
            self._events.append(ElementLost(NAME, reason))
        self.is_connected = False

    def _begin_round(self, now: float) -> None:
        """Check which modules answer, then ask all of them."""
        self.deadline = now + PERIOD
        if self.is_connected:
            silent = [n for n, module in self._modules.items() if now - module.answered_at > PATIENCE]
            if silent:
                self._lose(f"module {silent[0]} no longer answers")
                self._begin(now)
                return
        elif now >= self._search_until:
            self._search_until = now + PATIENCE
            self._events.append(ElementSilent(NAME))
        self._line.repeat(now)
        self._unanswered = set(self._modules)
        for number, module in self._modules.items():
            missing = [each for each in FIGURES if each not in module.figures]
            for parameter in (ModuleParameter.STATE, ModuleParameter.POSITION, *missing):
                self._line.ask(number, ModuleRequest(CubeCommand.GET, parameter))

    def _take(self, heard: ModuleAnswer, module: _Module, now: float) -> None:
        number, (command, about, outcome, value, state) = heard
        module.answered_at = now
        if state is not None:
            module.state = state
        if outcome is ModuleOutcome.REFUSED:
            self._refusal = now, f"module {number} refused a request"
        if value is not None and command == CubeCommand.GET and about in FIGURES:
            module.figures[about] = value
        elif value is not None and about not in FIGURES:
            module.position = value
        if command == CubeCommand.GET and about == ModuleParameter.POSITION:
            self._unanswered.discard(number)
            if not self._unanswered:
                self._end_round()

    def _end_round(self) -> None:
        """Report the arm: all modules have answered."""
        modules = self._modules.values()
        if not all(module.is_known for module in modules):
            return
        if not self.is_connected:
            self.is_connected = True
            self.limits = tuple(self._limits(number, module.figures) for number, module in self._modules.items())
            self._events.append(ElementFound(NAME, self.baud))
        moving = tuple(module.has(CubeState.MOVING) for module in modules)
        self._events.append(
            ArmSeen(
                not any(module.has(CubeState.HALTED) for module in modules),
                all(module.has(CubeState.HOMED) for module in modules),
                moving,
                tuple(module.position or 0.0 for module in modules),
            )
        )
        if self._rounds_at_rest is not None:
            self._rounds_at_rest = 0 if any(moving) or self._line.has_orders else self._rounds_at_rest + 1
            if self._rounds_at_rest >= ROUNDS_AT_REST and self._last_run is not None:
                self._rounds_at_rest = None
                self._order_all(ModuleRequest(CubeCommand.HALT), self._last_run)

    def _limits(self, number: int, figures: Mapping[int, float]) -> JointLimits:
        lower, upper, fastest = (figures[each] for each in FIGURES)
        return JointLimits(lower, upper, SLOWEST, fastest, slides=number == self._gripper)

    def _order_all(self, request: ModuleRequest, now: float) -> None:
        for number in self._modules:
            self._line.order(number, request, now)

    def _check_link(self, now: float) -> None:
        self._wake(now)
        if not self.is_connected:
            raise CommandRefused("the arm does not answer; the gateway goes on looking for it")

    def _check_ready(self, now: float) -> None:
        self._check_link(now)
        self._rounds_at_rest = None
        halted = self._halted()
        if halted:
            raise CommandRefused(f"the arm is halted: {halted[0]}; {SWITCH_ON}")

    def _halted(self) -> list[str]:
        return [
            f"module {number} {next(why for state, why in WHY.items() if module.has(state))}"
            for number, module in self._modules.items()
            if module.has(CubeState.HALTED)
        ]
