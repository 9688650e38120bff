"""`acromovi teleop`: drive a robot with the keys of a terminal."""

import argparse
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from acromovi.keypad import HELP, PERIOD, Action, Keypad, KeyReader
from acromovi.options import add_bus

if TYPE_CHECKING:
    from acromovi.presence import Presence
    from acromovi.terminal import Terminal
    from bus.bus import Bus, Sample, Subscription
    from bus.keys import Topic

ANSWER_TIMEOUT = 2.0  # s
READ_TIMEOUT = PERIOD / 4  # s between looks at what is due
EPILOG = f"""\
keys: {HELP}

The robot drives while a key is held, and stops when the keys cease, by itself too when this program is gone.

example:
  acromovi teleop happy --speed 0.5

Exit codes: 0 quit with q, 1 no such robot or no terminal, 130 stopped by Ctrl-C; the robot stops in every case.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = EPILOG
    parser.add_argument("robot", metavar="ROBOT", help="the robot's name")
    parser.add_argument("--speed", type=float, default=0.3, metavar="M_S", help="forward, m/s (default: %(default)g)")
    parser.add_argument(
        "--turn", type=float, default=0.8, metavar="RAD_S", help="turning, rad/s (default: %(default)g)"
    )
    add_bus(parser)


def run(arguments: argparse.Namespace) -> int:
    """Drive until q."""
    from acromovi.presence import Presence
    from acromovi.terminal import Terminal
    from bus.session import ZenohBus

    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        print("acromovi teleop: this needs a terminal for its keys, and none is there", file=sys.stderr)
        return 1
    with ZenohBus.open(arguments.bus) as bus:
        presence = Presence(bus)
        presence.expect(arguments.robot)
        print(HELP)
        with Terminal() as terminal, Teleop(bus, arguments.robot, arguments.speed, arguments.turn) as teleop:
            drive(teleop, terminal, presence)
    return 0


def drive(teleop: "Teleop", terminal: "Terminal", presence: "Presence") -> None:
    """Read keys, command the robot and show how it is, until q or the end of the terminal."""
    reader = KeyReader()
    shown_at = 0.0
    while True:
        data = terminal.read(READ_TIMEOUT)
        now = time.monotonic()
        if data is None or not all(teleop.press(key, now) for key in reader.receive(data)):
            return
        teleop.step(now)
        if now - shown_at >= PERIOD:
            shown_at = now
            terminal.show(teleop.line(teleop.robot in presence.robots))


class Teleop:
    """Keys to commands of one robot, and what the robot says to one line. Time is an argument, s on a steady clock."""

    def __init__(self, bus: "Bus", robot: str, linear_speed: float, angular_speed: float) -> None:
        """Drive `robot` with these speeds, m/s and rad/s."""
        from bus import keys

        self.robot = robot
        self._bus = bus
        self._keypad = Keypad(linear_speed, angular_speed)
        self._command = bus.publisher(keys.CMD_VEL.key(robot), keys.CMD_VEL.type_name)
        self._latest: dict[str, Any] = {}  # message by topic suffix
        self._note = ""
        self._requests = ThreadPoolExecutor(1, "teleop")  # an answer may take its time, the wheels may not
        self._subscriptions = [self._hear(topic) for topic in (keys.ODOM, keys.BATTERY, keys.STATE)]

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._publish(0.0, 0.0)
        self._requests.shutdown()
        for subscription in self._subscriptions:
            subscription.close()
        self._command.close()

    def press(self, key: str, now: float) -> bool:
        """Take one key; False when it asks to quit."""
        action = self._keypad.press(key, now)
        if action is Action.QUIT:
            return False
        if action is not None:
            self._requests.submit(self._request, action)
        return True

    def step(self, now: float) -> None:
        """Command what is due."""
        due = self._keypad.due(now)
        if due is not None:
            self._publish(*due)

    def line(self, is_there: bool) -> str:
        """How the robot is, in one line."""
        from bus.messages import heading

        parts = [self.robot if is_there else f"{self.robot} IS GONE"]
        if odom := self._latest.get("odom"):
            twist, pose = odom.twist.twist, odom.pose.pose
            parts.append(f"{twist.linear.x:+.2f} m/s {twist.angular.z:+.2f} rad/s")
            parts.append(
                f"x {pose.position.x:.2f} m y {pose.position.y:.2f} m heading {heading(pose.orientation):.2f} rad"
            )
        if battery := self._latest.get("battery"):
            parts.append(f"{battery.voltage:.1f} V")
        if state := self._latest.get("state"):
            parts.append(f"{state.connection}, motors {'on' if state.motors else 'off'}" + ", E-STOP" * state.estop)
        return " | ".join(parts + [self._note] * bool(self._note))

    def _hear(self, topic: "Topic") -> "Subscription":
        from bus.messages import decode

        def hear(sample: "Sample") -> None:
            self._latest[topic.suffix] = decode(topic.type_name, sample.payload)

        return self._bus.subscribe(topic.key(self.robot), hear)

    def _publish(self, linear: float, angular: float) -> None:
        from bus.messages import twist

        self._command.put(twist(linear, angular))

    def _request(self, action: Action) -> None:
        """Ask the robot for something, and note the outcome for people."""
        from bus import keys
        from bus.errors import BusError

        state = self._latest.get("state")
        is_on = not (state and state.motors)
        topic, arguments, done = {
            Action.STOP: (keys.STOP, {}, "stopped"),
            Action.ENABLE: (keys.ENABLE, {"on": is_on}, f"motors switched {'on' if is_on else 'off'}"),
            Action.ESTOP: (keys.ESTOP, {"on": True}, "emergency stop; c clears it, then e switches the motors on"),
            Action.CLEAR: (keys.ESTOP, {"on": False}, "emergency stop cleared; e switches the motors on"),
        }[action]
        try:
            self._bus.query(topic.key(self.robot), arguments, ANSWER_TIMEOUT)
            self._note = done
        except BusError as err:
            self._note = f"{action}: {err}"
