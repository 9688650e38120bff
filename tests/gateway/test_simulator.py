"""A gateway on a robot simulator of the MobileSim family: `simulator_peer` behaves as these do."""

import math
import random
import subprocess
import sys
from itertools import pairwise
from math import pi, radians
from typing import TypeVar

import pytest

from bus import Bus, Sample, keys, messages
from configs import load
from gateway.bridge import LONGEST_BACKOFF, Backoff
from gateway.connector import AS_IT_IS, CLOSE, STOP
from gateway.driver import Driver
from gateway.events import Event, HandshakeCompleted, MotionEnd, MotionEnded, SweepFailed, SweepReceived
from gateway.settings import Fitted, Settings
from p2os import Command, RobotModel, encode_command
from tests.gateway.conftest import MakeBench, find_model
from tests.gateway.simulator_peer import SimulatorPeer, serving
from tests.gateway.virtual_time import VirtualTime
from tests.waiting import wait_until

T = TypeVar("T")
STEP = 0.01
SYNC0 = encode_command(Command.SYNC0)


class Line(VirtualTime):
    """A driver on a TCP connection to a peer that may hang up, under a virtual clock.

    reopening: s until the driver is given a new connection. connections: bytes sent on each.
    """

    def __init__(self, peer: SimulatorPeer, settings: Settings | None = None, model: str | None = None) -> None:
        self.now = 50.0
        self.peer = peer
        find = find_model if model is None else lambda identity: load(RobotModel, "robots", model)
        self.driver = Driver(find, (AS_IT_IS,), settings, random.Random(3))
        self.events: list[Event] = []
        self._opens_at = self.now

    def step(self) -> None:
        self.now += STEP
        if not self.driver.has_port:
            if self.now < self._opens_at:
                return
            self.peer.connect()
            self.driver.port_opened(self.now)
        data = self.peer.step(STEP)
        self.events += self.driver.receive(data, self.now)
        while due := self.driver.bytes_due(self.now):
            self.events += self.driver.receive(self.peer.receive(due), self.now)
        if self.peer.hung_up:
            self.driver.port_lost("the other end was closed", self.now)
            self._opens_at = self.now + 0.15

    def of(self, kind: type[T]) -> list[T]:
        return [event for event in self.events if isinstance(event, kind)]

    def connect(self) -> None:
        self.run_until(lambda: self.driver.is_connected, 5.0)


def test_after_a_hang_up_that_follows_close_the_next_connection_begins_with_sync0_alone() -> None:
    line = Line(SimulatorPeer())
    line.connect()
    first, second = line.peer.first_bytes[-2:]
    assert first == STOP + CLOSE
    assert second.startswith(SYNC0 + encode_command(Command.SYNC1) + encode_command(Command.SYNC2))
    assert line.peer.sessions == 2
    assert line.of(HandshakeCompleted)[0].identity.name == "MobileSim"


def test_simulator_that_is_slow_to_hang_up_is_known_by_its_echo() -> None:
    class Slow(SimulatorPeer):
        def receive(self, data: bytes) -> bytes:
            answer = super().receive(data)
            if self.hung_up:
                self.hung_up = False  # it does not get round to it while this connection lasts
            return answer

    line = Line(Slow())
    line.run_until(lambda: bool(line.of(SweepFailed)), 5.0)
    line.driver.port_lost("the connection is dead", line.now)  # as the bridge gives up a dead connection
    line.connect()
    assert line.peer.first_bytes[-1].startswith(SYNC0)


def test_simulator_that_is_lost_is_connected_again_in_the_same_way() -> None:
    line = Line(SimulatorPeer())
    line.connect()
    line.peer.hung_up = True
    line.run(0.05)
    assert not line.driver.is_connected
    line.connect()
    assert line.peer.sessions == 3
    assert line.peer.first_bytes[-1].startswith(SYNC0)


def test_robot_that_streams_on_a_new_connection_hears_stop_and_never_sync0_first(make_bench: MakeBench) -> None:
    """A serial server that drops its connection just after CLOSE, which was lost: behind it the robot is still open."""
    bench = make_bench(rates=(AS_IT_IS,))
    bench.connect()
    bench.driver.set_velocity(0.5, 0.0, bench.now)
    bench.run(0.3)
    bench.is_frozen = True
    bench.run(5.0)  # the robot's watchdog has stopped it; a PULSE would let it go on

    stranger = make_bench(rates=(AS_IT_IS,))
    stranger.robot, stranger.body = bench.robot, bench.body
    stranger.deaf = True
    stranger.start()
    stranger.run(0.05)  # STOP and CLOSE have left, and did not arrive
    stranger.driver.port_lost("the connection was reset", stranger.now)
    stranger.deaf = False
    stranger.sent.clear()
    stranger.connect()
    stranger.run(1.0)
    assert stranger.commands()[:4] == [Command.STOP, Command.CLOSE, Command.STOP, Command.CLOSE]
    assert stranger.moments_in_motion == []


def test_peer_that_also_hangs_up_on_sync0_hears_stop_first_the_next_time() -> None:
    class Refusing(SimulatorPeer):
        def receive(self, data: bytes) -> bytes:
            super().receive(data)
            self.hung_up = bool(data)
            return b""

    line = Line(Refusing())
    line.run(4.0)
    assert len(line.peer.first_bytes) > 4
    shown = [each[: len(STOP)] for each in line.peer.first_bytes if each]
    assert set(shown) <= {STOP, SYNC0}
    assert all(first != second for first, second in pairwise(shown) if first == SYNC0)


