"""Holding of an object between two surfaces that press on it, for every gripper.

Friction that holds is a constraint between the part that carries the surfaces and the object, no stronger than friction
would be at the force that they press with. What asks for more slips. (Friction alone lets the solver shake an object
out in seconds.)
"""

from math import dist

from p2os_emu.world.collision import HULL
from p2os_emu.world.engine import PhysicsClient, engine
from p2os_emu.world.objects import Objects
from p2os_emu.world.rays import Place

SLIP = 0.003  # m that a held object gives way before its hold begins anew
TOUCH = 0.001  # m; the rubber of surfaces that have stopped still presses on what is so near
SQUARE = 0.5  # least part of a contact's normal that points along the motion of a surface, for its inner face


class FrictionHold:
    """What one gripper holds.

    held: body id of the object, None for none. force: of one surface, N.
    """

    def __init__(self, client: PhysicsClient, body: int, carrier: int, objects: Objects, friction: float) -> None:
        """Begin with nothing.

        Args:
            client, body: Of the engine.
            carrier: Index of the link that carries both surfaces.
            objects: What can be held.
            friction: Of the surfaces.
        """
        self.held: int | None = None
        self.force = 0.0
        self._client = client
        self._body = body
        self._carrier = carrier
        self._objects = objects
        self._friction = friction
        self._constraint = 0
        self._place: Place = (0.0, 0.0, 0.0)  # of the object when it was taken, from the carrier, m

    @property
    def carrier(self) -> tuple[Place, tuple[float, float, float, float]]:
        """Place (m, in the world) and orientation of the middle of the part that carries the surfaces."""
        state = self._client.getLinkState(
            self._body,
            self._carrier,
            computeForwardKinematics=True,  # otherwise it is where it was a step ago
        )
        return state[0], state[1]

    def take(self, held: int, force: float) -> None:
        """Begin to hold an object where it is, with a force of each surface, N."""
        place, orientation = self._from_carrier(held)
        self._constraint = self._client.createConstraint(
            self._body,
            self._carrier,
            held,
            HULL,
            engine.JOINT_FIXED,
            [0.0] * 3,
            place,
            [0.0] * 3,
            orientation,
            [0.0, 0.0, 0.0, 1.0],
        )
        self.held, self._place = held, place
        self.press(force)

    def press(self, force: float) -> None:
        """Hold what is held with another force of each surface, N."""
        assert self.held is not None
        self.force = force
        friction = self._objects.friction(self.held, self._friction)
        self._client.changeConstraint(self._constraint, maxForce=2 * friction * force)

    def has_slipped(self) -> bool:
        """Return whether what is held has given way."""
        assert self.held is not None
        place, _ = self._from_carrier(self.held)
        return dist(place, self._place) > SLIP

    def let_go(self) -> None:
        """Hold nothing any more."""
        if self.held is not None:
            self._client.removeConstraint(self._constraint)
            self.held = None

    def _from_carrier(self, held: int) -> tuple[Place, tuple[float, float, float, float]]:
        """Place (m) and orientation of an object, seen from the middle of the carrier."""
        thing = self._client.getBasePositionAndOrientation(held)
        place, orientation = engine.multiplyTransforms(*engine.invertTransform(*self.carrier), *thing)
        return place, orientation
