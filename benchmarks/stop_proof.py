"""Does it stop when it must: every process of the chain killed or frozen in mid-drive, and every way a cable fails.

A robot drives at 0.5 m/s in an empty world, commanded over the bus ten times a second. Something happens; time and true
distance are taken from the emulator until the wheels stand, and they must go on standing.
"""

import argparse
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from acromovi.children import EmulatedRobots, emulator, end, gateway
from benchmarks.figures import Figure
from bus import ZenohBus, keys
from bus.heartbeat import SILENCE
from configs.defaults import default_bus

MODEL = "p3dx-sh"
SPEED = 0.5  # m/s
MOVE_SPEED = 0.75  # m/s, of a move when it happens; the robot is still speeding up then
STANDS = 0.005  # m/s; below it the wheels stand
STAYS_S = 1.0
TIMEOUT_S = 20.0
PAGE = "stop-proof.md"

FAR = 25.0  # m; a move that lasts longer than anything here
CMD_VEL_SILENCE_S = 0.5
WATCHDOG_S = 2.0
ACCELERATION = 0.3  # m/s2, of the firmware, and its deceleration
BRAKING_S = SPEED / ACCELERATION
EMERGENCY_BRAKING_S = 0.5  # motors at their strongest
REACTION_S = 0.25  # a SIP cycle and the way through the processes
MOTION_REACTION_S = 0.1  # a motion is stopped within 0.6 s of the last sign of life


@dataclass(slots=True)
class Chain:
    """Everything between a person and the wheels.

    application: sends velocities, or asks an agent for a long move. agents: the container, for such a move.
    """

    robots: EmulatedRobots
    gateway: subprocess.Popen[str]
    application: subprocess.Popen[str]
    agents: subprocess.Popen[str] | None
    router: subprocess.Popen[str] | None
    name: str


@dataclass(frozen=True, slots=True)
class Mishap:
    """Something that happens in mid-drive.

    notices: s until somebody must have noticed. brakes: s of braking after that. is_asked: an agent was asked for a
    long move, and carries it out; otherwise the application sends velocities.
    """

    name: str
    who_stops: str
    happen: Callable[[Chain], None]
    notices: float
    brakes: float = BRAKING_S
    has_router: bool = False
    is_asked: bool = False

    @property
    def speed(self) -> float:
        """Of the robot when it happens, m/s."""
        return MOVE_SPEED if self.is_asked else SPEED

    @property
    def delay(self) -> float:
        """The longest until the robot brakes, s."""
        return self.notices + (MOTION_REACTION_S if self.is_asked else REACTION_S)

    @property
    def top_speed(self) -> float:
        """Of the robot when it begins to brake, at most, m/s: in a move it speeds up until then."""
        return self.speed + (ACCELERATION * self.delay if self.is_asked else 0.0)

    @property
    def braking(self) -> float:
        """Longest time for braking, s."""
        return self.brakes * self.top_speed / SPEED

    @property
    def time(self) -> float:
        """The longest that it may take, s."""
        return self.delay + self.braking

    @property
    def distance(self) -> float:
        """The farthest that the robot may come, m."""
        return (self.speed + self.top_speed) / 2 * self.delay + self.top_speed * self.braking / 2


@dataclass(frozen=True, slots=True)
class Proof:
    """What was seen: time (s) and distance (m) until the wheels stood."""

    mishap: Mishap
    time: float
    distance: float


def _kill(process: subprocess.Popen[str]) -> None:
    process.kill()


def _freeze(process: subprocess.Popen[str]) -> None:
    os.kill(process.pid, signal.SIGSTOP)


def _agents(chain: Chain) -> subprocess.Popen[str]:
    assert chain.agents is not None  # `is_asked` of the mishap
    return chain.agents


def _router(chain: Chain) -> subprocess.Popen[str]:
    assert chain.router is not None  # `has_router` of the mishap
    return chain.router


def _fault(spec: str) -> Callable[[Chain], None]:
    def happen(chain: Chain) -> None:
        chain.robots.ask("fault", fault=spec)

    return happen


