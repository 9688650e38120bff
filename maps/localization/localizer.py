"""Localization of a robot on a map: odometry and range readings in, pose and transform with their trust out.

Monte-Carlo localization follows the pose. The readings of the last metres are compared with the whole map while the
pose is not known: one is believed only if it explains the readings, and no other one does. A pose that does not explain
them any more is given up. So a robot that was carried away is found again, and a wrong map is noticed.
"""

from dataclasses import dataclass, field
from enum import StrEnum
from math import exp, hypot

import numpy as np
from numpy.typing import NDArray

from geometry.pose import Pose2D, wrap_angle
from maps.building.readings import is_jump
from maps.building_map import BuildingMap
from maps.localization.likelihood_field import LikelihoodField
from maps.localization.memory import ReadingMemory
from maps.localization.motion import OdometryHistory, moved, placed
from maps.localization.odometry_errors import OdometryErrorFilter, SystematicErrors
from maps.localization.particles import Particles
from maps.localization.pose_search import FoundPose, PoseSearch
from maps.localization.settings import LocalizationSettings, SensorTrust

Points = NDArray[np.float64]

_SMOOTHING = 0.5  # m of travel after which an old score counts for 1/e ...
_SMOOTHING_TIME = 1.0  # ... or s while the robot stands
_DRIVING = 0.03  # m/s; a slower robot stands
_SILENCE = 2.0  # s; after a longer silence of odometry its watchdog has stopped the robot, and it stands where it was
_FIRST_LOOK = 1.0  # s for which a lost robot has stood when it looks whether it is where it was; again after twice that
_FOUND_SIGMA, _FOUND_TURN = 0.1, 0.05  # m and rad, of a pose that was found by search
_LATE = 0.12  # s after the latest odometry for which its motion is continued


class LocalizationState(StrEnum):
    """What is known of the pose."""

    SEARCHING = "searching"  # not known: the readings fit several places, or none yet
    CHECKING = "checking"  # a pose was given, and the readings do not confirm it yet
    LOCALIZED = "localized"
    WRONG_MAP = "wrong map"  # no place of the map explains the readings


@dataclass(frozen=True, slots=True)
class LocalizationEstimate:
    """What is known now.

    time: of the odometry, s.
    state: whether the pose is to be believed; `pose` is a guess in any other state than localized.
    pose: in `map`, at the latest odometry; None where there is no guess.
    covariance: of x, y and heading: m2, m rad, rad2, shape (3, 3).
    map_to_odom: pose of `odom` in `map`; None where there is no guess.
    score: share of the latest readings that the map explains, 0 to 1.
    particles: how many there are.
    errors: systematic errors of odometry.
    silence: s since the latest range reading.
    """

    time: float
    state: LocalizationState
    pose: Pose2D | None
    covariance: NDArray[np.float64] = field(repr=False)
    map_to_odom: Pose2D | None
    score: float
    particles: int
    errors: SystematicErrors
    silence: float


