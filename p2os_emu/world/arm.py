"""An arm on a robot: its parts as links, and the servos that move them; implements `p2os_emu.body.ArmMechanism`.

The engine's own motors hold and move the joints, with no more torque than the model gives them: a joint that is asked
for more lags or sinks. Fingers that close are watched for what they close on (`holding`); nothing else is computed here
in a step.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import mul
from typing import Any

from p2os.accessories.arm_model import ArmGripperModel, ArmModel
from p2os_emu.world.engine import PhysicsClient, engine
from p2os_emu.world.holding import SQUARE, TOUCH, FrictionHold
from p2os_emu.world.links import BodyLink, Joint, Triple
from p2os_emu.world.objects import Objects

GAIN = 0.5
"""Of what is left to go, the part that a servo wants to be rid of in one step; its speed bounds it before."""
FINGERS = 2
ARRIVED = 0.0005
"""m that closing fingers may lack, when they have met nothing."""


@dataclass(frozen=True, slots=True)
class _Servo:
    """One joint: its links, which share the way evenly, its ends (rad or m), and what its motor and friction give."""

    links: tuple[int, ...]
    lower: float
    upper: float
    strength: float
    friction: float


class JointedArm:
    """The arm of one robot."""

    def __init__(
        self,
        client: PhysicsClient,
        body: int,
        first: int,
        model: ArmModel,
        objects: Objects,
        on_command: Callable[[], None] = lambda: None,
    ) -> None:
        """Take hold of an arm that is part of a body.

        Args:
            client, body: Of the engine.
            first: Index of its first link.
            model: The same that its links were made of; they are put at home, without power.
            objects: What its fingers can hold.
            on_command: Called before every command.
        """
        self._on_command = on_command
        self._client = client
        self._body = body
        joints = [
            _Servo((first + number,), joint.lower, joint.upper, joint.torque_nm, joint.friction_nm)
            for number, joint in enumerate(model.joints)
        ]
        fingers = tuple(range(first + len(joints), first + len(joints) + FINGERS))
        self._gripper, force = model.gripper, model.gripper.force_n
        self._objects = objects
        self._holding = FrictionHold(client, body, fingers[0] - 1, objects, model.gripper.friction)
        self._held_at = 0.0  # m between the fingers
        self._closing: float | None = None  # to how many m, while fingers close
        self._finger_speed = model.gripper.speed_m_s
        self._fingers = fingers
        self._servos = (*joints, _Servo(fingers, 0.0, model.gripper.opening_m, force, force))
        self._links = [link for servo in self._servos for link in servo.links]
        for number, place in enumerate(model.home):
            for link in self._servos[number].links:
                share = place / len(self._servos[number].links)
                client.resetJointState(body, link, share, 0.0)
            self.release(number)

    @property
    def positions(self) -> Sequence[float]:
        """Of each joint after the last physics step, rad; of the gripper, m between its fingers."""
        return self._shared(0)

    @property
    def velocities(self) -> Sequence[float]:
        """Of each joint, rad/s; of the gripper, m/s."""
        return self._shared(1)

    @property
    def held(self) -> int | None:
        """Body id of the object between the fingers, None for none."""
        return self._holding.held

    @property
    def holds(self) -> bool:
        """Whether an object is held between the fingers."""
        return self._holding.held is not None

    def move(self, joint: int, position: float, speed: float) -> None:
        """Let a joint, counted from 0, go to a position, rad (m), or its end, no faster than `speed`, rad/s (m/s)."""
        self._on_command()
        servo = self._servos[joint]
        if servo.links == self._fingers:
            position = self._allowed(position)
            self._finger_speed = speed
        self._drive(servo, position, speed)

    def _drive(self, servo: _Servo, position: float, speed: float) -> None:
        share = len(servo.links)
        for link in servo.links:
            self._client.setJointMotorControl2(
                self._body,
                link,
                engine.POSITION_CONTROL,
                targetPosition=min(max(position, servo.lower), servo.upper) / share,
                maxVelocity=speed / share,
                positionGain=GAIN,
                velocityGain=1.0,
                force=servo.strength,
            )

    def release(self, joint: int) -> None:
        """Take the power off a joint: it sinks as its friction lets it."""
        self._on_command()
        servo = self._servos[joint]
        for link in servo.links:
            self._client.setJointMotorControl2(
                self._body,
                link,
                engine.VELOCITY_CONTROL,
                targetVelocity=0.0,
                force=servo.friction,
            )

    def let_go(self) -> None:
        """Hold nothing any more, until the fingers are told to close again."""
        self._closing = None
        self._holding.let_go()

    def follow(self) -> None:
        """Update after a step of the physics: what closing fingers have met, and whether what they hold slips."""
        holding = self._holding
        if holding.held is not None:
            if holding.has_slipped():
                held = holding.held
                holding.let_go()
                if self._between() == held:
                    holding.take(held, self._gripper.force_n)
                elif self._closing is not None:
                    self._drive(self._servos[-1], self._closing, self._finger_speed)
        elif self._closing is not None:
            opening = self._opening
            if opening <= self._closing + ARRIVED:
                self._closing = None
            elif (met := self._between()) is not None:
                self._held_at = opening
                holding.take(met, self._gripper.force_n)
                self._drive(self._servos[-1], opening, self._finger_speed)  # the object does not give way

    def _allowed(self, opening: float) -> float:
        """Return to which opening fingers go that are sent to one, m; they let go when they open."""
        if self._holding.held is not None and opening > self._held_at:
            self.let_go()
        if self._holding.held is None:
            self._closing = opening if opening < self._opening else None
            return opening
        self._closing = opening
        return self._held_at

    @property
    def _opening(self) -> float:
        """Between the fingers, m."""
        states: Sequence[tuple[Any, ...]] = self._client.getJointStates(self._body, self._fingers)
        return float(sum(state[0] for state in states))

    def _between(self) -> int | None:
        """The object that both fingers press on."""
        left, right = self._fingers
        met = self._touched(left, 1.0)
        return next((body for body in self._touched(right, -1.0) if body in met), None) if met else None

    def _touched(self, finger: int, side: float) -> set[int]:
        """The objects that press on the inner face of a finger."""
        contacts = self._client.getContactPoints(bodyA=self._body, linkIndexA=finger)
        pressed = [each for each in contacts if each[2] in self._objects and each[8] <= TOUCH]
        if not pressed:
            return set()
        _, orientation = self._holding.carrier
        outward = engine.rotateVector(orientation, _scaled(self._gripper.axis, side))
        return {each[2] for each in pressed if sum(map(mul, each[7], outward)) > SQUARE}

    def _shared(self, value: int) -> list[float]:
        states: Sequence[tuple[Any, ...]] = self._client.getJointStates(self._body, self._links)
        row = [state[value] for state in states]
        return [*row[:-FINGERS], sum(row[-FINGERS:])]


def arm_links(model: ArmModel) -> tuple[BodyLink, ...]:
    """The parts of an arm, each carried by the one before, and the two fingers, which slide apart."""
    parts = [
        BodyLink(
            mass=joint.mass_kg,
            size=joint.size_m,
            centre=joint.centre_m,
            place=joint.offset_m if number else _sum(model.base_m, joint.offset_m),
            parent=number - 1 if number else None,
            joint=Joint.TURNS,
            axis=joint.axis,
            lower=joint.lower,
            upper=joint.upper,
            rotor=joint.rotor_kg_m2,
        )
        for number, joint in enumerate(model.joints)
    ]
    return (*parts, *(_finger(model.gripper, len(parts) - 1, side) for side in (1.0, -1.0)))


def _finger(gripper: ArmGripperModel, parent: int, side: float) -> BodyLink:
    """One finger, on one side of the middle: at zero both touch there."""
    outward = _scaled(gripper.axis, side)
    return BodyLink(
        mass=gripper.mass_kg,
        size=gripper.finger_m,
        centre=_sum(gripper.centre_m, _scaled(outward, _along(gripper.finger_m, gripper.axis) / 2)),
        place=gripper.offset_m,
        parent=parent,
        joint=Joint.SLIDES,
        axis=outward,
        lower=0.0,
        upper=gripper.opening_m / FINGERS,
        friction=gripper.friction,
    )


def _sum(one: Triple, other: Triple) -> Triple:
    return one[0] + other[0], one[1] + other[1], one[2] + other[2]


def _scaled(one: Triple, by: float) -> Triple:
    return one[0] * by, one[1] * by, one[2] * by


def _along(one: Triple, axis: Triple) -> float:
    return sum(abs(part * share) for part, share in zip(one, axis, strict=True))
