"""Everything in a world that crosses the plane of the sonar discs, for fans of level rays.

What moves is looked up where a fan may meet it: the places by which that is decided are up to `PERIOD` steps old, the
outline is of this step. Shapes are those of the physics engine: people and cylinders are round, and hulls that lean are
cut as they lean.
"""

from cmath import rect
from collections.abc import Callable, Iterable, Sequence
from math import hypot
from typing import NamedTuple

from geometry import Pose2D
from p2os_emu.world.chassis import HULL_BOTTOM, MASS_HEIGHT, Chassis
from p2os_emu.world.engine import STEP, PhysicsClient
from p2os_emu.world.fan import AllHits, BoxSide, Cylinder, Fan, FirstHit, box_corners, box_sides
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.moving_doors import LEAF_HEIGHT, LEAF_THICKNESS, MovingDoor
from p2os_emu.world.people import BODY_RADIUS, HEIGHT, Person
from p2os_emu.world.spec import Block
from p2os_emu.world.standing import StandingSides

PERIOD = 12
"""Steps from one look at where everything is to the next."""
MOVES = 0.3
"""m; nothing but leaves of doors moves as far in `PERIOD` steps."""
MOST_SPREAD = 1.0
"""m; no disc is so far from the middle of its robot's axle."""
UPRIGHT = 0.99995
"""Least cosine between the vertical and the axis of what is cut as if it stood upright; 0.6 degrees."""


class Solid(NamedTuple):
    """A body of the physics engine that moves, in its base frame, whose x axis lies along the body.

    corners: of a box, as `box_sides` takes them. radius: of a cylinder, m; 0 for a box. bottom, top: m.
    reach: radius of a sphere about the origin that contains all of it that can be at the height of the discs, and
    how far a fast one moves between two looks, m.
    """

    corners: Sequence[complex]
    radius: float
    bottom: float
    top: float
    reach: float

    @classmethod
    def robot(cls, chassis: Chassis) -> "Solid":
        """Of a robot without accessories that collide."""
        reach = hypot(max(chassis.front, chassis.rear), chassis.width / 2)
        low, high = HULL_BOTTOM - MASS_HEIGHT, chassis.height - MASS_HEIGHT
        return cls(box_corners(chassis.front, chassis.rear, chassis.width / 2), 0.0, low, high, reach)

    @classmethod
    def movable(cls, movable: Movable) -> "Solid":
        """Of a movable object, which may also fall over."""
        if movable.shape is Shape.CYLINDER:
            return cls._cylinder(movable.length / 2, movable.height)
        return cls._box(movable.length, movable.width, movable.height)

    @classmethod
    def bystander(cls, bystander: Person | MovingDoor) -> "Solid":
        """Of somebody, or of the leaf of a door."""
        if isinstance(bystander, MovingDoor):
            leaf = cls._box(bystander.width, LEAF_THICKNESS, LEAF_HEIGHT)
            return leaf._replace(reach=leaf.reach + PERIOD * STEP * bystander.speed)
        return cls._cylinder(BODY_RADIUS, HEIGHT)

    @classmethod
    def _box(cls, length: float, width: float, height: float) -> "Solid":
        half = height / 2
        corners = box_corners(length / 2, length / 2, width / 2)
        return cls(corners, 0.0, -half, half, hypot(length, width, height) / 2)

    @classmethod
    def _cylinder(cls, radius: float, height: float) -> "Solid":
        return cls((), radius, -height / 2, height / 2, hypot(radius, height / 2))


class _Cut(NamedTuple):
    """What of a body crosses the plane. is_known: False for a body that has fallen over."""

    sides: Sequence[BoxSide] = ()
    cylinder: Cylinder | None = None
    is_known: bool = True