def _command(topic: keys.Topic, arguments: dict[str, object]) -> Callable[[Chain], None]:
    def happen(chain: Chain) -> None:
        with ZenohBus.open() as bus:
            bus.query(topic.key(chain.name), arguments)

    return happen


MISHAPS = (
    Mishap("application killed", "gateway", lambda chain: _kill(chain.application), CMD_VEL_SILENCE_S),
    Mishap("application frozen", "gateway", lambda chain: _freeze(chain.application), CMD_VEL_SILENCE_S),
    Mishap("router killed", "gateway", lambda chain: _kill(_router(chain)), CMD_VEL_SILENCE_S, has_router=True),
    Mishap("router frozen", "gateway", lambda chain: _freeze(_router(chain)), CMD_VEL_SILENCE_S, has_router=True),
    Mishap(
        "asker of a move killed", "gateway", lambda chain: _kill(chain.application), SILENCE, BRAKING_S, is_asked=True
    ),
    Mishap(
        "asker of a move frozen", "gateway", lambda chain: _freeze(chain.application), SILENCE, BRAKING_S, is_asked=True
    ),
    Mishap("agents killed in a move", "gateway", lambda chain: _kill(_agents(chain)), SILENCE, is_asked=True),
    Mishap("agents frozen in a move", "gateway", lambda chain: _freeze(_agents(chain)), SILENCE, is_asked=True),
    Mishap(
        "router killed in a move",
        "gateway",
        lambda chain: _kill(_router(chain)),
        SILENCE,
        has_router=True,
        is_asked=True,
    ),
    Mishap("gateway killed", "the robot's watchdog", lambda chain: _kill(chain.gateway), WATCHDOG_S),
    Mishap("gateway frozen", "the robot's watchdog", lambda chain: _freeze(chain.gateway), WATCHDOG_S),
    Mishap("gateway ended by SIGTERM", "gateway", lambda chain: chain.gateway.terminate(), 0.0),
    Mishap("cable cut", "the robot's watchdog", _fault("line-cut"), WATCHDOG_S),
    Mishap("adapter pulled out", "the robot's watchdog", _fault("hang-up@0+30"), WATCHDOG_S),
    Mishap("red STOP button", "the robot", _fault("stop-pressed"), 0.0, EMERGENCY_BRAKING_S),
    Mishap(
        "command/estop under a running stream",
        "gateway and robot",
        _command(keys.ESTOP, {"on": True}),
        0.0,
        EMERGENCY_BRAKING_S,
    ),
    Mishap("command/stop under a running stream", "gateway and robot", _command(keys.STOP, {}), 0.0),
)


def measure(options: argparse.Namespace) -> list[Figure]:
    """Let everything happen once, and write the page."""
    proofs = [_prove(index, mishap) for index, mishap in enumerate(MISHAPS)]
    options.out.mkdir(parents=True, exist_ok=True)
    _write_page(proofs, options.out / PAGE)
    return [figure for proof in proofs for figure in _figures(proof)]


def _prove(index: int, mishap: Mishap) -> Proof:
    with _driving(f"stop-proof-{index}", mishap) as chain:
        before = _truth(chain)
        mishap.happen(chain)
        after, x = _wait_until_it_stands(chain)
        return Proof(mishap, after - before[0], abs(x - before[1]))


@contextmanager
def _driving(name: str, mishap: Mishap) -> Iterator[Chain]:
    """The whole chain, and the robot at speed."""
    profile = "router" if mishap.has_router else default_bus()
    with ExitStack() as stack:
        router = stack.enter_context(_program("acromovi", "router")) if mishap.has_router else None
        robots = stack.enter_context(emulator("--robot", f"{MODEL}:{name}", "--world", "empty", "--quiet"))
        driver = stack.enter_context(gateway(robots.port, "--quiet", "--bus", profile))
        agents = None
        if mishap.is_asked:
            agents = stack.enter_context(_program("acromovi", "container", "--robot", name, "--json", "--bus", profile))
            _wait_for_agent(name, profile)
            asking = ("ask", f"base@{name}", "move", f"distance={FAR}", "--timeout", "120", "--bus", profile)
            application = stack.enter_context(_program("acromovi", *asking, is_heard=False))
        else:
            application = stack.enter_context(_program("benchmarks.commander", name, str(SPEED), profile))
        stack.callback(_thaw, [process for process in (driver, application, agents, router) if process])
        chain = Chain(robots, driver, application, agents, router, name)
        _wait(lambda: _truth(chain)[2] > mishap.speed * 0.95, "the robot did not come up to speed")
        yield chain


