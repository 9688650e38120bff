"""Test support for the firmware and its clients: a simple body, and a bench that steps a controller with it."""

from collections.abc import Callable, Sequence
from math import inf
from typing import NamedTuple, TypeVar

from p2os.command_table import Command
from p2os.commands import CommandValue, encode_command
from p2os.framing import Frame, FrameDecoder
from p2os.packets import Packet, decode_packet
from p2os.robot_model import RobotModel
from p2os.sip import OPEN_INPUTS, SipCodec, StandardSip
from p2os_emu.body import ArmMechanism, BodyState, Echoes, GripperMechanismState, ScanBeams
from p2os_emu.fit import BARE, Fit
from p2os_emu.microcontroller.flash import Flash
from p2os_emu.microcontroller.microcontroller import Microcontroller

STEP = 1 / 120
"""s; as long as a step of the physics."""
PULSE_PERIOD = 0.5
"""s between two PULSEs of the bench's client."""

P = TypeVar("P")


class _Wheel:
    """A wheel that follows its command with a first-order lag; m, m/s, load from 0 to 1."""

    def __init__(self) -> None:
        self.travel = self.velocity = self.load = self.wanted = 0.0

    def step(self, dt: float, lag: float, wall: float) -> None:
        """Let time pass; at `wall` m of travel the wheel only pushes."""
        self.velocity += (self.wanted - self.velocity) * (min(1.0, dt / lag) if lag else 1.0)
        if self.velocity > 0.0 and self.travel + self.velocity * dt > wall:
            self.velocity, self.load = 0.0, 1.0
        else:
            self.load = 0.1 if self.velocity else 0.0
        self.travel += self.velocity * dt


class PlainGripper:
    """Paddles and a lift that need some seconds for their whole way.

    thing: opening at which the paddles meet something; 0 for nothing between them. stuck: nothing moves.
    """

    def __init__(self, *, thing: float = 0.0, paddle_time: float = 2.0, lift_time: float = 3.5) -> None:
        self.thing = thing
        self.stuck = False
        self.told: list[tuple[float, float]] = []
        self._times = paddle_time, lift_time
        self._opening, self._lift = 1.0, 0.0
        self._wanted = 0.0, 0.0

    @property
    def state(self) -> GripperMechanismState:
        """The gripper after the last step."""
        touches = self._opening <= self.thing
        return GripperMechanismState(
            opening=self._opening,
            lift=self._lift,
            outer_beam=self.thing > 0.0,
            inner_beam=self.thing > 0.0,
            left_contact=touches,
            right_contact=touches,
            holds=touches,
        )

    def drive(self, paddles: float, lift: float) -> None:
        """Command both motors."""
        self._wanted = paddles, lift
        self.told.append(self._wanted)

    def step(self, dt: float) -> None:
        """Let time pass."""
        if not self.stuck:
            paddles, lift = (wanted * dt / time for wanted, time in zip(self._wanted, self._times, strict=True))
            self._opening = min(max(self._opening + paddles, self.thing), 1.0)
            self._lift = min(max(self._lift + lift, 0.0), 1.0)


class PlainArm:
    """Joints that are at once where they are told to be, unless something holds them.

    orders: joint to what it was told last, (position, speed), or None for no power. told: how often it was.
    held: joints that do not move. holds: an object is between the fingers.
    """

    holds = False

    def __init__(self, joints: int) -> None:
        self.positions = [0.0] * joints
        self.velocities = [0.0] * joints
        self.orders: dict[int, tuple[float, float] | None] = {}
        self.held: set[int] = set()
        self.told = 0

    @property
    def braked(self) -> set[int]:
        """Joints that have no power."""
        return {joint for joint, order in self.orders.items() if order is None}

    def move(self, joint: int, position: float, speed: float) -> None:
        """Let a joint go to a position."""
        self.told += 1
        self.orders[joint] = position, speed
        if joint not in self.held:
            self.positions[joint] = position

    def release(self, joint: int) -> None:
        """Take the power off a joint; it stays."""
        self.told += 1
        self.orders[joint] = None


