"""A stranger on the bus: plain Zenoh, CDR read and written by hand from the ROS 2 message definitions."""

import struct
import threading
import uuid
from collections.abc import Callable, Iterator

import pytest
import zenoh

from acromovi.children import EmulatedRobots, emulator, gateway
from tests.plain_zenoh import plain_session

LITTLE_ENDIAN = b"\x00\x01\x00\x00"  # representation header: CDR, little-endian


class Reader:
    """Takes aligned fields off a CDR payload, one after the other."""

    def __init__(self, payload: bytes) -> None:
        assert payload[:4] == LITTLE_ENDIAN
        self._body = payload[4:]
        self._at = 0

    def number(self, code: str) -> float:
        size = struct.calcsize(code)
        self._at += -self._at % size
        (value,) = struct.unpack_from("<" + code, self._body, self._at)
        self._at += size
        return float(value)

    def text(self) -> str:
        length = int(self.number("I"))
        self._at += length
        return self._body[self._at - length : self._at - 1].decode()


def twist(linear: float, angular: float) -> bytes:
    return LITTLE_ENDIAN + struct.pack("<6d", linear, 0.0, 0.0, 0.0, 0.0, angular)


class Ear:
    """Odometry as it came: how much, and of the last the frames, x and forward speed."""

    def __init__(self) -> None:
        self.count = 0
        self.frames = ("", "")
        self.x = 0.0
        self.speed = 0.0

    def hear(self, sample: zenoh.Sample) -> None:
        reader = Reader(sample.payload.to_bytes())
        reader.number("i"), reader.number("I")  # stamp
        self.frames = (reader.text(), reader.text())
        self.x = reader.number("d")
        for _ in range(6 + 36):
            reader.number("d")  # the rest of the pose, and its covariance
        self.speed = reader.number("d")
        self.count += 1


@pytest.fixture
def name() -> str:
    return f"stranger-{uuid.uuid4().hex[:8]}"


@pytest.fixture
def robots(name: str) -> Iterator[EmulatedRobots]:
    with (
        emulator("--robot", f"powerbot:{name}", "--world", "empty", "--quiet") as robots,
        gateway(robots.port, "--quiet"),
    ):
        yield robots


def test_plain_zenoh_reads_odometry_drives_and_sees_silence_stop_the_robot(
    robots: EmulatedRobots, name: str, until: Callable[..., None]
) -> None:
    ear = Ear()
    with plain_session() as session:
        session.declare_subscriber(f"{name}/odom", ear.hear)
        until(lambda: ear.count > 0, "odometry does not come")
        assert ear.frames == (f"{name}/odom", f"{name}/base_link")

        def twenty_messages() -> float:
            """How long they take, s of the robot's own time."""
            began, enough = robots.ask("truth")["time"], ear.count + 20
            until(lambda: ear.count >= enough, "odometry does not go on")
            return float(robots.ask("truth")["time"] - began)

        # Ten messages a second; on a busy machine a gateway that was held up connects anew, and some are missing.
        until(lambda: twenty_messages() == pytest.approx(2.0, abs=0.5), "ten messages come in a second")

        silent = threading.Event()

        def drive() -> None:
            while not silent.wait(0.1):
                session.put(f"{name}/cmd_vel", twist(0.3, 0.0))

        driver = threading.Thread(target=drive)
        driver.start()
        try:
            until(lambda: ear.speed > 0.25, "a plain Twist does not move the robot")
        finally:
            silent.set()
            driver.join()
        until(lambda: ear.speed == 0.0, "silence does not stop the robot")
        stood_at = robots.ask("truth", robot=name)["x"]
        until(lambda: ear.x > 0.1, "odometry does not show the way driven")
        heard = ear.count
        until(lambda: ear.count >= heard + 10, "odometry does not go on")
        assert robots.ask("truth", robot=name)["x"] == pytest.approx(stood_at, abs=0.005)
