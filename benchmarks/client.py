"""A plain client on a port, for measuring: it connects, sends frames, and notes when each SIP's last byte arrived."""

import os
import select
import socket
import time
import tty
from collections.abc import Iterator
from typing import Self

import configs
from p2os import (
    Command,
    CommandValue,
    Frame,
    FrameDecoder,
    HostHandshake,
    RobotModel,
    SipCodec,
    StandardSip,
    encode_command,
)
from p2os.sip import SIP_TYPES

ANSWER_TIMEOUT_S = 0.5
CONNECT_TIMEOUT_S = 5.0


TCP = "socket://"


def open_port(port: str) -> int:
    """Open a pty or `socket://HOST:PORT` for reading without waiting; returns the descriptor."""
    if port.startswith(TCP):
        host, _, number = port.removeprefix(TCP).rpartition(":")
        connection = socket.create_connection((host, int(number)), CONNECT_TIMEOUT_S)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setblocking(False)
        return connection.detach()
    descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    tty.setraw(descriptor)
    return descriptor


class PortClient:
    """Holds a pty or a TCP connection open as a client would; use it as a context manager."""

    def __init__(self, port: str) -> None:
        self.descriptor = open_port(port)
        self._frames = FrameDecoder()
        self._codec: SipCodec | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        os.close(self.descriptor)

    def connect(self) -> None:
        """Shake hands and open the robot.

        Raises:
            TimeoutError: The robot did not answer.
        """
        handshake = HostHandshake()
        deadline = time.monotonic() + CONNECT_TIMEOUT_S
        while handshake.identity is None:
            if time.monotonic() > deadline:
                raise TimeoutError(f"no robot answered in {CONNECT_TIMEOUT_S} s")
            os.write(self.descriptor, handshake.request())
            for _, payload in self.payloads(ANSWER_TIMEOUT_S):
                handshake.receive(payload)
                break
        self._codec = SipCodec(configs.load(RobotModel, "robots", handshake.identity.subtype))
        self.send(Command.OPEN)

    def send(self, command: Command, value: CommandValue | None = None) -> float:
        """Send one command; returns the time just before, s on the steady clock."""
        now = time.monotonic()
        os.write(self.descriptor, encode_command(command, value))
        return now

    def payloads(self, seconds: float) -> Iterator[tuple[float, bytes]]:
        """Arrival time and payload of every frame that comes within some seconds."""
        deadline = time.monotonic() + seconds
        while (rest := deadline - time.monotonic()) > 0:
            if select.select([self.descriptor], [], [], rest)[0]:
                yield from self.read()

    def read(self) -> list[tuple[float, bytes]]:
        """Arrival time and payload of every frame that is complete with the bytes that wait.

        Raises:
            ConnectionError: The robot hung up.
        """
        data = os.read(self.descriptor, 4096)
        if not data:
            raise ConnectionError("the robot hung up")
        now = time.monotonic()
        return [(now, event.payload) for event in self._frames.receive(data, now) if isinstance(event, Frame)]

    def sips(self, seconds: float) -> Iterator[tuple[float, StandardSip]]:
        """Arrival time and content of every SIP that comes within some seconds."""
        if self._codec is None:
            raise RuntimeError("connect first: the robot's model says how to read its SIPs")
        for now, payload in self.payloads(seconds):
            if payload[0] in SIP_TYPES:
                yield now, self._codec.decode(payload)
