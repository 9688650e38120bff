"""The screen of teleoperation: the robot's state, then why a key has no effect. No bus, no clock."""

import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from acromovi.keyboard import HELP

SEPARATOR, DOT = " | ", " · "
LATCHED = "the e-stop is latched"  # among the faults of a robot's state, as the two below
AT_THE_ROBOT = ("the STOP button is pressed", "the robot's emergency stop is engaged")
NOT_CONNECTED = "the robot is not connected"
REFUSED = " was refused: "  # in a fault that tells of a command that was not obeyed
MOVES = 0.01, 0.02  # m/s and rad/s, above which a robot moves
IN_KEYS = (
    (re.compile(r'send estop \{"on": false\} and then enable \{"on": true\}'), "press c and then e"),
    (re.compile(r'send estop \{"on": false\}( first)?'), "press c first"),
    (re.compile(r'send enable \{"on": true\}'), "press e"),
)


@dataclass
class RobotView:
    """The latest messages of one robot, None before the first, and what the last key did.

    lease: of `lease/state`. note: for people.
    """

    robot: str
    is_there: bool = True
    odom: Any = None
    battery: Any = None
    state: Any = None
    lease: Mapping[str, Any] | None = None
    note: str = ""

    def obstacle(self) -> str:
        """Return why the keys that drive have no effect now, and what to do; empty when no reason is known."""
        state = self.state
        if not self.is_there:
            return f"no effect: {self.robot} is gone; its gateway does not run"
        if state is None:
            return f"no effect yet: {self.robot} has not reported its state"
        if state.connection != "connected":
            more = [in_keys(fault) for fault in state.faults if fault != NOT_CONNECTED]
            return "; ".join([f"no effect: the gateway is not connected to the robot ({state.connection})", *more[:1]])
        if state.estop:
            return f"no effect: {self._emergency_stop()}"
        if holder := self._holder():
            return f"no effect: {holder}; only its holder drives the robot until it ends"
        if not state.motors:
            return "no effect: the motors are off; press e to switch them on"
        return ""

    def screen(self, width: int, height: int) -> list[str]:
        """Return the lines to show, the state first and whole, none wider than `width` and at most `height` of them."""
        notes = [line for text in (self.note, *self._faults()) for line in textwrap.wrap(text, max(width, 1))]
        keys = joined(HELP.split(DOT), width, DOT)
        return [*joined(self._state(), width), *notes, *joined(self._motion(), width), *keys][: max(height, 1)]

    def _state(self) -> list[str]:
        parts = [self.robot if self.is_there else f"{self.robot} IS GONE"]
        if state := self.state:
            parts += ["E-STOP"] * state.estop
            parts += [state.connection, f"motors {'on' if state.motors else 'off'}"]
        if battery := self.battery:
            parts.append(f"{battery.voltage:.1f} V")
        return parts

    def _motion(self) -> list[str]:
        if (odom := self.odom) is None:
            return []
        from bus.messages import heading  # here and not at the top: it takes a while, and only people wait for it

        twist, pose = odom.twist.twist, odom.pose.pose
        return [
            f"{twist.linear.x:+.2f} m/s",
            f"{twist.angular.z:+.2f} rad/s",
            f"x {pose.position.x:.2f} m",
            f"y {pose.position.y:.2f} m",
            f"heading {heading(pose.orientation):.2f} rad",
        ]

    def _faults(self) -> list[str]:
        """The robot's faults, without what the first line and the note say, and without refusals of before."""
        known = (LATCHED, NOT_CONNECTED)
        faults = [in_keys(fault) for fault in self.state.faults if fault not in known] if self.state else []
        is_explained = bool(self.obstacle()) or self._moves()
        return [fault for fault in faults if fault not in self.note and not (is_explained and REFUSED in fault)]

    def _moves(self) -> bool:
        twist = self.odom.twist.twist if self.odom is not None else None
        return twist is not None and (abs(twist.linear.x) > MOVES[0] or abs(twist.angular.z) > MOVES[1])

    def _emergency_stop(self) -> str:
        """Which emergency stop holds the robot, and how it is released."""
        at_robot = next((fault for fault in AT_THE_ROBOT if fault in self.state.faults), "")
        if at_robot and LATCHED not in self.state.faults:
            return f"{at_robot}; release it at the robot, then press e"
        return "the e-stop is latched; press c to release it, then e to switch the motors on"

    def _holder(self) -> str:
        """Who holds the lease on the robot or on its base; empty when nobody does."""
        lease = self.lease or {}
        elements = lease.get("elements")
        base = elements.get("base") if isinstance(elements, Mapping) else None
        for what, row in (("robot", lease), ("base", base)):
            if isinstance(row, Mapping) and isinstance(row.get("holder"), str):
                return f"{row['holder']} holds the lease on the {what}"
        return ""


def in_keys(why: str) -> str:
    """A reason of the gateway's with the keys to press in place of the commands to send."""
    for command, keys in IN_KEYS:
        why = command.sub(keys, why)
    return why


def joined(parts: Sequence[str], width: int, separator: str = SEPARATOR) -> list[str]:
    """Put parts on as few lines as they need; a part is broken only where it is wider than a line."""
    lines: list[str] = []
    for part in parts:
        if lines and len(lines[-1]) + len(separator) + len(part) <= width:
            lines[-1] += separator + part
        else:
            lines += textwrap.wrap(part, max(width, 1))
    return lines
