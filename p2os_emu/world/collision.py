"""Bodies of the physics engine: the floor, fixed blocks and robots; and their collision groups."""

from collections.abc import Iterable, Sequence
from enum import IntFlag
from math import atan2

from geometry import Pose2D
from p2os_emu.world.chassis import (
    CASTER_GAP,
    CASTER_RADIUS,
    CASTER_REACH,
    FLOOR_FRICTION,
    HULL_BOTTOM,
    HULL_FRICTION,
    HULL_TOP,
    MASS_HEIGHT,
    OBJECT_FLOOR_FRICTION,
    WALL_FRICTION,
    WHEEL_FRICTION,
    Chassis,
)
from p2os_emu.world.engine import PhysicsClient, engine
from p2os_emu.world.links import FIRST, BodyLink, Joint
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.spec import Block

HULL = -1  # link indices of a robot
WHEELS = (0, 1)  # left, right


class Group(IntFlag):
    """Collision groups. Wheels touch the floor only; hulls touch everything but wheels.

    Movable objects have a floor of their own: the robots' is as slippery as their casters want it.
    """

    RAY = 1  # the group the engine gives its rays
    FLOOR = 2
    BLOCK = 4
    HULL = 8
    WHEEL = 16
    OBJECT = 32
    OBJECT_FLOOR = 64
    GLASS = 128


SEEN_BY_LIGHT = int(Group.BLOCK | Group.HULL | Group.OBJECT)
HEARD_BY_SONAR = SEEN_BY_LIGHT | int(Group.GLASS)
_TOUCHES = {
    Group.FLOOR: Group.HULL | Group.WHEEL,  # of a hull only the casters reach down
    Group.BLOCK: Group.RAY | Group.HULL | Group.OBJECT,
    Group.GLASS: Group.RAY | Group.HULL | Group.OBJECT,
    Group.HULL: Group.RAY | Group.FLOOR | Group.BLOCK | Group.GLASS | Group.HULL | Group.OBJECT,
    Group.WHEEL: Group.FLOOR,
    Group.OBJECT: Group.RAY | Group.BLOCK | Group.GLASS | Group.HULL | Group.OBJECT | Group.OBJECT_FLOOR,
    Group.OBJECT_FLOOR: Group.OBJECT,
}


def build_floor(client: PhysicsClient) -> int:
    """An endless floor at z = 0 for robots; returns its body id."""
    return _plane(client, FLOOR_FRICTION, Group.FLOOR)


def build_object_floor(client: PhysicsClient) -> int:
    """An endless floor at z = 0 for movable objects; returns its body id."""
    return _plane(client, OBJECT_FLOOR_FRICTION, Group.OBJECT_FLOOR)


def _plane(client: PhysicsClient, friction: float, group: Group) -> int:
    shape = client.createCollisionShape(engine.GEOM_PLANE)
    body: int = client.createMultiBody(0.0, shape, _drawn_shape(client))
    client.changeDynamics(body, HULL, lateralFriction=friction)
    _join(client, body, HULL, group)
    return body


def build_blocks(client: PhysicsClient, blocks: Iterable[Block]) -> list[int]:
    """Boxes that do not move; returns their body ids."""
    bodies = []
    for block in blocks:
        shape = client.createCollisionShape(
            engine.GEOM_BOX,
            halfExtents=[block.length / 2, block.width / 2, block.height / 2],
        )
        body = client.createMultiBody(
            0.0,
            shape,
            basePosition=[block.x, block.y, block.bottom + block.height / 2],
            baseOrientation=upright(block.heading),
            useMaximalCoordinates=True,  # a plain rigid body: nothing of it is looked at in a step
        )
        client.changeDynamics(body, HULL, lateralFriction=WALL_FRICTION)
        _join(client, body, HULL, Group.GLASS if block.glass else Group.BLOCK)
        bodies.append(body)
    return bodies


def build_person(client: PhysicsClient, radius: float, height: float) -> int:
    """An upright cylinder that goes where it is put and yields to nothing; returns its body id."""
    shape = client.createCollisionShape(engine.GEOM_CYLINDER, radius=radius, height=height)
    return _kinematic(client, shape)


def build_leaf(client: PhysicsClient, width: float, thickness: float, height: float) -> int:
    """A panel that goes where it is put and yields to nothing; returns its body id."""
    half = [width / 2, thickness / 2, height / 2]
    return _kinematic(client, client.createCollisionShape(engine.GEOM_BOX, halfExtents=half))


