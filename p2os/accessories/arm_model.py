"""Model of an arm: joints, links and strength, from a file of `configs/accessories`.

At zero every axis is the robot's: x forward, y left, z up. A joint carries a part, and the next joint sits on that.
"""

from dataclasses import dataclass
from math import radians

Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class JointModel:
    """One turning joint and the part that it carries.

    axis: it turns about, by the right hand. offset_m: from the joint before, or from the arm's base.
    size_m, centre_m: the part as an even box, its middle seen from the joint. mass_kg: of the part with its motor.
    lower_deg, upper_deg, home_deg: ends, and where it rests. speed_deg_s: the most.
    torque_nm: the most its motor gives. friction_nm: what turning it without power takes. rotor_kg_m2: inertia of the
    motor, as felt behind its gear.
    """

    axis: Triple
    offset_m: Triple
    size_m: Triple
    centre_m: Triple
    mass_kg: float
    lower_deg: float
    upper_deg: float
    speed_deg_s: float
    torque_nm: float
    friction_nm: float
    rotor_kg_m2: float
    home_deg: float = 0.0

    @property
    def lower(self) -> float:
        """The lower end, rad."""
        return radians(self.lower_deg)

    @property
    def upper(self) -> float:
        """The upper end, rad."""
        return radians(self.upper_deg)

    @property
    def home(self) -> float:
        """Where it rests, rad."""
        return radians(self.home_deg)

    @property
    def speed(self) -> float:
        """The most, rad/s."""
        return radians(self.speed_deg_s)


@dataclass(frozen=True, slots=True)
class ArmGripperModel:
    """Two fingers that part evenly; as a joint it counts behind all others, in m between the fingers.

    axis: along which the fingers part. offset_m: of their roots, from the last joint. finger_m: size of one.
    centre_m: of a finger of no thickness, from the root.
    opening_m: the most; home_m: where it rests. speed_m_s: of the opening. force_n: of the grip. mass_kg: of
    one finger. friction: of its inside.
    """

    axis: Triple
    offset_m: Triple
    finger_m: Triple
    centre_m: Triple
    mass_kg: float
    opening_m: float
    speed_m_s: float
    force_n: float
    friction: float
    home_m: float = 0.0


@dataclass(frozen=True, slots=True)
class ServoModel:
    """How a controller counts one servo.

    centre: count at zero. ticks_per_90: counts in a quarter turn. reversed: the count falls while the angle rises.
    speed_ms: for each count, until a client sets another.
    """

    centre: int
    ticks_per_90: int
    speed_ms: int
    reversed: bool = False

    def tick(self, angle: float) -> int:
        """The count at an angle, rad."""
        ticks = angle / (radians(90.0) / self.ticks_per_90)
        return self.centre + round(-ticks if self.reversed else ticks)

    def angle(self, tick: float) -> float:
        """The angle at a count, rad."""
        ticks = self.centre - tick if self.reversed else tick - self.centre
        return ticks * radians(90.0) / self.ticks_per_90


@dataclass(frozen=True, slots=True)
class GripperServo:
    """How a controller counts the servo of the fingers: in proportion between two ends; speed_ms as `ServoModel`."""

    closed: int
    open: int
    ticks_per_90: int
    speed_ms: int

    def tick(self, opening: float, most: float) -> int:
        """The count at an opening, m, of fingers that open `most`."""
        return self.closed + round(opening / most * (self.open - self.closed))

    def opening(self, tick: float, most: float) -> float:
        """The opening at a count, m."""
        return (tick - self.closed) / (self.open - self.closed) * most


@dataclass(frozen=True, slots=True)
class CubeModel:
    """Common properties of the modules of an arm.

    baud: bit/s of their line. watchdog_s: without a telegram after which a moving module halts.
    acceleration_s: in which a module reaches its full speed, at best. lag_deg, lag_m: behind its way, at which a joint
    or the gripper gives up. most_current_a: as the modules report it.
    """

    baud: int
    watchdog_s: float
    acceleration_s: float
    lag_deg: float
    lag_m: float
    most_current_a: float


@dataclass(frozen=True, slots=True)
class ArmModel:
    """An arm of turning joints with a gripper at its end.

    base_m: from the floor under the middle of the axle. cubes: of an arm of modules.
    servos, finger_servo: as a Pioneer's controller counts joints and gripper. manual_order: it sends the bytes of
    ARMpac in the manual's order, not in the one that the most used client library reads.
    """

    name: str
    base_m: Triple
    joints: tuple[JointModel, ...]
    gripper: ArmGripperModel
    servos: tuple[ServoModel, ...] = ()
    finger_servo: GripperServo | None = None
    manual_order: bool = False
    cubes: CubeModel | None = None

    @property
    def home(self) -> tuple[float, ...]:
        """Where everything rests: rad, and m for the gripper at the end."""
        return (*(joint.home for joint in self.joints), self.gripper.home_m)
