"""A body with faults, between the microcontroller and the machine of the world."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from random import Random

from p2os_emu.body import ArmMechanism, Body, BodyState, Echoes, GripperMechanism, ScanBeams

WHOLE = (1.0, 1.0)
"""Grip of wheels that do not slip, left and right."""
FREE = (False, False)
"""Wheels that nothing blocks, left and right."""
NO_BUMPERS = (0, 0)


@dataclass(frozen=True, slots=True)
class SonarFaults:
    """Faults of sonar discs, by number.

    dead: hear nothing. stuck: report this range, m, whatever they hear. noisy: chance from 0 to 1 that a firing reports
    an echo that never was, anywhere within `reach`, m.
    """

    dead: frozenset[int] = frozenset()
    stuck: Mapping[int, float] = field(default_factory=dict)
    noisy: Mapping[int, float] = field(default_factory=dict)
    reach: tuple[float, float] = (0.1, 5.0)

    def heard(self, disc: int, distance: float, rng: Random) -> float:
        """Return the range that a disc reports instead of the measured one, m."""
        if disc in self.stuck:
            return self.stuck[disc]
        if disc in self.dead:
            return float("inf")
        if disc in self.noisy and rng.random() < self.noisy[disc]:
            return rng.uniform(*self.reach)
        return distance


HEALTHY_SONAR = SonarFaults()


class FaultyBody:
    """A machine with its faults; implements `Body`. A healthy one passes everything on as it is.

    bumpers: segments held down, front and rear, by the bits of `BodyState`.
    sonar: what is wrong with the discs.
    """

    def __init__(self, body: Body, rng: Random) -> None:
        """Wrap a body; it has no faults yet.

        Args:
            body: The machine; nobody else drives it from now on.
            rng: Decides what noisy discs hear.
        """
        self.bumpers = NO_BUMPERS
        self.sonar = HEALTHY_SONAR
        self._body = body
        self._rng = rng
        self._grip = WHOLE
        self._blocked = FREE
        self._wanted: tuple[float, float] | None = None  # m/s; None while the motors have no power
        self._slipped = [0.0, 0.0]  # m that each rim has spun without moving the machine
        self._is_untrue = False  # the wheels, or their encoders, are not simply those of the machine

    @property
    def grip(self) -> tuple[float, float]:
        """What arrives of each wheel's turning on the floor, 0 to 1, left and right; the rims spin as commanded."""
        return self._grip

    @grip.setter
    def grip(self, grip: tuple[float, float]) -> None:
        self._grip = grip
        self._drive_anew()

    @property
    def blocked(self) -> tuple[bool, bool]:
        """Blocked wheels, left and right; their motors push without turning."""
        return self._blocked

    @blocked.setter
    def blocked(self, blocked: tuple[bool, bool]) -> None:
        self._blocked = blocked
        self._drive_anew()

    @property
    def state(self) -> BodyState:
        """The machine after the last physics step, as encoders and switches tell it."""
        state = self._body.state
        if self._is_untrue:
            state = self._with_wheels(state)
        front, rear = self.bumpers
        if front or rear:
            state = state._replace(front_bumpers=state.front_bumpers | front, rear_bumpers=state.rear_bumpers | rear)
        return state

    @property
    def gripper(self) -> GripperMechanism | None:
        """As `Body.gripper`."""
        return self._body.gripper

    @property
    def arm(self) -> ArmMechanism | None:
        """As `Body.arm`."""
        return self._body.arm

    @property
    def is_docked(self) -> bool:
        """As `Body.is_docked`."""
        return self._body.is_docked

    def drive(self, left: float, right: float) -> None:
        """As `Body.drive`."""
        self._wanted = left, right
        if self._is_untrue:
            left, right = (
                0.0 if blocked else wanted * grip
                for wanted, grip, blocked in zip(self._wanted, self._grip, self._blocked, strict=True)
            )
        self._body.drive(left, right)

    def release(self) -> None:
        """As `Body.release`."""
        self._wanted = None
        self._body.release()

    def ping(self, discs: Sequence[int]) -> Sequence[float]:
        """As `Body.ping`."""
        ranges = self._body.ping(discs)
        if self.sonar is HEALTHY_SONAR:
            return ranges
        return [self.sonar.heard(disc, heard, self._rng) for disc, heard in zip(discs, ranges, strict=True)]

    def scan(self, beams: ScanBeams) -> Echoes:
        """As `Body.scan`."""
        return self._body.scan(beams)

    def advance(self, dt: float) -> None:
        """Let wheels slip for `dt` s; a machine whose wheels grip need not be told."""
        for wheel, spin in enumerate(self._spin()):
            self._slipped[wheel] += spin * dt

    def _spin(self) -> tuple[float, float]:
        """How much faster each rim turns than the floor under it passes, m/s."""
        left, right = (
            0.0 if blocked else wanted * (1.0 - grip)
            for wanted, grip, blocked in zip(self._wanted or (0.0, 0.0), self._grip, self._blocked, strict=True)
        )
        return left, right

    def _with_wheels(self, state: BodyState) -> BodyState:
        left_spin, right_spin = self._spin()
        left_strives, right_strives = (
            blocked and wanted != 0.0 for wanted, blocked in zip(self._wanted or (0.0, 0.0), self._blocked, strict=True)
        )
        return state._replace(
            left_travel=state.left_travel + self._slipped[0],
            right_travel=state.right_travel + self._slipped[1],
            left_velocity=state.left_velocity + left_spin,
            right_velocity=state.right_velocity + right_spin,
            left_load=1.0 if left_strives else state.left_load,
            right_load=1.0 if right_strives else state.right_load,
        )

    def _drive_anew(self) -> None:
        """Repeat the last motor command for the present state of the wheels."""
        # Encoders never forget what a rim has spun: once slipped, they stay apart from the machine.
        self._is_untrue = self._grip != WHOLE or self._blocked != FREE or any(self._slipped)
        if self._wanted is not None:
            self.drive(*self._wanted)
