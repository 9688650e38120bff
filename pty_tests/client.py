"""A small P2OS client of the suite's own, made from the protocol's description alone.

Frame: FA FB, COUNT (payload + 2), payload, checksum with its high byte first. Inside the payload all is little-endian.
"""

import time
from collections.abc import Callable, Iterator
from typing import NamedTuple, Self

import serial

from pty_tests.packets import Sip
from tests.waiting import Deadline

SYNC = b"\xfa\xfb"
LONGEST_FRAME = 208  # bytes in all; the old clients' buffers hold no more
POSITIVE, NEGATIVE, STRING = 0x3B, 0x1B, 0x2B

PULSE, OPEN, CLOSE, POLLING, ENABLE, SETA, SETV, SETO, MOVE, ROTATE, SETRV, VEL, HEAD, DHEAD = range(14)
CONFIG, ENCODER, RVEL, DCHEAD, SETRA, SONAR, STOP, VEL2 = 18, 19, 21, 22, 23, 28, 29, 32
ADSEL, IOREQUEST, SONARCYCLE, HOSTBAUD, ESTOP, BATTERYINFO, RESET = 35, 40, 48, 50, 55, 62, 253


class Silence(AssertionError):
    """The robot did not send in time what it owed."""


class Heard(NamedTuple):
    """One sound frame: its payload, and when it had wholly arrived (s on this process's steady clock)."""

    payload: bytes
    at: float


class Identity(NamedTuple):
    """The three strings of the SYNC2 answer."""

    name: str
    robot_class: str
    subtype: str


def checksum(payload: bytes) -> int:
    """Sum of the payload's 16-bit big-endian words; an odd last byte is XORed into the low byte."""
    total = 0
    for i in range(0, len(payload) - 1, 2):
        total = (total + payload[i] * 256 + payload[i + 1]) % 65536
    return total ^ payload[-1] if len(payload) % 2 else total


