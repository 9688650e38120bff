"""Every fault: it begins, it ends, and what it leaves behind; in emulated time."""

from collections.abc import Iterator

import pytest

import configs
from p2os import Command, RobotModel, encode_command
from p2os.sip import ChargeState
from p2os_emu.accessories.lms200 import Lms200
from p2os_emu.accessories.vcc4 import Vcc4
from p2os_emu.emulator import STEP, Emulator
from p2os_emu.fault_spec import FaultError, parse_fault
from p2os_emu.faults.board import FAULTS, FaultBoard
from p2os_emu.fit import read_fit
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.lists import listing
from tests.p2os_emu.flat_world import FlatWorld

POWERBOT = configs.load(RobotModel, "robots", "powerbot")
SYNCS = [bytes.fromhex(frame) for frame in ("FA FB 03 00 00 00", "FA FB 03 01 00 01", "FA FB 03 02 00 02")]


class Rig:
    """Two PowerBots; the client of the first is connected and drives it."""

    def __init__(self) -> None:
        self.emulator = Emulator(FlatWorld(), LinkProfile("ideal"))
        self.link = MemoryLink()
        model, fit = read_fit(["gyro", "laser", "ptz:vcc4"], POWERBOT)
        self.laser = MemoryLink()
        self.happy = self.emulator.add("happy", model, self.link, fit=fit, cables={"laser": self.laser})
        self.grumpy = self.emulator.add("grumpy", POWERBOT, MemoryLink())
        self.board = FaultBoard(self.emulator.robots)
        self.emulator.before_step = self.board.advance
        self.pulses = False  # which would be a SYNC0 in the handshake
        for sync in SYNCS:
            self.link.client_write(sync)
            self.run(0.1)
        self.pulses = True
        for command, value in ((Command.OPEN, None), (Command.ENABLE, 1), (Command.VEL, 0.2)):
            self.link.client_write(encode_command(command, value))
        self.run(1.5)
        self.link.client_read()

    @property
    def speed(self) -> float:
        return self.emulator.world.truth("happy").linear

    def fault(self, text: str) -> int:
        return self.board.schedule(parse_fault(text), self.emulator.time).number

    def run(self, seconds: float) -> None:
        for step in range(round(seconds / STEP)):
            if self.pulses and step % 60 == 0:
                self.link.client_write(encode_command(Command.PULSE))
            self.emulator.step()


@pytest.fixture
def rig() -> Iterator[Rig]:
    rig = Rig()
    assert rig.speed == pytest.approx(0.2, abs=0.01)
    yield rig
    rig.emulator.close()


def test_fault_begins_and_ends_at_its_time(rig: Rig) -> None:
    rig.fault("line-cut@1+2")
    now = rig.emulator.time
    cut = []
    while rig.emulator.time < now + 4:
        rig.run(STEP)
        cut.append(rig.happy.line.is_cut)
    assert cut.index(True) == 120
    assert sum(cut) == 240
    assert rig.board.faults == []


def test_fault_befalls_the_named_robot_or_every_robot(rig: Rig) -> None:
    rig.fault("line-cut:robot=grumpy")
    rig.run(STEP)
    assert (rig.happy.line.is_cut, rig.grumpy.line.is_cut) == (False, True)
    rig.fault("line-cut")
    rig.run(STEP)
    assert (rig.happy.line.is_cut, rig.grumpy.line.is_cut) == (True, True)


def test_fault_lasts_until_it_is_cleared(rig: Rig) -> None:
    number = rig.fault("line-cut")
    rig.run(5.0)
    assert rig.happy.line.is_cut
    rig.board.clear(number)
    assert not rig.happy.line.is_cut


def test_fault_to_come_can_be_called_off(rig: Rig) -> None:
    rig.board.clear(rig.fault("line-cut@1"))
    rig.run(1.5)
    assert not rig.happy.line.is_cut


def test_end_of_one_fault_does_not_end_another_of_its_kind(rig: Rig) -> None:
    rig.fault("line-cut@0+1")
    rig.fault("line-cut@0.5+1")
    rig.run(1.2)
    assert rig.happy.line.is_cut
    rig.run(0.5)
    assert not rig.happy.line.is_cut


