"""What somebody who never saw this project writes against a PowerBot on a serial port, with the standard library only.

Usage: stranger.py PORT. Prints what the robot did as one JSON object. Run by `test_stranger.py`.
"""

import json
import os
import select
import struct
import sys
import termios
import time
import tty
from collections.abc import Callable

DIST_CONV = 0.5813  # mm per count, powerbot.p
Sip = tuple[int, int, int, int, int, int]  # x, y, heading (counts), left, right (mm/s), motor flag


class Robot:
    """The robot behind a serial port."""

    def __init__(self, path: str) -> None:
        self.fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(self.fd)
        attributes = termios.tcgetattr(self.fd)
        attributes[4] = attributes[5] = termios.B9600
        termios.tcsetattr(self.fd, termios.TCSANOW, attributes)
        self.buffer = b""
        self.sonar: set[int] = set()

    def send(self, *payload: int) -> None:
        data = bytes(payload)
        padded = data[: len(data) // 2 * 2]
        total = sum(struct.unpack(f">{len(padded) // 2}H", padded)) & 0xFFFF
        if len(data) % 2:
            total ^= data[-1]
        os.write(self.fd, b"\xfa\xfb" + bytes([len(data) + 2]) + data + struct.pack(">H", total))

    def order(self, number: int, value: int) -> None:
        self.send(number, 0x1B if value < 0 else 0x3B, abs(value) & 255, abs(value) >> 8)

    def packet(self, seconds: float = 2.0) -> bytes:
        """The next payload."""
        deadline = time.monotonic() + seconds
        while True:
            if len(self.buffer) > 2 and len(self.buffer) >= self.buffer[2] + 3:
                size = self.buffer[2] + 3
                payload, self.buffer = self.buffer[3 : size - 2], self.buffer[size:]
                return payload
            if not select.select([self.fd], [], [], max(0.0, deadline - time.monotonic()))[0]:
                raise SystemExit(f"nothing heard for {seconds} s")
            self.buffer += os.read(self.fd, 1024)

    def sip(self) -> Sip:
        """The next SIP; the sonar numbers in it are collected."""
        while True:
            payload = self.packet()
            if payload[0] in (0x32, 0x33):
                x, y, heading, left, right = struct.unpack_from("<HHhhh", payload, 1)
                self.sonar |= {payload[20 + 3 * i] for i in range(payload[19])}
                return x, y, heading, left, right, payload[16] & 1

    def until(self, holds: Callable[[Sip], object], sips: int = 60, pulse: bool = True) -> Sip:
        """SIPs until one fits."""
        for _ in range(sips):
            sip = self.sip()
            if holds(sip):
                return sip
            if pulse:
                self.send(0)
        raise SystemExit(f"not in {sips} SIPs; the last was {sip}")


def straight(sip: Sip, speed: int) -> bool:
    return abs(sip[3] - speed) < 10 and abs(sip[4] - speed) < 10


def main() -> None:
    robot = Robot(sys.argv[1])
    answers = []
    for sync in range(3):
        robot.send(sync)
        answers.append(robot.packet())
    robot.send(1)  # OPEN
    robot.order(28, 1)  # SONAR
    robot.order(4, 1)  # ENABLE
    robot.until(lambda sip: sip[5] and len(robot.sonar) >= 28)

    before = robot.sip()
    robot.order(11, 200)  # VEL
    robot.until(lambda sip: straight(sip, 200))
    driven = robot.until(lambda sip: (sip[0] - before[0]) % 32768 * DIST_CONV > 150)
    robot.order(11, 0)
    stopped = robot.until(lambda sip: straight(sip, 0))

    robot.order(12, 45)  # HEAD
    robot.until(lambda sip: abs(sip[2] - 512) < 12)
    robot.order(12, 0)
    turned = robot.until(lambda sip: abs(sip[2]) < 12)

    robot.order(11, 100)
    robot.until(lambda sip: straight(sip, 100))
    robot.send(0)  # the last word
    silence = time.monotonic()
    halted = robot.until(lambda sip: straight(sip, 0), pulse=False)
    silence = time.monotonic() - silence
    robot.send(29)  # STOP, or the next packet would resume the drive
    robot.send(2)  # CLOSE
    print(
        json.dumps(
            {
                "syncs": [answer[0] for answer in answers],
                "identity": answers[2][1:].decode().split("\0"),
                "sonar": sorted(robot.sonar),
                "speed": driven[3:5],
                "rest": stopped[3:5],
                "turned": turned[2],
                "halted": halted[3:5],
                "silence": silence,
            }
        )
    )


main()
