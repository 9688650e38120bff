"""The Pioneer arm on the microcontroller: six servos, the last of them the gripper's.

The robot says how its servos count; in which sense, and how far the fingers open, is in the arm's own file.
Source: fact sheet of accessories, section 5.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from math import inf, pi
from typing import NamedTuple

from configs import load
from gateway.elements.arm.joint_limits import JointLimits
from gateway.elements.asked import AskedElement
from gateway.errors import CommandRefused
from gateway.events import ArmSeen
from p2os import ArmInformation, ArmJoint, ArmReport, ArmStatus, Command, RobotModel, encode_command
from p2os.accessories.arm_model import ArmModel
from p2os.accessories.pioneer_arm import EVERY_JOINT, LONGEST_MS, MANUAL_CONNECTED, MANUAL_POWERED, MS
from p2os.arguments import PacketRequest


class _ServoScale(NamedTuple):
    """The meaning of a servo's counts. zero: count at zero. per_tick: rad or m, signed. usual: default ms a count."""

    zero: int
    per_tick: float
    usual: int
    limits: JointLimits

    def place(self, tick: float) -> float:
        """Return the position of a count, rad or m."""
        return (tick - self.zero) * self.per_tick

    def tick(self, place: float) -> int:
        """Return the count of a position, rad or m."""
        return self.zero + round(place / self.per_tick)

    def pace(self, speed: float) -> int:
        """Return the ms for each count that give a speed."""
        return min(max(round(abs(self.per_tick) / speed / MS), 1), LONGEST_MS)


