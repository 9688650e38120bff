"""What lies between the microcontroller and the world: motors, encoders, bumpers and sonar discs.

The microcontroller reads a `BodyState` and calls the methods of a `Body`. It knows nothing of PyBullet, and the world
knows nothing of packets; tests of the firmware use a body of a few lines.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol


class BodyState(NamedTuple):
    """One robot's machine at the end of a physics step.

    left_travel, right_travel: m rolled since the start by the wheel rims, as the encoders see it (wheel and track
        errors of this one robot included), not wrapped, not yet counted in ticks.
    left_velocity, right_velocity: m/s, likewise.
    left_load, right_load: motor effort as a fraction of the most the motor can give, 0 to 1.
    front_bumpers, rear_bumpers: bit i is set while segment i + 1 is pressed; segments count from right to left in front
        and behind, seen from above with the robot facing up the page.
    """

    left_travel: float = 0.0
    right_travel: float = 0.0
    left_velocity: float = 0.0
    right_velocity: float = 0.0
    left_load: float = 0.0
    right_load: float = 0.0
    front_bumpers: int = 0
    rear_bumpers: int = 0


class Body(Protocol):
    """A robot's machine, as its microcontroller can reach it."""

    @property
    def state(self) -> BodyState:
        """The machine after the last physics step."""
        ...

    def drive(self, left: float, right: float) -> None:
        """Command the wheel rims, m/s; the motors follow as far as their torque allows."""
        ...

    def release(self) -> None:
        """Take the power off both motors; the wheels turn as gears and friction let them."""
        ...

    def ping(self, discs: Sequence[int]) -> Sequence[float]:
        """Fire sonar discs.

        Args:
            discs: Sonar numbers as the robot model counts them (0-based).
        Returns:
            One range per disc, m from the disc's face; `inf` where no echo came back.
        """
        ...
