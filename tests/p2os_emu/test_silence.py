"""An emulator is as silent as it says: what lets a runner take steps together."""

import math
from collections.abc import Iterator

import pytest

import configs
from p2os import Command, RobotModel, encode_command
from p2os.accessories.lms import LmsMode, LmsRequestCode
from p2os.accessories.lms_framing import encode
from p2os.framing import encode_frame
from p2os_emu.emulator import STEP, Emulator
from p2os_emu.fit import read_fit
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.world import World, load_world

OPENING = (bytes([Command.SYNC0]), bytes([Command.SYNC1]), bytes([Command.SYNC2]), bytes([Command.OPEN]))


class Site:
    """A robot with a laser, and the client's ends of its lines."""

    def __init__(self, world: World, profile: str = "ideal") -> None:
        model, fit = read_fit(["laser"], configs.load(RobotModel, "robots", "p3dx-sh"))
        self.line, self.laser = MemoryLink(), MemoryLink()
        self.emulator = Emulator(world, configs.load(LinkProfile, "links", profile))
        self.emulator.add("happy", model, self.line, fit=fit, cables={"laser": self.laser})

    def sends(self) -> bool:
        """Take a step; return whether anything was sent."""
        self.emulator.step()
        return bool(self.line.client_read()) | bool(self.laser.client_read())

    def longest_silence(self, seconds: float) -> int:
        """Steps of the longest silence that was announced; fails where something is sent in one."""
        longest = silent = 0
        for _ in range(round(seconds / STEP)):
            if silent:
                silent -= 1
                assert not self.sends()
                continue
            self.sends()
            silence = self.emulator.silence
            silent = 12 if silence == math.inf else max(0, math.ceil(silence / STEP - 1e-6) - 1)
            longest = max(longest, silent)
        return longest


@pytest.fixture
def world() -> Iterator[World]:
    with World(load_world("office")) as world:
        yield world


def test_a_robot_without_client_is_silent_until_it_is_spoken_to(world: World) -> None:
    site = Site(world)
    assert site.longest_silence(3.0) == 12
    assert site.emulator.robots["happy"].microcontroller.silence == math.inf


def test_a_robot_with_a_client_is_silent_between_two_sips(world: World) -> None:
    site = Site(world)
    for word in OPENING:
        site.line.client_write(encode_frame(word))
        site.sends()
    site.longest_silence(0.2)
    site.line.client_write(encode_command(Command.ENABLE, 1))
    site.line.client_write(encode_command(Command.VEL, 0.2))
    site.sends()
    assert site.longest_silence(3.0) == 11


def test_a_laser_that_scans_is_silent_between_two_scans(world: World) -> None:
    site = Site(world)
    for _ in range(240):
        site.emulator.step()  # it boots
    site.laser.client_write(encode(LmsRequestCode.MODE, bytes((LmsMode.CONTINUOUS,))))
    for _ in range(24):
        site.emulator.step()
    site.laser.client_read()
    assert site.longest_silence(3.0) > 3
    assert site.emulator.silence < math.inf


def test_a_line_that_keeps_bytes_back_is_never_taken_for_silent(world: World) -> None:
    assert Site(world, "rs232").emulator.silence == 0.0