class SonarScene:
    """Everything in one world that sonar can meet in the plane of the discs.

    is_used: False where the rays of the physics engine are wanted.
    """

    def __init__(
        self,
        client: PhysicsClient,
        height: float,
        fan: Fan,
        blocks: Iterable[Block],
        steps: Callable[[], int],
    ) -> None:
        """Prepare what stands still.

        Args:
            client: Of the physics engine.
            height: Of the discs, m above the floor.
            fan: Like the fans of all discs, up to their places.
            blocks: What stands still; sonar hears glass.
            steps: Return how many steps the world has made.
        """
        self._client = client
        self._height = height
        self._steps = steps
        self.is_used = True
        still = (side for block in blocks if block.crosses(height) for side in _block_sides(block))
        self._still = StandingSides(still, fan)
        self._unknown: set[int] = set()
        self._solids: dict[int, Solid] = {}
        self._level_poses: dict[int, Callable[[], Pose2D | None]] = {}
        self._places: list[tuple[int, complex, float]] = []
        self._places_until = -1
        self._neighbours: dict[int, list[tuple[int, complex, float]]] = {}
        self._span = fan.reach + MOST_SPREAD + MOVES
        self._cuts: dict[int, _Cut] = {}
        self._cuts_of = -1

    def add(self, body: int, solid: Solid | None, level_pose: Callable[[], Pose2D | None] | None = None) -> None:
        """Add a body that moves.

        Args:
            body: The engine's number of it.
            solid: Its shape; None for one that this scene cannot cut.
            level_pose: Return where it stands upright; None while the engine knows.
        """
        if solid is None:
            self._unknown.add(body)
        else:
            self._solids[body] = solid
            self._level_poses[body] = level_pose or _leave_to_engine
            self.forget_places()

    def remove(self, body: int) -> None:
        """Remove a body that moves."""
        self._unknown.discard(body)
        self._solids.pop(body, None)
        self._level_poses.pop(body, None)
        self.forget_places()

    def forget_places(self) -> None:
        """Look up everything again: something was put somewhere else."""
        self._places_until = self._cuts_of = -1

    def nearest(self, fans: Iterable[Fan], pose: Pose2D, own: int, least: float) -> list[float] | None:
        """Find the first surface that each ray meets, and of those of each fan the nearest that is met squarely enough.

        Args:
            fans: Of one robot.
            pose: Of that robot.
            own: Its body id; it does not hear itself.
            least: The cosine of the angle of incidence must be greater.
        Returns:
            Distances ahead of the points of the fans, m, `inf` where there is no such surface. None where a fan may
            meet a body whose outline is not known here: one that has fallen over, or one without a solid.
        """
        if self._unknown or not self.is_used:
            return None
        steps = self._steps()
        if steps >= self._places_until:
            self._look(steps)
        if steps != self._cuts_of:
            self._cuts_of = steps
            self._cuts.clear()
        place, ahead = complex(pose.x, pose.y), rect(1.0, pose.heading)
        neighbours = self._neighbours.get(own)
        if neighbours is None:
            neighbours = self._neighbours[own] = [
                each for each in self._places if each[0] != own and abs(each[1] - place) <= self._span + each[2]
            ]
        found = []
        for fan in fans:
            hit = FirstHit(fan, place, ahead)
            if not self._follow(hit, pose.heading + fan.heading, neighbours):
                return None
            distance = hit.nearest(least)
            if distance is None:
                hits = AllHits(fan, place, ahead)
                if not self._follow(hits, pose.heading + fan.heading, neighbours):
                    return None
                distance = hits.nearest(least)
            found.append(distance)
        return found

    def _follow(self, hit: FirstHit, heading: float, neighbours: Sequence[tuple[int, complex, float]]) -> bool:
        """Follow the rays of a fan that looks along a heading, rad; False where an outline is not known."""
        hit.meet_sides(self._still.near(hit.point, heading))
        for body in hit.among(neighbours):
            cut = self._cuts.get(body) or self._cut(body)
            if not cut.is_known:
                return False
            hit.meet_sides(cut.sides)
            if cut.cylinder is not None:
                hit.meet_cylinder(cut.cylinder)
        return True

    def _look(self, steps: int) -> None:
        self._places_until = steps + PERIOD
        self._places = []
        self._neighbours.clear()
        for body, solid in self._solids.items():
            pose = self._level_poses[body]()
            if pose is not None:
                x, y = pose.x, pose.y
            else:
                (x, y, _), _ = self._client.getBasePositionAndOrientation(body)
            self._places.append((body, complex(x, y), solid.reach + MOVES))

    def _cut(self, body: int) -> _Cut:
        solid = self._solids[body]
        pose = self._level_poses[body]()
        if pose is not None:
            cut = _cut_at(solid, complex(pose.x, pose.y), rect(1.0, pose.heading))
        else:
            cut = self._cut_in_engine(body, solid)
        self._cuts[body] = cut
        return cut

    def _cut_in_engine(self, body: int, solid: Solid) -> _Cut:
        (x, y, z), (qx, qy, qz, qw) = self._client.getBasePositionAndOrientation(body)
        upright = 1.0 - 2.0 * (qx * qx + qy * qy)
        above = self._height - z
        if upright < UPRIGHT:
            return _Cut(is_known=False)
        if not solid.bottom <= above <= solid.top:
            return _Cut()
        middle = complex(x, y) + 2.0 * above * complex(qx * qz + qw * qy, qy * qz - qw * qx)
        return _cut_at(solid, middle, complex(1.0 - 2.0 * (qy * qy + qz * qz), 2.0 * (qx * qy + qw * qz)))


def _leave_to_engine() -> None:
    """Return that only the engine knows where a body is."""


def _cut_at(solid: Solid, middle: complex, ahead: complex) -> _Cut:
    """Return the outline of a body at a place, whose x axis has a direction of length 1."""
    if solid.radius:
        return _Cut(cylinder=Cylinder(middle, solid.radius))
    return _Cut(box_sides(middle, ahead, solid.corners))


def _block_sides(block: Block) -> Sequence[BoxSide]:
    corners = box_corners(block.length / 2, block.length / 2, block.width / 2)
    return box_sides(complex(block.x, block.y), rect(1.0, block.heading), corners)
