"""What one robot on patrol knows: where it is, where the others are, and what of its readings is not explained."""

import asyncio
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from math import atan, cos, hypot, inf, sin, tan
from typing import Any

import numpy as np

from agents.components.localization.localization_tools import SensorPlaces, scan_ends, sonar_ends
from agents.platform import Agent
from apps.robot_following.history import StampedPoses
from apps.surveillance.algorithms.changes import MapComparison, NearRobot, SeenFloor, UnexplainedThing
from apps.surveillance.algorithms.intruders import AlarmSensor, IntruderWatch, WatchedThing
from apps.surveillance.settings import SurveillanceSettings
from bus import MessageError, Sample, Subscription, keys
from bus.aio import hand_over
from bus.bus import Closeable
from bus.messages import NS_PER_S, LaserScan, RangeArray, stamp_ns
from geometry import Pose2D, wrap_angle
from maps.localization.settings import LocalizationSettings

LOCALIZATION, MOTION = "localization", "motion"
"""Agents of the robot whose results are used."""
_BEYOND = 0.3  # s after the newest pose for which it holds
_WAITING = 4  # readings that wait for the pose at their time
_FRESH = 1.0  # s for which a pose and a scan are news
_LEAST_APART = 0.02  # s between two poses from which a velocity follows
_BESIDE = 0.05  # m beside the hull that have to be free
_NEAR = 2.5  # m; another robot within may be in the way
_GUESS = 1.5  # m ahead, where something moves that only the camera sees

HearReading = Callable[[Any], None]


