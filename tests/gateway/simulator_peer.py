"""A robot simulator as the MobileSim family behaves on its TCP port, without world or windows.

What differs from a robot: each connection is a new session; the first packets of a session are taken for SYNCs whatever
they are, and one out of sequence is echoed and goes on from its own number; CLOSE closes the connection; while a client
is served, others are refused; motors are on by themselves; DCHEAD and most requests are unknown; every robot has the
same name and model; laser readings come on the robot's own line. Source: what public documentation and client
libraries say of these simulators.

    python -m tests.gateway.simulator_peer [PORT]     serves until it is killed, and prints its port
"""

import argparse
import contextlib
import select
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable, Iterator
from math import copysign, cos, degrees, pi, sin

from configs import load
from p2os import (
    Command,
    Frame,
    FrameDecoder,
    ReceivedCommand,
    RobotModel,
    StandardSip,
    decode_command,
    encode_frame,
    encode_packet,
)
from p2os.fields import POSITION_UNITS

CYCLE = 0.1
"""Seconds between SIPs."""
HANDSHAKES = 10
"""Packets of a handshake after which a session is given up."""
READINGS = 32
"""In a laser packet."""
SPEED, TURN_RATE = 0.6, 1.5
"""m/s and rad/s of MOVE and of the turns."""
NAME, KIND, SUBTYPE = "MobileSim", "Pioneer", "p3dx"
ABORTING = (253, 255)
"""Commands at which such a simulator ends itself."""


class SimulatorPeer:
    """One session after the other, without socket and clock.

    sends_configuration: it answers CONFIG with a CONFIGpac. name: in the answer to SYNC2. hung_up: the connection is to
    be closed. heard: commands of all sessions. sessions: how many there were. x, y, turned: odometry, m and rad.
    """

    def __init__(self, *, name: str = NAME, sends_configuration: bool = False) -> None:
        self.sends_configuration = sends_configuration
        self.name = name
        self.model = load(RobotModel, "robots", SUBTYPE)
        self.heard: list[ReceivedCommand] = []
        self.first_bytes: list[bytes] = []
        self.sessions = 0
        self.hung_up = True
        self.connect()
        self.sessions = 0

    def connect(self) -> None:
        """A client has connected."""
        self.sessions += 1
        self.first_bytes.append(b"")
        self.hung_up = False
        self._decoder = FrameDecoder()
        self._sequence = self._attempts = 0
        self._now = self._cycle = 0.0
        self._is_open = False
        self._laser = 0
        self._first_bearing, self._last_bearing = -90, 90
        self.x = self.y = self.turned = 0.0
        self._linear = self._angular = 0.0
        self._left_to_go: float | None = None
        self._left_to_turn: float | None = None

    def receive(self, data: bytes) -> bytes:
        """Take bytes of the client; return what is sent at once."""
        self.first_bytes[-1] += data
        answer = b""
        for found in self._decoder.receive(data, self._now):
            if isinstance(found, Frame) and not self.hung_up:
                answer += self._shake(found.payload) if self._sequence < 3 else self._obey(found.payload)
        return answer

    def step(self, seconds: float) -> bytes:
        """Let time pass; return what is sent."""
        self._now += seconds
        self._roll(seconds)
        self._cycle += seconds
        if self.hung_up or not self._is_open or self._cycle < CYCLE - 1e-9:
            return b""
        self._cycle = 0.0
        ring = POSITION_UNITS * self.model.scales.distance
        turned = (self.turned + pi) % (2 * pi) - pi
        sip = StandardSip(
            x=self.x % ring,
            y=self.y % ring,
            heading=turned,
            left_velocity=self._linear - self._angular * self.model.wheel_track / 2,
            right_velocity=self._linear + self._angular * self.model.wheel_track / 2,
            battery=13.0,
            flags=1,
        )
        return encode_frame(encode_packet(sip, self.model)) + b"".join(self._sweep())

    def _shake(self, payload: bytes) -> bytes:
        number = payload[0]
        self._attempts += 1
        if self._attempts > HANDSHAKES:
            self.hung_up = True
            return b""
        self._sequence = number + 1
        if number != Command.SYNC2:
            return encode_frame(bytes([number]))
        return encode_frame(bytes([number]) + b"".join(text.encode() + b"\0" for text in (self.name, KIND, SUBTYPE)))

    def _obey(self, payload: bytes) -> bytes:
        received = decode_command(payload)
        self.heard.append(received)
        value = received.value if isinstance(received.value, int | float) else 0
        assert received.number not in ABORTING, "this ends such a simulator"
        effects: dict[int, dict[str, object]] = {
            Command.OPEN: {"_is_open": True},
            Command.CLOSE: {"hung_up": True},
            Command.STOP: {"_linear": 0.0, "_angular": 0.0, "_left_to_go": None, "_left_to_turn": None},
            Command.VEL: {"_linear": value, "_left_to_go": None},
            Command.RVEL: {"_angular": value, "_left_to_turn": None},
            Command.MOVE: {"_left_to_go": value},
            Command.DHEAD: {"_left_to_turn": (value + pi) % (2 * pi) - pi},
            Command.HEAD: {"_left_to_turn": (value - self.turned + pi) % (2 * pi) - pi},
            Command.SIM_LRF_ENABLE: {"_laser": int(value)},
            Command.SIM_LRF_SET_FOV_START: {"_first_bearing": round(degrees(value))},
            Command.SIM_LRF_SET_FOV_END: {"_last_bearing": round(degrees(value))},
            Command.GRIPREQUEST: {"_last_bearing": int(value)},  # the old number of SIM_LRF_SET_FOV_END
        }
        vars(self).update(effects.get(received.number, {}))
        if received.number == Command.CONFIG and self.sends_configuration:
            return encode_frame(b"\x20Pioneer\0p3dx\0SIM\0")
        return b""

    def _roll(self, seconds: float) -> None:
        self._linear, self._left_to_go = _towards(self._left_to_go, SPEED, self._linear, seconds)
        self._angular, self._left_to_turn = _towards(self._left_to_turn, TURN_RATE, self._angular, seconds)
        self.x += self._linear * cos(self.turned) * seconds
        self.y += self._linear * sin(self.turned) * seconds
        self.turned += self._angular * seconds

    def _sweep(self) -> Iterator[bytes]:
        """A reading each degree, 1 m at the first bearing and 1 cm more at each further one."""
        if not self._laser:
            return
        total = self._last_bearing - self._first_bearing + 1
        for first in range(0, total, READINGS):
            ranges = [1000 + 10 * index for index in range(first, min(total, first + READINGS))]
            if self._laser == 2:
                head = struct.pack("<BHHB", 0x61, total, first, len(ranges))
                body = b"".join(struct.pack("<HBBB", each, 33 if each == 1000 else 0, 0, 0) for each in ranges)
                yield encode_frame(head + body + b"\0\0")  # index of the laser, and flags
            else:
                head = struct.pack("<BhhhHHB", 0x60, 0, 0, 0, total, first, len(ranges))
                yield encode_frame(head + struct.pack(f"<{len(ranges)}H", *ranges))


