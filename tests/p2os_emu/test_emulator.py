"""One step of robots on lines in memory, in a world without physics."""

import pytest

import configs
from geometry import Pose2D
from p2os import Command, RobotModel, encode_command
from p2os_emu.emulator import STEP, EmulatedRobot, Emulator
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.world import STEP as WORLD_STEP
from tests.p2os_emu.flat_world import FlatWorld

P3DX = configs.load(RobotModel, "robots", "p3dx")
IDEAL = configs.load(LinkProfile, "links", "ideal")
RS232 = configs.load(LinkProfile, "links", "rs232")
SYNCS = [bytes.fromhex(frame) for frame in ("FA FB 03 00 00 00", "FA FB 03 01 00 01", "FA FB 03 02 00 02")]

SIP_BEGIN = b"\xfa\xfb"


class Rig:
    """An emulator with one robot and its client."""

    def __init__(self, profile: LinkProfile = IDEAL, *, seed: int = 0, hangup_stops: bool = False) -> None:
        self.world = FlatWorld()
        self.emulator = Emulator(self.world, profile, seed=seed, hangup_stops=hangup_stops)
        self.link = MemoryLink()
        self.robot: EmulatedRobot = self.emulator.add("happy", P3DX, self.link)

    def tell(self, command: Command, value: float | None = None) -> None:
        self.link.client_write(encode_command(command, value))

    def run(self, seconds: float) -> bytes:
        for _ in range(round(seconds / STEP)):
            self.emulator.step()
        return self.link.client_read()

    def connect(self) -> None:
        for sync in SYNCS:
            self.link.client_write(sync)
            self.run(0.1)
        self.tell(Command.OPEN)
        self.tell(Command.ENABLE, 1)
        self.run(0.1)

    def drive(self) -> None:
        self.connect()
        self.tell(Command.VEL, 0.2)
        self.run(1.5)


def test_step_is_the_worlds_step() -> None:
    assert WORLD_STEP == STEP


def test_command_from_the_line_turns_the_wheels_in_the_same_step() -> None:
    rig = Rig()
    rig.connect()
    rig.tell(Command.VEL, 0.2)
    rig.run(STEP)
    assert rig.emulator.world.truth("happy").linear > 0


def test_sip_comes_every_tenth_of_a_second() -> None:
    rig = Rig()
    rig.connect()
    rig.link.client_read()
    sips = 0
    for _ in range(240):
        rig.emulator.step()
        pieces = rig.link.client_read_pieces()
        sips += sum(piece[3] & 0xF0 == 0x30 for piece in pieces)
    assert sips == 20


def test_second_robot_does_not_change_what_the_first_one_says() -> None:
    alone, accompanied = Rig(), Rig()
    accompanied.emulator.add("grumpy", P3DX, MemoryLink())
    for rig in (alone, accompanied):
        rig.drive()
    assert alone.run(1.0) == accompanied.run(1.0)


def test_run_repeats_with_the_seed() -> None:
    def said(seed: int) -> bytes:
        rig = Rig(RS232, seed=seed)
        rig.drive()
        return rig.run(1.0)

    assert said(3) == said(3)


def test_the_world_hears_each_tune_once_and_nothing_of_a_buzzer_that_is_off() -> None:
    rig = Rig()
    rig.connect()
    tune = Command.SAY, b"\x0a\x45\x05\x00\x0a\x51"  # 0.2 s, a rest of 0.1 s, 0.2 s
    for _ in range(2):
        rig.link.client_write(encode_command(*tune))
        rig.run(1.0)
    assert rig.world.sounds == {"happy": 2}
    rig.tell(Command.SOUNDTOG, 0)
    rig.link.client_write(encode_command(*tune))
    rig.run(1.0)
    assert rig.world.sounds == {"happy": 2}


def test_name_in_use_is_refused() -> None:
    rig = Rig()
    with pytest.raises(ValueError, match="there is a robot 'happy' already"):
        rig.emulator.add("happy", P3DX, MemoryLink())


def test_removed_robot_is_gone_from_world_and_line() -> None:
    rig = Rig()
    rig.emulator.remove("happy")
    assert rig.world.bodies == {}
    assert not rig.link.attached
    rig.emulator.step()


def test_restart_carries_the_robot_back_and_presses_reset() -> None:
    rig = Rig()
    rig.drive()
    assert rig.emulator.world.truth("happy").pose.x > 0.1
    rig.emulator.restart(["happy"])
    assert rig.emulator.world.truth("happy").pose == Pose2D()
    rig.run(0.1)
    assert not rig.robot.microcontroller.connected
    assert rig.emulator.world.truth("happy").linear == 0


@pytest.mark.parametrize(("hangup_stops", "moves"), [(True, False), (False, True)])
def test_robot_whose_client_left_stops_at_once_only_if_asked_to(hangup_stops: bool, moves: bool) -> None:
    rig = Rig(hangup_stops=hangup_stops)
    rig.drive()
    rig.tell(Command.PULSE)
    rig.run(STEP)
    rig.link.unplug()
    rig.run(1.0)
    assert (rig.emulator.world.truth("happy").linear > 0) is moves


def test_rs232_line_delays_the_answer_by_the_time_of_its_bytes() -> None:
    rig = Rig(RS232)
    rig.link.client_write(SYNCS[0])
    # Six bytes of ten bits each way at 9600 bit/s: 12.5 ms, and the firmware's step.
    assert rig.run(STEP) == b""
    assert rig.run(3 * STEP) == SYNCS[0]


def test_hostbaud_takes_the_line_to_a_new_rate_that_the_client_must_follow() -> None:
    rig = Rig(RS232)
    rig.link.client_rate = 9600
    rig.connect()
    rig.tell(Command.HOSTBAUD, 2)
    rig.run(0.2)
    assert rig.robot.microcontroller.board.host_baud == 38400
    assert SIP_BEGIN not in rig.run(1.0), "the client still listens at 9600"
    rig.link.client_rate = 38400
    assert rig.run(1.0).count(SIP_BEGIN) >= 9
    rig.tell(Command.VEL, 0.2)
    rig.run(0.5)
    assert rig.emulator.world.truth("happy").linear > 0


def test_serial_numbers_differ_between_robots_and_seeds_and_repeat_with_the_seed() -> None:
    model = configs.load(RobotModel, "robots", "p3dx-sh")

    def serials(seed: int) -> list[str]:
        emulator = Emulator(FlatWorld(), LinkProfile("ideal"), seed=seed)
        return [emulator.flash(model, name).serial for name in ("happy", "doc")]

    assert len({*serials(0), *serials(1)}) == 4
    assert serials(1) == serials(1)