def test_pressed_stop_button_stops_the_robot_and_leaves_it_without_motors(rig: Rig) -> None:
    rig.fault("stop-pressed@0+1")
    rig.run(2.0)
    assert rig.speed == 0
    assert not rig.happy.microcontroller.board.motors.enabled


def test_low_battery_shows_what_it_is_told_to_show(rig: Rig) -> None:
    number = rig.fault("low-battery:volts=20.5,robot=happy")
    shown = []
    rig.run(STEP)
    shown.append(rig.happy.microcontroller.panel.battery)
    rig.board.clear(number)
    shown.append(rig.happy.microcontroller.panel.battery)
    rig.fault("low-battery")
    rig.run(STEP)
    shown.append(rig.happy.microcontroller.panel.battery)
    assert shown == [20.5, None, pytest.approx(0.9 * POWERBOT.battery_nominal)]


def test_charger_is_plugged_and_pulled(rig: Rig) -> None:
    rig.fault("charger-plugged@0+1")
    rig.run(STEP)
    assert rig.happy.microcontroller.panel.charger_plugged
    rig.run(1.0)
    assert not rig.happy.microcontroller.panel.charger_plugged


def test_robot_at_its_dock_charges_once_its_contacts_are_down(rig: Rig) -> None:
    rig.fault("docked@0+12")
    rig.happy.microcontroller.receive(encode_command(Command.CHARGE, 1))
    charges = []
    for seconds in (4.0, 4.0, 5.0):
        rig.run(seconds)
        charges.append(rig.happy.microcontroller.board.battery.charging is not ChargeState.NOT_CHARGING)
    assert charges == [False, True, False]


def test_brown_out_resets_at_once_and_tells_the_client(rig: Rig) -> None:
    rig.fault("brown-out:robot=happy")
    rig.run(STEP)
    assert not rig.happy.microcontroller.connected
    assert rig.link.client_read().startswith(bytes.fromhex("FA FB 03 FF"))
    rig.run(1.0)
    assert rig.speed == 0


def test_longer_brown_out_is_silent_until_power_returns(rig: Rig) -> None:
    rig.fault("brown-out:robot=happy@0+1")
    rig.run(0.9)
    assert rig.link.client_read() == b""
    assert rig.speed == 0
    rig.run(0.2)
    assert rig.link.client_read().startswith(bytes.fromhex("FA FB 03 FF"))


def test_frozen_firmware_says_nothing_and_keeps_rolling(rig: Rig) -> None:
    rig.fault("frozen-firmware:robot=happy@0+3")
    rig.run(STEP)
    rig.link.client_read()
    rig.run(2.5)
    assert rig.link.client_read() == b""
    assert rig.speed == pytest.approx(0.2, abs=0.01)
    rig.run(1.0)
    assert rig.link.client_read() != b""


def test_stuck_bumpers_are_felt_together_and_spring_back(rig: Rig) -> None:
    rear = rig.fault("bumper-stuck:segment=rear1")
    rig.fault("bumper-stuck:segment=rear3@0+1")
    rig.run(STEP)
    assert rig.happy.body.state.rear_bumpers == 0b101
    rig.run(1.0)
    assert rig.happy.body.state.rear_bumpers == 0b001
    rig.board.clear(rear)
    assert rig.happy.body.state.rear_bumpers == 0


def test_stuck_bumper_still_lets_the_robot_hear_and_drive(rig: Rig) -> None:
    rig.fault("bumper-stuck:segment=rear1")
    rig.run(1.0)
    assert rig.speed == pytest.approx(0.2, abs=0.01)
    rig.happy.body.release()
    assert len(rig.happy.body.ping([0, 1])) == 2


def test_cut_line_is_silent_and_the_watchdog_stops_the_robot(rig: Rig) -> None:
    rig.fault("line-cut")
    rig.run(4.0)
    assert rig.link.client_read() == b""
    assert rig.speed == 0


