"""Motion commands of the robot, and their frames.

A keep-alive repeats the command in force, so that the first packet that arrives after a cut is never a bare
PULSE, which would reactivate setpoints that its watchdog had stopped: a standing robot is told STOP again, a driving
one its speeds. PULSE serves where there are no setpoints (nothing was asked since the handshake) or where they are to
go on (a long motion).
"""

from collections.abc import Callable, Iterable
from enum import Enum, auto
from math import inf, isfinite

from gateway.connector import STOP
from gateway.errors import CommandRefused
from gateway.events import MotionEnd, MotionEnded
from gateway.motion_in_progress import MotionInProgress, is_at_rest
from gateway.outbox import Outbox
from p2os import Command, StandardSip, encode_command

PATIENCE = 1.0
"""Seconds for which a robot may stand although it is told to drive."""
SLOWEST = 0.02, 0.05
"""m/s and rad/s: slower speeds may be below the resolution of the wire or the friction of the gears."""


class Obedience:
    """Compares what was asked for with what the SIPs show.

    is_ignored: the robot stands although it is told to drive, has power, and reports no stalled wheel.
    """

    def __init__(self) -> None:
        self.is_ignored = False
        self._stands_since = inf

    def judge(self, linear: float, angular: float, sip: StandardSip, now: float) -> None:
        """Take a SIP.

        Args:
            linear, angular: Velocity that is in force, m/s and rad/s.
            sip: A plausible one.
            now: Steady time, s.
        """
        is_asked = abs(linear) >= SLOWEST[0] or abs(angular) >= SLOWEST[1]
        is_able = sip.motors_enabled and not (sip.left_stalled or sip.right_stalled)
        self._stands_since = min(self._stands_since, now) if is_asked and is_able and is_at_rest(sip) else inf
        self.is_ignored = now - self._stands_since >= PATIENCE


CMD_VEL_SILENCE = 0.5
"""Seconds without a velocity after which the robot stops, and after which a stop no longer holds."""
KEEP_ALIVE = 0.4
"""Seconds; well below the watchdog of 2 s, and below the gap after which the gateway distrusts itself."""
REPEAT_STOP = 0.15
"""Seconds after which a robot that still rolls is told to stop again."""
TIME_TO_BRAKE = 1.0
"""Seconds after an e-stop at which the motors lose their power, even if the robot still rolls."""
TIME_TO_SWITCH = 0.5
"""Seconds within which SIPs may not yet show that the motors were switched."""
MOST_SWITCHED = 3
"""Times that the motors are switched at most while SIPs do not show it. A frame can be lost; people have buttons."""

STANDSTILL = 0.0, 0.0
ESTOP = encode_command(Command.ESTOP)
PULSE = encode_command(Command.PULSE)
MOTORS_ON = encode_command(Command.ENABLE, 1)
MOTORS_OFF = encode_command(Command.ENABLE, 0)


class _Mode(Enum):
    UNASKED = auto()
    DRIVING = auto()
    STANDING = auto()
    TRAVELLING = auto()