def _wait_for_agent(name: str, profile: str) -> None:
    """Wait for the agent of the wheels."""
    tokens: list[str] = []
    with ZenohBus.open(profile) as bus:
        bus.watch_alive(f"{name}/agents/base/alive", lambda key, is_alive: tokens.append(key))
        _wait(lambda: bool(tokens), "the robot's agents did not come")


@contextmanager
def _program(module: str, *arguments: str, is_heard: bool = True) -> Iterator[subprocess.Popen[str]]:
    """A program of ours, once it has said its first line if that is waited for."""
    command = [sys.executable, "-m", module, *arguments]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        if is_heard:
            process.stdout.readline()
        try:
            yield process
        finally:
            end(process)


def _thaw(processes: Sequence[subprocess.Popen[str]]) -> None:
    for process in processes:
        if process.poll() is None:
            os.kill(process.pid, signal.SIGCONT)


def _wait_until_it_stands(chain: Chain) -> tuple[float, float]:
    """Emulated time when the wheels stood for good, s, and where, m.

    Raises:
        TimeoutError: They did not.
    """
    stood: tuple[float, float] | None = None
    deadline = time.monotonic() + TIMEOUT_S
    while time.monotonic() < deadline:
        now, x, speed = _truth(chain)
        if abs(speed) >= STANDS:
            stood = None
        elif stood is None:
            stood = now, x
        elif now - stood[0] >= STAYS_S:
            return stood
        time.sleep(0.005)
    raise TimeoutError(f"the wheels still turned after {TIMEOUT_S} s")


def _truth(chain: Chain) -> tuple[float, float, float]:
    """Emulated time, s; x, m; forward speed, m/s."""
    answer = chain.robots.ask("truth")
    return answer["time"], answer["x"], answer["robots"][chain.name]["linear"]


def _wait(condition: Callable[[], bool], complaint: str) -> None:
    deadline = time.monotonic() + TIMEOUT_S
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(complaint)
        time.sleep(0.01)


def _figures(proof: Proof) -> Iterator[Figure]:
    mishap = proof.mishap
    yield Figure("stop_proof", f"{mishap.name}: wheels stand after", proof.time, mishap.time, "s")
    yield Figure("stop_proof", f"{mishap.name}: they stand within", proof.distance, mishap.distance, "m")


def _write_page(proofs: Sequence[Proof], path: Path) -> None:
    rows = "".join(
        f"| {proof.mishap.name} | {proof.mishap.who_stops} | {proof.time:.2f} s | {proof.mishap.time:.2f} s "
        f"| {proof.distance:.2f} m | {proof.mishap.distance:.2f} m |\n"
        for proof in proofs
    )
    path.write_text(
        "# Does it stop when it must?\n\n"
        f"A {MODEL} at {SPEED} m/s, commanded over the bus ten times a second, or at {MOVE_SPEED} m/s and "
        "speeding up in a move that an agent was asked for; measured on the emulated robot's true "
        "motion\nuntil its wheels stood, and went on standing for "
        f"{STAYS_S:g} s. Made by `python -m benchmarks stop_proof`.\n\n"
        "| what happens | who stops it | stands after | at most | stands within | at most |\n"
        "|---|---|---|---|---|---|\n"
        f"{rows}\n"
        f"At most: {CMD_VEL_SILENCE_S} s of silence that the gateway allows, or {WATCHDOG_S:g} s that the robot's "
        f"watchdog allows, then {BRAKING_S:.1f} s of braking at\nthe firmware's 0.3 m/s² ({EMERGENCY_BRAKING_S} s in "
        f"an emergency), and {REACTION_S} s ({MOTION_REACTION_S} s in a move) for the way there.\n\n"
        "Firmware that hangs (`frozen-firmware`) keeps its wheels turning, and nothing on the cable can stop it, on "
        "a real robot as here: only\nswitching off can.\n",
        encoding="utf-8",
    )
