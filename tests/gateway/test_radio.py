"""A robot behind radio modems: driver, modems and firmware in virtual time."""

import itertools
import random
from dataclasses import replace
from math import inf

import pytest

import configs
from gateway.driver import Driver
from gateway.elements.ptz.element import PtzElement
from gateway.elements.standard.element import UserPorts
from gateway.events import Event, LinkLost, SipReceived
from gateway.line import DIAL, FIRST_DIAL_TIMEOUT, LONGEST_DIAL_TIMEOUT, RADIO, RADIO_BAUD, ModemDialler
from gateway.settings import Settings
from p2os import Command, Frame, FrameDecoder, Identity, RobotModel, decode_command, encode_command
from p2os.accessories.head_model import HeadModel
from p2os_emu.accessories.evid30 import EviD30
from p2os_emu.accessories.vcc4 import Vcc4
from p2os_emu.links.line import EmulatedLine, LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.microcontroller import Microcontroller
from tests.gateway.virtual_time import VirtualTime
from tests.p2os_emu.microcontroller.bench import STEP, PlainBody

STOP = encode_command(Command.STOP)
CLOSE = encode_command(Command.CLOSE)
PROFILE = configs.load(LinkProfile, "links", "radio-modem")


class Radio(VirtualTime):
    """now: steady time, s. sent: bytes from the driver, with time. heard: bytes to it, likewise."""

    def __init__(self, model: str = "powerbot-sh", seed: int = 1, *, auto_connect: bool = True) -> None:
        assert PROFILE.modem is not None
        profile = replace(PROFILE, modem=replace(PROFILE.modem, auto_connect=auto_connect))
        self.now = 50.0
        self.body = PlainBody()
        self.robot = Microcontroller(configs.load(RobotModel, "robots", model), "happy")
        self.link = MemoryLink(client_rate=RADIO_BAUD)
        self.line = EmulatedLine(self.link, profile, seed)
        settings = Settings(radio=True, encoders=True, inputs_outputs=True, raise_baud_to=38400)
        self.driver = Driver(find_model, (RADIO_BAUD,), settings, random.Random(seed))
        self.sent: list[tuple[float, bytes]] = []
        self.heard: list[tuple[float, bytes]] = []
        self.events: list[tuple[float, Event]] = []
        self.turning: list[float] = []

    def step(self) -> None:
        self.now += STEP
        self.body.step(STEP)
        self.robot.receive(self.line.receive(self.now, RADIO_BAUD))
        self.line.send(self.robot.step(STEP, self.body), self.now, RADIO_BAUD)
        if self.body.is_turning():
            self.turning.append(self.now)
        data = self.link.client_read()
        self.heard.append((self.now, data))
        self.events += [(self.now, event) for event in self.driver.receive(data, self.now)]
        while frame := self.driver.bytes_due(self.now):
            self.sent.append((self.now, frame))
            self.link.client_write(frame)

    def commands(self, since: float = 0.0) -> list[Command | None]:
        found = FrameDecoder().receive(b"".join(frame for at, frame in self.sent if at > since), 0.0)
        return [decode_command(each.payload).command for each in found if isinstance(each, Frame)]

    def rate_sent(self, since: float) -> float:
        """Bytes a second."""
        return sum(len(frame) for at, frame in self.sent if at > since) / (self.now - since)

    def connect(self) -> float:
        self.driver.port_opened(self.now)
        seconds = self.run_until(lambda: self.driver.is_connected)
        self.run_until(lambda: self.robot.board.motors.enabled)
        return seconds


@pytest.mark.parametrize(("kind", "name"), [(Vcc4, "vcc4"), (EviD30, "evid30")])
def test_camera_head_is_found_and_steered_through_the_modems(kind: type[Vcc4 | EviD30], name: str) -> None:
    radio = Radio()
    device = kind(configs.load(HeadModel, "accessories", name))
    radio.robot.board.plug(1, lambda: device)
    radio.connect()
    radio.run_until(lambda: radio.driver.has(PtzElement))
    radio.run(15.0)
    radio.driver.element(PtzElement, radio.now).look(0.5, None, None, radio.now)
    radio.run(5.0)
    assert device.head.pan.position == pytest.approx(0.5, abs=0.01)
    assert radio.rate_sent(radio.now - 5.0) < 0.25 * RADIO_BAUD / 10
    assert radio.driver.faults == []


def find_model(identity: Identity) -> RobotModel:
    return configs.load(RobotModel, "robots", identity.subtype)


@pytest.mark.parametrize("auto_connect", [True, False])
def test_modem_is_dialled_before_the_robot_is_told_stop_and_close(auto_connect: bool) -> None:
    radio = Radio(auto_connect=auto_connect)
    seconds = radio.connect()
    assert b"".join(frame for _, frame in radio.sent).startswith(DIAL + STOP + CLOSE)
    assert seconds < 3.0