def frame(payload: bytes) -> bytes:
    """The wire form of a payload."""
    total = checksum(payload)
    return SYNC + bytes([len(payload) + 2]) + payload + bytes([total // 256, total % 256])


def command(number: int, value: int | bytes | None = None) -> bytes:
    """The wire form of a command with no argument, a signed integer (sign by argument type) or a counted string."""
    if value is None:
        return frame(bytes([number]))
    if isinstance(value, bytes):
        return frame(bytes([number, STRING, len(value)]) + value)
    kind = NEGATIVE if value < 0 else POSITIVE
    return frame(bytes([number, kind, abs(value) % 256, abs(value) // 256]))


class Splitter:
    """Cuts a byte stream into payloads, and keeps whatever was no sound frame for a test to complain about."""

    def __init__(self) -> None:
        self._buffer = b""
        self.stray = b""
        self.damaged: list[bytes] = []

    def receive(self, data: bytes) -> Iterator[bytes]:
        """Payloads completed by these bytes."""
        self._buffer += data
        while (start := self._buffer.find(SYNC)) >= 0:
            self.stray += self._buffer[:start]
            self._buffer = self._buffer[start:]
            if len(self._buffer) < 3 or len(self._buffer) < self._buffer[2] + 3:
                return
            whole, self._buffer = self._buffer[: self._buffer[2] + 3], self._buffer[self._buffer[2] + 3 :]
            payload = whole[3:-2]
            if payload and whole == frame(payload):
                yield payload
            else:
                self.damaged.append(whole)
        keep = 1 if self._buffer.endswith(SYNC[:1]) else 0
        self.stray += self._buffer[: len(self._buffer) - keep]
        self._buffer = self._buffer[len(self._buffer) - keep :]

    def forget(self) -> None:
        """Start over, as after a stream that was joined in the middle."""
        self._buffer, self.stray, self.damaged = b"", b"", []


class Client:
    """One end of the cable. Reads only while a test waits for something; a test's thread is the only one.

    clock: steady time, s: the port's own if it has one, as the port of a robot in virtual time does.
    """

    def __init__(self, port: str, baud: int = 9600) -> None:
        # A read returns with the first byte, or empty after 20 ms; nobody sleeps longer than that.
        self._line = serial.serial_for_url(port, baudrate=baud, timeout=0.02, write_timeout=5.0)
        self.clock: Callable[[], float] = getattr(self._line, "clock", time.monotonic)
        self._splitter = Splitter()
        self._last_sent = self.clock()
        self._heard: list[Heard] = []  # arrived, not yet asked for
        self.longest = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.shut()

    def shut(self) -> None:
        """Close this end of the cable and say nothing to the robot."""
        self._line.close()

    @property
    def complaints(self) -> list[str]:
        """What was wrong with the bytes heard since the connection was made."""
        found = []
        if self._splitter.stray:
            found.append(f"bytes outside any frame: {self._splitter.stray.hex(' ')}")
        found += [f"damaged frame: {raw.hex(' ')}" for raw in self._splitter.damaged]
        if self.longest > LONGEST_FRAME:
            found.append(f"a frame of {self.longest} bytes; clients hold {LONGEST_FRAME}")
        return found

    # Sending

    def write(self, raw: bytes) -> None:
        """Put bytes on the line as they are."""
        self._line.write(raw)
        self._line.flush()
        self._last_sent = self.clock()

    def send(self, number: int, value: int | bytes | None = None) -> None:
        """Send one command."""
        self.write(command(number, value))

    # Hearing

    def hear(self, seconds: float, *, pulse: bool = True) -> Iterator[Heard]:
        """Frames as they arrive until the time is up; keeps the robot's watchdog fed unless told not to."""
        deadline = self.clock() + seconds
        while True:
            while self._heard:
                yield self._heard.pop(0)
            if self.clock() >= deadline:
                return
            if pulse and self.clock() - self._last_sent > 0.5:
                self.send(PULSE)
            self._read()

    def _hear_until(self, deadline: Deadline, *, pulse: bool) -> Iterator[Heard]:
        """Frames as they arrive until the deadline has passed."""
        is_over = False
        while not is_over:
            yield from self.hear(deadline.left, pulse=pulse)
            is_over = deadline.has_passed()

    def _read(self) -> None:
        data = self._line.read(1)
        if data and (more := self._line.in_waiting):
            data += self._line.read(more)
        now = self.clock()
        for payload in self._splitter.receive(data):
            self.longest = max(self.longest, len(payload) + 5)
            self._heard.append(Heard(payload, now))

    def wait(self, wanted: Callable[[bytes], bool], what: str, within: float = 3.0, *, pulse: bool = True) -> bytes:
        """The next payload that is wanted; those before it are dropped.

        Raises:
            Silence: It did not come within this many seconds, or more where the machine of this test is busy.
        """
        for heard in self._hear_until(Deadline(within), pulse=pulse):
            if wanted(heard.payload):
                return heard.payload
        raise Silence(f"no {what} within {within} s")

    def answer(self, raw: bytes, within: float = 1.0) -> bytes:
        """Send bytes and return the first payload that comes back, whatever it is."""
        self.write(raw)
        return self.wait(lambda _: True, f"answer to {raw.hex(' ')}", within, pulse=False)

    def sip(
        self, wanted: Callable[[Sip], bool] = lambda _: True, what: str = "standard SIP", within: float = 3.0
    ) -> Sip:
        """The next standard SIP that is wanted."""
        return Sip.parse(self.wait(lambda p: Sip.is_one(p) and wanted(Sip.parse(p)), what, within))

    def next(self, packet_type: int, within: float = 1.0, *, pulse: bool = True) -> bytes:
        """The next payload of one type."""
        return self.wait(lambda payload: payload[0] == packet_type, f"packet {packet_type:#04x}", within, pulse=pulse)

    def motors_become(self, on: bool) -> Sip:
        """The next SIP whose flag says that the motors are on, or off."""
        return self.sip(lambda sip: sip.motors is on, f"SIP with motors {'on' if on else 'off'}")

    def fresh_sip(self) -> Sip:
        """A SIP composed after everything sent before this call was processed: the second from now."""
        self.forget()
        self.sip()
        return self.sip()

    def record(self, count: int, *, pulse: bool = True) -> list[Heard]:
        """Everything heard up to and including this many standard SIPs."""
        heard = []
        for item in self._hear_until(Deadline(1.0 + count * 0.5), pulse=pulse):
            heard.append(item)
            count -= Sip.is_one(item.payload)
            if not count:
                return heard
        raise Silence(f"the SIP stream stopped {count} SIPs too early")

    def sips(self, count: int, *, pulse: bool = True) -> list[Sip]:
        """The next standard SIPs."""
        return [Sip.parse(heard.payload) for heard in self.record(count, pulse=pulse) if Sip.is_one(heard.payload)]

    def forget(self) -> None:
        """Drop the frames that have arrived and were not asked for."""
        self._read()
        self._heard.clear()

    # Handshake

    def greets(self, within: float) -> bool:
        """Send one SYNC0; whether it is answered, as a robot in conversation never does."""
        self.send(PULSE)
        return any(heard.payload == b"\x00" for heard in self.hear(within, pulse=False))

    def hang_up(self) -> None:
        """Bring a robot from any state to the one before a handshake, and the line to rest."""
        for _ in range(5):
            self.send(CLOSE, 1)  # with an argument it is a CLOSE in every state; a bare 02 may be a SYNC2
            if self.greets(0.4):  # which proves that the stream has ended
                break
        else:
            raise Silence("no answer to SYNC0 after CLOSE")
        self.send(CLOSE, 1)
        self.forget()
        self._splitter.forget()
        self.longest = 0

    def sync(self) -> Identity:
        """SYNC0, SYNC1, SYNC2 from any state of the robot; a try is lost when an answer takes longer than a second."""
        for _ in range(5):
            self.send(CLOSE, 1)
            self.forget()
            try:
                for number in range(3):
                    self.write(frame(bytes([number])))
                    answer = self.next(number, 1.0, pulse=False)
            except Silence:
                continue  # it does not answer yet: once more
            self._splitter.forget()  # the stream may have been joined in the middle
            return identity(answer)
        raise Silence("no handshake in five tries")

    def connect(self) -> Identity:
        """Handshake and OPEN; returns with the first SIP heard."""
        announced = self.sync()
        self.send(OPEN)
        self.sip(what="SIP after OPEN", within=1.0)
        return announced


def identity(payload: bytes) -> Identity:
    """The strings of a SYNC2 answer.

    Raises:
        AssertionError: The payload is not 02 and three strings that end with NUL.
    """
    assert payload[0] == 2, payload.hex(" ")
    assert payload.endswith(b"\0"), payload
    strings = payload[1:-1].split(b"\0")
    assert len(strings) == 3, payload
    return Identity(*(text.decode("ascii") for text in strings))