def test_hang_up_takes_the_port_away_for_its_duration(rig: Rig) -> None:
    rig.fault("hang-up:robot=happy@0+1")
    rig.run(0.5)
    assert not rig.link.attached
    rig.run(0.6)
    assert rig.link.attached


def test_hang_up_without_duration_returns_at_once(rig: Rig) -> None:
    rig.fault("hang-up")
    rig.run(STEP)
    assert rig.link.attached
    assert rig.board.faults == []


def test_fault_of_a_robot_that_was_removed_does_no_harm(rig: Rig) -> None:
    rig.fault("line-cut:robot=grumpy@0+1")
    rig.fault("stop-pressed:robot=grumpy@0.5")
    rig.run(STEP)
    rig.emulator.remove("grumpy")
    rig.run(2.0)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("line-cutt", "there is no fault 'line-cutt'; did you mean line-cut"),
        ("xyzzy", "the robots here can suffer sonar-dead, sonar-stuck, "),
        ("line-cutt:robot=happy", "happy can suffer sonar-dead, sonar-stuck, "),
        ("line-cut:rowboat=happy", "no parameter 'rowboat'; did you mean robot"),
        ("line-cut:robot=hapy", "there is no robot 'hapy'; did you mean happy"),
        ("low-battery:volts=lots", "volts=lots will not do; give volts from 0 to 48"),
        ("low-battery:volts=99", "give volts from 0 to"),
        ("bumper-stuck:segment=front99", "happy has front1, front2"),
        ("sonar-dead:disc=99", r"happy has the discs 0-6\+8-14\+16-22\+24-30"),
        ("sonar-dead:disc=all+3", r"write numbers as in 3, 0-7, 3\+5 or all"),
        ("wheel-stalled:side=top", "choose left, right, both"),
        ("wheel-slipping:factor=2", "give a number from 0 to 1"),
        ("line-cut:robot=grumpy,cable=laser", "grumpy has robot"),
        ("line-half-duplex:toward=me", "choose robot, host"),
        ("laser-dirty:robot=grumpy", "grumpy has no laser to suffer laser-dirty; grumpy can suffer sonar-dead"),
        ("gyro-failed:robot=grumpy", "grumpy has no gyro to suffer gyro-failed; "),
    ],
)
def test_fault_that_cannot_be_is_refused_with_what_can(rig: Rig, text: str, complaint: str) -> None:
    with pytest.raises(FaultError, match=complaint):
        rig.fault(text)


def test_bumper_of_a_robot_without_bumpers_is_refused() -> None:
    emulator = Emulator(FlatWorld(), LinkProfile("ideal"))
    emulator.add("p3dx", configs.load(RobotModel, "robots", "p3dx"), MemoryLink())
    with pytest.raises(FaultError, match="p3dx has no bumpers to suffer bumper-stuck; p3dx can suffer sonar-dead, "):
        FaultBoard(emulator.robots).schedule(parse_fault("bumper-stuck"), 0.0)


def test_clearing_a_fault_that_is_not_there_is_refused(rig: Rig) -> None:
    with pytest.raises(FaultError, match="no fault number 7"):
        rig.board.clear(7)


def test_longer_brown_out_takes_the_power_from_the_laser_too_and_leaves_the_dirt_on_it(rig: Rig) -> None:
    rig.fault("laser-dirty:robot=happy,dirt=0.7")
    rig.run(0.5)
    scanner = rig.happy.cables["laser"].device
    rig.fault("brown-out:robot=happy@0+1")
    rig.run(0.5)
    powered = [rig.happy.cables["laser"].is_powered]
    rig.run(1.0)
    powered.append(rig.happy.cables["laser"].is_powered)
    assert powered == [False, True]
    again = rig.happy.cables["laser"].device
    assert again is not scanner, "it begins as after the power switch"
    assert isinstance(again, Lms200)
    assert again.dirt == 0.7


def test_brown_out_takes_the_power_from_the_camera_head_as_well(rig: Rig) -> None:
    head = rig.happy.microcontroller.board.aux[1].device
    assert isinstance(head, Vcc4)
    head.is_host_controlled = True
    rig.fault("brown-out:robot=happy")
    rig.run(STEP)
    again = rig.happy.microcontroller.board.aux[1].device
    assert isinstance(again, Vcc4)
    assert again is not head
    assert not again.is_host_controlled


