"""Keyboard control for teleoperation: keys and time to twists; no terminal, no bus and no clock.

A terminal tells when a key goes down, and repeats it while it is held, but never that it was let go. So a key counts as
held for `HOLD` after each time it is heard of, which also bridges the pause before the first repetition.
"""

import re
from dataclasses import dataclass
from enum import Enum, StrEnum

HOLD = 0.6  # s; longer than the usual 0.5 s before a held key repeats
PERIOD = 0.1  # s between commands

ARROWS = {b"[A": "up", b"[B": "down", b"[C": "right", b"[D": "left"}
ARROWS |= {key.replace(b"[", b"O"): name for key, name in ARROWS.items()}  # of a terminal in application mode
SPECIAL = "special key"  # any other that a terminal sends as an escape sequence: a function key, Ctrl with an arrow
ESCAPE = b"\x1b"
SEQUENCE = re.compile(rb"\x1b(\[[0-?]*[ -/]*[@-~]|O[ -~])", re.DOTALL)
BEGINNING = re.compile(rb"\x1b(\[[0-?]*[ -/]*|O)?", re.DOTALL)
LONGEST = 32  # bytes of a sequence; what is longer is none


class Action(StrEnum):
    """Requests of keys that do not drive."""

    STOP = "stop"
    ENABLE = "enable"
    ESTOP = "estop"
    CLEAR = "clear"
    QUIT = "quit"


class _KeypadAxis(Enum):
    """The axis that a key moves: forward or turning."""

    LINEAR = "linear"
    ANGULAR = "angular"


MOVES = {
    "up": (_KeypadAxis.LINEAR, 1),
    "w": (_KeypadAxis.LINEAR, 1),
    "down": (_KeypadAxis.LINEAR, -1),
    "s": (_KeypadAxis.LINEAR, -1),
    "left": (_KeypadAxis.ANGULAR, 1),
    "a": (_KeypadAxis.ANGULAR, 1),
    "right": (_KeypadAxis.ANGULAR, -1),
    "d": (_KeypadAxis.ANGULAR, -1),
}
ACTIONS = {" ": Action.STOP, "e": Action.ENABLE, "x": Action.ESTOP, "c": Action.CLEAR, "q": Action.QUIT}
HELP = "arrows or w a s d drive · space stops · e motors on or off · x e-stop · c clears it · q quits"


class KeyReader:
    """Converts bytes of a terminal to names of keys; the bytes of a special key may come in several pieces."""

    def __init__(self) -> None:
        self._rest = b""

    @property
    def has_lone_escape(self) -> bool:
        """Whether an Esc has come that nothing has followed yet."""
        return self._rest == ESCAPE

    def receive(self, data: bytes) -> list[str]:
        """The keys that are complete now: `up`, `down`, `left`, `right`, a character in lower case, or `SPECIAL`."""
        data = self._rest + data
        keys = []
        while data:
            if data[:1] != ESCAPE:
                keys.append(chr(data[0]).lower())
                data = data[1:]
            elif found := SEQUENCE.match(data):
                keys.append(ARROWS.get(found[1], SPECIAL))
                data = data[found.end() :]
            elif len(data) < LONGEST and BEGINNING.fullmatch(data):
                break
            else:
                data = data[1:]
        self._rest = data
        return keys


@dataclass
class _HeldAxis:
    """One axis: its direction, and the time until which its key counts as held, s."""

    direction: int = 0
    until: float = 0.0


class KeyboardControl:
    """Keys in, twists out; time in s on any steady clock."""

    def __init__(self, linear_speed: float, angular_speed: float) -> None:
        """Drive with these speeds, m/s and rad/s."""
        self._speeds = {_KeypadAxis.LINEAR: linear_speed, _KeypadAxis.ANGULAR: angular_speed}
        self._held = {axis: _HeldAxis() for axis in _KeypadAxis}
        self._next = 0.0
        self._is_driving = False

    def press(self, key: str, now: float) -> Action | None:
        """Take one key; the result is what it asks for besides driving."""
        if key in MOVES:
            axis, direction = MOVES[key]
            if self._held[axis].direction != direction:
                self._next = now  # a change is not kept waiting
            self._held[axis] = _HeldAxis(direction, now + HOLD)
            return None
        action = ACTIONS.get(key)
        if action is not None:
            self._held = {axis: _HeldAxis() for axis in _KeypadAxis}
        return action

    def twist(self, now: float) -> tuple[float, float]:
        """What the keys held ask for: m/s forward, rad/s counter-clockwise."""
        linear, angular = (
            self._speeds[axis] * held.direction if now < held.until else 0.0 for axis, held in self._held.items()
        )
        return linear, angular

    def due(self, now: float) -> tuple[float, float] | None:
        """The twist to publish now, or None: every `PERIOD` while a key is held, then once a zero, then nothing."""
        twist = self.twist(now)
        is_held = twist != (0.0, 0.0)
        if not is_held:
            was_driving, self._is_driving = self._is_driving, False
            return twist if was_driving else None
        if now < self._next:
            return None
        self._is_driving = True
        is_late = now - self._next > PERIOD  # after a pause, begin anew; otherwise keep the rhythm
        self._next = (now if is_late else self._next) + PERIOD
        return twist
