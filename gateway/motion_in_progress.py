"""Long motions: the robot gets one command, and its SIPs show how the motion ends.

A radio link loses frames, and the robot acknowledges none. So a motion begins at rest, and a robot that still stands
after a while is given the command again. One that was driving would go on as before if the command were lost, for as
long as the line keeps its watchdog quiet.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from math import cos, degrees, inf, radians, sin

from gateway.connector import STOP
from gateway.events import MotionEnd
from gateway.odometry import OdometryTracker
from p2os import Command, StandardSip, encode_command

AT_REST = 0.01
"""m/s below which a wheel stands."""
REST_TO_ARRIVE = 0.2
REST_TO_GIVE_UP = 1.0
STALL_TO_GIVE_UP = 1.0
"""Seconds."""
TIME_TO_START = 0.5
"""Seconds; modems on both ways take half of it. A robot that is given a command twice follows the later one."""
MOST_TOLD = 3
"""Times that the command is sent to a robot that stands."""
TIME_TO_SPARE = 10.0
SLOWEST = 0.05
"""m/s or rad/s at the least, on the whole way; slower is a timeout."""


def is_at_rest(sip: StandardSip) -> bool:
    """Return whether both wheels stand still."""
    return max(abs(sip.left_velocity), abs(sip.right_velocity)) < AT_REST


class MotionInProgress(ABC):
    """A move or a turn on its way.

    motion_id: as the answer to the command gave it. kind: the command. goal: m or rad, by `unit`, signed. done: how
    much of it is done.
    """

    tolerance: float
    unit: str

    def __init__(
        self, motion_id: str, kind: str, goal: float, command: float, odometry: OdometryTracker, now: float
    ) -> None:
        """Make it.

        Args:
            motion_id, kind, goal: As the attributes.
            command: The goal by the robot's own odometry, m or rad.
            odometry: The robot's, by calibrated odometry.
            now: Steady time, s.
        """
        self.motion_id = motion_id
        self.kind = kind
        self.goal = goal
        self.done = 0.0
        self._scale = command / goal if goal else 1.0
        self._odometry = odometry
        self._started = self._told_at = now
        self._times_told = 0
        self._is_to_be_told = True
        self._resting_since = self._unstalled_at = now
        self._stalled_at = -inf
        self._has_rolled = False  # since it was told
        self._rest = 0.0  # s for which both wheels have stood

    def frames(self, is_rolling: bool, now: float) -> Iterator[bytes]:
        """Return the frames that are due now, given the progress.

        Args:
            is_rolling: Whether the robot rolls, or may do so at any moment since it was told to.
            now: Steady time, s.
        """
        if not self._is_to_be_told:
            yield from self._further_frames()
        elif is_rolling:
            yield STOP
        else:
            self._is_to_be_told = self._has_rolled = False
            self._times_told += 1
            self._told_at = now
            yield from self._first_frames()

    @abstractmethod
    def _first_frames(self) -> Iterator[bytes]:
        """Return the frames that let a robot that stands go on from `done`."""

    def _further_frames(self) -> Iterator[bytes]:
        """Return the frames that are due on the way."""
        return iter(())

    @abstractmethod
    def _progress(self) -> float:
        """Return the progress, m or rad in the direction of the goal's axis."""

    @property
    def times_out_at(self) -> float:
        """When to give up, s."""
        return self._started + TIME_TO_SPARE + abs(self.goal) / SLOWEST

    def update(self, sip: StandardSip, now: float) -> MotionEnd | None:
        """Take a SIP that the odometry has already taken; return how the motion ended, once it has."""
        self.done = self._progress()
        if not is_at_rest(sip):
            self._resting_since = now
            self._has_rolled = True
        if sip.left_stalled or sip.right_stalled:
            self._stalled_at = now
        else:
            self._unstalled_at = now
        self._rest = resting = now - self._resting_since
        started = now - self._started >= TIME_TO_START or abs(self.done) > self.tolerance
        if started and resting >= REST_TO_ARRIVE and abs(self.goal - self.done) <= self.tolerance:
            return MotionEnd.REACHED
        if now - self._unstalled_at >= STALL_TO_GIVE_UP:
            return MotionEnd.STALLED
        if now - self._told_at >= TIME_TO_START and self._can_have_missed_it(sip):
            self._is_to_be_told = True
        elif resting >= REST_TO_GIVE_UP and now - self._told_at >= REST_TO_GIVE_UP:
            return self._why_it_rests(sip)
        if now >= self.times_out_at:
            return MotionEnd.TIMEOUT
        return None

    def _can_have_missed_it(self, sip: StandardSip) -> bool:
        """Return whether a robot that was told to go stands without a reason that it shows."""
        is_able = sip.motors_enabled and not (sip.stop_button or sip.e_stalled or sip.left_stalled or sip.right_stalled)
        return is_able and not self._has_rolled and self._times_told < MOST_TOLD

    def _why_it_rests(self, sip: StandardSip) -> MotionEnd:
        """Return how the motion ended of a robot that stands elsewhere than at the goal."""
        if self._stalled_at >= self._resting_since - REST_TO_GIVE_UP:
            return MotionEnd.STALLED
        if sip.stop_button or sip.e_stalled:
            return MotionEnd.STOPPED_BY_ROBOT
        if not self._has_rolled and abs(self.done) <= self.tolerance:
            return MotionEnd.NOT_STARTED
        if not sip.motors_enabled:
            return MotionEnd.STOPPED_BY_ROBOT
        return (
            MotionEnd.OVERSHOOT
            if abs(self.done) > abs(self.goal) and self.done * self.goal >= 0
            else MotionEnd.UNDERSHOOT
        )


