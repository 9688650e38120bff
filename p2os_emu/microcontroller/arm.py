"""The arm server: the Pioneer arm's six servos behind commands 70 to 81.

A servo is told a position in counts and says nothing back: what an ARMpac reports is what the servos are told. The
board lets that move one count every so many milliseconds. Source: fact sheet section 5. Where it is silent, assumed:

- a target beyond a servo's ends is brought to the end; nothing moves without power, or before it has settled;
- SPEED for joint 0 means joint 1 (one well-known driver counts from 0 there); INIT and the end of a connection bring
  back the usual speeds;
- GRIPPARK sends the gripper home after so many seconds without an order for it;
- a robot without arm answers STATUS with a status of 0, which is not good.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum, auto
from functools import partial

from p2os.accessories.arm_model import ArmModel
from p2os.accessories.pioneer_arm import (
    ALL_JOINTS,
    GRIPPER_JOINT,
    JOINTS,
    LONGEST_MS,
    MANUAL_CONNECTED,
    MANUAL_POWERED,
    MS,
    NO_ARM,
)
from p2os.accessory_packets import ArmInformation, ArmJoint, ArmReport, ArmStatus
from p2os_emu.body import ArmMechanism

VERSION = "1.0"
INIT_TIME = 0.7
"""s that INIT takes."""
SETTLING_TIME = 2.0
"""s after power-on in which the servos find their places."""
AUTOPARK = 600.0
"""s without a command for the arm after which it parks."""


class _Power(Enum):
    """Power state of the servos."""

    OFF = auto()
    SETTLING = auto()
    ON = auto()
    GOING_HOME = auto()  # and off then


@dataclass(slots=True)
class _ArmServo:
    """One servo.

    figures: as ARMINFOpac says. place: rad or m at a count. top_speed: rad/s or m/s. position: where it is told to be,
    in counts; goal: where that goes. speed: ms a count. homes: the goal is its home because it was sent there. told:
    the goal and speed that the body's joint was given last.
    """

    figures: ArmJoint
    place: Callable[[float], float]
    top_speed: float
    position: float
    goal: int
    speed: int
    homes: bool = False
    told: tuple[int, int] | None = None

    @property
    def is_moving(self) -> bool:
        """It is on its way."""
        return self.position != self.goal

    def aim(self, tick: int, *, homes: bool = False) -> None:
        """Set the goal, between the servo's ends."""
        self.goal = min(max(tick, self.figures.minimum), self.figures.maximum)
        self.homes = homes

    def advance(self, dt: float) -> None:
        """Let time pass, s."""
        step = dt / (self.speed * MS)
        left = self.goal - self.position
        self.position = float(self.goal) if abs(left) <= step else self.position + (step if left > 0 else -step)

    def drive(self, joint: int, arm: ArmMechanism) -> None:
        """Send goal and speed to the body's joint, if they changed."""
        if self.told != (self.goal, self.speed):
            self.told = self.goal, self.speed
            speed = abs(self.place(1.0) - self.place(0.0)) / (self.speed * MS)
            arm.move(joint, self.place(self.goal), speed)


