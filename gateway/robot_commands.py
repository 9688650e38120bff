"""Commands of a robot: velocities, long motions, stops, and access to its elements.

`Driver` obeys these commands with a robot at the other end of a line.
"""

import itertools
import re
from abc import ABC, abstractmethod
from math import isfinite
from typing import Any, TypeVar

from gateway.elements.all_elements import ELEMENTS
from gateway.elements.element import Element
from gateway.elements.joystick.element import JoystickElement
from gateway.errors import CommandRefused
from gateway.events import Event, MotionEnd
from gateway.motion import MotionTracker
from gateway.motion_in_progress import MotionInProgress, Move, Turn
from gateway.odometry import OdometryTracker
from gateway.outbox import Outbox
from gateway.settings import Settings
from geometry import wrap_angle

LONGEST_MOVE = 30.0
"""m; the argument of MOVE carries 65 m, which is more than a room."""
LONGEST_TURN = 100.0
"""rad."""

E = TypeVar("E", bound=Element[Any])


class RobotCommands(ABC):
    """Takes commands for one robot.

    is_connected: SIPs come. odometry: the pose.
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._outbox = Outbox()
        self._events: list[Event] = []
        self._motion = MotionTracker(self._outbox, self._events.append, settings.enable_motors)
        self._elements = {
            kind: kind(self._outbox, self._events.append, settings) for row in ELEMENTS for kind in row.elements
        }
        self._motion_ids = itertools.count(1)
        self.odometry = OdometryTracker(settings.calibration, settings.odometry_errors)
        self.is_connected = False

    @abstractmethod
    def _wake(self, now: float) -> bool:
        """Detect that the last call is too long ago; return whether the connection begins again."""

    @abstractmethod
    def _check_link(self, now: float) -> None:
        """Refuse whatever needs a robot while there is none.

        Raises:
            CommandRefused: The robot is not connected, or it is not known how old the command is.
        """

    @property
    def is_moving(self) -> bool:
        """The wheels turn, by the last SIP; false while the robot is not connected."""
        return self.is_connected and self._motion.is_rolling

    @property
    def is_estopped(self) -> bool:
        """The e-stop is latched."""
        return self._motion.is_estopped

    @property
    def max_linear(self) -> float:
        """Velocities are clipped to this, m/s."""
        return self._motion.max_linear

    @property
    def max_angular(self) -> float:
        """Velocities are clipped to this, rad/s."""
        return self._motion.max_angular

    @property
    def motion_id(self) -> str | None:
        """The long motion that is under way."""
        return self._motion.motion_id

    @property
    def unbound_motion(self) -> float:
        """Longest expected duration of a motion that is bound to no heartbeat, s."""
        return self._settings.unbound_motion_s

    @property
    def is_asked_to_move(self) -> bool:
        """A velocity or a long motion is in force."""
        return self._motion.is_asked_to_move

    @property
    def faults(self) -> list[str]:
        """Faults of the robot's motion and of its elements, a sentence each."""
        ignored = ["the robot stands although it is told to drive; check the line from the gateway to the robot"]
        return [
            *(ignored if self._motion.is_ignored else []),
            *(fault for element in self._elements.values() for fault in element.faults),
        ]

    def set_velocity(self, linear: float, angular: float, now: float) -> None:
        """Drive at m/s forward and rad/s counter-clockwise, until 0.5 s pass without a new velocity.

        Raises:
            CommandRefused: Not connected, held by a stop or an e-stop, motors off, or not finite.
        """
        self._check_link(now)
        self._motion.drive(linear, angular, now)

    def move(self, distance: float, now: float) -> str:
        """Drive a distance, m, backward if negative; return the id under which its end is reported.

        Raises:
            CommandRefused: As `set_velocity`, or too far.
        """
        self._check_link(now)
        if not abs(distance) <= LONGEST_MOVE:
            raise CommandRefused(f"distance {distance} m is not within ±{LONGEST_MOVE:g} m")
        command = distance / self._settings.calibration.distance
        return self._travel(Move(self._next_id("move"), distance, command, self.odometry, now), now)

    def turn(self, angle: float, now: float) -> str:
        """Turn by an angle, rad counter-clockwise, more than a turn if so asked; to the nearest degree.

        Raises:
            CommandRefused: As `set_velocity`, or too far.
        """
        self._check_link(now)
        return self._turn("turn", angle, now)

    def turn_to(self, heading: float, now: float) -> str:
        """Turn the shorter way to a heading in `odom`, rad; to the nearest degree.

        Raises:
            CommandRefused: As `set_velocity`, or not finite.
        """
        self._check_link(now)
        if not isfinite(heading):
            raise CommandRefused(f"heading {heading} rad is not finite; send a number")
        return self._turn("heading", wrap_angle(heading - self.odometry.pose.heading), now)

    def stop(self, now: float) -> None:
        """Stop, and hold until the velocities have paused for 0.5 s. Never refused."""
        self._wake(now)
        self._motion.stop(now)
        self._halt_elements(now)

    def halt_base(self, now: float, end: MotionEnd = MotionEnd.STOPPED) -> None:
        """Stop the wheels without holding them; the next command moves them. end: reported for a motion under way."""
        self._wake(now)
        joystick = self.lookup(JoystickElement)
        if self._motion.is_asked_to_move or joystick.drives:
            self._motion.halt(now, end)
        joystick.halt(now)

    def halt_element(self, kind: type[Element[Any]], now: float) -> None:
        """Stop one element where it is."""
        self._wake(now)
        self._elements[kind].halt(now)

    def release_wheels(self, now: float) -> None:
        """Stop, and send nothing to the wheels until the next command: the joystick drives.

        Raises:
            CommandRefused: Not connected, or the e-stop is latched.
        """
        self._check_link(now)
        self._motion.release_wheels(now)

    def emergency_stop(self, on: bool, now: float) -> None:
        """Stop as fast as the robot can and latch; or unlatch, which leaves the motors off. Never refused."""
        self._wake(now)
        if on:
            self._motion.emergency_stop(now)
            self._halt_elements(now)
        else:
            self._motion.release()

    def enable(self, on: bool, now: float) -> None:
        """Switch the motors.

        Raises:
            CommandRefused: Not connected, or the e-stop is latched.
        """
        self._check_link(now)
        self._motion.enable(on, now)

    def has(self, kind: type[Element[Any]]) -> bool:
        """Return whether the robot is known to have an element."""
        return self._elements[kind].is_present

    def element(self, kind: type[E], now: float) -> E:
        """Return an element of the robot, to command it.

        Raises:
            CommandRefused: The robot is not connected, or has no such element.
        """
        self._check_link(now)
        element = self.lookup(kind)
        if not element.is_present:
            raise CommandRefused(f"this robot has no {_words(kind)}, or has not shown it yet")
        return element

    def check_free(self) -> None:
        """Refuse whatever moves a part of the robot while the e-stop is latched.

        Raises:
            CommandRefused: It is.
        """
        if self.is_estopped:
            raise CommandRefused('the e-stop is latched; send estop {"on": false} first')

    def lookup(self, kind: type[E]) -> E:
        """Return the state of an element, whether the robot has it or not."""
        element = self._elements[kind]
        assert isinstance(element, kind)
        return element

    def _halt_elements(self, now: float) -> None:
        for element in self._elements.values():
            element.halt(now)

    def _travel(self, motion_in_progress: MotionInProgress, now: float) -> str:
        self._motion.travel(motion_in_progress, now)
        return motion_in_progress.motion_id

    def _turn(self, kind: str, angle: float, now: float) -> str:
        if not abs(angle) <= LONGEST_TURN:
            raise CommandRefused(f"angle {angle} rad is not within ±{LONGEST_TURN:g} rad")
        command = angle / self._settings.calibration.heading
        return self._travel(Turn(self._next_id(kind), kind, angle, command, self.odometry, now), now)

    def _next_id(self, kind: str) -> str:
        return f"{kind}-{next(self._motion_ids)}"


def _words(kind: type[Element[Any]]) -> str:
    """Return the name of an element in sentences: "power outputs" for `PowerOutputs`, "arm" for `ArmElement`."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", kind.__name__.removesuffix("Element")).lower()
