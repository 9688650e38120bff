"""An arm of PowerCube modules on a line of its own: each module moves one joint along a ramp.

Module 1 is the joint nearest to the robot, module 8 the gripper. Source: fact sheet of accessories, section 6, and the
codec's own assumptions. Assumed besides:

- after power-on a module does not know where it is; HOME drives it to its zero, and before that it refuses to move;
- a target beyond its ends is refused, and so is any motion while the module is halted; RESET ends that;
- a moving module halts when the line brings no sound telegram for a while, and when its joint lags too far behind;
- a module that is halted, or has not moved yet, is held by its brake.
"""

from dataclasses import dataclass
from math import copysign, inf, isfinite, radians

from p2os.accessories.arm_model import ArmModel, CubeModel
from p2os.accessories.powercube import (
    EVERY_MODULE,
    CubeCommand,
    CubeState,
    ModuleOutcome,
    ModuleParameter,
    ModuleReply,
    ModuleRequest,
    ModuleTelegramDecoder,
    MotionKind,
)
from p2os.errors import DecodeError
from p2os_emu.body import ArmMechanism
from p2os_emu.microcontroller.profile import approach, braking_speed

SLACK = 1e-4
"""rad or m by which a target may lie beyond an end: what 32 bits round."""
ARRIVED = 1e-5
"""rad or m from its target at which a module has arrived."""
KINDS = frozenset(MotionKind)
FAULTS = CubeState.ERROR | CubeState.HALTED | CubeState.LAGS | CubeState.SILENCE


@dataclass(frozen=True, slots=True)
class _ModuleLimits:
    """Of one module: rad and rad/s, or m and m/s. lag: at which it gives up."""

    lower: float
    upper: float
    home: float
    speed: float
    acceleration: float
    lag: float


class _Cube:
    """One module.

    state: as it reports it. setpoint: where the joint should be now, along its ramp.
    """

    def __init__(self, joint: int, limits: _ModuleLimits, most_current: float) -> None:
        self.state = CubeState.BRAKED
        self.setpoint = limits.home
        self._joint = joint
        self._limits = limits
        self._speed = 0.0
        self._target: float | None = None  # of a motion to a place
        self._cruise = 0.0  # signed, of a motion without one
        self._is_homing = False
        self._top = limits.speed
        self._settings = {
            ModuleParameter.RAMP_VELOCITY: limits.speed,
            ModuleParameter.RAMP_ACCELERATION: limits.acceleration / 2,
            ModuleParameter.MOST_CURRENT: most_current,
        }

    @property
    def is_moving(self) -> bool:
        """It is on its way."""
        return CubeState.MOVING in self.state

    def answer(self, request: ModuleRequest, arm: ArmMechanism) -> ModuleReply:
        """Carry out a request of the host."""
        command, about, value, time = request
        match command:
            case CubeCommand.RESET:
                self._reset(arm)
            case CubeCommand.HALT:
                self.halt(arm, CubeState.HALTED)
            case CubeCommand.HOME if not self.state & CubeState.HALTED:
                self._is_homing = True
                self._begin(arm, self._limits.home, self._settings[ModuleParameter.RAMP_VELOCITY])
            case CubeCommand.GET:
                return self._get(about, arm)
            case CubeCommand.SET if about in self._settings and isfinite(value) and value > 0.0:
                self._settings[ModuleParameter(about)] = value
            case CubeCommand.MOVE if about in KINDS and self._may_move(about, value, time):
                self._move(MotionKind(about), value, time, arm)
                if about != MotionKind.RAMP:
                    return ModuleReply(command, about, value=arm.positions[self._joint], state=self.state)
            case _:
                return ModuleReply(command, about, ModuleOutcome.REFUSED)
        return ModuleReply(command, about, ModuleOutcome.DONE)

    def halt(self, arm: ArmMechanism, why: CubeState) -> None:
        """Stop at once; the brake holds until RESET."""
        self.state = self.state & ~CubeState.MOVING | CubeState.BRAKED | CubeState.HALTED | why
        self._is_homing = False
        self._speed = 0.0
        arm.release(self._joint)

    def advance(self, arm: ArmMechanism, position: float, dt: float) -> None:
        """Take one step along the ramp. position: of the joint, rad or m."""
        if abs(self.setpoint - position) > self._limits.lag:
            self.halt(arm, CubeState.ERROR | CubeState.LAGS)
            return
        wanted = self._wanted_speed(dt)
        acceleration = self._settings[ModuleParameter.RAMP_ACCELERATION]
        self._speed = approach(self._speed, wanted, acceleration, self._limits.acceleration, dt)
        self.setpoint = min(max(self.setpoint + self._speed * dt, self._limits.lower), self._limits.upper)
        if wanted == self._speed == 0.0:
            self._arrive()
        arm.move(self._joint, self.setpoint, self._limits.speed)

    def _wanted_speed(self, dt: float) -> float:
        """Signed; along the way it brakes in time for the target, or for the end."""
        towards_end = self._limits.upper if self._cruise > 0.0 else self._limits.lower
        left = (towards_end if self._target is None else self._target) - self.setpoint
        if abs(left) <= ARRIVED or (self._target is None and self._cruise == 0.0):
            return 0.0
        return copysign(min(self._top, braking_speed(abs(left), self._braking, dt)), left)

    @property
    def _braking(self) -> float:
        return min(self._settings[ModuleParameter.RAMP_ACCELERATION], self._limits.acceleration)

    def _arrive(self) -> None:
        self.state &= ~CubeState.MOVING
        if self._target is not None:
            self.setpoint = self._target
        if self._is_homing:
            self._is_homing = False
            self.state |= CubeState.HOMED

    def _reset(self, arm: ArmMechanism) -> None:
        if self.state & FAULTS:
            self.state &= ~FAULTS
            self.setpoint = arm.positions[self._joint]

    def _may_move(self, about: int, value: float, time: float) -> bool:
        limits = self._limits
        if self.state & CubeState.HALTED or not isfinite(value):
            return False
        if about == MotionKind.VELOCITY_ACKNOWLEDGED and value == 0.0:
            return True  # to stand still one need not know where
        if not self.state & CubeState.HOMED:
            return False
        if about == MotionKind.VELOCITY_ACKNOWLEDGED:
            return abs(value) <= limits.speed + SLACK
        return limits.lower - SLACK <= value <= limits.upper + SLACK

    def _move(self, kind: MotionKind, value: float, time: float, arm: ArmMechanism) -> None:
        self._is_homing = False
        match kind:
            case MotionKind.VELOCITY_ACKNOWLEDGED:
                self._begin(arm, None, abs(value))
                self._cruise = value
            case MotionKind.STEP_ACKNOWLEDGED:
                way = abs(value - self.setpoint)
                self._begin(arm, value, way / time if time > 0.0 else self._limits.speed)
            case _:
                self._begin(arm, value, self._settings[ModuleParameter.RAMP_VELOCITY])

    def _begin(self, arm: ArmMechanism, target: float | None, speed: float) -> None:
        if CubeState.BRAKED in self.state:
            self.setpoint = arm.positions[self._joint]
        self.state = self.state & ~CubeState.BRAKED | CubeState.MOVING
        self._target = target if target is None else min(max(target, self._limits.lower), self._limits.upper)
        self._top = min(speed, self._limits.speed)
        self._cruise = 0.0

    def _get(self, about: int, arm: ArmMechanism) -> ModuleReply:
        if about == ModuleParameter.STATE:
            return ModuleReply(CubeCommand.GET, about, state=self.state)
        limits = self._limits
        values = {
            ModuleParameter.MINIMUM: limits.lower,
            ModuleParameter.MAXIMUM: limits.upper,
            ModuleParameter.MOST_VELOCITY: limits.speed,
            ModuleParameter.MOST_ACCELERATION: limits.acceleration,
            **self._settings,
        }
        match about:
            case ModuleParameter.POSITION:
                value: float | None = arm.positions[self._joint]
            case ModuleParameter.VELOCITY:
                value = arm.velocities[self._joint]
            case _:
                value = values[ModuleParameter(about)] if about in values else None
        return ModuleReply(
            CubeCommand.GET, about, value=value, outcome=ModuleOutcome.REFUSED if value is None else None
        )