class ArmServer:
    """Firmware of the arm; without an arm it reports so and does nothing else.

    power: what the servos get. follows_manual: the bytes of ARMpac are in the manual's order, not in the one that the
    most used client library reads.
    """

    def __init__(self) -> None:
        self.follows_manual = False
        self.power = _Power.OFF
        self._servos: tuple[_ArmServo, ...] = ()
        self._is_driven = False
        self._init_left = self._settling_left = 0.0
        self._autopark, self._gripper_park = AUTOPARK, 0.0
        self._idle = self._gripper_idle = 0.0

    def fit(self, model: ArmModel) -> None:
        """An arm is there from now on, at home and without power."""
        self._servos = tuple(_servos(model))
        self.follows_manual = model.manual_order

    def power_on(self) -> None:
        """Start as after the power switch: servo commands are forgotten, and power is off."""
        for servo in self._servos:
            servo.position, servo.goal = float(servo.figures.home), servo.figures.home
        self._switch_off()
        self._init_left = 0.0
        self.restore()

    def restore(self) -> None:
        """Handle the end of the connection: park, switch off, restore the parameters."""
        self.park()
        self._autopark, self._gripper_park = AUTOPARK, 0.0
        for servo in self._servos:
            servo.speed = servo.figures.speed

    @property
    def information(self) -> ArmInformation:
        """Content of ARMINFOpac."""
        return ArmInformation(VERSION if self._servos else NO_ARM, tuple(servo.figures for servo in self._servos))

    @property
    def report(self) -> ArmReport:
        """Content of ARMpac."""
        moving = sum(servo.is_moving << bit for bit, servo in enumerate(self._servos)) if self._has_settled else 0
        positions = tuple(round(servo.position) for servo in self._servos) or (0,) * JOINTS
        if self.follows_manual:
            connected = MANUAL_CONNECTED if self._servos else 0
            return ArmReport(connected | (MANUAL_POWERED if self.is_powered else 0), moving, positions)
        return ArmReport(moving, self._status, positions)

    # Commands.

    def initialise(self) -> None:
        """INIT: stop, and bring back the usual speeds; takes its time."""
        self.stop(0)
        self._init_left = INIT_TIME
        for servo in self._servos:
            servo.speed = servo.figures.speed

    def check(self) -> None:
        """CHECK: look for the arm, which is where it was; like every command it keeps AUTOPARK from parking."""
        self._idle = 0.0

    def switch(self, on: bool) -> None:
        """POWER: on, or home and then off."""
        self.check()
        if not on:
            self.park()
        elif self._servos and not self.is_powered:
            self.power = _Power.SETTLING
            self._settling_left = SETTLING_TIME
        elif self.power is _Power.GOING_HOME:
            self.power = _Power.ON

    def home(self, joint: int) -> None:
        """HOME: one joint, counted from 1, or every one."""
        for servo in self._chosen(joint):
            servo.aim(servo.figures.home, homes=True)

    def park(self) -> None:
        """PARK: everything home, then off."""
        if self.is_powered:
            for servo in self._servos:
                servo.aim(servo.figures.home, homes=True)
            self.power = _Power.GOING_HOME

    def move(self, joint: int, tick: int) -> None:
        """POS: send a joint, counted from 1, to a count."""
        if 1 <= joint <= JOINTS:
            for servo in self._chosen(joint):
                servo.aim(tick)

    def set_speed(self, joint: int, milliseconds: int) -> None:
        """SPEED: of a joint, counted from 1, in ms a count."""
        self.check()
        index = max(joint, 1) - 1
        if index < len(self._servos) and milliseconds > 0:
            self._servos[index].speed = min(milliseconds, LONGEST_MS)

    def stop(self, joint: int) -> None:
        """STOP: one joint, counted from 1, or every one; an arm on its last way home stays where it is, with power."""
        if self.power is _Power.GOING_HOME:
            self.power = _Power.ON
        for servo in self._chosen(joint):
            servo.aim(round(servo.position))

    def park_after(self, seconds: int) -> None:
        """AUTOPARK: after so many seconds without a command for the arm; 0 never."""
        self.check()
        self._autopark = max(0.0, float(seconds))

    def park_gripper_after(self, seconds: int) -> None:
        """GRIPPARK: after so many seconds without an order for the gripper; 0 never."""
        self.check()
        self._gripper_idle = 0.0
        self._gripper_park = max(0.0, float(seconds))

    # Time.

    def advance(self, arm: ArmMechanism | None, dt: float, *, is_deserted: bool) -> None:
        """Take one step.

        Args:
            arm: The body's; None where there is none.
            dt: s.
            is_deserted: The client has fallen silent.
        """
        if self._init_left > 0.0:
            self._init_left -= dt
        if arm is None:
            return
        if not self.is_powered:
            self._release(arm)
            return
        self._count_idleness(dt)
        if is_deserted:
            self.park()
        if self.power is _Power.SETTLING:
            self._settling_left -= dt
            if self._settling_left <= 0.0:
                self.power = _Power.ON
            self._hold(arm)
            return
        self._is_driven = True
        for joint, servo in enumerate(self._servos):
            servo.drive(joint, arm)
            if servo.position != servo.goal:
                servo.advance(dt)
        if self.power is _Power.GOING_HOME and not any(servo.is_moving for servo in self._servos):
            self._switch_off()

    @property
    def is_fitted(self) -> bool:
        """There is an arm."""
        return bool(self._servos)

    @property
    def is_powered(self) -> bool:
        """The servos have power."""
        return self.power is not _Power.OFF

    @property
    def _has_settled(self) -> bool:
        return self.power in (_Power.ON, _Power.GOING_HOME)

    @property
    def _status(self) -> ArmStatus:
        if not self._servos:
            return ArmStatus(0)
        homing = any(servo.homes and servo.is_moving for servo in self._servos)
        return (
            ArmStatus.GOOD
            | (ArmStatus.INITIALISED if self._init_left <= 0.0 else 0)
            | (ArmStatus.POWERED if self.is_powered else 0)
            | (ArmStatus.HOMING if homing else 0)
        )

    def _chosen(self, joint: int) -> Iterable[_ArmServo]:
        """The servos that an order is for; nothing can be ordered without power, or on the last way home."""
        self.check()
        if self.power not in (_Power.SETTLING, _Power.ON):
            return ()
        chosen = self._servos if joint in ALL_JOINTS else self._servos[joint - 1 : joint] if joint > 0 else ()
        if any(servo is self._servos[GRIPPER_JOINT - 1] for servo in chosen):
            self._gripper_idle = 0.0
        return chosen

    def _count_idleness(self, dt: float) -> None:
        self._idle += dt
        self._gripper_idle += dt
        if self._idle >= self._autopark > 0.0:
            self.park()
        elif self._gripper_idle >= self._gripper_park > 0.0 and self.power is _Power.ON:
            gripper = self._servos[GRIPPER_JOINT - 1]
            gripper.aim(gripper.figures.home, homes=True)

    def _hold(self, arm: ArmMechanism) -> None:
        """Drive every servo to its commanded position at top speed, as it does when it gets power."""
        if not self._is_driven:
            self._is_driven = True
            for joint, servo in enumerate(self._servos):
                servo.told = None
                arm.move(joint, servo.place(servo.position), servo.top_speed)

    def _release(self, arm: ArmMechanism) -> None:
        if self._is_driven:
            self._is_driven = False
            for joint in range(len(self._servos)):
                arm.release(joint)

    def _switch_off(self) -> None:
        self.power = _Power.OFF
        for servo in self._servos:
            servo.aim(round(servo.position))


def _servos(model: ArmModel) -> Iterable[_ArmServo]:
    """The servos of an arm, at home; the gripper's comes last."""
    for joint, servo in zip(model.joints, model.servos, strict=True):
        ends = sorted((servo.tick(joint.lower), servo.tick(joint.upper)))
        home = servo.tick(joint.home)
        figures = ArmJoint(servo.speed_ms, home, ends[0], servo.centre, ends[1], servo.ticks_per_90)
        yield _ArmServo(figures, servo.angle, joint.speed, float(home), home, servo.speed_ms)
    gripper, fingers = model.gripper, model.finger_servo
    if fingers is not None:
        least, most = sorted((fingers.closed, fingers.open))
        home = fingers.tick(gripper.home_m, gripper.opening_m)
        figures = ArmJoint(fingers.speed_ms, home, least, (least + most) // 2, most, fingers.ticks_per_90)
        place = partial(fingers.opening, most=gripper.opening_m)
        yield _ArmServo(figures, place, gripper.speed_m_s, float(home), home, fingers.speed_ms)
