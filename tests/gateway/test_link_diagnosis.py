"""The cause that is reported while there is no robot: found in virtual time, told by the programs."""

import json
import random
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import pytest

from configs import load
from gateway.connector import RATES
from gateway.driver import Driver
from gateway.events import LinkLost
from gateway.link_diagnosis import PATIENCE, REPEAT, Cause, LinkProblem, LinkReports
from p2os import RobotModel
from p2os_emu.microcontroller import Microcontroller
from tests.gateway.conftest import Bench, find_model
from tests.gateway.simulator_peer import SimulatorPeer, serving
from tests.gateway.test_command_line import peer, stranger
from tests.gateway.test_simulator import Line
from tests.waiting import end_of

if TYPE_CHECKING:
    from tests.gateway.conftest import MakeBench

T = TypeVar("T")


def cause(driver: Driver) -> Cause | None:
    return None if driver.link_problem is None else driver.link_problem.cause


def sentence(driver: Driver) -> str:
    return "" if driver.link_problem is None else driver.link_problem.sentence


def test_nothing_is_reported_in_the_first_seconds_nor_once_a_robot_is_connected(bench: "Bench") -> None:
    bench.cut = True
    bench.start()
    bench.run(PATIENCE - 0.1)
    assert cause(bench.driver) is None
    bench.run(0.2)
    assert cause(bench.driver) is Cause.NO_ANSWER
    bench.cut = False
    bench.run_until(lambda: bench.driver.is_connected)
    bench.run(0.1)
    assert cause(bench.driver) is None


def test_silent_line_is_no_answer_and_names_the_rates(bench: "Bench") -> None:
    bench.cut = True
    bench.start()
    bench.run(3.0)
    assert cause(bench.driver) is Cause.NO_ANSWER
    assert all(str(rate) in sentence(bench.driver) for rate in RATES)


def test_robot_that_is_lost_is_reported_after_the_same_time(bench: "Bench") -> None:
    bench.connect()
    bench.cut = True
    bench.run_until(lambda: bool(bench.of(LinkLost)))
    bench.run(PATIENCE - 0.1)
    assert cause(bench.driver) is None
    bench.run(1.0)
    assert cause(bench.driver) is Cause.NO_ANSWER


def test_bytes_that_are_no_frames_are_told_from_silence(make_bench: "MakeBench") -> None:
    bench = make_bench(rates=(9600,))
    bench.start()
    bench.cut = True
    end = bench.now + 4.0
    while bench.now < end:
        bench.step()
        bench.driver.receive(b"login: ", bench.now)
    assert cause(bench.driver) is Cause.NO_FRAMES


def test_frames_without_a_handshake_are_told_from_noise(make_bench: "MakeBench") -> None:
    """The robot streams, and does not hear the gateway."""
    former = make_bench(rates=(9600,))
    former.connect()
    bench = make_bench(rates=(9600,))
    bench.robot, bench.body = former.robot, former.body
    bench.deaf = True
    bench.start()
    bench.run(4.0)
    assert cause(bench.driver) is Cause.NO_HANDSHAKE


@pytest.mark.parametrize("robot_baud", [38400, 57600])
def test_robot_at_another_rate_than_the_only_one_to_try_is_found_and_not_connected(robot_baud: int) -> None:
    robot = Microcontroller(load(RobotModel, "robots", "p3dx-sh"), "happy")
    probes = [rate for rate in RATES if rate != 9600]
    driver = Driver(find_model, (9600,), rng=random.Random(5), probe_rates=probes)
    bench = Bench(robot, driver, robot_baud=robot_baud)
    bench.start()
    bench.run(5.0)
    assert cause(driver) is Cause.OTHER_RATE
    assert f"answers at {robot_baud} bit/s" in sentence(driver)
    assert driver.identity is None
    bench.robot_baud = 9600
    bench.run_until(lambda: driver.is_connected, 5.0)


def test_peer_that_hangs_up_is_told_from_one_that_is_silent() -> None:
    class Closing(SimulatorPeer):
        def receive(self, data: bytes) -> bytes:
            self.hung_up = bool(data)
            return b""

    line = Line(Closing())
    seen = set()
    for _ in range(400):
        line.step()
        seen.add(cause(line.driver))
    assert seen == {None, Cause.HANG_UP}