class PowerCubeArm:
    """The modules of one arm on their line; implements `Device`.

    cubes: in the order of the joints. baud: bit/s.
    """

    def __init__(self, model: ArmModel, arm: ArmMechanism) -> None:
        """Switch the modules on.

        Args:
            model: Of an arm that is made of modules.
            arm: What they move.
        Raises:
            ValueError: The model says nothing of modules.
        """
        if model.cubes is None:
            raise ValueError(f"the arm {model.name!r} is not made of modules; give its file a table [cubes]")
        self.baud = model.cubes.baud
        limits = _limits(model, model.cubes)
        self.cubes = tuple(_Cube(joint, each, model.cubes.most_current_a) for joint, each in enumerate(limits))
        self._arm = arm
        self._patience = model.cubes.watchdog_s
        self._silence = 0.0
        self._decoder = ModuleTelegramDecoder()
        self._answers: list[bytes] = []
        for joint in range(len(self.cubes)):
            arm.release(joint)

    def receive(self, data: bytes) -> None:
        """Take bytes from the line."""
        for module, is_answer, content in self._decoder.receive(data):
            if is_answer:
                continue
            self._silence = 0.0
            try:
                request = ModuleRequest.decode(content)
            except DecodeError:
                continue  # like any telegram that a module does not understand
            if module == EVERY_MODULE:
                for cube in self.cubes:
                    cube.answer(request, self._arm)
            elif module <= len(self.cubes):
                self._answers.append(self.cubes[module - 1].answer(request, self._arm).encode(module))

    @property
    def silence(self) -> float:
        """Time in which the modules send nothing unless they receive something, s."""
        return 0.0 if self._answers else inf

    def step(self, dt: float) -> bytes:
        """Advance time, s; return the bytes that the modules send."""
        self._silence += dt
        if any(cube.is_moving for cube in self.cubes):
            self._move(dt)
        sent = b"".join(self._answers)
        self._answers.clear()
        return sent

    def _move(self, dt: float) -> None:
        positions = self._arm.positions
        for cube, position in zip(self.cubes, positions, strict=True):
            if cube.is_moving and self._silence >= self._patience:
                cube.halt(self._arm, CubeState.ERROR | CubeState.SILENCE)
            elif cube.is_moving:
                cube.advance(self._arm, position, dt)


def _limits(model: ArmModel, cubes: CubeModel) -> list[_ModuleLimits]:
    joints = [
        _ModuleLimits(
            joint.lower,
            joint.upper,
            joint.home,
            joint.speed,
            joint.speed / cubes.acceleration_s,
            radians(cubes.lag_deg),
        )
        for joint in model.joints
    ]
    gripper = model.gripper
    acceleration = gripper.speed_m_s / cubes.acceleration_s
    return [
        *joints,
        _ModuleLimits(0.0, gripper.opening_m, gripper.home_m, gripper.speed_m_s, acceleration, cubes.lag_m),
    ]
