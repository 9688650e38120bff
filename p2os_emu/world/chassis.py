"""Chassis of a robot: masses, torques and friction for the physics, derived from its model.

The dimensions that matter to driving and sensing come from the model. What no model states (how high the hull is, how
heavy a wheel, how strong a motor) is assumed here, once, in proportion to what is stated.
"""

from dataclasses import dataclass
from random import Random

from geometry import Polygon, Pose2D
from p2os.robot_model import RobotModel
from p2os_emu.world.spec import rectangle

GRAVITY = 9.81  # m/s2

HULL_BOTTOM = 0.05  # m above the floor; what rolls stays below, what bumps lies above
HULL_TOP = 0.30
CASTER_RADIUS = 0.02
CASTER_REACH = 0.8  # of the way from the axle to the ends of the hull

# The wheels carry the robot: its mass hangs on the axle, a little below its middle, and casters touch only when it
# leans. (Where casters bear, the solver shares the load as it likes, wheels slip in turns, and a robot at rest creeps.)
MASS_HEIGHT = 0.03  # m above the floor
CASTER_GAP = 0.0005  # m under a level robot

WHEEL_MASS = 0.02  # of the robot's, each
# Of a wheel with the motor behind its gear, in units of robot mass x wheel radius squared: a rotor behind a gear of 38
# is worth as much. With light wheels the solver converges slowly and a robot at rest creeps 0.5 mm/s.
WHEEL_INERTIA = 0.2

# Friction multiplies in Bullet. Casters belong to the hull, and the hull rubs along walls, so a slippery floor under
# wheels of strong grip is what lets casters glide (0.003) while wheels hold (1) and walls brake (0.3).
FLOOR_FRICTION = 0.01
WHEEL_FRICTION = 100.0
HULL_FRICTION = 0.3
WALL_FRICTION = 1.0
OBJECT_FLOOR_FRICTION = 1.0  # so that a movable object's own friction is what its file says

# What both motors together can give, as an acceleration of robot and wheels: it follows every profile that the firmware
# allows (2 m/s2), and at a wall the motors stall long before the wheels slip.
PEAK_ACCELERATION = 2.1
# Likewise, how gears and brushes brake a wheel that has no power.
COASTING_DECELERATION = 0.8

WHEEL_ERROR = 0.005  # both wheels, of the nominal diameter
WHEEL_MISMATCH = 0.001  # each wheel, beyond what both share
TRACK_ERROR = 0.01


@dataclass(frozen=True, slots=True)
class Imperfections:
    """How one robot differs from its model: true track / nominal, and nominal wheel diameter / true, left and right."""

    track: float = 1.0
    left_wheel: float = 1.0
    right_wheel: float = 1.0

    @classmethod
    def drawn(cls, random: Random) -> "Imperfections":
        """Draw a robot as factories make them."""
        both = random.uniform(-WHEEL_ERROR, WHEEL_ERROR)
        return cls(
            track=1.0 + random.uniform(-TRACK_ERROR, TRACK_ERROR),
            left_wheel=1.0 + both + random.uniform(-WHEEL_MISMATCH, WHEEL_MISMATCH),
            right_wheel=1.0 + both + random.uniform(-WHEEL_MISMATCH, WHEEL_MISMATCH),
        )


@dataclass(frozen=True, slots=True)
class Chassis:
    """One robot's machine: lengths in m, masses in kg, torques of one motor in N m; x = 0 is the axle.

    overhang: how far accessories stick out ahead of the hull.
    height: of the highest part above the floor; what is above the hull has the outline of the hull.
    """

    front: float
    rear: float
    width: float
    wheel_radius: float
    wheel_track: float
    mass: float
    imperfections: Imperfections
    overhang: float = 0.0
    height: float = HULL_TOP

    @classmethod
    def of(
        cls, model: RobotModel, imperfections: Imperfections, overhang: float = 0.0, height: float = HULL_TOP
    ) -> "Chassis":
        """Derive a chassis from a model, from how far its accessories stick out ahead, and from its height, m."""
        return cls(
            front=model.length_front,
            rear=model.length_rear,
            width=model.width,
            wheel_radius=model.wheel_diameter / 2,
            wheel_track=model.wheel_track * imperfections.track,
            mass=model.mass,
            imperfections=imperfections,
            overhang=overhang,
            height=max(HULL_TOP, height),
        )

    @property
    def wheel_mass(self) -> float:
        """Of one wheel."""
        return self.mass * WHEEL_MASS

    @property
    def hull_mass(self) -> float:
        """Of everything but the wheels."""
        return self.mass - 2 * self.wheel_mass

    @property
    def hull_inertia(self) -> tuple[float, float, float]:
        """Of the hull about its centre of mass, as of an even box, kg m2."""
        length, height = self.front + self.rear, HULL_TOP - HULL_BOTTOM
        part = self.hull_mass / 12
        return (
            part * (self.width**2 + height**2),
            part * (length**2 + height**2),
            part * (length**2 + self.width**2),
        )

    @property
    def wheel_inertia(self) -> tuple[float, float, float]:
        """Of one wheel about its middle, kg m2; y is its axis."""
        about_axis = WHEEL_INERTIA * self.mass * self.wheel_radius**2
        across = 0.25 * self.wheel_mass * self.wheel_radius**2  # a disc: the motor turns about the axis only
        return across, about_axis, across

    @property
    def motor_torque(self) -> float:
        """The most one motor gives."""
        return self._torque(PEAK_ACCELERATION)

    @property
    def coasting_torque(self) -> float:
        """Torque that turns a motor without power."""
        return self._torque(COASTING_DECELERATION)

    def _torque(self, acceleration: float) -> float:
        """Of one motor, so that both together accelerate the robot and its wheels this much."""
        return self.mass * (1 + 2 * WHEEL_INERTIA) * acceleration * self.wheel_radius / 2

    @property
    def sweep(self) -> float:
        """Radius of the circle that the robot needs to turn in place, m."""
        return float(abs(complex(max(self.front + self.overhang, self.rear), self.width / 2)))

    def footprint(self, pose: Pose2D) -> Polygon:
        """Return the footprint of a robot at a pose, with its accessories, m."""
        return rectangle(pose, self.front + self.overhang, self.rear, self.width)

    def hull(self, pose: Pose2D) -> Polygon:
        """Corners of the hull when the robot is at a pose, m."""
        return rectangle(pose, self.front, self.rear, self.width)