def test_serial_port_that_vanishes_after_close_is_never_connected_without_stop(make_bench: MakeBench) -> None:
    bench = make_bench(rates=(9600,), robot_baud=9600)
    bench.cut = True
    bench.start()
    bench.run(0.05)
    bench.driver.port_lost("the adapter was pulled out", bench.now)
    bench.cut = False
    bench.sent.clear()
    bench.connect()
    assert bench.commands()[:2] == [Command.STOP, Command.CLOSE]


@pytest.mark.parametrize(("name", "sends_configuration"), [("MobileSim", False), ("anybody", False), ("anybody", True)])
def test_laser_on_the_robots_line_becomes_sweeps(name: str, sends_configuration: bool) -> None:
    line = Line(SimulatorPeer(name=name, sends_configuration=sends_configuration))
    line.connect()
    line.run(3.0)
    sweeps = line.of(SweepReceived)
    assert len(sweeps) >= 15
    last = sweeps[-1]
    assert len(last.ranges) == len(last.reflectances) == 181
    assert last.ranges == pytest.approx([1.0 + 0.01 * index for index in range(181)])
    assert (last.reflectances[0], last.reflectances[1]) == (33, 0)
    assert (last.first_bearing, last.step) == pytest.approx((-pi / 2, radians(1.0)))
    assert last.period == pytest.approx(0.1, abs=0.02)


def test_laser_is_not_asked_for_where_the_settings_do_not_want_it_or_the_robot_may_be_real(
    make_bench: MakeBench,
) -> None:
    line = Line(SimulatorPeer(), Settings(fitted=Fitted(simulated_laser=False)))
    line.connect()
    line.run(3.0)
    bench = make_bench()
    bench.connect()
    bench.run(3.0)
    asked = [command.command for command in line.peer.heard] + bench.commands()
    assert Command.SIM_LRF_ENABLE not in asked


@pytest.mark.parametrize("angle", [radians(175), 2 * pi, -3 * pi])
def test_turn_over_170_degrees_is_reached_though_the_simulator_knows_no_dchead(angle: float) -> None:
    line = Line(SimulatorPeer())
    line.connect()
    line.run(1.0)
    turned = line.peer.turned
    line.driver.turn(angle, line.now)
    line.run_until(lambda: bool(line.of(MotionEnded)), 60.0)
    assert line.of(MotionEnded)[0].end is MotionEnd.REACHED
    assert line.peer.turned - turned == pytest.approx(angle, abs=radians(3))


def test_setting_names_the_model_of_a_simulator_that_reports_one_for_all_robots() -> None:
    line = Line(SimulatorPeer(), model="powerbot-sh")
    line.connect()
    assert line.driver.model is not None
    assert line.driver.model.name == "powerbot-sh"


class Hearing:
    """What a robot publishes: the last scan and odometry."""

    def __init__(self, bus: Bus, name: str) -> None:
        self.scan: messages.LaserScan | None = None
        self.odom: messages.Odometry | None = None
        bus.subscribe(keys.SCAN.key(name), self._on_scan)
        bus.subscribe(keys.ODOM.key(name), self._on_odom)

    def _on_scan(self, sample: Sample) -> None:
        self.scan = messages.decode(keys.SCAN.type_name, sample.payload)

    def _on_odom(self, sample: Sample) -> None:
        self.odom = messages.decode(keys.ODOM.type_name, sample.payload)


def test_gateway_process_connects_to_the_simulator_drives_it_and_publishes_its_laser(bus: Bus, name: str) -> None:
    hearing = Hearing(bus, name)
    with serving(SimulatorPeer()) as served:
        command = [sys.executable, "-m", "gateway", served.url, "--name", name]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            try:
                wait_until(lambda: hearing.scan is not None, "a scan was published")
                wait_until(lambda: _drive(bus, name) and served.look(lambda peer: peer.x > 0.1), "the robot rolled")
            finally:
                process.terminate()
                process.wait(15.0)
    scan = hearing.scan
    assert scan is not None
    assert scan.angle_min == pytest.approx(-pi / 2)
    assert len(scan.ranges) == 181
    assert scan.ranges[90] == pytest.approx(1.9)
    assert not math.isnan(scan.ranges[0])
    assert served.peer.sessions <= 3


def _drive(bus: Bus, name: str) -> bool:
    bus.put(keys.CMD_VEL.key(name), messages.twist(0.3, 0.0))
    return True


def test_connections_that_the_peer_closes_follow_each_other_ever_more_slowly() -> None:
    class Closing(SimulatorPeer):
        def receive(self, data: bytes) -> bytes:
            self.hung_up = bool(data)
            return b""

    with serving(Closing()) as served:
        command = [sys.executable, "-m", "gateway", served.url, "--wait", "--quiet"]
        # What it complains of is tested elsewhere.
        with subprocess.Popen(command, stderr=subprocess.DEVNULL) as process:
            try:
                wait_until(lambda: len(served.connections) >= 7)
            finally:
                process.terminate()
                process.wait(15.0)
    assert served.connections[6] - served.connections[5] >= LONGEST_BACKOFF / 2


def test_backoff_doubles_up_to_its_longest_pause_and_begins_again_after_a_success() -> None:
    backoff = Backoff(0.15, 2.0, random.Random(1))
    bounds = [0.15, 0.3, 0.6, 1.2, 2.0, 2.0]
    assert all(bound / 2 <= backoff.pause() <= bound for bound in bounds)
    backoff.reset()
    assert backoff.pause() <= 0.15