class ArmElement(AskedElement[ArmInformation | ArmReport]):
    """Asks whether there is one, and then requests its reports.

    version: what the arm's board calls itself, once it is known.
    """

    takes = (ArmInformation, ArmReport)
    question = Command.ARM_INFO, None
    stream = Command.ARM_STATUS, PacketRequest.CONTINUOUS
    single = Command.ARM_STATUS, PacketRequest.ONE
    version = ""
    _scales: tuple[_ServoScale, ...] = ()
    _is_powered = False
    _follows_manual = False
    _was_initialised = False
    _paces: Mapping[int, int] = {}
    _places: tuple[float, ...] = ()
    _moves = False

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask; the robot has taken the arm home and its power off, and forgotten the speeds."""
        self._is_powered = self._was_initialised = False
        self._paces = {}
        super().begin_link(model, now)

    def take(self, packet: ArmInformation | ArmReport, now: float) -> None:
        """Take the arm's data or its state."""
        if isinstance(packet, ArmInformation):
            self._meet(packet)
            if not self.is_present:
                self._outbox.drop(self.question[0])
                self.deadline = inf
                return
            super().take(packet, now)
            if not self._settings.line.streams:
                self._ask(*self.single)
        elif isinstance(packet, ArmReport) and self.is_present:
            super().take(packet, now)
            self._see(packet)
            if self._stop.is_due(self._moves, now):
                self._put_stop()

    @property
    def limits(self) -> Sequence[JointLimits]:
        """The limits of every joint."""
        return [scale.limits for scale in self._scales]

    @property
    def model(self) -> ArmModel:
        """The model of every Pioneer arm."""
        return _pioneer_arm()

    def move(self, targets: Mapping[int, float], speed: float | None, now: float) -> None:
        """Send joints to their targets, rad (m), each turning one at `speed`, rad/s; at its usual one if None.

        Raises:
            CommandRefused: The arm has no power.
        """
        self._check_power()
        self._stop.end()
        for joint, place in targets.items():
            scale = self._scales[joint]
            pace = scale.usual if speed is None or scale.limits.slides else scale.pace(speed)
            if self._paces.get(joint, scale.usual) != pace:
                self._paces = {**self._paces, joint: pace}
                self._ask(Command.ARM_SPEED, (joint + 1, pace), (Command.ARM_SPEED, joint))
            self._ask(Command.ARM_POS, (joint + 1, scale.tick(place)), (Command.ARM_POS, joint))

    def home(self, now: float) -> None:
        """Send every joint home.

        Raises:
            CommandRefused: The arm has no power.
        """
        self._check_power()
        self._instead(Command.ARM_HOME, EVERY_JOINT)

    def park(self, now: float) -> None:
        """Send every joint home, then take the power off."""
        self._instead(Command.ARM_PARK, None)

    def duration(self, targets: Mapping[int, float] | None, speed: float | None) -> float:
        """Return the expected duration until the joints are at their targets, s; home if None."""
        if targets is None:
            targets = {joint: scale.limits.home for joint, scale in enumerate(self._scales)}
        times = []
        for joint, place in targets.items():
            scale = self._scales[joint]
            usual = abs(scale.per_tick) / (scale.usual * MS)
            pace = usual if speed is None or scale.limits.slides else speed
            start = self._places[joint] if self._places else scale.limits.lower
            times.append(abs(place - start) / pace)
        return max(times, default=0.0)

    def is_moving(self, now: float) -> bool:
        """Return whether a joint moves, by the last ARMpac."""
        return self._moves

    def halt(self, now: float) -> None:
        """Stop every joint where it is; what stops goes first."""
        if self.is_present:
            self._drop()
            self._put_stop()
            self._stop.begin()

    def switch(self, on: bool, now: float) -> None:
        """Switch the power; off goes home first."""
        self._instead(Command.ARM_POWER, int(on))

    def _meet(self, information: ArmInformation) -> None:
        self.version = information.version
        joints = information.joints
        makes_sense = all(each.ticks_per_90 > 0 and each.minimum < each.maximum for each in joints)
        # A robot without an arm has no joints, and needs no model.
        self.is_present = bool(joints) and makes_sense and len(joints) == len(self.model.joints) + 1
        if self.is_present:
            self._scales = tuple(_scale(joint, figures, self.model) for joint, figures in enumerate(joints))

    def _see(self, report: ArmReport) -> None:
        first, second, positions = report
        if first == 0 or (second == 0 and first & MANUAL_CONNECTED):
            self._follows_manual = first != 0
        if self._follows_manual:
            self._is_powered, is_initialised, moving = bool(first & MANUAL_POWERED), True, second
        else:
            status = ArmStatus(second)
            self._is_powered, moving = ArmStatus.POWERED in status, first
            is_initialised = ArmStatus.INITIALISED in status
        if not (is_initialised or self._was_initialised):
            self._ask(Command.ARM_INIT)
        self._was_initialised = True
        joints = tuple(bool(moving >> joint & 1) for joint in range(len(self._scales)))
        self._moves = any(joints)
        self._places = tuple(scale.place(tick) for scale, tick in zip(self._scales, positions, strict=True))
        self._announce(ArmSeen(self._is_powered, is_initialised, joints, self._places))

    def _check_power(self) -> None:
        if not self._is_powered:
            raise CommandRefused('the arm has no power; send arm {"do": "power", "on": true}')

    def _instead(self, command: Command, value: int | None) -> None:
        """Queue an order that replaces those still waiting."""
        self._stop.end()
        self._drop()
        self._ask(command, value)

    def _put_stop(self) -> None:
        self._outbox.put(Command.ARM_STOP, encode_command(Command.ARM_STOP, EVERY_JOINT))

    def _drop(self) -> None:
        self._outbox.drop(
            Command.ARM_HOME,
            Command.ARM_PARK,
            Command.ARM_POWER,
            Command.ARM_STOP,
            *((Command.ARM_POS, joint) for joint in range(len(self._scales))),
        )


@cache
def _pioneer_arm() -> ArmModel:
    """Return the model of the Pioneer arm."""
    return load(ArmModel, "accessories", "pioneer-arm")


def _scale(joint: int, figures: ArmJoint, model: ArmModel) -> _ServoScale:
    if joint < len(model.joints):
        sense = -1 if model.servos[joint].reversed else 1
        zero, per_tick, fastest = figures.centre, sense * pi / 2 / figures.ticks_per_90, model.joints[joint].speed
    else:
        fingers = model.finger_servo
        opens = fingers is None or fingers.closed < fingers.open
        zero = figures.minimum if opens else figures.maximum
        per_tick = model.gripper.opening_m / (figures.maximum - figures.minimum) * (1 if opens else -1)
        fastest = model.gripper.speed_m_s
    lower, upper = sorted((tick - zero) * per_tick for tick in (figures.minimum, figures.maximum))
    slowest = abs(per_tick) / (LONGEST_MS * MS)
    home = (figures.home - zero) * per_tick
    limits = JointLimits(lower, upper, slowest, fastest, slides=joint == len(model.joints), home=home)
    return _ServoScale(zero, per_tick, figures.speed, limits)