def test_cable_of_an_accessory_is_cut_and_vanishes_by_itself(rig: Rig) -> None:
    cut = rig.fault("line-cut:robot=happy,cable=laser")
    rig.fault("hang-up:robot=happy,cable=laser@0+1")
    rig.run(0.5)
    assert (rig.happy.line.is_cut, rig.happy.cables["laser"].line.is_cut) == (False, True)
    assert (rig.link.attached, rig.laser.attached) == (True, False)
    rig.board.clear(cut)
    rig.run(0.6)
    assert not rig.happy.cables["laser"].line.is_cut
    assert rig.laser.attached


@pytest.mark.parametrize(
    ("spec", "impaired"),
    [
        ("line-frozen", "frozen"),
        ("line-noisy:rate=0.1", "noisy"),
        ("line-garbled", "garbled"),
        ("line-half-duplex:toward=host", "half-duplex"),
    ],
)
def test_impaired_line_is_mended_when_the_last_fault_of_its_kind_ends(rig: Rig, spec: str, impaired: str) -> None:
    rig.fault(f"{spec}@0+1")
    rig.fault(f"{spec}@0.5+1")
    for lines, seconds in (([impaired], 1.2), ([], 0.5)):
        rig.run(seconds)
        assert rig.happy.line.faults == rig.grumpy.line.faults == lines


def test_frozen_line_keeps_what_it_holds_when_a_second_fault_begins(rig: Rig) -> None:
    rig.fault("line-frozen:robot=happy@0+2")
    rig.run(0.5)
    rig.fault("line-frozen:robot=happy@0+1")
    rig.run(1.4)
    assert rig.link.client_read() == b""
    rig.run(0.5)
    assert rig.link.client_read().count(bytes.fromhex("FA FB")) > 10


def test_robot_added_later_under_the_same_name_is_not_befallen(rig: Rig) -> None:
    rig.fault("line-cut:robot=grumpy@0+2")
    rig.run(0.5)
    rig.emulator.remove("grumpy")
    link = MemoryLink()
    robot = rig.emulator.add("grumpy", POWERBOT, link)
    rig.run(0.5)
    assert not robot.line.is_cut
    rig.run(2.0)
    rig.fault("line-cut:robot=grumpy")
    rig.run(STEP)
    assert robot.line.is_cut


def test_robot_that_is_reset_keeps_its_faults(rig: Rig) -> None:
    rig.fault("stop-pressed:robot=happy")
    rig.fault("sonar-dead:robot=happy")
    rig.run(STEP)
    rig.emulator.restart(["happy"])
    rig.run(STEP)
    assert rig.happy.microcontroller.panel.stop_button
    assert rig.happy.body.sonar.dead


def test_fault_for_every_robot_befalls_those_that_can_suffer_it(rig: Rig) -> None:
    rig.fault("laser-dirty")
    rig.run(STEP)
    rig.fault("bumper-stuck")
    rig.run(STEP)
    assert rig.grumpy.body.state.front_bumpers == 1


@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_leaves_a_robot_that_a_new_client_can_use(rig: Rig, name: str) -> None:
    rig.fault(f"{name}@0+0.5")
    rig.run(1.0)
    rig.pulses = False
    rig.link.client_write(encode_command(Command.CLOSE))
    rig.run(0.2)
    rig.link.client_read()
    for sync in SYNCS:
        rig.link.client_write(sync)
        rig.run(0.1)
        assert rig.link.client_read()[3] == sync[3]


def test_list_of_faults_explains_each_with_its_end_and_its_parameters() -> None:
    shown = listing("faults")
    for kind in FAULTS.values():
        assert kind.name in shown
        assert kind.meaning in shown
        assert f"ends: {kind.ending}" in shown
        assert all(f"{key}=: {parameter.meaning}" in shown for key, parameter in kind.parameters.items())
    assert "needs: gyro" in shown