def _kinematic(client: PhysicsClient, shape: int) -> int:
    body: int = client.createMultiBody(0.0, shape, useMaximalCoordinates=True)
    client.changeDynamics(body, HULL, lateralFriction=WALL_FRICTION)
    _join(client, body, HULL, Group.BLOCK)
    return body


def put(client: PhysicsClient, body: int, pose: Pose2D, height: float) -> None:
    """Put something that stands upright on the floor and is `height` m high where its middle is at a pose."""
    client.resetBasePositionAndOrientation(body, [pose.x, pose.y, height / 2], upright(pose.heading))


def build_object(client: PhysicsClient, movable: Movable) -> int:
    """Something that can be pushed and gripped; returns its body id. Its base frame lies in its middle."""
    if movable.shape is Shape.CYLINDER:
        shape = client.createCollisionShape(engine.GEOM_CYLINDER, radius=movable.length / 2, height=movable.height)
    else:
        half = [movable.length / 2, movable.width / 2, movable.height / 2]
        shape = client.createCollisionShape(engine.GEOM_BOX, halfExtents=half)
    pose = movable.pose
    body: int = client.createMultiBody(
        movable.mass,
        shape,
        basePosition=[pose.x, pose.y, movable.height / 2],
        baseOrientation=upright(pose.heading),
        flags=engine.URDF_ENABLE_SLEEPING,  # what rests costs nothing until something touches it
    )
    client.changeDynamics(body, HULL, lateralFriction=movable.friction)
    _join(client, body, HULL, Group.OBJECT)
    return body


def build_robot(client: PhysicsClient, chassis: Chassis, pose: Pose2D, links: Sequence[BodyLink] = ()) -> int:
    """A hull on casters with two driven wheels, and the links of its accessories; returns its body id.

    Its base frame lies in the centre of mass, right above or below the middle of the axle. Wheels collide as spheres,
    whose one point of contact stays under the axle (cylinders shift it by 19 mm). Links count from `links.FIRST`, and
    a parent among them as it stands in `links`.
    """
    wheel = client.createCollisionShape(engine.GEOM_SPHERE, radius=chassis.wheel_radius)
    sides = (chassis.wheel_track / 2, -chassis.wheel_track / 2)
    axles = [_from_mass(0.0, side, chassis.wheel_radius) for side in sides]
    everything = len(sides) + len(links)
    drawn = _drawn_shape(client)
    body: int = client.createMultiBody(
        chassis.hull_mass,
        _hull_shape(client, chassis),
        drawn,
        basePosition=mass_position(pose),
        baseOrientation=upright(pose.heading),
        linkMasses=[*[chassis.wheel_mass] * 2, *(link.mass for link in links)],
        linkCollisionShapeIndices=[wheel, wheel, *(_link_shape(client, link) for link in links)],
        linkVisualShapeIndices=[drawn] * everything,
        linkPositions=[*axles, *(_from_mass(*link.place) if link.parent is None else link.place for link in links)],
        linkOrientations=[[0.0, 0.0, 0.0, 1.0]] * everything,
        linkInertialFramePositions=[*[(0.0, 0.0, 0.0)] * 2, *(link.centre for link in links)],
        linkInertialFrameOrientations=[[0.0, 0.0, 0.0, 1.0]] * everything,
        # The engine counts parents from 1; 0 is the hull.
        linkParentIndices=[0, 0, *(0 if link.parent is None else FIRST + link.parent + 1 for link in links)],
        linkJointTypes=[*[engine.JOINT_REVOLUTE] * 2, *(link.joint.value for link in links)],
        linkJointAxis=[*[(0.0, 1.0, 0.0)] * 2, *(link.axis for link in links)],
    )
    parts = [(HULL, chassis.hull_inertia, HULL_FRICTION, Group.HULL)]
    parts += [(link, chassis.wheel_inertia, WHEEL_FRICTION, Group.WHEEL) for link in WHEELS]
    for link, inertia, friction, group in parts:
        client.changeDynamics(body, link, localInertiaDiagonal=inertia)
        # In a call of its own: beside others it would land on the base.
        client.changeDynamics(body, link, lateralFriction=friction)
        _join(client, body, link, group)
    for index, part in enumerate(links, FIRST):
        _finish_link(client, body, index, part)
    # Damping would brake spinning wheels: motors of a robot at 1 m/s would work at 80 % of their strength.
    client.changeDynamics(body, HULL, linearDamping=0.0, angularDamping=0.0)
    # Casters in the air are none of the solver's business.
    client.changeDynamics(body, HULL, contactProcessingThreshold=0.0)
    return body