class Localizer:
    """Localizes one robot. Times are those of the stamps, s; call `advance` after readings were added."""

    def __init__(self, map_: BuildingMap, settings: LocalizationSettings, seed: int = 0) -> None:
        """Prepare the map, which takes a fraction of a second for a large building.

        Raises:
            ValueError: the map shows no walls.
        """
        self._settings = settings
        self._rng = np.random.default_rng(seed)
        self.likelihoods = LikelihoodField(map_, settings.field.cell)
        self._laser_costs = self.likelihoods.costs(settings.field.laser_sigma, settings.field.clutter)
        self._sonar_costs = self.likelihoods.costs(settings.field.sonar_sigma, settings.field.clutter)
        self._search = PoseSearch(self.likelihoods, settings, self._rng)
        self._history = OdometryHistory()
        self._memory = ReadingMemory(settings.memory)
        self._errors = OdometryErrorFilter(settings.odometry)
        self.state = LocalizationState.SEARCHING
        self._particles: Particles | None = None
        self._covariance = np.zeros((3, 3))
        self._map_to_odom: Pose2D | None = None
        self._score = 0.0
        self._scan: tuple[float, Points] | None = None
        self._sonar: list[tuple[float, Points]] = []
        self._scan_time = self._reading_time = -np.inf
        self._raw: tuple[float, Pose2D] | None = None  # time and pose in odom of the latest reading
        self._corrected = Pose2D()  # the same without systematic errors, from where the localization began
        self._updated: Pose2D | None = None  # likewise, of the latest update of the particles
        self._updated_raw = Pose2D()
        self._poor_travel = 0.0
        self._driven = self._searched_at = 0.0  # s of driving
        self._standing, self._look_after = 0.0, _FIRST_LOOK  # s
        self._believed: Pose2D | None = None  # the pose of `odom` in `map` that the readings fitted last
        self._unexplained = 0.0  # s of driving without a pose that explains the readings

    def start_at(self, pose: Pose2D, sigma: float | None = None, turn: float | None = None) -> None:
        """Begin at a pose in `map`, with standard deviations in m and rad; None for those of the settings."""
        settings = self._settings.particles
        sigma, turn = settings.start_sigma if sigma is None else sigma, settings.start_turn if turn is None else turn
        self._forget()
        self.state = LocalizationState.CHECKING
        self._begin_at(pose, sigma, turn)

    def start_unknown(self) -> None:
        """Begin anywhere in the map."""
        self._forget()
        self.state = LocalizationState.SEARCHING
        self._particles = self._map_to_odom = None

    def add_odometry(self, time: float, pose: Pose2D) -> None:
        """Take a pose in `odom`; where `odom` has a new origin, begin again where the robot was."""
        before = self._history.latest
        if before is None:
            self._reading_time = time
        elif _is_new_origin(pose.relative_to(before[1]), time - before[0]):
            self._history = OdometryHistory()
            self._history.add(time, pose)
            self._begin_after_jump(before[1])
            return
        self._history.add(time, pose)

    def add_scan(self, time: float, ends: Points) -> None:
        """Take a scan: ends of its ranges in `base_link`, m, shape (n, 2), without those that measured nothing."""
        self._scan = time, ends

    def add_sonar(self, time: float, ends: Points) -> None:
        """Take sonar echoes: places on the arc of each cone in `base_link`, m, shape (n, odd number of places, 2)."""
        if time - self._scan_time > self._settings.trust.silence:  # otherwise the laser knows better
            self._sonar.append((time, ends))

    def advance(self) -> bool:
        """Use the readings whose odometry is known; returns whether there were any."""
        latest = self._history.latest
        if latest is None:
            return False
        if self._scan is not None and self._scan[0] <= latest[0] + _LATE:
            (time, ends), self._scan = self._scan, None
            if (raw := self._history.at(time)) is not None:
                self._scan_time = time
                self._sonar.clear()
                self._take(time, raw, ends, is_laser=True)
                return True
        return self._take_sonar()

    @property
    def estimate(self) -> LocalizationEstimate:
        """What is known now."""
        time, odom = self._history.latest or (0.0, Pose2D())
        pose = None if self._map_to_odom is None else self._map_to_odom.compose(odom)
        covariance = self._covariance.copy()
        if self._updated is not None:  # since then by odometry alone
            away = hypot(odom.x - self._updated_raw.x, odom.y - self._updated_raw.y)
            motion = self._settings.motion
            covariance[[0, 1], [0, 1]] += (motion.distance_per_m * away) ** 2
            covariance[2, 2] += (motion.turn_per_m * away) ** 2
        count = 0 if self._particles is None else len(self._particles.poses)
        silence = max(0.0, time - self._reading_time)
        return LocalizationEstimate(
            time, self.state, pose, covariance, self._map_to_odom, self._score, count, self._errors.errors, silence
        )

    @property
    def particles(self) -> NDArray[np.float64]:
        """Poses of the particles, shape (n, 3), for pictures."""
        return np.empty((0, 3)) if self._particles is None else self._particles.poses

    def _forget(self) -> None:
        self._memory.clear()
        self._believed = None
        self._errors.restart()
        self._updated = None
        self._score = self._poor_travel = self._unexplained = 0.0
        self._searched_at = self._driven - self._settings.search.every

    def _begin_at(self, pose: Pose2D, sigma: float, turn: float) -> None:
        self._particles = Particles.around(pose, sigma, turn, self._settings.particles, self._rng)
        self._covariance = np.diag((sigma**2, sigma**2, turn**2))
        self._updated = None
        self._errors.restart()
        odom = self._raw[1] if self._raw is not None else (self._history.latest or (0.0, Pose2D()))[1]
        self._map_to_odom = _origin(pose, odom)

    def _take_sonar(self) -> bool:
        """Use sonar echoes together that came since the robot has moved by a step."""
        if not self._sonar:
            return False
        time = self._sonar[-1][0]
        raw, first = self._history.at(time), self._history.at(self._sonar[0][0])
        if raw is None or first is None:
            self._sonar.clear()
            return False
        motion = self._settings.motion
        is_moved = hypot(raw.x - first.x, raw.y - first.y) >= motion.step or time - self._sonar[0][0] > 1.0
        if not is_moved and abs(wrap_angle(raw.heading - first.heading)) < motion.step_turn:
            return False
        parts = []
        for at, ends in self._sonar:
            if (pose := self._history.at(at)) is not None and len(ends):
                parts.append(placed(pose.relative_to(raw), ends))
        self._sonar.clear()
        if not parts:
            return False
        self._take(time, raw, np.concatenate(parts), is_laser=False)
        return True

    def _take(self, time: float, raw: Pose2D, ends: Points, *, is_laser: bool) -> None:
        """Use readings at a pose in `odom`."""
        before, self._raw = self._raw, (time, raw)
        self._reading_time = time
        travel = interval = 0.0
        if before is not None:
            step = raw.relative_to(before[1])
            self._corrected = self._corrected.compose(self._errors.errors.corrected(step))
            travel, interval = hypot(step.x, step.y), max(0.0, time - before[0])
            if interval and travel / interval > _DRIVING:
                self._driven += min(interval, 1.0)
                self._unexplained += min(interval, 1.0)
                self._standing, self._look_after = 0.0, _FIRST_LOOK
            else:
                self._standing += interval
        trust = self._settings.trust.laser if is_laser else self._settings.trust.sonar
        axis = ends if ends.ndim == 2 else ends[:, ends.shape[1] // 2]
        is_keyframe = self._memory.add(self._corrected, axis)
        if self._particles is not None:
            self._update(raw, ends, trust, is_laser)
            self._follow_score(axis, trust, travel, interval)
        self._decide(axis, trust, travel, is_keyframe)

    def _begin_after_jump(self, before: Pose2D) -> None:
        """Go on where the robot was when `odom` has a new origin, as after a restart of the gateway; check the pose."""
        self._raw = self._scan = None  # readings that wait belong to the old origin
        self._sonar.clear()
        pose = None if self._map_to_odom is None else self._map_to_odom.compose(before)
        if pose is None:
            self.start_unknown()
        else:
            self.start_at(pose)

    def _update(self, raw: Pose2D, ends: Points, trust: SensorTrust, is_laser: bool) -> None:
        """Move the particles, and weigh them by readings, where the robot has moved by a step."""
        assert self._particles is not None
        settings = self._settings
        if self._updated is not None:
            step = self._corrected.relative_to(self._updated)
            if hypot(step.x, step.y) < settings.motion.step and abs(step.heading) < settings.motion.step_turn:
                return
            self._particles.poses = moved(self._particles.poses, step, settings.motion, self._rng)
        is_first = self._updated is None
        if is_laser:
            used = ends[:: max(1, len(ends) // settings.field.beams)]
            costs = settings.field.laser_weight * self._laser_costs.of(self._particles.poses, used.astype(np.float32))
        else:
            costs = settings.field.sonar_weight * self._sonar_costs.of(self._particles.poses, ends.astype(np.float32))
        self._particles.weigh(costs)
        mean, self._covariance = self._particles.mean()
        self._particles.resample()
        if not is_first and self._score < trust.good:
            self._particles.inject(mean)
        self._map_to_odom = _origin(mean, raw)
        if not is_first and self.state is LocalizationState.LOCALIZED:
            self._errors.add(raw.relative_to(self._updated_raw), mean, self._covariance)
        self._updated, self._updated_raw = self._corrected, raw

    def _follow_score(self, axis: Points, trust: SensorTrust, travel: float, interval: float) -> None:
        """Smooth the share of readings that the map explains at the pose."""
        assert self._map_to_odom is not None
        assert self._raw is not None
        score = self._search.score(self._map_to_odom.compose(self._raw[1]), axis, np.zeros_like(axis), trust.near)
        keep = exp(-travel / _SMOOTHING - interval / _SMOOTHING_TIME) if self._score else 0.0
        self._score = keep * self._score + (1.0 - keep) * score

    def _decide(self, axis: Points, trust: SensorTrust, travel: float, is_keyframe: bool) -> None:
        """Believe the pose, give it up, or search for another one."""
        if self.state is LocalizationState.LOCALIZED:
            self._poor_travel = self._poor_travel + travel if self._score < trust.poor else 0.0
            if self._score >= trust.good:
                self._believed = self._map_to_odom
            is_doubtful = is_keyframe and self._score < trust.good and self._remembered_score(trust) < trust.poor
            if is_doubtful or self._poor_travel >= self._settings.trust.patience:
                self._give_up()
            elif self._score >= trust.good and self._memory.travel > self._settings.trust.confirmed:
                self._unexplained = 0.0
        elif self.state is LocalizationState.CHECKING and (is_keyframe or self._standing >= self._look_after):
            self._look_after = max(_FIRST_LOOK, 2.0 * self._standing)
            if self._is_confirmed(trust):
                self.state = LocalizationState.LOCALIZED
        elif self._driven - self._searched_at >= self._settings.search.every:
            self._look_everywhere(trust)
        elif self._believed is not None and self._standing >= self._look_after:
            self._look_after = 2.0 * self._standing
            self._look_where_it_was(self._believed, axis, trust)

    def _remembered_score(self, trust: SensorTrust) -> float:
        """Share of the readings of the last metres that the map explains at the pose."""
        assert self._map_to_odom is not None
        assert self._raw is not None
        pose = self._map_to_odom.compose(self._raw[1])
        return self._search.score(pose, *self._memory.readings(self._corrected), trust.near)

    def _is_confirmed(self, trust: SensorTrust) -> bool:
        """Whether the readings fit the pose that was given, and no other place better."""
        assert self._map_to_odom is not None
        assert self._raw is not None
        pose, readings = self._map_to_odom.compose(self._raw[1]), self._memory.readings(self._corrected)
        return self._search.compare(pose, *readings, trust).is_confirmed(trust)

    def _give_up(self) -> None:
        self.state = LocalizationState.SEARCHING
        self._memory.clear()
        self._poor_travel = 0.0
        self._searched_at = self._driven

    def _look_everywhere(self, trust: SensorTrust) -> None:
        """Search the whole map, and begin at the pose found if it is the only good one."""
        self._searched_at = self._driven
        found = self._search.find(*self._memory.readings(self._corrected), trust.near)
        if found is None:
            return
        is_believed = found.is_clear(trust) and self._memory.travel >= self._settings.trust.travel
        if is_believed or self.state is not LocalizationState.CHECKING:
            self._begin_at_found(found)
        if is_believed:
            self.state = LocalizationState.LOCALIZED
        elif found.score >= trust.good:
            if self.state is LocalizationState.WRONG_MAP:
                self.state = LocalizationState.SEARCHING
        elif self._unexplained >= self._settings.trust.wrong_map:
            self.state = LocalizationState.WRONG_MAP

    def _look_where_it_was(self, believed: Pose2D, axis: Points, trust: SensorTrust) -> None:
        """Believe the pose of before, continued by odometry, if the present readings fit there and nowhere else.

        Readings that come late, on a busy machine, fit no place while the robot drives. Who asked it to drive stops it
        then, and no driving would show that they fit again.
        """
        assert self._raw is not None
        present = ReadingMemory(self._settings.memory)
        present.add(self._corrected, axis)
        found = self._search.find(*present.readings(self._corrected), trust.near)
        if found is None or not found.is_clear(trust):
            return
        if not self._search.is_apart(found.pose, believed.compose(self._raw[1])):
            self._memory = present
            self._begin_at_found(found)
            self.state = LocalizationState.LOCALIZED
            self._unexplained = 0.0

    def _begin_at_found(self, found: FoundPose) -> None:
        assert self._raw is not None
        self._begin_at(found.pose, _FOUND_SIGMA, _FOUND_TURN)
        self._updated, self._updated_raw = self._corrected, self._raw[1]
        self._score = found.score


def _is_new_origin(step: Pose2D, seconds: float) -> bool:
    """Whether `odom` has a new origin, by the step between two odometries."""
    return is_jump(step, 0.0 if abs(seconds) > _SILENCE else seconds)


def _origin(pose: Pose2D, odom: Pose2D) -> Pose2D:
    """Pose of `odom` in `map` for a robot's poses in both."""
    back = Pose2D().relative_to(odom)
    return pose.compose(back)