def _towards(left: float | None, limit: float, speed: float, seconds: float) -> tuple[float, float | None]:
    """The speed during the next step, and what is then left of a motion; without one the speed stays."""
    if left is None:
        return speed, None
    if not left:
        return 0.0, None
    speed = copysign(min(limit, abs(left) / seconds), left)
    return speed, left - speed * seconds if abs(left) > limit * seconds else 0.0


class ServedPeer:
    """A peer on a port of this machine.

    connections: steady times at which clients connected.
    """

    def __init__(self, peer: SimulatorPeer, port: int = 0) -> None:
        self.peer = peer
        self.connections: list[float] = []
        self._lock = threading.Lock()
        self._listener = self._listen(port)
        self.port = self._listener.getsockname()[1]
        self.url = f"socket://127.0.0.1:{self.port}"
        self._is_stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, name="simulator peer")
        self._thread.start()

    def look(self, at: Callable[[SimulatorPeer], object]) -> object:
        """Read something of the peer between two of its steps."""
        with self._lock:
            return at(self.peer)

    def close(self) -> None:
        """End the thread and let go of the port."""
        self._is_stopped.set()
        self._thread.join()

    @staticmethod
    def _listen(port: int) -> socket.socket:
        listener = socket.socket()
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(("127.0.0.1", port))
        listener.listen()
        return listener

    def _run(self) -> None:
        while not self._is_stopped.is_set():
            if not select.select([self._listener], (), (), 0.05)[0]:
                continue
            client, _ = self._listener.accept()
            self.connections.append(time.monotonic())
            self._listener.close()  # one client at a time
            with client:
                self._serve(client)
            self._listener = self._listen(self.port)
        self._listener.close()

    def _serve(self, client: socket.socket) -> None:
        with self._lock:
            self.peer.connect()
        before = time.monotonic()
        while not (self.peer.hung_up or self._is_stopped.is_set()):
            data = None
            if select.select([client], (), (), 0.01)[0]:
                try:
                    data = client.recv(4096)
                except ConnectionError:  # the client has hung up
                    return
                if not data:
                    return
            now = time.monotonic()
            with self._lock:
                answer = self.peer.receive(data or b"") + self.peer.step(max(1e-3, now - before))
            before = now
            with contextlib.suppress(ConnectionError):  # the next read notices
                client.sendall(answer)


@contextlib.contextmanager
def serving(peer: SimulatorPeer) -> Iterator[ServedPeer]:
    """Serve a peer until the block ends."""
    served = ServedPeer(peer)
    try:
        yield served
    finally:
        served.close()


def main() -> None:
    """Serve until killed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("port", nargs="?", type=int, default=0)
    parser.add_argument("--name", default=NAME)
    arguments = parser.parse_args()
    served = ServedPeer(SimulatorPeer(name=arguments.name), arguments.port)
    print(served.url, flush=True)
    with contextlib.suppress(KeyboardInterrupt):  # how the test ends it
        while True:
            time.sleep(1.0)
    served.close()
    print([command.command for command in served.peer.heard], file=sys.stderr)


if __name__ == "__main__":
    main()
