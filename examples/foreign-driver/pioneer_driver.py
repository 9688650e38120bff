"""A small driver for Pioneer robots, as somebody might have written it for one lab: pyserial and a thread.

with PioneerDriver("/dev/ttyUSB0") as robot:
    robot.move(0.5)
    robot.wait_until(lambda: robot.x > 0.49)
"""

import struct
import threading
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple, Self

import serial

SYNC0, SYNC1, SYNC2 = PULSE, OPEN, CLOSE = 0, 1, 2
ENABLE, MOVE, VEL, STOP = 4, 8, 11, 29
SIP_TYPES = (0x32, 0x33)
SIP = struct.Struct("<B hh h hh B H h H")  # type, x, y, heading, left and right speed, battery, stalls, control, flags
MOTORS_ENABLED, STOP_BUTTON = 1 << 0, 1 << 5
METRES = 0.001  # per count of a P3-DX

BEAT_S = 0.2  # between two packets to the robot, whose watchdog waits for 2 s
SILENCE_S = 1.0  # without a packet from the robot, after which it is lost
ANSWER_S = 0.5  # that a step of the handshake may take


class DriverError(Exception):
    """The robot cannot be used as asked."""


class Report(NamedTuple):
    """The robot's last packet. x, y: m since the robot was switched on. speed: m/s."""

    x: float
    y: float
    speed: float
    motors_enabled: bool
    stop_pressed: bool


class PioneerDriver:
    """One robot. Connects when it is made, and again by itself when the line fails."""

    def __init__(self, port: str, baud: int = 9600) -> None:
        self.name = ""
        self.lost = 0  # how often the line has failed
        self._line = serial.Serial(port, baud, timeout=0.02)
        self._heard = bytearray()
        self._report: Report | None = None
        self._beat = packet(PULSE)
        self._lock = threading.Lock()
        self._is_closing = threading.Event()
        self._connect()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @property
    def is_connected(self) -> bool:
        """Whether the robot is heard."""
        return self._report is not None

    @property
    def report(self) -> Report:
        """The last one."""
        report = self._report
        if report is None:
            raise DriverError("the robot is not connected")
        return report

    def drive(self, speed: float) -> None:
        """Drive at a speed, m/s, until told otherwise."""
        self._command(VEL, speed)

    def move(self, distance: float) -> None:
        """Drive a distance, m."""
        self._command(MOVE, distance)

    def stop(self) -> None:
        """Stop."""
        self._beat = packet(STOP)
        self._say(self._beat)

    def enable(self) -> None:
        """Switch the motors on."""
        self._beat = packet(PULSE)
        self._say(packet(ENABLE, 1))

    def wait_until(self, condition: Callable[[], bool], seconds: float = 20.0) -> None:
        """Wait until something is so."""
        end = time.monotonic() + seconds
        while not (self.is_connected and condition()):
            if time.monotonic() > end:
                raise DriverError(f"it did not happen within {seconds} s")
            time.sleep(0.01)

    def close(self) -> None:
        """Stop the robot and let it go."""
        self._is_closing.set()
        self._thread.join()
        self._say(packet(STOP))
        self._say(packet(CLOSE))
        self._line.flush()
        self._line.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _command(self, number: int, metres: float) -> None:
        if not self.report.motors_enabled:
            raise DriverError("the motors are off; enable them first")
        command = packet(number, round(metres / METRES))
        self._beat = command if number == VEL else packet(PULSE)
        self._say(command)

    def _run(self) -> None:
        heard_at = beaten_at = time.monotonic()
        while not self._is_closing.is_set():
            now = time.monotonic()
            for payload in self._listen():
                if self._take(payload):
                    heard_at = now
            if now - heard_at > SILENCE_S:
                self.lost += 1
                self._report = None
                self._beat = packet(STOP)  # whatever was asked for: a robot that is found again stands
                self._connect()
                heard_at = time.monotonic()
            if now - beaten_at > BEAT_S:
                self._say(self._beat)
                beaten_at = now

    def _connect(self) -> None:
        while not self._is_closing.is_set():
            # A robot that was left in the middle of something stops and begins anew.
            for begin in STOP, CLOSE:
                self._say(packet(begin))
            if all(self._shake_hands(step) for step in (SYNC0, SYNC1, SYNC2)):
                for opening in packet(OPEN), packet(STOP), packet(ENABLE, 1):
                    self._say(opening)
                return

    def _shake_hands(self, step: int) -> bool:
        end = time.monotonic() + ANSWER_S
        self._say(packet(step))
        while time.monotonic() < end:
            for payload in self._listen():
                if payload[0] == step:
                    self.name = payload[1:].split(b"\0")[0].decode() or self.name
                    return True
        return False

    def _take(self, payload: bytes) -> bool:
        if payload[0] not in SIP_TYPES:
            return False
        _, x, y, _, left, right, _, _, _, flags = SIP.unpack_from(payload)
        speed = (left + right) / 2 * METRES
        self._report = Report(x * METRES, y * METRES, speed, bool(flags & MOTORS_ENABLED), bool(flags & STOP_BUTTON))
        return True

    def _say(self, data: bytes) -> None:
        with self._lock:
            self._line.write(data)

    def _listen(self) -> Iterator[bytes]:
        """The payloads of the sound packets that have come."""
        self._heard += self._line.read(256)
        while (start := self._heard.find(b"\xfa\xfb")) >= 0:
            del self._heard[:start]
            if len(self._heard) < 3 or len(self._heard) < 3 + self._heard[2]:
                return
            payload, sum_ = bytes(self._heard[3 : 1 + self._heard[2]]), self._heard[1 + self._heard[2] :][:2]
            is_sound = bool(payload) and checksum(payload) == sum_
            del self._heard[: 3 + self._heard[2] if is_sound else 2]
            if is_sound:
                yield payload


def packet(command: int, argument: int | None = None) -> bytes:
    """A command as the wire carries it."""
    payload = bytes([command])
    if argument is not None:
        payload += struct.pack("<BH", 0x3B if argument >= 0 else 0x1B, abs(argument))
    return b"\xfa\xfb" + bytes([len(payload) + 2]) + payload + checksum(payload)


def checksum(payload: bytes) -> bytes:
    """The sum of the payload's words, high byte first; an odd last byte is XORed in."""
    even = len(payload) & ~1
    total = sum(struct.unpack(f">{even // 2}H", payload[:even])) & 0xFFFF
    return struct.pack(">H", total ^ payload[-1] if len(payload) & 1 else total)
