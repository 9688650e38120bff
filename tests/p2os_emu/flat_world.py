"""A world without physics, for tests: an endless floor on which wheels reach the commanded speed at once.

It has the face of `p2os_emu.world.World` as far as the emulator needs it, and starts in no time.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from math import inf

from geometry import Pose2D, Twist2D, integrate
from p2os import RobotModel
from p2os_emu.body import ArmMechanism, BodyState, Echoes, GripperMechanism, ScanBeams
from p2os_emu.emulator import STEP
from p2os_emu.fit import BARE, Fit
from p2os_emu.surroundings import Touches, Truth


class FlatBody:
    """A machine whose wheels turn as commanded, whose bumpers touch nothing and whose sonar hears nothing.

    pose: in the world. left, right: wheel rims, m/s.
    """

    gripper: GripperMechanism | None = None
    arm: ArmMechanism | None = None
    is_docked = False

    def __init__(self, track: float, pose: Pose2D) -> None:
        self.pose = pose
        self.left = self.right = 0.0
        self._track = track
        self._state = BodyState()

    @property
    def state(self) -> BodyState:
        """The machine after the last step."""
        return self._state

    @property
    def twist(self) -> Twist2D:
        """How it moves now."""
        return Twist2D((self.left + self.right) / 2, (self.right - self.left) / self._track)

    def drive(self, left: float, right: float) -> None:
        """Turn the wheel rims at these speeds, m/s, from now on."""
        self.left, self.right = left, right

    def release(self) -> None:
        """Stand."""
        self.left = self.right = 0.0

    def ping(self, discs: Sequence[int]) -> Sequence[float]:
        """Hear nothing."""
        return [inf] * len(discs)

    def scan(self, beams: ScanBeams) -> Echoes:
        """See nothing."""
        return Echoes.nothing(beams.count)

    def advance(self) -> None:
        """Let `STEP` seconds pass."""
        self.pose = integrate(self.pose, self.twist, STEP)
        self._state = BodyState(
            left_travel=self._state.left_travel + self.left * STEP,
            right_travel=self._state.right_travel + self.right * STEP,
            left_velocity=self.left,
            right_velocity=self.right,
            heading=self.pose.heading,
            turn_rate=self.twist.angular,
        )


class FlatWorld:
    """An endless floor. Robots start side by side, 2 m apart, and pass through each other.

    bodies, moves, sounds: by robot name.
    """

    def __init__(self) -> None:
        self.bodies: dict[str, FlatBody] = {}
        self.moves: Counter[str] = Counter()
        self.sounds: Counter[str] = Counter()
        self._steps = 0

    @property
    def time(self) -> float:
        """Emulated time since the start, s."""
        return self._steps * STEP

    def step(self) -> None:
        """Let `STEP` seconds pass."""
        self._steps += 1
        for body in self.bodies.values():
            body.advance()

    def add_robot(self, name: str, model: RobotModel, pose: Pose2D | None = None, fit: Fit = BARE) -> FlatBody:
        """Put a robot down."""
        body = FlatBody(model.wheel_track, pose or Pose2D(0.0, 2.0 * len(self.bodies), 0.0))
        self.bodies[name] = body
        return body

    def remove_robot(self, name: str) -> None:
        """Take a robot away."""
        del self.bodies[name]

    def truth(self, name: str) -> Truth:
        """Where a robot is and how it moves."""
        body = self.bodies[name]
        return Truth(body.pose, body.twist.linear, body.twist.angular)

    def object_places(self) -> Mapping[str, tuple[float, float, float, float]]:
        """There are none."""
        return {}

    def held(self, name: str) -> str | None:
        """Return None: there are no objects."""
        return None

    def touches(self, name: str) -> Touches:
        """There is nothing to bump into."""
        return Touches()

    def sound(self, name: str) -> None:
        """Note it."""
        self.sounds[name] += 1

    def people(self) -> Mapping[str, tuple[float, float, float, bool]]:
        """There are none."""
        return {}

    def doors(self) -> Mapping[str, tuple[float, float]]:
        """There are none."""
        return {}

    def set_door(self, name: str, is_open: bool) -> None:
        """There is none."""
        raise ValueError(f"there is no door {name!r} on an endless floor; take another world")

    def place(self, name: str, pose: Pose2D) -> None:
        """Put a robot elsewhere."""
        self.place_all({name: pose})

    def place_all(self, poses: Mapping[str, Pose2D]) -> None:
        """Put robots elsewhere."""
        for name, pose in poses.items():
            self.bodies[name].pose = pose
            self.moves[name] += 1

    def placed(self, name: str) -> int:
        """How often that was done."""
        return self.moves[name]
