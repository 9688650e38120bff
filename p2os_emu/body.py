"""Interface between the microcontroller and the world: motors, encoders, bumpers, sonar discs, gripper and arm.

The microcontroller reads a `BodyState` and calls the methods of a `Body`. It knows nothing of PyBullet, and the world
knows nothing of packets; tests of the firmware use a body of a few lines.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from p2os.sip import OPEN_INPUTS


class BodyState(NamedTuple):
    """One robot's machine at the end of a physics step.

    left_travel, right_travel: m rolled since the start by the wheel rims, as the encoders see it (wheel and track
        errors of this one robot included), not wrapped, not yet counted in ticks.
    left_velocity, right_velocity: m/s, likewise.
    left_load, right_load: motor effort as a fraction of the most the motor can give, 0 to 1.
    front_bumpers, rear_bumpers: bit i is set while segment i + 1 is pressed; segments count from right to left in front
        and behind, seen from above with the robot facing up the page.
    heading: true heading in the world, rad, as a compass needle has it; not wrapped.
    magnetic: what stands nearby adds to the earth's field, T along the world's x and y.
    turn_rate: true turning speed of the hull, rad/s counter-clockwise, as a gyro feels it.
    infrared: bit i is clear while infrared sensor i sees something (they are active low).
    far_ledge, near_ledge: a ledge sensor looks over an edge of the floor.
    """

    left_travel: float = 0.0
    right_travel: float = 0.0
    left_velocity: float = 0.0
    right_velocity: float = 0.0
    left_load: float = 0.0
    right_load: float = 0.0
    front_bumpers: int = 0
    rear_bumpers: int = 0
    heading: float = 0.0
    magnetic: tuple[float, float] = (0.0, 0.0)
    turn_rate: float = 0.0
    infrared: int = OPEN_INPUTS
    far_ledge: bool = False
    near_ledge: bool = False


class GripperMechanismState(NamedTuple):
    """A gripper's machine at the end of a physics step.

    opening: of the paddles, 0 closed to 1 open. lift: 0 down to 1 up. opening_speed, lift_speed: 1/s.
    outer_beam, inner_beam: something stands in the break-beam between the paddles.
    left_contact, right_contact: something presses on the paddle's contact switch.
    holds: the paddles press on something from both sides and cannot close further.
    """

    opening: float = 1.0
    lift: float = 0.0
    opening_speed: float = 0.0
    lift_speed: float = 0.0
    outer_beam: bool = False
    inner_beam: bool = False
    left_contact: bool = False
    right_contact: bool = False
    holds: bool = False


class GripperMechanism(Protocol):
    """Paddles on a lift, as the microcontroller can reach them."""

    @property
    def state(self) -> GripperMechanismState:
        """The gripper after the last physics step."""

    def drive(self, paddles: float, lift: float) -> None:
        """Command the motors, at their own speed: -1 closes or lowers, 0 holds where it is, 1 opens or lifts."""


class ArmMechanism(Protocol):
    """Joints one behind the other, each a servo of its own; the last may be a gripper's."""

    @property
    def positions(self) -> Sequence[float]:
        """Of each joint after the last physics step, rad (m for a joint that slides)."""

    @property
    def velocities(self) -> Sequence[float]:
        """Of each joint, rad/s (m/s)."""

    @property
    def holds(self) -> bool:
        """Whether an object is held between the fingers."""

    def move(self, joint: int, position: float, speed: float) -> None:
        """Let a joint, counted from 0, go to a position, rad (m), no faster than `speed`, rad/s (m/s)."""

    def release(self, joint: int) -> None:
        """Take the power off a joint: it sinks as its friction lets it."""


@dataclass(frozen=True, slots=True)
class ScanBeams:
    """Beams of a planar scanner: m and rad in `base_link`, height in m above the floor.

    first: bearing of the first beam. step: to the next one, negative where they go clockwise. reach: how far to look.
    noise: standard deviation of a distance, m.
    """

    x: float
    y: float
    height: float
    first: float
    step: float
    count: int
    reach: float
    noise: float = 0.0


class Echoes(NamedTuple):
    """What beams meet, in their order, shape (n,).

    ranges: m; `inf` where nothing stands within reach. cosines: of the angle between beam and surface normal, 0 where
    nothing stands. reflects: the surface is a reflector.
    """

    ranges: NDArray[np.float64]
    cosines: NDArray[np.float64]
    reflects: NDArray[np.bool_]

    def reversed(self) -> "Echoes":
        """Of the same beams, counted from the other end."""
        return Echoes(self.ranges[::-1], self.cosines[::-1], self.reflects[::-1])

    @classmethod
    def nothing(cls, count: int) -> "Echoes":
        """Of so many beams into the open."""
        return cls(np.full(count, np.inf), np.zeros(count), np.zeros(count, np.bool_))


class Body(Protocol):
    """A robot's machine, as its microcontroller can reach it."""

    @property
    def state(self) -> BodyState:
        """The machine after the last physics step."""

    @property
    def gripper(self) -> GripperMechanism | None:
        """The gripper, where one is fitted."""

    @property
    def arm(self) -> ArmMechanism | None:
        """The arm, where one is fitted."""

    def drive(self, left: float, right: float) -> None:
        """Command the wheel rims, m/s; the motors follow as far as their torque allows."""

    def release(self) -> None:
        """Take the power off both motors; the wheels turn as gears and friction let them."""

    @property
    def is_docked(self) -> bool:
        """Whether the robot stands at a dock, whose power lowered contacts find."""

    def ping(self, discs: Sequence[int]) -> Sequence[float]:
        """Fire sonar discs.

        Args:
            discs: Sonar numbers as the robot model counts them (0-based).
        Returns:
            One range per disc, m from the disc's face; `inf` where no echo came back.
        """

    def scan(self, beams: ScanBeams) -> Echoes:
        """Look along the beams of a planar scanner; its noise comes on top, unless the world is perfect."""
