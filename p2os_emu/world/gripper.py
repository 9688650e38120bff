"""A gripper on a robot: paddles and lift as links of its body; implements `p2os_emu.body.GripperMechanism`.

Paddles close with the force that triggers their contact switches. Once both press on one object it is gripped
(`holding`), and it slips when it asks for more than their friction.
"""

from collections.abc import Callable, Iterator, Sequence
from math import cos, sin
from typing import Any

from p2os_emu.body import GripperMechanismState
from p2os_emu.gripper_model import GripperModel
from p2os_emu.world.chassis import Chassis
from p2os_emu.world.collision import SEEN_BY_LIGHT, heading_of
from p2os_emu.world.engine import STEP, PhysicsClient, engine
from p2os_emu.world.holding import SQUARE, TOUCH, FrictionHold
from p2os_emu.world.links import BodyLink, Joint
from p2os_emu.world.objects import Objects
from p2os_emu.world.rays import Place

CARRIAGE = 0.02  # m along the robot, of what carries the paddles
CLOSED = 0.01  # opening below which the paddles press on each other
BEAM_INSET = 0.005  # m within the paddles, of the ends of a beam, so that it meets what touches a paddle
NOTHING = -1  # what the engine says a ray has met that met nothing
PADDLE_FORCE = 50.0  # N; opens paddles, and holds them where they are
GAIN = 0.3  # of what is left to go, that a motor wants to be rid of in one step; its speed bounds it before


def gripper_links(model: GripperModel, chassis: Chassis) -> tuple[BodyLink, ...]:
    """The lift's carriage and both paddles, left first, all down and open."""
    half = model.opening_m / 2
    size = model.paddle_length_m, model.paddle_thickness_m, model.paddle_height_m
    lift = BodyLink(
        mass=model.lift_mass_kg,
        size=(CARRIAGE, model.opening_m, model.paddle_height_m / 2),
        centre=(-CARRIAGE / 2, 0.0, 0.0),
        place=(chassis.front + model.gap_m, 0.0, model.clearance_m + model.paddle_height_m / 2),
        joint=Joint.SLIDES,
        upper=model.lift_travel_m,
    )
    paddles = (
        BodyLink(
            mass=model.paddle_mass_kg,
            size=size,
            centre=(model.paddle_length_m / 2, side * model.paddle_thickness_m / 2, 0.0),
            place=(0.0, side * half, 0.0),
            parent=0,
            joint=Joint.SLIDES,
            axis=(0.0, -side, 0.0),
            upper=half,
            friction=model.paddle_friction,
        )
        for side in (1.0, -1.0)
    )
    return lift, *paddles


