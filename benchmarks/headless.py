"""How many times faster than real time the emulator is without ports, with driving robots in `office`."""

import argparse
import time

import configs
from benchmarks.figures import Figure
from p2os import Command, HostHandshake, RobotModel, encode_command
from p2os.accessories.lms import MODE_OF_BAUD, LmsMode, LmsRequestCode
from p2os.accessories.lms_framing import encode
from p2os.framing import Frame, FrameDecoder
from p2os_emu.emulator import STEP, Emulator
from p2os_emu.fit import read_fit
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.world import World, load_world

FACTORS = {1: 120.0, 7: 30.0, 20: 12.0, 50: 4.0}
"""Times real time to reach, by number of robots."""
SECONDS = 10.0  # of emulated time
SETTLE_S = 1.0
ANSWER_S = 0.5
KEEP_ALIVE_S = 1.0
LASER_MODES = (LmsMode.ON_REQUEST, MODE_OF_BAUD[38400], LmsMode.CONTINUOUS)
"""What lets a laser scan without end, ten times a second."""


def measure(options: argparse.Namespace) -> list[Figure]:
    """Teams of each size, in processor time; the figure is what one emulated second takes."""
    return [_figure(robots, factor(robots)) for robots in FACTORS]


def _figure(robots: int, times: float) -> Figure:
    name = f"headless, robots with sonar and laser: {robots}; processor time of 1 s ({times:.1f} times real time)"
    return Figure("headless", name, 1e3 / times, 1e3 / FACTORS[robots], "ms", robots)


def factor(robots: int, seconds: float = SECONDS) -> float:
    """Return the emulated seconds for each second of processor time."""
    team = Team(robots)
    team.run(SETTLE_S)
    begun = time.process_time()
    team.run(seconds)
    return seconds / (time.process_time() - begun)


class Team:
    """Robots that drive in circles and whose lasers scan without end, with hosts in this process.

    scanned: bytes that the lasers have sent.
    """

    def __init__(self, robots: int) -> None:
        self.scanned = 0
        self._emulator = Emulator(World(load_world("office"), seed=1), LinkProfile("ideal"), seed=1)
        self._links: list[MemoryLink] = []
        self._lasers: list[MemoryLink] = []
        for number in range(robots):
            model, fit = read_fit(["laser"], configs.load(RobotModel, "robots", "p3dx-sh"))
            link, cables = MemoryLink(), {part: MemoryLink() for part in fit.cables}
            self._emulator.add(f"r{number}", model, link, fit=fit, cables=cables)
            self._links.append(link)
            self._lasers.append(cables["laser"])
        for link in self._links:
            self._connect(link)
            for command, value in ((Command.OPEN, None), (Command.ENABLE, 1), (Command.VEL, 0.3), (Command.RVEL, 0.5)):
                link.client_write(encode_command(command, value))
        for mode in LASER_MODES:
            for laser in self._lasers:
                laser.client_write(encode(LmsRequestCode.MODE, bytes((mode,))))
            self.run(ANSWER_S)

    def run(self, seconds: float) -> None:
        """Let emulated time pass; hosts keep their robots alive and read what comes."""
        per_pulse = round(KEEP_ALIVE_S / STEP)
        for step in range(round(seconds / STEP)):
            if step % per_pulse == 0:
                for link in self._links:
                    link.client_write(encode_command(Command.PULSE))
                    link.client_read()
                for laser in self._lasers:
                    self.scanned += len(laser.client_read())
            self._emulator.step()

    def _connect(self, link: MemoryLink) -> None:
        handshake, frames = HostHandshake(), FrameDecoder()
        deadline = self._emulator.time + ANSWER_S
        while handshake.identity is None:
            if self._emulator.time > deadline:
                raise TimeoutError(f"the robot did not answer in {ANSWER_S} s")
            link.client_write(handshake.request())
            self._emulator.step()
            for event in frames.receive(link.client_read(), self._emulator.time):
                if isinstance(event, Frame):
                    handshake.receive(event.payload)