class PlainBody:
    """Exact wheels on an endless floor.

    lag: time constant of the wheels, s; 0 follows within one step. wall: m of travel beyond which the wheels only push.
    front_bumpers, rear_bumpers: as `BodyState` has them, to be pressed by hand. ranges: range that a disc measures, m.
    infrared, far_ledge, near_ledge, heading, turn_rate: likewise, whatever the wheels do.
    powered: the motors are driven. pings: the discs of every firing, in order. told: how often the motors were told.
    gripper: one to hang on, where the test is about it.
    """

    gripper: PlainGripper | None = None
    arm: ArmMechanism | None = None
    is_docked = False

    def __init__(self, lag: float = 0.0) -> None:
        self.lag = lag
        self.wall = inf
        self.front_bumpers = 0
        self.rear_bumpers = 0
        self.ranges: Callable[[int], float] = lambda disc: 1.0 + disc / 10
        self.powered = True  # until the controller first says otherwise
        self.infrared = OPEN_INPUTS
        self.far_ledge = self.near_ledge = False
        self.heading = self.turn_rate = 0.0
        self.pings: list[tuple[int, ...]] = []
        self.told = 0
        self.left = _Wheel()
        self.right = _Wheel()

    @property
    def state(self) -> BodyState:
        """The machine after the last step."""
        left, right = self.left, self.right
        return BodyState(
            left_travel=left.travel,
            right_travel=right.travel,
            left_velocity=left.velocity,
            right_velocity=right.velocity,
            left_load=left.load,
            right_load=right.load,
            front_bumpers=self.front_bumpers,
            rear_bumpers=self.rear_bumpers,
            heading=self.heading,
            turn_rate=self.turn_rate,
            infrared=self.infrared,
            far_ledge=self.far_ledge,
            near_ledge=self.near_ledge,
        )

    @property
    def travel(self) -> float:
        """m that the robot has come forward."""
        return (self.left.travel + self.right.travel) / 2

    @property
    def velocity(self) -> float:
        """m/s forward."""
        return (self.left.velocity + self.right.velocity) / 2

    def is_turning(self) -> bool:
        """A wheel turns."""
        return max(abs(self.left.velocity), abs(self.right.velocity)) > 1e-6

    def drive(self, left: float, right: float) -> None:
        """Command the wheel rims, m/s."""
        self._tell(True, left, right)

    def release(self) -> None:
        """Take the power off; the gears hold the wheels."""
        self._tell(False, 0.0, 0.0)

    def ping(self, discs: Sequence[int]) -> Sequence[float]:
        """Fire sonar discs."""
        self.pings.append(tuple(discs))
        return [self.ranges(disc) for disc in discs]

    def scan(self, beams: ScanBeams) -> Echoes:
        """See nothing."""
        return Echoes.nothing(beams.count)

    def step(self, dt: float) -> None:
        """Let time pass."""
        self.left.step(dt, self.lag, self.wall)
        self.right.step(dt, self.lag, self.wall)
        if self.gripper is not None:
            self.gripper.step(dt)

    def _tell(self, powered: bool, left: float, right: float) -> None:
        self.told += 1
        self.powered = powered
        self.left.wanted, self.right.wanted = left, right


class _Sent(NamedTuple):
    """A frame from the robot.

    time: of the step that sent it, s. payload: as on the wire. packet: decoded.
    """

    time: float
    payload: bytes
    packet: Packet


class MicrocontrollerBench:
    """A microcontroller, its body and a client that pulses; virtual time only.

    time: s since power-on. pulsing: the client keeps the watchdog fed.
    """

    def __init__(
        self,
        model: RobotModel,
        name: str = "PowerBot1",
        *,
        flash: Flash | None = None,
        body: PlainBody | None = None,
        seed: int = 0,
        fit: Fit = BARE,
    ) -> None:
        self.model = model
        self.body = body or PlainBody()
        self.controller = Microcontroller(model, name, flash=flash, seed=seed, fit=fit)
        self.time = 0.0
        self.pulsing = True
        self._codec = SipCodec(model)
        self._decoder = FrameDecoder()
        self._next_pulse = 0.0

    @property
    def turned(self) -> float:
        """Rad that the robot has turned counter-clockwise, by its true wheels."""
        return (self.body.right.travel - self.body.left.travel) / self.model.wheel_track

    def send(self, command: Command, value: CommandValue | None = None) -> None:
        """Send a command; it takes effect in the next step."""
        self.controller.receive(encode_command(command, value))

    def step(self) -> bytes:
        """Take one step; the bytes that the robot sends in it."""
        sent = self.controller.step(STEP, self.body)
        self.body.step(STEP)
        self.time += STEP
        return sent

    def run(self, seconds: float) -> list[_Sent]:
        """Let time pass; what the robot sends meanwhile."""
        sent: list[_Sent] = []
        for _ in range(round(seconds / STEP)):
            if self.pulsing and self.controller.connected and self.time >= self._next_pulse:
                self.send(Command.PULSE)
                self._next_pulse = self.time + PULSE_PERIOD
            for event in self._decoder.receive(self.step(), self.time):
                if not isinstance(event, Frame):
                    raise AssertionError(f"the robot sent a damaged frame: {event}")
                packet = decode_packet(event.payload, self.model, self._codec)
                sent.append(_Sent(self.time, event.payload, packet))
        return sent

    def sips(self, seconds: float) -> list[StandardSip]:
        """Let time pass; the SIPs of it."""
        return self.packets(StandardSip, seconds)

    def packets(self, kind: type[P], seconds: float) -> list[P]:
        """Let time pass; the packets of one kind of it."""
        return [each.packet for each in self.run(seconds) if isinstance(each.packet, kind)]

    def sip(self) -> StandardSip:
        """The next SIP."""
        return self.sips(0.2)[-1]

    def connect(self, *, motors: bool = False) -> "MicrocontrollerBench":
        """Shake hands and OPEN; with `motors` ENABLE as well."""
        for command in (Command.SYNC0, Command.SYNC1, Command.SYNC2, Command.OPEN):
            self.send(command)
            self.step()
        if motors:
            self.send(Command.ENABLE, 1)
            self.step()
        return self