def test_port_that_cannot_be_opened_is_reported_with_the_reason(bench: "Bench") -> None:
    bench.connect()
    bench.driver.port_lost("/dev/ttyUSB0 is gone", bench.now)
    bench.driver.port_lost("there is no port /dev/ttyUSB0", bench.now)
    bench.run(PATIENCE + 0.5)
    assert bench.driver.link_problem == LinkProblem(Cause.NO_PORT, "there is no port /dev/ttyUSB0")


def test_robot_that_answers_the_handshake_and_sends_no_sips_is_reported_as_such() -> None:
    class Silent(SimulatorPeer):
        def step(self, seconds: float) -> bytes:
            super().step(seconds)
            return b""

    line = Line(Silent())
    line.run(4.0)
    assert cause(line.driver) is Cause.NO_PACKETS


def test_problem_is_reported_on_change_and_once_a_minute() -> None:
    silent, noisy = LinkProblem(Cause.NO_ANSWER, "no"), LinkProblem(Cause.NO_FRAMES, "noise")
    reports = LinkReports()
    told = [
        (now, problem.cause)
        for now, problem in (
            (now, reports.due(silent if now < 100 else noisy if now < 110 else None if now < 120 else noisy, now))
            for now in map(float, range(130))
        )
        if problem is not None
    ]
    assert told == [
        (0.0, Cause.NO_ANSWER),
        (REPEAT, Cause.NO_ANSWER),
        (100.0, Cause.NO_FRAMES),
        (120.0, Cause.NO_FRAMES),
    ]


def test_state_and_diagnostics_carry_the_cause(bench: "Bench") -> None:
    from bus import MemoryBus, Sample, messages  # with the message types, which the other tests do without
    from gateway.robot_on_bus import RobotOnBus
    from gateway.settings import Settings

    bench.connect()
    heard: dict[str, Sample] = {}
    bus = MemoryBus()
    bus.subscribe("happy/**", lambda sample: heard.__setitem__(sample.key, sample))
    robot = RobotOnBus("happy", bus, bench.driver, _Commander(bench), Settings())
    bench.cut = True
    bench.run(4.0, lambda: robot.on_events([], bench.now, int(bench.now * 1e9)))
    state = messages.decode(heard["happy/state"].type_name, heard["happy/state"].payload)
    assert [fault for fault in state.faults if "no robot answers" in fault]
    found = messages.decode(heard["happy/diagnostics"].type_name, heard["happy/diagnostics"].payload)
    values = {value.key: value.value for value in found.status[0].values}
    assert values == {"cause": "no answer"}
    assert "no robot answers" in found.status[0].message
    robot.close()


class _Commander:
    def __init__(self, bench: "Bench") -> None:
        self._bench = bench

    def command(self, give: Callable[[Driver, float], T]) -> T:
        return give(self._bench.driver, self._bench.now)

    def post(self, call: Callable[[Driver, float], object]) -> None:
        self.command(call)


@contextmanager
def gateway(port: str, *arguments: str) -> Iterator["subprocess.Popen[str]"]:
    command = [sys.executable, "-m", "gateway", port, *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.terminate()
            process.wait(15.0)


def test_gateway_that_waits_prints_the_cause_of_a_silent_line() -> None:
    with peer(lambda data: b"") as port, gateway(port, "--wait", "--quiet") as process:
        assert process.stderr is not None
        said = process.stderr.readline()
    assert said.startswith(f"p2os-gateway: {port}: no robot answers at ")


def test_gateway_that_waits_prints_the_cause_as_json() -> None:
    with peer(stranger) as port, gateway(port, "--wait", "--json", "--baud", "9600") as process:
        assert process.stdout is not None
        said = json.loads(process.stdout.readline())
    assert said == {"event": "no robot", "cause": "bytes but no frames", "reason": said["reason"], "port": port}


def test_gateway_that_waits_for_a_port_prints_why_it_cannot_be_opened(tmp_path: Path) -> None:
    port = str(tmp_path / "ttyUSB0")
    with gateway(port, "--wait") as process:
        assert process.stderr is not None
        assert process.stderr.readline() == (
            f"p2os-gateway: there is no port {port}; plug the robot in, or start p2os-emu, and look at its name again\n"
        )


def test_gateway_that_does_not_wait_ends_when_each_connection_is_closed() -> None:
    class Closing(SimulatorPeer):
        def receive(self, data: bytes) -> bytes:
            self.hung_up = bool(data)
            return b""

    with serving(Closing()) as served, gateway(served.url) as process:
        _, said = end_of(process)
        assert process.returncode == 8
    assert "closed by the other end" in said
