"""The motion servers: what the motion commands mean, and the wheel speeds that follow from them.

Two modes exclude each other: translation with rotation, and independent wheels (VEL2). ARCOS has the second one
recomposed into the first; a command of one mode abandons the setpoints of the other all the same.
Source: fact sheet section 9.
"""

from enum import Enum
from math import pi

from p2os.firmware import Family
from p2os.robot_model import RobotModel
from p2os_emu.microcontroller.flash import Flash
from p2os_emu.microcontroller.odometry import OdometryIntegrator
from p2os_emu.microcontroller.servo import Servo, ServoLimits

NEAR_ENOUGH = 0.0005
"""m at a wheel rim within which a place counts as reached."""
RECOMPOSES_WHEELS = frozenset({Family.ARCOS, Family.UARCS})


class _MotionMode(Enum):
    """Which servers have the wheels."""

    BODY = "translation and rotation"
    RECOMPOSED = "wheels by way of translation and rotation"
    WHEELS = "independent wheels"


class MotionController:
    """Turns motion commands into wheel speeds.

    left, right: wanted speed of the wheel rims, m/s. halted: stand still, but keep the commands (the watchdog).
    """

    __slots__ = (
        "_drives_wheels",
        "_left_servo",
        "_mode",
        "_odometry",
        "_recomposes",
        "_right_servo",
        "_track",
        "halted",
        "left",
        "right",
        "rotation",
        "translation",
    )

    def __init__(self, model: RobotModel, flash: Flash, odometry: OdometryIntegrator) -> None:
        """Stand still with the limits of `flash`."""
        self._odometry = odometry
        self._track = model.wheel_track
        self._recomposes = model.firmware in RECOMPOSES_WHEELS
        self.restore(flash)

    def restore(self, flash: Flash) -> None:
        """Take the working limits from FLASH and forget every command."""
        along = ServoLimits(
            top=flash.velocity_top,
            fastest=flash.max_velocity,
            acceleration=flash.acceleration,
            deceleration=flash.deceleration,
            acceleration_top=flash.acceleration_top,
            emergency=flash.emergency_deceleration,
        )
        around = ServoLimits(
            top=flash.rotation_top,
            fastest=flash.max_rotation,
            acceleration=flash.rotational_acceleration,
            deceleration=flash.rotational_deceleration,
            acceleration_top=flash.rotational_acceleration_top,
            emergency=flash.emergency_rotational_deceleration,
        )
        self.translation = Servo(along, NEAR_ENOUGH)
        self.rotation = Servo(around, 2 * NEAR_ENOUGH / self._track)
        self._left_servo = Servo(along, NEAR_ENOUGH)
        self._right_servo = Servo(along, NEAR_ENOUGH)
        self.rest()

    def rest(self) -> None:
        """Forget every command and stand still."""
        self._mode = _MotionMode.BODY
        self._drives_wheels = False
        self.halted = False
        self.left = self.right = 0.0
        for servo in (self.translation, self.rotation, self._left_servo, self._right_servo):
            servo.rest(0.0)

    @property
    def heading_setpoint(self) -> float:
        """Where the robot turns to or is held, else where it looks: rad in the odometry frame."""
        odometry = self._odometry
        setpoint = self.rotation.setpoint
        return odometry.heading if setpoint is None else setpoint - odometry.turned + odometry.heading

    def translate(self, speed: float) -> None:
        """VEL, m/s."""
        self._enter(_MotionMode.BODY)
        self.translation.run(speed)

    def move(self, distance: float) -> None:
        """MOVE, m from here."""
        self._enter(_MotionMode.BODY)
        self.translation.go(self._odometry.travelled, distance)

    def rotate(self, speed: float) -> None:
        """RVEL and ROTATE, rad/s."""
        self._enter(_MotionMode.BODY)
        self.rotation.run(speed)

    def head(self, heading: float) -> None:
        """HEAD: the shortest way to a heading in the odometry frame, rad; half a turn goes counter-clockwise."""
        self.turn(pi - (pi - heading + self._odometry.heading) % (2 * pi))

    def turn(self, angle: float) -> None:
        """DHEAD: an angle from the present heading, rad; the whole of it, even if the other way round were shorter."""
        self._enter(_MotionMode.BODY)
        self.rotation.go(self._odometry.turned, angle)

    def turn_setpoint(self, angle: float) -> None:
        """DCHEAD: an angle from the last heading setpoint, rad."""
        self.turn(self.heading_setpoint - self._odometry.heading + angle)

    def wheels(self, left: float, right: float) -> None:
        """VEL2, m/s of each rim."""
        if self._recomposes:
            self._enter(_MotionMode.RECOMPOSED)
            self.translation.run((left + right) / 2)
            self.rotation.run((right - left) / self._track)
        else:
            self._enter(_MotionMode.WHEELS)
            self._left_servo.run(left)
            self._right_servo.run(right)

    def stop(self, emergency: bool = False) -> None:
        """STOP and ESTOP: stay stopped until a new motion command."""
        for servo in (self.translation, self.rotation, self._left_servo, self._right_servo):
            servo.stop(emergency)

    def restart(self, left: float, right: float) -> None:
        """Go on with the same commands after the motors had no power.

        Args:
            left: Speed of the rim now, m/s.
            right: Likewise.
        """
        self.left, self.right = left, right
        self.translation.restart((left + right) / 2)
        self.rotation.restart((right - left) / self._track)
        self._left_servo.restart(left)
        self._right_servo.restart(right)

    def forget_heading(self) -> None:
        """SETO: the heading setpoint becomes the present heading."""
        self.rotation.forget_place()

    def advance(self, left_speed: float, right_speed: float, dt: float) -> None:
        """Take one step of the profiles and set `left` and `right`.

        Args:
            left_speed: Of the rim as the encoders see it, m/s.
            right_speed: Likewise.
            dt: s.
        """
        odometry = self._odometry
        halted = self.halted
        if self._drives_wheels:
            self.left = self._left_servo.advance(odometry.left_travelled, left_speed, dt, halted)
            self.right = self._right_servo.advance(odometry.right_travelled, right_speed, dt, halted)
            return
        track = self._track
        forward = self.translation.advance(odometry.travelled, (left_speed + right_speed) / 2, dt, halted)
        turning = self.rotation.advance(odometry.turned, (right_speed - left_speed) / track, dt, halted)
        difference = turning * track / 2
        self.left = forward - difference
        self.right = forward + difference

    def _enter(self, mode: _MotionMode) -> None:
        """Give the wheels to the servers of a mode; they begin at the present speeds, without a setpoint."""
        if mode is self._mode:
            return
        self._mode = mode
        self._drives_wheels = mode is _MotionMode.WHEELS
        self.translation.rest((self.left + self.right) / 2)
        self.rotation.rest((self.right - self.left) / self._track)
        self._left_servo.rest(self.left)
        self._right_servo.rest(self.right)