class RobotGripper:
    """The gripper of one robot."""

    def __init__(
        self,
        client: PhysicsClient,
        body: int,
        first: int,
        model: GripperModel,
        objects: Objects,
        on_command: Callable[[], None] = lambda: None,
    ) -> None:
        """Take hold of a gripper that is part of a body.

        Args:
            client, body: Of the engine.
            first: Index of its first link.
            model: The same that its links were made of.
            objects: What can be gripped.
            on_command: Called before every command.
        """
        self.model = model
        self._on_command = on_command
        self._client = client
        self._body = body
        self._lift, self._left, self._right = range(first, first + 3)
        self._objects = objects
        self._holding = FrictionHold(client, body, self._lift, objects, model.paddle_friction)
        self._state: GripperMechanismState | None = None
        self._paddles = self._raising = 0.0
        self._hold(self._left, self._right, self._lift)

    @property
    def state(self) -> GripperMechanismState:
        """The gripper after the last physics step."""
        if self._state is None:
            self._state = self._look()
        return self._state

    @property
    def held(self) -> int | None:
        """Body id of the object that is held, None for none."""
        return self._holding.held

    def drive(self, paddles: float, lift: float) -> None:
        """Command the motors, at their own speed: -1 closes or lowers, 0 holds where it is, 1 opens or lifts."""
        if (paddles, lift) != (self._paddles, self._raising):
            self._on_command()
        if paddles != self._paddles:
            self._paddles = paddles
            self._drive_paddles()
        if lift != self._raising:
            self._raising = lift
            self._drive_lift()

    def let_go(self) -> None:
        """Hold nothing any more."""
        self._holding.let_go()

    def follow(self) -> None:
        """Update after a step of the physics: which objects are gripped, pressed or slip."""
        self._state = None
        if self._holding.held is not None:
            self._watch(self._holding.held)
        elif self._paddles < 0.0:
            held = self._between()
            if held is not None:
                self._holding.take(held, self.model.contact_force_n)

    def _drive_paddles(self) -> None:
        speed = abs(self._paddles) * self.model.paddle_speed_m_s
        if self._paddles > 0.0:
            self.let_go()
            for paddle in (self._left, self._right):
                self._move(paddle, 0.0, speed, PADDLE_FORCE)
        elif self._paddles < 0.0:
            self._client.setJointMotorControlArray(
                self._body,
                (self._left, self._right),
                engine.VELOCITY_CONTROL,
                targetVelocities=[speed] * 2,
                forces=[self.model.contact_force_n] * 2,
            )
        else:
            self._hold(self._left, self._right)

    def _drive_lift(self) -> None:
        if self._raising:
            end = self.model.lift_travel_m if self._raising > 0.0 else 0.0
            speed = abs(self._raising) * self.model.lift_speed_m_s
            self._move(self._lift, end, speed, self.model.lift_force_n)
        else:
            self._hold(self._lift)

    def _hold(self, *links: int) -> None:
        """Keep links where they are."""
        for link, (position, *_) in zip(links, self._joints(*links), strict=True):
            force = self.model.lift_force_n if link == self._lift else PADDLE_FORCE
            self._move(link, position, self.model.lift_speed_m_s, force)

    def _move(self, link: int, position: float, speed: float, force: float) -> None:
        self._client.setJointMotorControl2(
            self._body,
            link,
            engine.POSITION_CONTROL,
            targetPosition=position,
            positionGain=GAIN,
            maxVelocity=speed,
            force=force,
        )

    def _joints(self, *links: int) -> Sequence[tuple[float, float, Any, float]]:
        """Place (m) and speed (m/s) of each link, among others."""
        states: Sequence[tuple[float, float, Any, float]] = self._client.getJointStates(self._body, links)
        return states

    def _between(self) -> int | None:
        """The object that both paddles press on."""
        right = set(self._touched(self._right, -1.0))
        return next((body for body in self._touched(self._left, 1.0) if body in right and body in self._objects), None)

    def _touched(self, paddle: int, outward: float) -> Iterator[int]:
        """What presses on the inner face of a paddle; `outward` is 1 for the left paddle, -1 for the right."""
        contacts = self._client.getContactPoints(bodyA=self._body, linkIndexA=paddle)
        if not contacts:
            return
        _, orientation = self._client.getBasePositionAndOrientation(self._body)
        heading = heading_of(orientation)
        for contact in contacts:
            other, normal, distance = contact[2], contact[7], contact[8]
            if distance <= TOUCH and outward * (normal[1] * cos(heading) - normal[0] * sin(heading)) > SQUARE:
                yield other

    def _watch(self, held: int) -> None:
        """Press harder while the motor goes on, and see whether the object slips."""
        holding, force = self._holding, self._holding.force
        if self._paddles < 0.0 and force < self.model.strongest_n:
            holding.press(min(force + self.model.pressing_n_s * STEP, self.model.strongest_n))
        if holding.has_slipped():
            holding.let_go()
            if self._between() == held:
                holding.take(held, holding.force)

    def _look(self) -> GripperMechanismState:
        lift, left, right = self._joints(self._lift, self._left, self._right)
        model = self.model
        opening = 1.0 - (left[0] + right[0]) / model.opening_m
        is_closed = opening < CLOSED
        outer, inner = self._beams(left[0], right[0])
        return GripperMechanismState(
            opening=min(max(opening, 0.0), 1.0),
            lift=min(max(lift[0] / model.lift_travel_m, 0.0), 1.0),
            opening_speed=-(left[1] + right[1]) / model.opening_m,
            lift_speed=lift[1] / model.lift_travel_m,
            outer_beam=outer,
            inner_beam=inner,
            left_contact=is_closed or any(True for _ in self._touched(self._left, 1.0)),
            right_contact=is_closed or any(True for _ in self._touched(self._right, -1.0)),
            holds=self._holding.held is not None,
        )

    def _beams(self, left: float, right: float) -> tuple[bool, bool]:
        """Whether something stands in the outer and the inner beam."""
        half = self.model.opening_m / 2 + BEAM_INSET
        ends = half - left, right - half
        origin, orientation = self._holding.carrier
        starts, stops = [], []
        for beam in (self.model.outer_beam_m, self.model.inner_beam_m):
            places = (self._in_world(origin, orientation, beam + CARRIAGE / 2, y) for y in ends)
            starts.append(next(places))
            stops.append(next(places))
        hits = self._client.rayTestBatch(starts, stops, numThreads=1, collisionFilterMask=SEEN_BY_LIGHT)
        outer, inner = (body not in (NOTHING, self._body) for body, *_ in hits)
        return outer, inner

    @staticmethod
    def _in_world(origin: Place, orientation: Sequence[float], x: float, y: float) -> Place:
        """A place beside the lift's carriage, x ahead of its middle and y to the left, m in the world."""
        heading = heading_of(orientation)
        c, s = cos(heading), sin(heading)
        return origin[0] + c * x - s * y, origin[1] + s * x + c * y, origin[2]