def _link_shape(client: PhysicsClient, link: BodyLink) -> int:
    """The box of a link; -1 where there is nothing to touch."""
    if not link.collides:
        return -1
    shape: int = client.createCollisionShape(
        engine.GEOM_BOX,
        halfExtents=[edge / 2 for edge in link.size],
        collisionFramePosition=link.centre,
    )
    return shape


def _finish_link(client: PhysicsClient, body: int, index: int, link: BodyLink) -> None:
    """Give a link what its creation could not: inertia of an even box and a rotor, friction, ends, and no motor."""
    x, y, z = (edge**2 for edge in link.size)
    box = (link.mass / 12 * edges for edges in (y + z, x + z, x + y))
    inertia = [part + link.rotor * abs(share) for part, share in zip(box, link.axis, strict=True)]
    client.changeDynamics(body, index, localInertiaDiagonal=inertia)
    client.changeDynamics(body, index, lateralFriction=link.friction)
    if link.lower < link.upper:
        client.changeDynamics(body, index, jointLowerLimit=link.lower, jointUpperLimit=link.upper)
    if link.joint is not Joint.FIXED:
        client.setJointMotorControl2(body, index, engine.VELOCITY_CONTROL, force=0.0)
    if link.collides:
        _join(client, body, index, Group.HULL)


def lift_wheels(client: PhysicsClient, body: int, off_the_floor: bool) -> None:
    """Let a robot's wheels turn in the air, or put them on the floor again."""
    touched = Group(0) if off_the_floor else _TOUCHES[Group.WHEEL]
    for link in WHEELS:
        client.setCollisionFilterGroupMask(body, link, int(Group.WHEEL), int(touched))


def mass_position(pose: Pose2D) -> tuple[float, float, float]:
    """Where the centre of mass of a robot is when the middle of its axle is at a pose, m in the world."""
    return pose.x, pose.y, MASS_HEIGHT


def _from_mass(x: float, y: float, z: float) -> tuple[float, float, float]:
    """Take a place given from the floor under the axle to the base frame, m."""
    return x, y, z - MASS_HEIGHT


def upright(heading: float) -> tuple[float, float, float, float]:
    """The engine's orientation of something that stands upright and looks along a heading."""
    quaternion: tuple[float, float, float, float] = engine.getQuaternionFromEuler([0.0, 0.0, heading])
    return quaternion


def heading_of(quaternion: Sequence[float]) -> float:
    """Which way something looks that has an orientation of the engine's, rad."""
    x, y, z, w = quaternion
    return atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def _hull_shape(client: PhysicsClient, chassis: Chassis) -> int:
    """A box, what a tall robot carries on it, and the two casters under it, as one shape."""
    spans = [(HULL_BOTTOM, HULL_TOP), *([(HULL_TOP, chassis.height)] if chassis.height > HULL_TOP else [])]
    length, middle = chassis.front + chassis.rear, (chassis.front - chassis.rear) / 2
    halves = [[length / 2, chassis.width / 2, (top - bottom) / 2] for bottom, top in spans]
    middles = [(middle, 0.0, (top + bottom) / 2) for bottom, top in spans]
    ends = (chassis.front, -chassis.rear)
    casters = [(CASTER_REACH * end, 0.0, CASTER_RADIUS + CASTER_GAP) for end in ends]
    shape: int = client.createCollisionShapeArray(
        shapeTypes=[*[engine.GEOM_BOX] * len(spans), engine.GEOM_SPHERE, engine.GEOM_SPHERE],
        halfExtents=[*halves, *halves[:1] * 2],
        radii=[CASTER_RADIUS] * (len(spans) + 2),
        collisionFramePositions=[_from_mass(*place) for place in (*middles, *casters)],
    )
    return shape


def _drawn_shape(client: PhysicsClient) -> int:
    """Return the shape that the engine draws of a body; -1 stands for all that collides.

    Only a window draws them. For planes and spheres the engine makes meshes, which takes longer than the rest of a
    small world.
    """
    if client.getConnectionInfo()["connectionMethod"] == engine.GUI:
        return -1
    shape: int = client.createVisualShape(engine.GEOM_BOX, halfExtents=[0.01] * 3)
    return shape


def _join(client: PhysicsClient, body: int, link: int, group: Group) -> None:
    client.setCollisionFilterGroupMask(body, link, int(group), int(_TOUCHES[group]))
