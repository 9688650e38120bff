"""Commands of MobileSim and of the simulators before it, as clients send them. Source: fact sheet section 7."""

import struct
from math import inf, pi, radians
from typing import Any

import numpy as np
import pytest

import configs
from geometry import Pose2D
from p2os import Command, Family, Frame, FrameDecoder, RobotModel, decode_packet, encode_command, encode_frame
from p2os.configuration import Configuration
from p2os.simulator_packets import ExtendedLaser, MapChanged, SimulatedLaser, SimulatorState
from p2os_emu.body import Echoes, ScanBeams
from p2os_emu.emulator import STEP, Emulator
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from tests.p2os_emu.flat_world import FlatBody, FlatWorld

WALL = 4.0


def look(self: FlatBody, beams: ScanBeams) -> Echoes:
    """A wall all round that reflects to the left."""
    bearings = beams.first + beams.step * np.arange(beams.count)
    return Echoes(np.full(beams.count, WALL), np.ones(beams.count), bearings > 0.0)


class Client:
    """A client of a simulated robot, in virtual time."""

    def __init__(self, *, as_simulator: bool = True) -> None:
        self.model = configs.load(RobotModel, "robots", "p3dx-sh")
        self.emulator = Emulator(FlatWorld(), LinkProfile("ideal"), as_simulator=as_simulator)
        self.link = MemoryLink()
        self.robot = self.emulator.add("happy", self.model, self.link)
        self._decoder = FrameDecoder()
        for command in (Command.SYNC0, Command.SYNC1, Command.SYNC2, Command.OPEN):
            self.link.client_write(encode_command(command))
            self.hear(2 * STEP)

    def say(self, payload: bytes) -> None:
        self.link.client_write(encode_frame(payload))

    def hear(self, seconds: float) -> list[Any]:
        for _ in range(round(seconds / STEP)):
            self.emulator.step()
        found = self._decoder.receive(self.link.client_read(), self.emulator.time)
        return [decode_packet(each.payload, self.model) for each in found if isinstance(each, Frame)]

    def hear_only(self, kind: type, seconds: float) -> list[Any]:
        return [packet for packet in self.hear(seconds) if isinstance(packet, kind)]

    @property
    def messages(self) -> tuple[str, ...]:
        return self.robot.microcontroller.simulator_messages


@pytest.fixture
def client(monkeypatch: pytest.MonkeyPatch) -> Client:
    monkeypatch.setattr(FlatBody, "scan", look)
    return Client()


COMMANDS = {
    "SIM_SET_POSE": bytes([224, 0]) + struct.pack("<iii", 1500, -2500, 90),
    "SIM_RESET": bytes([225]),
    "SIM_MODEL_CONFIG": bytes([226, 0, 1]),
    "SIM_LRF_ENABLE": bytes([230, 0x3B, 2, 0]),
    "SIM_LRF_SET_FOV_START": bytes([231, 0x1B, 45, 0]),
    "SIM_LRF_SET_FOV_END": bytes([232, 0x3B, 45, 0]),
    "SIM_LRF_SET_RES": bytes([233, 0x3B, 2, 0]),
    "SIM_CTRL": bytes([236, 0]) + struct.pack("<HH", 5, 7) + b"a note\0",
    "SIM_STAT": bytes([237, 0x3B, 2, 0]),
    "SIM_MESSAGE": bytes([238, 0x2B, 5]) + b"hello",
    "SIM_EXIT": bytes([239, 0x3B, 1, 0]),
}
UNKNOWN = bytes([199])
"""A number that no firmware and no simulator has a command for."""


def what_follows(command: bytes, *, as_simulator: bool) -> tuple[Any, ...]:
    """Return all that a robot that has turned away from its start shows after a command, its bytes included."""
    client = Client(as_simulator=as_simulator)
    client.emulator.place("happy", Pose2D(0.0, 0.0, 1.0))
    client.say(bytes([230, 0x3B, 1, 0]) if as_simulator else UNKNOWN)  # sweeps show the laser's settings
    client.say(command)
    packets = client.hear(0.5)
    return packets, client.emulator.world.truth("happy").pose, client.messages


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_of_a_simulator_has_an_effect_with_the_option(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FlatBody, "scan", look)
    assert what_follows(COMMANDS[name], as_simulator=True) != what_follows(UNKNOWN, as_simulator=True)


@pytest.mark.parametrize("name", COMMANDS)
def test_without_the_option_each_command_of_a_simulator_is_an_unknown_command(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FlatBody, "scan", look)
    assert what_follows(COMMANDS[name], as_simulator=False) == what_follows(UNKNOWN, as_simulator=False)


@pytest.mark.parametrize(("as_simulator", "is_simulator"), [(True, True), (False, False)])
def test_the_serial_number_by_which_clients_recognise_a_simulator_comes_with_the_option(
    as_simulator: bool, is_simulator: bool
) -> None:
    client = Client(as_simulator=as_simulator)
    client.say(bytes([Command.CONFIG]))
    (configuration,) = client.hear_only(Configuration, 0.3)
    assert (configuration.serial == "SIM") is is_simulator


