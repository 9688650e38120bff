"""A robot reduced to its cable: shakes hands, sends a SIP each cycle, and notes when bytes were written and read.

Stands in for the emulator where only the gateway's own time is to be measured.
"""

import os
import select
import threading
import time
import tty
from typing import Self

import configs
from p2os import (
    Command,
    ConnectionState,
    Frame,
    FrameDecoder,
    Identity,
    RobotHandshake,
    RobotModel,
    SipCodec,
    SipFlag,
    StandardSip,
    decode_command,
    encode_frame,
)

CYCLE_S = 0.1
STEP_M = 0.001


class CableRobot:
    """Runs in a thread between `with` and its end.

    written: time at which the SIP whose position is this many steps of 1 mm had left, s on the steady clock.
    velocities: arrival time and value of each VEL; a STOP is one of zero.
    """

    def __init__(self, name: str, model: str = "p3dx-sh") -> None:
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)
        self._identity = Identity(name, "Pioneer", model)
        self._handshake = RobotHandshake(self._identity)
        self._codec = SipCodec(configs.load(RobotModel, "robots", model))
        self._frames = FrameDecoder()
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._enabled = False
        self._steps = 0
        self.written: dict[int, float] = {}
        self.velocities: list[tuple[float, float]] = []

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._ending.set()
        self._thread.join()
        os.close(self._master)
        os.close(self._slave)

    @property
    def speed(self) -> float:
        """The last that it was told, m/s."""
        return self.velocities[-1][1] if self.velocities else 0.0

    def _run(self) -> None:
        due = time.monotonic()
        while not self._ending.is_set():
            wait = max(0.0, due - time.monotonic())
            if select.select([self._master], [], [], wait)[0]:
                self._read()
            if time.monotonic() >= due:
                due += CYCLE_S
                self._send_sip()

    def _read(self) -> None:
        data = os.read(self._master, 4096)
        now = time.monotonic()
        for event in self._frames.receive(data, now):
            if isinstance(event, Frame):
                self._obey(event.payload, now)

    def _obey(self, payload: bytes, now: float) -> None:
        answer = self._handshake.receive(payload)
        if answer is not None:
            os.write(self._master, encode_frame(answer))
            return
        received = decode_command(payload)
        if received.command is Command.ENABLE:
            self._enabled = bool(received.value)
        elif received.command is Command.VEL and isinstance(received.value, float):
            self.velocities.append((now, received.value))
        elif received.command in (Command.STOP, Command.ESTOP):
            self.velocities.append((now, 0.0))

    def _send_sip(self) -> None:
        if self._handshake.state is not ConnectionState.OPEN:
            return
        self._steps += 1
        flags = int(SipFlag.SONAR_ARRAY_1 | (SipFlag.MOTORS_ENABLED if self._enabled else 0))
        sonar = tuple((number, 2.0) for number in range(5))
        sip = StandardSip(x=self._steps * STEP_M, battery=12.5, battery_fine=12.5, flags=flags, sonar=sonar)
        sip = sip._replace(charge_state=0, rotational_velocity=0.0, fault_flags=0)
        os.write(self._master, encode_frame(self._codec.encode(sip)))
        self.written[self._steps] = time.monotonic()
