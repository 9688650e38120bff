"""What a robot drives with: two wheels and their motors, computed by the engine or by a model of the wheels.

The engine computes a robot while something may touch it, the model while nothing can; they hand over to each other.
"""

from collections.abc import Sequence
from math import cos, sin
from typing import Any, NamedTuple

from geometry import Pose2D
from p2os_emu.world.chassis import MASS_HEIGHT, Chassis
from p2os_emu.world.collision import HULL, WHEELS, heading_of, mass_position, upright
from p2os_emu.world.engine import STEP, PhysicsClient, engine
from p2os_emu.world.wheel_model import WheelModel

LEVEL = 0.002
"""m that the middle of a robot may be off its height, and m/s or rad/s that its wheels may slip, for the model to
hold."""
STANDING = 0.002
"""m/s or rad/s; a part of a robot that moves no faster stands."""


class WheelStates(NamedTuple):
    """Angle, rad, speed, rad/s, and torque of the motor, N m, of each wheel."""

    left: float
    left_speed: float
    left_torque: float
    right: float
    right_speed: float
    right_torque: float


class DriveTrain:
    """The wheels of one robot.

    is_in_engine: the engine computes the robot, unless it sleeps.
    """

    def __init__(self, client: PhysicsClient, body: int, chassis: Chassis) -> None:
        """Take over a robot that the engine computes.

        Args:
            client: Of the physics engine.
            body: The engine's number of the robot.
            chassis: Of the robot.
        """
        self._client = client
        self._body = body
        self._chassis = chassis
        self._command = (0.0, 0.0, 0.0)  # speeds of the wheels that the motors strive for, rad/s, and their torque, N m
        self._model: WheelModel | None = None
        self._height = 0.0  # m of the body's frame, when the engine last computed it
        self._is_put = True  # the engine has the robot where the model has it
        self.is_in_engine = True

    @property
    def pose(self) -> Pose2D:
        """Where the middle of the axle is, in the world."""
        if self._model is not None:
            return self._model.pose
        (x, y, _), quaternion = self._client.getBasePositionAndOrientation(self._body)
        return Pose2D(x, y, heading_of(quaternion))

    @property
    def velocity(self) -> tuple[float, float]:
        """m/s forward, rad/s counter-clockwise."""
        if self._model is not None:
            return self._model.velocity
        (vx, vy, _), (_, _, turning) = self._client.getBaseVelocity(self._body)
        heading = self.pose.heading
        return vx * cos(heading) + vy * sin(heading), turning

    @property
    def turn_rate(self) -> float:
        """rad/s counter-clockwise."""
        if self._model is not None:
            return self._model.velocity[1]
        rate: float = self._client.getBaseVelocity(self._body)[1][2]
        return rate

    @property
    def wheels(self) -> WheelStates:
        """Both wheels, after the last step."""
        model = self._model
        if model is not None:
            return WheelStates(
                model.left,
                model.left_speed,
                model.left_torque,
                model.right,
                model.right_speed,
                model.right_torque,
            )
        states: Sequence[tuple[float, float, Any, float]] = self._client.getJointStates(self._body, WHEELS)
        (left, left_speed, _, left_torque), (right, right_speed, _, right_torque) = states
        return WheelStates(left, left_speed, left_torque, right, right_speed, right_torque)

    @property
    def moves(self) -> bool:
        """Whether the robot or any joint of it moves."""
        model = self._model
        if model is not None:
            return any(abs(each) > STANDING for each in (*model.velocity, model.left_speed, model.right_speed))
        (vx, vy, _), (_, _, turning) = self._client.getBaseVelocity(self._body)
        if max(abs(vx), abs(vy), abs(turning)) > STANDING:
            return True
        joints = range(self._client.getNumJoints(self._body))
        return any(abs(speed) > STANDING for _, speed, *_ in self._client.getJointStates(self._body, list(joints)))

    def drive(self, left: float, right: float, torque: float) -> None:
        """Let the motors strive for speeds, rad/s, with this torque at most, N m."""
        self._command = left, right, torque
        if self._model is not None:
            self._model.drive(left, right, torque)
        else:
            self._set_motors(left, right, torque)

    def advance(self) -> None:
        """Take a step; the engine takes its own."""
        if self._model is not None:
            self._model.advance(STEP)
            self._is_put = False

    def leave_engine(self) -> None:
        """Let the model compute the robot, if it stands level on wheels that do not slip."""
        left, left_speed, _, right, right_speed, _ = self.wheels
        model = WheelModel(self._chassis, self.pose, (left, left_speed), (right, right_speed))
        (_, _, height), (qx, qy, *_) = self._client.getBasePositionAndOrientation(self._body)
        if max(abs(height - MASS_HEIGHT), abs(qx), abs(qy)) > LEVEL or self._slips(model):
            return
        model.drive(*self._command)
        self._height = height
        self._set_state((0.0, 0.0), 0.0, (left, 0.0), (right, 0.0))
        self._set_motors(0.0, 0.0, self._chassis.motor_torque)
        self.sleep()
        self._model, self.is_in_engine = model, False

    def enter_engine(self, *, asleep: bool) -> None:
        """Let the engine compute the robot from now on, or from when it is woken."""
        model = self._model
        if model is None:
            return
        self.put()
        self._model, self.is_in_engine = None, True
        speed, turning = model.velocity
        c, s = cos(model.heading), sin(model.heading)
        wheels = (model.left, model.left_speed), (model.right, model.right_speed)
        self._set_state((speed * c, speed * s), turning, *wheels)
        self._set_motors(*self._command)
        if not asleep:
            self.wake_up()

    def put(self) -> None:
        """Put the robot where it is in the engine too, for those who look there."""
        model = self._model
        if model is not None and not self._is_put:
            self._is_put = True
            place = model.x, model.y, self._height
            self._client.resetBasePositionAndOrientation(self._body, place, upright(model.heading))

    def place(self, pose: Pose2D) -> None:
        """Put the robot somewhere else, at rest; the angles of its wheels stay."""
        self.enter_engine(asleep=False)
        self._client.resetBasePositionAndOrientation(self._body, mass_position(pose), upright(pose.heading))
        wheels = self.wheels
        self._set_state((0.0, 0.0), 0.0, (wheels.left, 0.0), (wheels.right, 0.0))

    def sleep(self) -> None:
        """Let the engine compute the robot no more."""
        self._activate(engine.ACTIVATION_STATE_ENABLE_SLEEPING + engine.ACTIVATION_STATE_SLEEP)

    def wake_up(self) -> None:
        """Let the engine compute the robot again."""
        self._activate(engine.ACTIVATION_STATE_WAKE_UP + engine.ACTIVATION_STATE_DISABLE_SLEEPING)

    def _slips(self, model: WheelModel) -> bool:
        """Return whether the robot moves otherwise than its wheels turn."""
        (vx, vy, vz), (_, _, turning) = self._client.getBaseVelocity(self._body)
        speed, turn_rate = model.velocity
        c, s = cos(model.heading), sin(model.heading)
        return any(abs(off) > LEVEL for off in (vx * c + vy * s - speed, vy * c - vx * s, vz, turning - turn_rate))

    def _set_state(self, velocity: tuple[float, float], turning: float, *wheels: tuple[float, float]) -> None:
        """Set the velocity in the world, m/s, the turn rate, rad/s, and angle and speed of both wheels."""
        self._client.resetBaseVelocity(self._body, [*velocity, 0.0], [0.0, 0.0, turning])
        for wheel, (angle, speed) in zip(WHEELS, wheels, strict=True):
            self._client.resetJointState(self._body, wheel, angle, speed)

    def _set_motors(self, left: float, right: float, torque: float) -> None:
        self._client.setJointMotorControlArray(
            self._body,
            WHEELS,
            engine.VELOCITY_CONTROL,
            targetVelocities=[left, right],
            forces=[torque, torque],
        )

    def _activate(self, state: int) -> None:
        self._client.changeDynamics(self._body, HULL, activationState=state)