class PatrolSenses(Closeable):
    """The readings of one robot, in the event loop of its agent.

    odom_in_map: where the frame `odom` is in `map`. charging, battery: of the battery, None where it does not tell.
    view: of the camera, rad; 0 without one.
    """

    def __init__(
        self,
        agent: Agent,
        sensors: SensorPlaces,
        comparison: MapComparison,
        seen: SeenFloor,
        settings: SurveillanceSettings,
        on_alarm: Callable[[WatchedThing], None],
        started: Any,
    ) -> None:
        """Subscribe.

        Args:
            agent: Of the patrol.
            sensors: Where they are on the robot.
            comparison: With the map.
            seen: The floor as the robot has seen it.
            settings: Of the application.
            on_alarm: Called in the loop with each new intruder.
            started: Of the localization on that map; poses of any other one are not believed.
        """
        self.odom_in_map: Pose2D | None = None
        self.charging: bool | None = None
        self.battery: float | None = None
        self.view = 0.0
        self._bus, self._settings = agent.bus, settings
        self._robot = agent.name.platform
        self._sensors, self._comparison, self._on_alarm = sensors, comparison, on_alarm
        self._seen = seen if settings.alarm.learn else None
        self._loop = asyncio.get_running_loop()
        self._watch = IntruderWatch(settings.alarm)
        self._poses = StampedPoses(_BEYOND)
        self._pose: Pose2D | None = None
        self._state, self._reason = "stopped", "no localization was started"
        self._started, self._is_another = started, False  # localization
        self._localized_at = self._heard_at = self._scanned_at = -inf
        self._looks_since = inf
        self._deviation = inf
        self._stamp, self._turn_rate = -inf, 0.0
        self._ends = np.empty((0, 2))
        self._pan = 0.0
        self._pending: deque[tuple[float, Any]] = deque(maxlen=_WAITING)
        self._others: dict[str, tuple[Sample, float]] = {}  # the latest pose of each robot, and when it came
        self._sonar_settings = LocalizationSettings.load()
        self._camera: list[Subscription] = []
        self._hearing = [self._bus.subscribe(f"*/{keys.POSE.suffix}", self._take_pose, urgent=True)]
        topics: list[tuple[str, HearReading]] = [
            (f"{self._robot}/agents/{LOCALIZATION}/results", self._hear_localization),
            (keys.BATTERY.key(self._robot), self._hear_battery),
        ]
        if sensors.laser is not None:
            topics.append((keys.SCAN.key(self._robot), self._pend))
        elif sensors.discs:
            topics.append((keys.SONAR.key(self._robot), self._pend))
        self._hearing += [self._subscribe(key, hear) for key, hear in topics]

    def close(self) -> None:
        """Subscribe to nothing any more."""
        self.look(False)
        while self._hearing:
            self._hearing.pop().close()

    @property
    def pose(self) -> Pose2D | None:
        """Where the robot is in `map`; None where that is not to be believed."""
        return self._pose if self.is_localized else None

    @property
    def is_localized(self) -> bool:
        """Whether the localization is to be believed now."""
        return self._state == "localized" and self._loop.time() - self._localized_at <= _FRESH

    @property
    def lost_for(self) -> float:
        """How long the localization has not been believed, s."""
        return max(0.0, self._loop.time() - self._localized_at)

    @property
    def trouble(self) -> str:
        """Why the localization is not to be believed; empty if it is."""
        if self.is_localized:
            return ""
        if self._is_another:
            return "its localization was started again, and its patrol has the map of the one before"
        silence = self._loop.time() - self._heard_at
        if self._heard_at > -inf and silence > _FRESH:
            return f"its localization has been silent for {silence:.1f} s"
        return f"it is not localized: {self._reason or self._state}"

    @property
    def intruders(self) -> list[WatchedThing]:
        """Intruders that this robot sees."""
        return self._watch.intruders

    def in_the_way(self, bearing: float, reach: float, width: float) -> str:
        """Return what bars the straight way in a direction, empty where it is free.

        Args:
            bearing: Of the way in base_link, rad.
            reach: From the middle of the robot to where the way must be free, m.
            width: Of the robot, m.
        """
        if self._sensors.laser is None and not self._sensors.discs:
            return "the robot has neither laser nor sonar"
        if self._loop.time() - self._scanned_at > _FRESH:
            return "no scan comes"
        along = self._ends @ (cos(bearing), sin(bearing))
        across = self._ends @ (-sin(bearing), cos(bearing))
        is_barred = np.any((along > 0.0) & (along < reach) & (np.abs(across) < 0.5 * width + _BESIDE))
        return "something is in the way" if bool(is_barred) else ""

    @property
    def near_robot(self) -> str:
        """The name of the nearest robot of the team, if it is so near that it may be what is in the way; or empty."""
        pose, found = self.pose, self._places()
        if pose is None or not found:
            return ""
        away = {robot: hypot(each.x - pose.x, each.y - pose.y) for robot, each in found.items()}
        robot = min(away, key=lambda name: away[name])
        return robot if away[robot] < _NEAR else ""

    def look(self, on: bool) -> None:
        """Look with the camera at what moves, or look no more; for a robot that stands."""
        if on and not self._camera and self.view > 0.0:
            self._looks_since = self._loop.time()
            self._camera = [
                self._subscribe(f"{self._robot}/agents/{MOTION}/results", self._hear_motion),
                self._subscribe(keys.PTZ.key(self._robot), self._hear_head),
            ]
        while not on and self._camera:
            self._camera.pop().close()

    def robots(self) -> list[NearRobot]:
        """Return the other robots of the team, as far as they share their poses."""
        return list(self._places().values())

    def _places(self) -> dict[str, NearRobot]:
        now, found = self._loop.time(), {}
        for robot, (sample, at) in list(self._others.items()):
            with suppress(MessageError, AttributeError):  # no odometry; a robot that shares no pose is not known
                place = sample.decoded().pose.pose.position
                found[robot] = NearRobot(float(place.x), float(place.y), now - at)
        return found

    def _subscribe(self, key: str, hear: HearReading) -> Subscription:
        """Have messages on a key heard in the loop; of those that wait, only the latest counts."""
        waiting: list[Sample] = []

        def take() -> None:
            if waiting:
                with suppress(MessageError, AttributeError, KeyError, TypeError, ValueError):  # it is missing only
                    hear(waiting.pop().decoded())

        def note(sample: Sample) -> None:  # on the bus's thread
            is_first = not waiting
            waiting[:] = [sample]
            if is_first:
                hand_over(self._loop, take)

        return self._bus.subscribe(key, note, urgent=True)

    def _hear_localization(self, result: dict[str, Any]) -> None:
        now = self._loop.time()
        self._heard_at = now
        self._state, self._reason = str(result["state"]), str(result.get("reason") or "")
        if self._state != "localized" or result.get("pose") is None:
            return
        if self._is_another or result.get("started") != self._started:
            self._is_another, self._localized_at = True, -inf
            return
        pose = _pose(result["pose"])
        self.odom_in_map = _pose(result["odom_in_map"])
        self._deviation = max(float(result["deviations"][0]), float(result["deviations"][1]))
        self._localized_at, stamp = now, float(result["stamp"])
        apart = stamp - self._stamp
        if self._pose is not None and _LEAST_APART < apart < _FRESH:
            self._turn_rate = wrap_angle(pose.heading - self._pose.heading) / apart
        self._pose, self._stamp = pose, stamp
        self._poses.add(stamp, pose)
        self._compare()

    def _hear_battery(self, message: Any) -> None:
        self.charging = int(message.power_supply_status) == message.POWER_SUPPLY_STATUS_CHARGING
        fraction = float(message.percentage)
        self.battery = fraction if 0.0 <= fraction <= 1.0 else None

    def _pend(self, message: Any) -> None:
        """Keep a scan or sonar message until the pose at its time is known."""
        self._pending.append((stamp_ns(message.header) / NS_PER_S, message))
        if isinstance(message, LaserScan) and self._sensors.laser is not None:
            self._scanned_at = self._loop.time()
            self._ends = scan_ends(message, self._sensors.laser, self._settings.scan.range_m)
        elif isinstance(message, RangeArray):
            self._scanned_at = self._loop.time()
            arcs = sonar_ends(message, self._sensors.discs, self._sonar_settings)
            self._ends = arcs[:, arcs.shape[1] // 2]
        self._compare()

    def _compare(self) -> None:
        """Compare the readings with the map for whose times the pose is known."""
        newest = self._poses.newest
        while self._pending and newest is not None and self._pending[0][0] <= newest + _BEYOND / 2.0:
            stamp, message = self._pending.popleft()
            pose = self._poses.at(stamp)
            if pose is None or not self.is_localized or self._deviation > self._settings.trust.deviation_m:
                continue
            if isinstance(message, LaserScan) and self._sensors.laser is not None:
                laser = self._sensors.laser
                things = self._comparison.in_scan(
                    pose,
                    scan_ends(message, laser, self._settings.scan.range_m),
                    (laser.x, laser.y),
                    float(message.angle_increment),
                    self._turn_rate,
                    self.robots(),
                    self._seen,
                )
                self._found(stamp, AlarmSensor.LASER, things)
            elif isinstance(message, RangeArray):
                arcs = sonar_ends(message, self._sensors.discs, self._sonar_settings)
                things = self._comparison.in_sonar(pose, arcs, self.robots(), self._seen)
                self._found(stamp, AlarmSensor.SONAR, things)

    def _hear_head(self, message: Any) -> None:
        self._pan = float(message.pan)

    def _hear_motion(self, result: dict[str, Any]) -> None:
        """Take what moves in the image of a robot that stands."""
        camera, now = self._settings.camera, self._loop.time()
        pose = self.pose
        if pose is None or now - self._looks_since < camera.standing_s or not result.get("settled"):
            return
        width, height = float(result["width"]), float(result["height"])
        things: list[UnexplainedThing] = []
        for blob in result["blobs"]:
            if float(blob["area"]) < camera.area * width * height:
                continue
            bearing = self._pan + atan((1.0 - 2.0 * float(blob["x"]) / width) * tan(0.5 * self.view))
            if not any(_hides(pose, each, bearing, self._settings.member.radius_m) for each in self.robots()):
                things.append(self._placed(pose, bearing))
        self._found(float(result["stamp"]), AlarmSensor.CAMERA, things)

    def _placed(self, pose: Pose2D, bearing: float) -> UnexplainedThing:
        """Return what the camera sees in a direction, at the nearest echo there."""
        away = np.hypot(self._ends[:, 0], self._ends[:, 1])
        off = np.abs(np.arctan2(self._ends[:, 1], self._ends[:, 0]) - bearing)
        there = away[off < 0.1]
        distance = float(there.min()) if len(there) else _GUESS
        x, y = pose.compose(Pose2D(0.0, 0.0, bearing)).transform(distance, 0.0)
        return UnexplainedThing(x, y)

    def _found(self, stamp: float, sensor: AlarmSensor, things: Sequence[UnexplainedThing]) -> None:
        for each in self._watch.take(stamp, sensor, things):
            self._on_alarm(each)
        if self._seen is not None and (settled := self._watch.settled(stamp)):
            self._seen.expect(np.array([each.place for each in settled]))

    # On the bus's thread.

    def _take_pose(self, sample: Sample) -> None:
        robot, _ = keys.split(sample.key)
        if robot != self._robot:
            self._others[robot] = sample, self._loop.time()


def _pose(row: Sequence[float]) -> Pose2D:
    x, y, heading = row
    return Pose2D(float(x), float(y), float(heading))


def _hides(pose: Pose2D, robot: NearRobot, bearing: float, radius: float) -> bool:
    """Return whether a robot of the team is in a direction, so that it may be what moves there."""
    away = hypot(robot.x - pose.x, robot.y - pose.y)
    return abs(wrap_angle(pose.bearing_to(robot.x, robot.y) - bearing)) < 0.15 + atan(radius / max(away, 0.1))