class Move(MotionInProgress):
    """Along the heading at which the robot is told; one that was turning has turned a little more while it braked."""

    tolerance = 0.03
    unit = "m"

    def __init__(self, motion_id: str, distance: float, command: float, odometry: OdometryTracker, now: float) -> None:
        super().__init__(motion_id, "move", distance, command, odometry, now)
        self._start, self._done_before = odometry.pose, 0.0

    def _first_frames(self) -> Iterator[bytes]:
        """Return the frames that end rotation and begin translation."""
        self._start, self._done_before = self._odometry.pose, self.done
        yield encode_command(Command.RVEL, 0.0)
        yield encode_command(Command.MOVE, (self.goal - self.done) * self._scale)

    def _progress(self) -> float:
        pose, start = self._odometry.pose, self._start
        along = (pose.x - start.x) * cos(start.heading) + (pose.y - start.y) * sin(start.heading)
        return self._done_before + along


class Turn(MotionInProgress):
    """By an angle of any size. A robot turns the shorter way to a heading, so a large turn is commanded in steps.

    Headings on the wire are whole degrees; the steps of one turn add up to the whole degree nearest to its angle. Steps
    are added with DCHEAD while the robot turns. A robot that comes to rest after that does not know DCHEAD, as some
    simulators, or the frame was lost: the rest of the turn is commanded with DHEAD, from the measured heading.
    """

    tolerance = radians(3.0)
    unit = "rad"
    LARGEST_AT_ONCE = 170
    STEP = 120
    AHEAD = 45
    """Degrees; a step is added when less than AHEAD is left, and STEP + AHEAD stays below half a turn."""

    def __init__(
        self, motion_id: str, kind: str, angle: float, command: float, odometry: OdometryTracker, now: float
    ) -> None:
        super().__init__(motion_id, kind, angle, command, odometry, now)
        self._start = odometry.turned
        self._total = round(degrees(command))
        self._told = 0  # degrees from the start
        self._is_extended = False  # DCHEAD was the last command

    def _first_frames(self) -> Iterator[bytes]:
        """Return the frames that end translation and begin rotation."""
        yield encode_command(Command.VEL, 0.0)
        yield self._from_here()

    def _further_frames(self) -> Iterator[bytes]:
        """Return the frame of the next step."""
        turned = self._turned
        if self._is_extended and self._rest >= REST_TO_ARRIVE and abs(self._told - turned) > degrees(self.tolerance):
            self._is_extended = False
            yield self._from_here()
        elif self._told != self._total and abs(self._told - turned) < self.AHEAD:
            step = self._total - self._told
            if abs(step) > self.STEP:
                step = self._step()
            self._told += step
            self._is_extended = True
            yield encode_command(Command.DCHEAD, radians(step))

    @property
    def _turned(self) -> float:
        """Degrees from the start, by the robot's own odometry."""
        return degrees(self.done * self._scale)

    def _from_here(self) -> bytes:
        """Return the next command to a robot at rest."""
        turned = round(self._turned)
        left = self._total - turned
        step = left if abs(left) <= self.LARGEST_AT_ONCE else self._step()
        self._told = turned + step
        return encode_command(Command.DHEAD, radians(step))

    def _step(self) -> int:
        return self.STEP if self._total > 0 else -self.STEP

    def _progress(self) -> float:
        return self._odometry.turned - self._start