def test_set_pose_moves_the_robot_and_not_its_odometry(client: Client) -> None:
    client.say(bytes([224, 0]) + struct.pack("<iii", 1500, -2500, 90))
    sip = client.hear(0.2)[-1]
    truth = client.emulator.world.truth("happy").pose
    assert (truth.x, truth.y, truth.heading) == pytest.approx((1.5, -2.5, pi / 2))
    assert (sip.x, sip.y, sip.heading) == (0.0, 0.0, 0.0)


def test_set_pose_that_ends_too_early_is_refused_with_a_message(client: Client) -> None:
    client.say(bytes([224, 0, 1, 2]))
    client.hear(0.1)
    assert client.messages == ("SIM_SET_POSE of 2 bytes was refused: it needs x, y and heading, i32 each",)


def test_reset_brings_pose_and_odometry_back(client: Client) -> None:
    client.say(bytes([Command.ENABLE, 0x3B, 1, 0]))
    client.say(bytes([Command.VEL, 0x3B, 200, 0]))
    client.hear(2.0)
    client.say(bytes([Command.STOP]))
    client.hear(2.0)
    assert client.emulator.world.truth("happy").pose.x > 0.3
    client.say(bytes([225]))
    sip = client.hear(0.2)[-1]
    assert client.emulator.world.truth("happy").pose == Pose2D(0.0, 0.0, 0.0)
    assert (sip.x, sip.y) == (0.0, 0.0)


@pytest.mark.parametrize(("argument", "count"), [(0, 0), (1, 1), (2, 10)])
def test_state_comes_as_often_as_it_is_asked_for(client: Client, argument: int, count: int) -> None:
    client.emulator.place("happy", Pose2D(3.0, 4.0, radians(30)))
    client.say(bytes([237, 0x3B, argument, 0]))
    states = client.hear_only(SimulatorState, 0.99)
    assert len(states) == count
    assert all((state.x, state.y, state.heading) == pytest.approx((3.0, 4.0, radians(30))) for state in states)


def test_laser_by_the_new_numbers_sends_whole_sweeps_in_packets_that_clients_hold(client: Client) -> None:
    for payload in ((231, 0x1B, 90, 0), (232, 0x3B, 90, 0), (233, 0x3B, 1, 0), (230, 0x3B, 2, 0)):
        client.say(bytes(payload))
    packets = client.hear_only(ExtendedLaser, 0.15)
    assert [(packet.total, packet.first, len(packet.readings)) for packet in packets[:5]] == [
        (181, 0, 38),
        (181, 38, 38),
        (181, 76, 38),
        (181, 114, 38),
        (181, 152, 29),
    ]
    readings = [reading for packet in packets[:5] for reading in packet.readings]
    assert {reading.range for reading in readings} == {WALL}
    assert [reading.reflectance > 0 for reading in readings] == [False] * 91 + [True] * 90


def test_laser_by_the_old_numbers_works_only_as_a_simulator(client: Client) -> None:
    """36, 37 in degrees, 38 in hundredths, then 35 with 2: what ARIA sends to simulators."""
    frames = ((36, 0x1B, 90, 0), (37, 0x3B, 90, 0), (38, 0x3B, 50, 0), (35, 0x3B, 2, 0))
    plain = Client(as_simulator=False)
    for robot in (plain, client):
        for payload in frames:
            robot.say(bytes(payload))
    assert plain.hear_only(ExtendedLaser, 0.5) == []
    assert client.hear_only(ExtendedLaser, 0.15)[0].total == 361


def test_plain_laser_packets_carry_the_pose_and_96_readings(client: Client) -> None:
    client.say(bytes([230, 0x3B, 1, 0]))
    packets = client.hear_only(SimulatedLaser, 0.15)
    assert [len(packet.ranges) for packet in packets[:2]] == [96, 85]
    client.say(bytes([230, 0x3B, 0, 0]))
    client.hear(0.1)
    assert client.hear_only(SimulatedLaser, 0.5) == []


def test_messages_are_kept_and_exit_and_maps_are_refused(client: Client) -> None:
    client.say(bytes([238, 0x2B, 5]) + b"hello")
    client.say(bytes([239, 0x3B, 1, 0]))
    client.say(bytes([236, 0]) + struct.pack("<HH", 1, 7) + b"lab.map\0")
    heard = client.hear_only(MapChanged, 0.2)
    assert heard == [MapChanged(by_user=False, loaded=False, name="lab.map")]
    assert client.messages == (
        "hello",
        "SIM_EXIT was refused: end the emulator itself",
        "map 'lab.map' was not loaded: start the emulator with --world",
    )


def test_laser_ends_with_its_client(client: Client) -> None:
    client.say(bytes([230, 0x3B, 1, 0]))
    client.hear(0.2)
    for payload in (bytes([2, 0x3B, 1, 0]), b"\0", b"\1", b"\2", b"\1"):
        client.say(payload)
        client.hear(0.05)
    assert client.hear_only(SimulatedLaser, 0.5) == []


def test_beams_into_the_open_read_as_far_as_the_laser_reaches() -> None:
    client = Client()
    assert client.model.firmware is Family.ARCOS
    client.say(bytes([230, 0x3B, 1, 0]))
    (packet, _, *_) = client.hear_only(SimulatedLaser, 0.15)
    assert set(packet.ranges) == {32.0}
    assert inf not in packet.ranges