def test_robot_on_a_plain_cable_is_found_although_no_modem_answers() -> None:
    radio = Radio()
    radio.line = EmulatedLine(radio.link, LinkProfile("a cable"))
    assert radio.connect() < 3.0


def test_minute_of_driving_stays_within_the_budget_and_at_its_rate() -> None:
    radio = Radio()
    radio.connect()
    start = radio.now
    speeds = random.Random(3)

    def drive() -> None:
        if radio.driver.is_connected:
            radio.driver.set_velocity(speeds.uniform(0.1, 0.3), speeds.uniform(-0.2, 0.2), radio.now)

    radio.run(60.0, drive)
    poses = [at for at, event in radio.events if isinstance(event, SipReceived) and at > start]
    assert len(poses) > 0.9 * 600
    assert max(later - earlier for earlier, later in itertools.pairwise(poses)) < RADIO.sip_timeout
    assert radio.rate_sent(start) < RADIO.share * RADIO_BAUD / 10 + 10
    assert not [event for _, event in radio.events if isinstance(event, LinkLost)]
    assert Command.HOSTBAUD not in radio.commands()
    assert radio.driver.baud == RADIO_BAUD
    assert len(radio.turning) > 50.0 / STEP


def test_packets_beside_the_sips_are_asked_for_one_at_a_time() -> None:
    radio = Radio()
    radio.connect()
    start = radio.now
    radio.run(10.0)
    asked = radio.commands(since=start)
    for command in (Command.ENCODER, Command.IOREQUEST):
        assert 4 <= asked.count(command) <= 6
    bodies = [
        decode_command(each.payload)
        for each in FrameDecoder().receive(b"".join(frame for _, frame in radio.sent), 0.0)
        if isinstance(each, Frame)
    ]
    assert {each.value for each in bodies if each.command in (Command.ENCODER, Command.IOREQUEST)} == {1}
    assert radio.driver.has(UserPorts)


def test_stop_goes_out_at_once_whatever_waits() -> None:
    radio = Radio()
    radio.connect()
    for turn in range(20):
        radio.driver.set_velocity(0.1 + turn / 100, 0.01 * turn, radio.now)
        radio.step()
    at = radio.now
    radio.driver.stop(radio.now)
    assert radio.driver.bytes_due(radio.now) == STOP
    assert radio.now == at


@pytest.mark.parametrize("pause", [1.0, 1.9, 2.3, 3.0, 6.0])
def test_move_does_not_resume_when_the_air_is_clear_again(pause: float) -> None:
    radio = Radio(seed=int(10 * pause))
    radio.connect()
    radio.driver.move(5.0, radio.now)
    radio.run(1.5)
    assert radio.body.is_turning()
    radio.line.is_cut = True
    radio.run(pause)
    radio.line.is_cut = False
    back = radio.now
    was_standing = not radio.body.is_turning()
    if radio.driver.is_connected:
        return  # it was never lost, and drives on
    radio.run_until(lambda: radio.driver.is_connected)
    radio.run(3.0)
    braked_by = 2.0 + back
    assert [at for at in radio.turning if at > (back if was_standing else braked_by)] == []
    assert not radio.body.is_turning()


def test_modem_is_dialled_again_after_a_loss_and_ever_more_patiently() -> None:
    radio = Radio()
    radio.connect()
    radio.line.is_cut = True
    cut = radio.now
    radio.run(30.0)
    dials = [at for at, frame in radio.sent if frame == DIAL and at > cut]
    gaps = [later - earlier for earlier, later in itertools.pairwise(dials)]
    assert len(dials) >= 4
    assert gaps[-1] > gaps[0]
    assert max(gaps) < 12.0
    radio.line.is_cut = False
    assert radio.run_until(lambda: radio.driver.is_connected) < 12.0


def test_dialler_hears_the_answer_in_any_pieces_and_waits_longer_after_each_failure() -> None:
    answer = b"WMS2\r\r\nConnecting...\r\nConnected to address 2\r\n"
    for size in range(1, len(answer)):
        dialler = ModemDialler(DIAL)
        dialler.begin()
        for start in range(0, len(answer), size):
            dialler.receive(answer[start : start + size])
        assert dialler.has_answered
    dialler.begin()
    dialler.receive(b"WMS2\r\r\nConnecting...")
    assert not dialler.has_answered
    patience = []
    for _ in range(5):
        patience.append(dialler.timeout)
        dialler.give_up()
    assert patience == [FIRST_DIAL_TIMEOUT, 2.0, LONGEST_DIAL_TIMEOUT, LONGEST_DIAL_TIMEOUT, LONGEST_DIAL_TIMEOUT]
    assert inf not in patience
