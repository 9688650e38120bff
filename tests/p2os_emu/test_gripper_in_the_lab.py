"""A Pioneer fetches a box: every command over the line, every reading from it, in virtual time."""

from collections.abc import Callable, Iterator
from math import degrees, hypot, pi
from typing import Any

import pytest

import configs
from geometry import wrap_angle
from p2os import Command, Frame, FrameDecoder, GripperReport, RobotModel, StandardSip, decode_packet, encode_command
from p2os.commands import CommandValue
from p2os_emu.emulator import STEP, Emulator
from p2os_emu.fit import Fit
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.truth_rows import robot_row
from p2os_emu.world import World, load_world

OPEN, CLOSED, UP, DOWN, MOVING = 0x01, 0x02, 0x10, 0x20, 0x44
OUTER_BEAM, INNER_BEAM, LEFT_CONTACT, RIGHT_CONTACT = 0x04, 0x08, 0x10, 0x20  # contacts are 0 when something presses
GRIP_OPEN, GRIP_CLOSE, LIFT_UP, LIFT_DOWN = 1, 2, 4, 5


class Client:
    """A client on the robot's line, and the truth beside it."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.model = configs.load(RobotModel, "robots", "p3dx-sh")
        self.link = MemoryLink()
        self.emulator = Emulator(world, LinkProfile("ideal"))
        self.robot = self.emulator.add("happy", self.model, self.link, fit=Fit({"gripper": "pioneer"}))
        self.reports: list[GripperReport] = []
        self.sip = StandardSip()
        self._decoder = FrameDecoder()
        for command in (Command.SYNC0, Command.SYNC1, Command.SYNC2, Command.OPEN):
            self.tell(command)
            self.emulator.step()
        self.tell(Command.ENABLE, 1)
        self.run(0.2)

    def tell(self, command: Command, value: CommandValue | None = None) -> None:
        self.link.client_write(encode_command(command, value))

    def run(self, seconds: float) -> None:
        for step in range(round(seconds / STEP)):
            if step % 60 == 0:
                self.tell(Command.PULSE)
            self.emulator.step()
            for event in self._decoder.receive(self.link.client_read(), self.emulator.time):
                assert isinstance(event, Frame)
                packet = decode_packet(event.payload, self.model)
                if isinstance(packet, StandardSip):
                    self.sip = packet
                elif isinstance(packet, GripperReport):
                    self.reports.append(packet)

    def until(self, holds: Callable[[StandardSip], bool], within: float) -> None:
        end = self.emulator.time + within
        while not holds(self.sip):
            assert self.emulator.time < end, f"not within {within} s: {self.sip}"
            self.run(0.1)

    def grip(self, order: int, state: int) -> None:
        """Order something of the gripper and wait until its state byte has these bits and nothing moves."""
        self.tell(Command.GRIPPER, order)
        self.run(0.2)
        self.until(lambda sip: sip.gripper_state & state == state and not sip.gripper_state & MOVING, 8.0)

    def drive(self, command: Command, value: float) -> None:
        """Move or turn by a way and wait until the robot stands."""
        self.tell(command, value)
        self.run(0.5)
        self.until(lambda sip: not sip.moving, 20.0)

    def truth(self) -> dict[str, Any]:
        """What the control socket reports of the gripper."""
        row: dict[str, Any] = robot_row(self.emulator, self.robot)["gripper"]
        return row

    @property
    def box(self) -> tuple[float, float, float]:
        """Where the box truly is, m."""
        place = self.emulator.world.object_places()["red box"]
        return place[0], place[1], place[2]

    @property
    def box_seen(self) -> tuple[float, float]:
        """Where its robot would see it: m ahead of the axle and to the left."""
        return self.emulator.world.truth("happy").pose.locate(*self.box[:2])


@pytest.fixture
def client() -> Iterator[Client]:
    with World(load_world("gripper-lab"), seed=3) as world:
        yield Client(world)


def test_a_pioneer_picks_a_box_up_carries_it_and_puts_it_down(client: Client) -> None:
    client.tell(Command.GRIPREQUEST, 1)
    client.run(0.3)
    assert [report.kind for report in client.reports] == [1]
    client.grip(GRIP_OPEN, OPEN)
    client.grip(LIFT_DOWN, DOWN)
    assert client.sip.digital_in & 0x3F == LEFT_CONTACT | RIGHT_CONTACT

    client.tell(Command.VEL, 0.1)
    client.until(lambda sip: bool(sip.digital_in & OUTER_BEAM), 20.0)
    client.until(lambda sip: bool(sip.digital_in & INNER_BEAM), 2.0)
    client.tell(Command.STOP)
    client.until(lambda sip: not sip.moving, 2.0)
    stood = client.box

    assert client.truth()["held"] is None
    client.grip(GRIP_CLOSE, CLOSED)
    assert client.truth()["held"] == "red box"
    assert client.truth()["lift"] == pytest.approx(0.0, abs=0.003)
    assert client.sip.digital_in & (LEFT_CONTACT | RIGHT_CONTACT) == 0
    client.grip(LIFT_UP, UP)
    assert client.truth()["lift"] == pytest.approx(0.07, abs=0.003)
    assert client.box[2] - stood[2] == pytest.approx(0.07, abs=0.003)
    seen = client.box_seen

    client.drive(Command.MOVE, -1.0)
    assert stood[0] - client.box[0] == pytest.approx(1.0, abs=0.03)
    before = client.emulator.world.truth("happy").pose.heading
    client.drive(Command.DHEAD, pi / 2)
    turned = wrap_angle(client.emulator.world.truth("happy").pose.heading - before)
    assert degrees(turned) == pytest.approx(90, abs=3)
    assert client.box[1] - stood[1] == pytest.approx(seen[0], abs=0.05)
    assert client.box_seen == pytest.approx(seen, abs=0.01)

    client.grip(LIFT_DOWN, DOWN)
    assert client.box[2] == pytest.approx(stood[2], abs=0.003)
    client.grip(GRIP_OPEN, OPEN)
    assert client.sip.digital_in & (LEFT_CONTACT | RIGHT_CONTACT) == LEFT_CONTACT | RIGHT_CONTACT
    assert client.truth()["held"] is None
    put_down = client.box
    client.drive(Command.MOVE, -0.4)
    client.run(1.0)
    assert client.box == pytest.approx(put_down, abs=0.003)
    assert client.sip.digital_in & (OUTER_BEAM | INNER_BEAM) == 0
    assert hypot(*client.box_seen) > 0.6
