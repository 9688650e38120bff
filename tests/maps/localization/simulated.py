"""A robot with laser and odometry in a plan of lines, without the emulator: cheap and exact."""

from collections.abc import Callable, Iterable
from functools import cache
from math import pi

import numpy as np
from numpy.typing import NDArray

from geometry import Pose2D, Segment, Twist2D, integrate
from maps.building_map import BuildingMap
from maps.localization.localizer import LocalizationState, Localizer
from maps.localization.settings import LocalizationSettings

PERIOD = 0.1  # s
ANGLES = np.linspace(-pi / 2, pi / 2, 91)
LONGEST = 12.0  # m


def box(x1: float, y1: float, x2: float, y2: float) -> list[Segment]:
    """The four sides of a box between two corners, m."""
    return [Segment(x1, y1, x2, y1), Segment(x2, y1, x2, y2), Segment(x2, y2, x1, y2), Segment(x1, y2, x1, y1)]


FLOOR = BuildingMap(
    (
        *box(0, 0, 12, 8),
        Segment(5, 0, 5, 3),
        Segment(5, 4.2, 5, 8),
        Segment(5, 5, 8, 5),
        Segment(9.2, 5, 12, 5),
        *box(1, 5.5, 2, 6.4),
        *box(10.5, 0.5, 11.3, 2.5),
        *box(7, 7, 7.6, 7.6),
    )
)
"""Three rooms with furniture; no two places look the same."""
OTHER = BuildingMap((*box(0, 0, 7, 11), Segment(0, 4, 2.6, 4), Segment(3.8, 4, 7, 4), *box(3, 7, 5, 8)))
"""Another building."""


@cache
def settings() -> LocalizationSettings:
    """Those of the file, with fewer particles at the beginning."""
    return LocalizationSettings.load()


def scan(plan: BuildingMap, pose: Pose2D, rng: np.random.Generator) -> NDArray[np.float64]:
    """Ends of the ranges of a scan in `base_link`, with noise of 1 cm."""
    lines = np.array(plan.lines)
    start, way = lines[:, :2], lines[:, 2:] - lines[:, :2]
    headings = pose.heading + ANGLES
    rays = np.stack((np.cos(headings), np.sin(headings)), axis=1)[:, np.newaxis]
    to = start - (pose.x, pose.y)
    cross = rays[..., 0] * way[:, 1] - rays[..., 1] * way[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):  # rays along a wall, which do not meet it
        ranges = (to[:, 0] * way[:, 1] - to[:, 1] * way[:, 0]) / cross
        along = (to[:, 0] * rays[..., 1] - to[:, 1] * rays[..., 0]) / cross
    is_hit = (ranges > 0.0) & (along >= 0.0) & (along <= 1.0)
    nearest = np.where(is_hit, ranges, np.inf).min(axis=1)
    nearest += rng.normal(0.0, 0.01, len(nearest))
    is_used = nearest < LONGEST
    ends: NDArray[np.float64] = np.stack((nearest * np.cos(ANGLES), nearest * np.sin(ANGLES)), axis=1)[is_used]
    return ends


class SimulatedDrive:
    """A robot that drives through a plan with odometry that measures distances and turns wrongly.

    pose: where it is. time: s. late: s by which scans are older than their stamps say, as on a machine that was busy.
    """

    def __init__(self, localizer: Localizer, plan: BuildingMap, pose: Pose2D, seed: int = 0) -> None:
        self.localizer, self.plan, self.pose = localizer, plan, pose
        self.time = self.late = 0.0
        self.distance_error, self.turn_error = 1.0, 1.0
        self.disturb: Callable[[NDArray[np.float64]], NDArray[np.float64]] = lambda ends: ends
        self.states: list[LocalizationState] = []
        self.errors: list[float] = []
        self._odometry = Pose2D(0.0, 0.0, 0.3)
        self._poses = [pose]
        self._rng = np.random.default_rng(seed)
        localizer.add_odometry(0.0, self._odometry)

    def drive(self, twists: Iterable[tuple[float, float, float]], *, sees: bool = True) -> None:
        """Drive with velocities in m/s and rad/s, each for some s."""
        for linear, angular, seconds in twists:
            for _ in range(round(seconds / PERIOD)):
                self.time += PERIOD
                self.pose = integrate(self.pose, Twist2D(linear, angular), PERIOD)
                self._poses.append(self.pose)
                measured = Twist2D(linear * self.distance_error, angular * self.turn_error)
                self._odometry = integrate(self._odometry, measured, PERIOD)
                self.localizer.add_odometry(self.time, self._odometry)
                if sees:
                    ends = scan(self.plan, self._poses[-1 - round(self.late / PERIOD)], self._rng)
                    self.localizer.add_scan(self.time, self.disturb(ends))
                self.localizer.advance()
                estimate = self.localizer.estimate
                self.states.append(estimate.state)
                if estimate.pose is not None:
                    self.errors.append(np.hypot(estimate.pose.x - self.pose.x, estimate.pose.y - self.pose.y))

    def pause(self, seconds: float) -> None:
        """Let time go by without odometry and readings, while the robot stands."""
        self.time += seconds

    def restart_odometry(self, pose: Pose2D) -> None:
        """Go on with odometry at another pose, as after a restart of the gateway."""
        self._odometry = pose

    def slip(self, distance: float, turn: float) -> None:
        """Let the wheels turn without effect, within half a second: m and rad that odometry measures."""
        for _ in range(5):
            self.time += PERIOD
            self._odometry = self._odometry.compose(Pose2D(distance / 5, 0.0, turn / 5))
            self.localizer.add_odometry(self.time, self._odometry)

    @property
    def was_confidently_wrong(self) -> bool:
        """Whether it ever believed a pose that was more than 0.5 m away; every step has a guess from some step on."""
        guessed = zip(self.states[len(self.states) - len(self.errors) :], self.errors, strict=True)
        return any(state is LocalizationState.LOCALIZED and error > 0.5 for state, error in guessed)


ROUND = [(0.4, 0.0, 4.0), (0.3, 0.5, 3.0), (0.4, 0.0, 4.0), (0.2, 0.8, 2.0)]
"""About 5 m with two turns to the left."""