class MotionTracker:
    """Commands in, frames into the outbox; SIPs in, ends of long motions out.

    is_estopped: latched. is_rolling: the wheels turned at the last SIP. wants_motors: the motors are to be on.
    max_linear, max_angular: m/s and rad/s; what no motion exceeds.
    """

    def __init__(self, outbox: Outbox, report: Callable[[MotionEnded], None], wants_motors: bool) -> None:
        self._outbox = outbox
        self._report = report
        self._is_open = False
        self._mode = _Mode.UNASKED
        self._speeds: dict[Command, tuple[bytes, float]] = {}  # last frame of each kind, and when it was queued
        self._motion: MotionInProgress | None = None
        self._obedience = Obedience()
        self._asked = STANDSTILL
        self._cmd_vel_at = -inf
        self._holds = False
        self._estopped_at = -inf
        self._stopped_at = -inf
        self._switched_at = -inf
        self._switches_left = 0
        self._motors_on = False
        self.is_estopped = False
        self.is_rolling = False
        self._needs_enable = False  # since an e-stop
        self.wants_motors = wants_motors
        self.max_linear = inf
        self.max_angular = inf
        self._speed_limits: dict[str, bytes] = {}

    @property
    def is_ignored(self) -> bool:
        """The robot stands although it is told to drive, without a known reason."""
        return self._obedience.is_ignored

    @property
    def motion_id(self) -> str | None:
        """The long motion that is under way."""
        return None if self._motion is None else self._motion.motion_id

    @property
    def is_asked_to_move(self) -> bool:
        """A velocity or a long motion is in force."""
        return self._mode in (_Mode.DRIVING, _Mode.TRAVELLING)

    def begin_link(self, now: float) -> None:
        """Zero the setpoints of a robot that has just been opened, and switch its motors on if wanted."""
        self._is_open = True
        self._mode = _Mode.UNASKED
        self._speeds.clear()
        self._motors_on = False
        self._outbox.put("stop", STOP)
        self._switches_left = 0
        if self.wants_motors and not self.is_estopped:
            self._switches_left = MOST_SWITCHED
            self._switch_motors(now)

    def lose_link(self) -> None:
        """Drop all commands: the robot is lost."""
        self._finish(MotionEnd.LOST)
        self._is_open = False
        self._mode = _Mode.UNASKED
        self._switched_at = -inf

    def limit_speeds(self, linear: float, angular: float, frames: Iterable[tuple[str, bytes]]) -> None:
        """Set what no motion exceeds.

        Args:
            linear, angular: m/s and rad/s; velocities are clipped to them.
            frames: Those by which the robot keeps them in moves and turns, each with its name.
        """
        self.max_linear, self.max_angular = linear, angular
        self._speed_limits = dict(frames)

    def drive(self, linear: float, angular: float, now: float) -> None:
        """Set the velocity, m/s and rad/s, clipped to the limits; in force until `CMD_VEL_SILENCE` has passed.

        Raises:
            CommandRefused: Not finite, held by a stop or an e-stop, or the motors are off.
        """
        if not (isfinite(linear) and isfinite(angular)):
            raise CommandRefused(f"velocity {linear} m/s, {angular} rad/s is not finite; send numbers")
        is_first = now - self._cmd_vel_at >= CMD_VEL_SILENCE
        self._cmd_vel_at = now
        try:
            self._check_free(now)
        except CommandRefused:
            if self._mode is _Mode.DRIVING:  # a velocity that is not obeyed must not keep an older one in force
                self.halt(now)
            raise
        if self._holds and not is_first:
            raise CommandRefused(f"a stop holds the robot until cmd_vel has been silent for {CMD_VEL_SILENCE} s")
        self._holds = False
        self._finish(MotionEnd.REPLACED)
        if self._mode is not _Mode.DRIVING:
            self._speeds.clear()
            self._mode = _Mode.DRIVING
        self._asked = _clip(linear, self.max_linear), _clip(angular, self.max_angular)
        self._set_speed(Command.VEL, self._asked[0], now)
        self._set_speed(Command.RVEL, self._asked[1], now)

    def travel(self, motion: MotionInProgress, now: float) -> None:
        """Begin a long motion in place of whatever is in force.

        Raises:
            CommandRefused: Held by an e-stop, or the motors are off.
        """
        self._check_free(now)
        self._finish(MotionEnd.REPLACED)
        self._outbox.drop(Command.VEL, Command.RVEL)
        may_roll = self.is_rolling or self.is_asked_to_move
        self._mode = _Mode.TRAVELLING
        self._motion = motion
        for name, frame in self._speed_limits.items():  # each time: a robot forgets them with the connection
            self._outbox.put(name, frame)
        self._queue_journey(may_roll, now)

    def stop(self, now: float) -> None:
        """Stop, and let no stream of velocities go on until it has paused for `CMD_VEL_SILENCE`."""
        self._holds = True
        self._cmd_vel_at = now
        self.halt(now)

    def halt(self, now: float, end: MotionEnd = MotionEnd.STOPPED) -> None:
        """Stop; the next velocity drives again."""
        self._finish(end)
        if not self._is_open:
            return  # STOP is the first frame that the robot receives
        self._mode = _Mode.STANDING
        self._outbox.drop(Command.VEL, Command.RVEL, ("journey", 0), ("journey", 1))
        self._outbox.put_first("stop", ESTOP if self.is_estopped else STOP)
        self._stopped_at = now

    def release_wheels(self, now: float) -> None:
        """Stop, and then only keep the robot awake: a joystick drives it.

        Raises:
            CommandRefused: The e-stop is latched.
        """
        if self.is_estopped:
            raise CommandRefused('the e-stop is latched; send estop {"on": false} first')
        self.halt(now)
        self._mode = _Mode.UNASKED

    def emergency_stop(self, now: float) -> None:
        """Stop at once, latch, and switch the motors off when the robot stands."""
        self.is_estopped = self._needs_enable = True
        self.wants_motors = False
        self._switches_left = 0
        self._estopped_at = now
        self._outbox.drop(Command.ENABLE)
        self.halt(now)

    def release(self) -> None:
        """Release the e-stop; the motors stay off until `enable`."""
        self.is_estopped = False

    def enable(self, on: bool, now: float) -> None:
        """Switch the motors; setpoints are zeroed before they are switched on.

        Raises:
            CommandRefused: The e-stop is latched.
        """
        if on and self.is_estopped:
            raise CommandRefused('the e-stop is latched; send estop {"on": false} first')
        self.halt(now)
        self.wants_motors = on
        self._needs_enable = self._needs_enable and not on
        self._switches_left = MOST_SWITCHED
        self._switch_motors(now)

    def take(self, sip: StandardSip, now: float) -> None:
        """Take a plausible SIP that the odometry has already taken."""
        self.is_rolling = not is_at_rest(sip)
        self._follow_motors(sip, now)
        self._obedience.judge(*(self._asked if self._mode is _Mode.DRIVING else STANDSTILL), sip, now)
        if self._motion is not None:
            end = self._motion.update(sip, now)
            if end is None:
                self._queue_journey(self.is_rolling, now)
            else:
                self.halt(now, end)
        elif self._mode is _Mode.STANDING and self.is_rolling and now - self._stopped_at >= REPEAT_STOP:
            self.halt(now)

    def watch(self, now: float) -> None:
        """Do what time asks for."""
        if self._mode is _Mode.DRIVING:
            if now - self._cmd_vel_at >= CMD_VEL_SILENCE:
                self.halt(now)
                return
            for command, (frame, queued_at) in self._speeds.items():
                if now - queued_at >= KEEP_ALIVE:
                    self._outbox.put(command, frame)
                    self._speeds[command] = frame, now
        elif self._outbox.last_sent is not None and now - self._outbox.last_sent >= KEEP_ALIVE:
            if self._mode is _Mode.STANDING:
                self._outbox.put("stop", ESTOP if self.is_estopped else STOP)
            else:
                self._outbox.put(Command.PULSE, PULSE)

    @property
    def deadline(self) -> float:
        """When `watch` is due, s."""
        if self._mode is _Mode.DRIVING:
            repeated = min(queued_at for _, queued_at in self._speeds.values()) + KEEP_ALIVE
            return min(repeated, self._cmd_vel_at + CMD_VEL_SILENCE)
        return inf if self._outbox.last_sent is None else self._outbox.last_sent + KEEP_ALIVE

    def _check_free(self, now: float) -> None:
        if self.is_estopped:
            raise CommandRefused('the e-stop is latched; send estop {"on": false} and then enable {"on": true}')
        has_power = self._motors_on or (self.wants_motors and now - self._switched_at <= TIME_TO_SWITCH)
        if self._needs_enable or not has_power:  # released so soon after an e-stop, they have not been switched off yet
            raise CommandRefused('the motors are off; send enable {"on": true}')

    def _set_speed(self, command: Command, value: float, now: float) -> None:
        frame = encode_command(command, value)
        if command not in self._speeds or self._speeds[command][0] != frame:
            self._outbox.put(command, frame)
            self._speeds[command] = frame, now

    def _queue_journey(self, is_rolling: bool, now: float) -> None:
        if self._motion is not None:
            for index, frame in enumerate(self._motion.frames(is_rolling, now)):
                self._outbox.put(("journey", index), frame)

    def _finish(self, end: MotionEnd) -> None:
        motion, self._motion = self._motion, None
        if motion is not None:
            self._report(MotionEnded(motion.motion_id, motion.kind, end, motion.done, motion.goal, motion.unit))

    def _switch_motors(self, now: float) -> None:
        self._outbox.put(Command.ENABLE, MOTORS_ON if self.wants_motors else MOTORS_OFF)
        self._switched_at = now
        self._switches_left -= 1

    def _follow_motors(self, sip: StandardSip, now: float) -> None:
        went_off = self._motors_on and not sip.motors_enabled
        self._motors_on = sip.motors_enabled
        if sip.motors_enabled == self.wants_motors or sip.stop_button or sip.e_stalled:
            self._switches_left = 0  # from now on somebody else has switched them
        if self._needs_enable and sip.motors_enabled:
            if not self.is_rolling or now - self._estopped_at >= TIME_TO_BRAKE:
                self._outbox.put(Command.ENABLE, MOTORS_OFF)
        elif self._switches_left and now - self._switched_at > TIME_TO_SWITCH:
            self._switch_motors(now)
        elif went_off and now - self._switched_at > TIME_TO_SWITCH:
            # The robot did it by itself (STOP button, e-stall, low battery): it takes a person to switch them on again.
            self.wants_motors = False
            self.halt(now, MotionEnd.STOPPED_BY_ROBOT)


def _clip(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
