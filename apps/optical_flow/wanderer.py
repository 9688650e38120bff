"""Wandering by optical flow: takes readings, and returns twist, situation and reason. No bus and no clock."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from apps.optical_flow.columns import Floats
from apps.optical_flow.memory import FloorMemory
from apps.optical_flow.movement import REST, crept, direction_ahead, direction_around, steered, turned
from apps.optical_flow.settings import FlowSettings
from apps.optical_flow.sight import FlowReadings, FlowSight
from apps.optical_flow.situation import FlowSituation, SituationFilter, SituationJudgement, judge
from apps.optical_flow.surroundings import FlowSurroundings
from geometry import Pose2D, Twist2D, wrap_angle

_AT_HEADING = 0.08  # rad
_KEEP = 0.3  # m by which another direction must be better than the one that the robot steers to
_CHECK_TURN, _CHECK_TIME = 0.3, 0.7  # rad/s and s of the turn that shows whether images are frozen
_TURNS = (0.4, -0.4, 0.8, -0.8, 1.2, -1.2)  # rad, tried where there is no room for the best turn
_BACKING = 0.1  # m/s, also away from what touches the rear
_PUSHING = 1.5  # s of contact after which the robot tries the other way
_APART = 0.5  # s without contact after which a touch is another one
_STANDING = 2.0  # s without room for any motion, after which the robot doubts what it remembers next to it


@dataclass(frozen=True, slots=True)
class WanderOrders:
    """What to do. changed: whether the situation is another one than before."""

    twist: Twist2D
    situation: FlowSituation
    reason: str
    changed: bool


class _WanderMode(Enum):
    DRIVE = 0
    TURN = 1
    BACK = 2
    LEAVE = 3  # forwards, from what touches the rear or a side
    CHECK = 4


class Wanderer:
    """Steps at a steady period. The same readings give the same orders.

    memory: what it has seen. contacts: how often it was touched.
    """

    def __init__(self, settings: FlowSettings) -> None:
        self.settings = settings
        self.memory = FloorMemory(settings)
        self.contacts = 0
        self._sight = FlowSight(settings, self.memory)
        self._filter = SituationFilter(settings.situation.hold_s)
        self._mode = _WanderMode.DRIVE
        self._time: float | None = None
        self._target = 0.0  # heading to turn to or to steer to, rad
        self._has_target = False
        self._turn_sign = 1.0
        self._mode_until = 0.0  # s
        self._mode_from = Pose2D()
        self._is_frozen = False
        self._check_sign = 1.0
        self._unknown_way = 0.0  # m driven where nothing is known
        self._ordered = REST
        self._touched_at = -math.inf  # s, when it last began to move away from a contact
        self._touched_until = -math.inf  # s, of the latest contact
        self._stands_since = math.inf  # s, since when it has had no room

    def step(self, readings: FlowReadings) -> WanderOrders:
        """Take readings, and return what to do now."""
        before = self._filter.current
        self._take(readings)
        twist = self._ordered = self._stop_reason(readings) or self._moved(readings)
        now = self._filter.current
        return WanderOrders(twist, now.situation, now.reason, _has_changed(before, now))

    def _take(self, readings: FlowReadings) -> None:
        dt = 0.0 if self._time is None else readings.time - self._time
        if self._time is None:
            self.memory.begin(readings.pose)
        self._time = readings.time
        is_unknown = self._filter.current.situation is FlowSituation.UNKNOWN
        self.memory.pass_time(readings.time, readings.pose.heading)
        self.memory.drive_over(readings.pose, readings.time)
        step = self._sight.take(readings, dt)
        self._unknown_way = self._unknown_way + step if is_unknown else 0.0
        self._is_frozen = self._is_frozen and not self._sight.moves

    def _stop_reason(self, readings: FlowReadings) -> Twist2D | None:
        """Return the orders where the situation is none of the surroundings."""
        safety = self.settings.safety
        if readings.touches:
            self.contacts += readings.time - self._touched_until > _APART
            self._touched_until = readings.time
            if readings.time - self._touched_at > _PUSHING:
                self._leave(readings)
        silence = readings.time - self._sight.image_at
        if readings.trouble:
            return self._blind(readings.trouble)
        if silence > safety.silent_s:
            return self._blind("no image has come yet" if math.isinf(silence) else "no image comes")
        if self._mode in (_WanderMode.BACK, _WanderMode.LEAVE):
            return self._backed(readings)
        if self._is_frozen or self._sight.unmoved >= safety.unseen_s:
            return self._frozen(readings)
        return None

    def _leave(self, readings: FlowReadings) -> None:
        """Begin to move away from a contact, and remember where it was."""
        robot, ordered = self.settings.robot, self._ordered
        half = robot.width_m / 2.0
        turns = ordered.angular if abs(ordered.linear) < _BACKING / 2.0 else 0.0
        is_rear = readings.is_rear
        if is_rear is None:
            is_rear = ordered.linear < 0.0 or turns != 0.0
        if not is_rear:
            self.memory.block(readings.pose, robot.front_m + 0.05, robot.width_m)
        elif turns:  # the rear corner that leads has struck
            corner = Pose2D(0.0, -math.copysign(half, turns))
            self.memory.block(readings.pose.compose(corner), -robot.rear_m, 0.1)
        else:
            self.memory.block(readings.pose, -robot.rear_m - 0.05, robot.width_m)
        self._touched_at = readings.time
        where, way = ("rear", "drives forward") if is_rear else ("front", "backs off")
        distance = self.settings.safety.back_m
        self._filter.force(
            SituationJudgement(FlowSituation.CONTACT, f"something touches the {where}; the robot {way} {distance:g} m")
        )
        mode = _WanderMode.LEAVE if is_rear else _WanderMode.BACK
        self._begin(mode, readings, readings.time + 2.0 * distance / _BACKING)

    def _blind(self, why: str) -> Twist2D:
        self._filter.force(SituationJudgement(FlowSituation.BLIND, f"{why}; the robot stands"))
        self._mode, self._has_target = _WanderMode.DRIVE, False
        self._sight.unmoved = 0.0
        return REST

    def _frozen(self, readings: FlowReadings) -> Twist2D:
        """Stand, and turn a little now and then to see whether the images move again."""
        if not self._is_frozen:
            self._is_frozen = True
            self._begin(_WanderMode.CHECK, readings, readings.time + self.settings.safety.check_s)
        why = "the images do not move although the robot does: they are frozen, or nothing has a texture"
        self._filter.force(SituationJudgement(FlowSituation.BLIND, why))
        self._has_target = False
        if readings.time < self._mode_until:
            return REST
        if readings.time < self._mode_until + _CHECK_TIME:
            return Twist2D(0.0, self._check_sign * _CHECK_TURN)
        self._check_sign = -self._check_sign
        self._mode_until = readings.time + self.settings.safety.check_s
        return REST

    def _backed(self, readings: FlowReadings) -> Twist2D:
        gone = math.dist((readings.pose.x, readings.pose.y), (self._mode_from.x, self._mode_from.y))
        around = FlowSurroundings.around(readings.pose, readings.time, self.memory, self.settings)
        if gone < self.settings.safety.back_m and readings.time < self._mode_until:
            if self._mode is _WanderMode.BACK:
                return Twist2D(-_BACKING, 0.0)
            away = crept(around, self.settings)
            if away is not None:
                return away
        return self._turned_away(around, readings)

    def _moved(self, readings: FlowReadings) -> Twist2D:
        around = FlowSurroundings.around(readings.pose, readings.time, self.memory, self.settings)
        if self._mode is _WanderMode.CHECK:
            self._mode = _WanderMode.DRIVE
        if self._mode is _WanderMode.TURN:
            left = wrap_angle(self._target - readings.pose.heading)
            if left * self._turn_sign < -_AT_HEADING and abs(left) > math.pi / 2:
                left += math.copysign(2.0 * math.pi, self._turn_sign)  # the long way round is the free one
            if abs(left) > _AT_HEADING and readings.time < self._mode_until:
                return turned(left, self.settings)
            self._mode, self._has_target = _WanderMode.DRIVE, False
            self._sight.begin_anew()
            self.memory.turn_over(readings.pose)
            self._filter.force(judge(around, self.settings))
        current = self._filter.update(judge(around, self.settings), readings.time)
        contact = self._sight.contact
        if contact < self.settings.memory.reflex_s:
            current = self._filter.current = SituationJudgement(
                FlowSituation.NEAR, f"columns ahead show contact in {contact:.1f} s"
            )
            gap = contact * self.settings.drive.speed_m_s
            self.memory.suspect(
                readings.pose, self.settings.robot.front_m + max(gap, 0.05), self.settings.robot.width_m
            )
            self._sight.contact = math.inf
        if current.situation is FlowSituation.UNKNOWN and self._unknown_way > self.settings.safety.unknown_m:
            self._unknown_way = 0.0
            self.memory.block(readings.pose, self.settings.robot.front_m + 0.2, self.settings.robot.width_m)
            return self._turned_away(around, readings)
        if current.situation in (FlowSituation.NEAR, FlowSituation.CORNER):
            return self._turned_away(around, readings)
        bearing = self._steer_to(around, current.situation, readings)
        twist = None if bearing is None else steered(around, current.situation, bearing, self.settings)
        if twist is None:
            self._filter.force(SituationJudgement(FlowSituation.NEAR, "no curve ahead is free"))
            return self._turned_away(around, readings)
        slow = self.settings.drive.slow_m_s
        is_unsure = not self._sight.has_seen or around.known < self.settings.drive.look_m
        if is_unsure and twist.linear > slow:
            twist = Twist2D(slow, twist.angular * slow / twist.linear)
        return twist

    def _steer_to(self, around: FlowSurroundings, situation: FlowSituation, readings: FlowReadings) -> float | None:
        """Return the bearing to steer to; another one only where it is clearly better."""
        best = direction_ahead(around, situation, self.settings)
        if best is None:
            self._has_target = False
            return None
        if self._has_target:
            kept = wrap_angle(self._target - readings.pose.heading)
            value = around.clear + around.fresh
            if abs(kept) < math.pi / 3 and _at(around, value, kept) + _KEEP > _at(around, value, best):
                return kept
        self._target, self._has_target = wrap_angle(readings.pose.heading + best), True
        return best

    def _turned_away(self, around: FlowSurroundings, readings: FlowReadings) -> Twist2D:
        """Turn on the spot where the hull has room; else back off first."""
        bearing = direction_around(around, self.settings)
        ways = (bearing, bearing - math.copysign(2.0 * math.pi, bearing))
        turn = self._free_turn(around, ways, is_seen=True)
        if turn is None and self._can_back(around, readings.pose):
            self._begin(_WanderMode.BACK, readings, readings.time + 2.0 * self.settings.safety.back_m / _BACKING)
            return REST
        turns = (*ways, *sorted(_TURNS, key=lambda each: -_at(around, around.clear, each)))
        for is_seen in (True, False):
            turn = turn if turn is not None else self._free_turn(around, turns, is_seen=is_seen)
        if turn is None:
            return self._squeezed(around, readings)
        self._turn_to(turn, readings)
        return REST

    def _free_turn(self, around: FlowSurroundings, turns: Iterable[float], *, is_seen: bool) -> float | None:
        """Return the first of some turns on the spot for which the hull has room, rad; None for none."""
        return next((each for each in turns if around.can_turn(each, self.settings, is_seen=is_seen)), None)

    def _squeezed(self, around: FlowSurroundings, readings: FlowReadings) -> Twist2D:
        """Creep along the freest arc ahead; where there is none, stand and doubt more and more what is remembered."""
        self._mode = _WanderMode.DRIVE
        away = crept(around, self.settings)
        if away is not None:
            self._stands_since = math.inf
            return away
        self._stands_since = min(self._stands_since, readings.time)
        if readings.time - self._stands_since > _STANDING:
            self.memory.doubt(readings.pose)
        return REST

    def _can_back(self, around: FlowSurroundings, pose: Pose2D) -> bool:
        """Return whether the floor behind is known to be free, since the robot has come from there."""
        back, robot = self.settings.safety.back_m, self.settings.robot
        along = np.arange(robot.rear_m, robot.rear_m + back + 0.05, 0.05)
        across = np.linspace(-robot.width_m / 2.0, robot.width_m / 2.0, 5)
        places = np.stack(np.meshgrid(-along, across), axis=2).reshape(-1, 2)
        return around.can_back(back, self.settings) and bool(self.memory.are_known(pose, places).all())

    def _turn_to(self, bearing: float, readings: FlowReadings) -> None:
        self._turn_sign = bearing
        self._target = wrap_angle(readings.pose.heading + bearing)
        self._begin(
            _WanderMode.TURN, readings, readings.time + 2.0 + 2.0 * abs(bearing) / self.settings.drive.turn_rad_s
        )

    def _begin(self, mode: _WanderMode, readings: FlowReadings, until: float) -> None:
        self._mode, self._mode_until, self._mode_from = mode, until, readings.pose
        self._stands_since = math.inf


def _has_changed(before: SituationJudgement, now: SituationJudgement) -> bool:
    """Return whether there is something to tell: another situation, or another reason to stand."""
    stands = now.situation is FlowSituation.BLIND and now.reason != before.reason
    return now.situation is not before.situation or stands


def _at(around: FlowSurroundings, values: Floats, bearing: float) -> float:
    return float(values[int(np.argmin(np.abs(np.remainder(around.bearings - bearing + np.pi, 2 * np.pi) - np.pi)))])
