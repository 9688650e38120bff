"""`acromovi teleop`: drive a robot with the keys of a terminal."""

import argparse
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import TYPE_CHECKING, Self

from acromovi.keyboard import HELP, MOVES, PERIOD, SPECIAL, Action, KeyboardControl, KeyReader
from acromovi.options import add_bus
from acromovi.robot_view import RobotView, in_keys
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from acromovi.presence import RobotPresence
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


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="the robot's name")
    parser.add_argument("--speed", type=float, default=0.3, metavar="M_S", help="forward, m/s (default: %(default)g)")
    parser.add_argument(
        "--turn", type=float, default=0.8, metavar="RAD_S", help="set the turning speed [%(default)g rad/s]"
    )
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Drive until q."""
    from acromovi.presence import RobotPresence
    from acromovi.terminal import Terminal
    from bus.session import ZenohBus

    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        print("acromovi teleop: this needs a terminal for its keys, and none is there", file=sys.stderr)
        return 1
    with ZenohBus.open(arguments.bus) as bus:
        presence = RobotPresence(bus)
        presence.expect(arguments.robot)
        with Terminal() as terminal, Teleop(bus, arguments.robot, arguments.speed, arguments.turn) as teleop:
            _drive(teleop, terminal, presence)
    return 0


def _drive(teleop: "Teleop", terminal: "Terminal", presence: "RobotPresence") -> None:
    """Read keys, command the robot and show how it is, until q or the end of the terminal."""
    reader = KeyReader()
    shown_at = 0.0
    while True:
        data = terminal.read(READ_TIMEOUT)
        now = time.monotonic()
        teleop.view.is_there = teleop.robot in presence.robots
        if data is None or not all(teleop.press(key, now) for key in reader.receive(data)):
            return
        if not data and reader.has_lone_escape:
            teleop.view.note = "Esc has no function; q quits"
        teleop.step(now)
        if data or now - shown_at >= PERIOD:
            shown_at = now
            terminal.show(teleop.view.screen(terminal.size.columns, terminal.size.lines))


class Teleop:
    """Keys to commands of one robot. Time is an argument, s on a steady clock.

    view: what is shown of the robot.
    """

    def __init__(self, bus: "Bus", robot: str, linear_speed: float, angular_speed: float) -> None:
        """Drive `robot` with these speeds, m/s and rad/s."""
        from bus import keys

        self.robot = robot
        self._bus = bus
        self._keyboard = KeyboardControl(linear_speed, angular_speed)
        self._command = bus.publisher(keys.CMD_VEL.key(robot), keys.CMD_VEL.type_name)
        self.view = RobotView(robot)
        # An answer may take its time, the wheels may not; and no stop waits for the answer to something else.
        self._stops, self._requests = ThreadPoolExecutor(1, "teleop-stop"), ThreadPoolExecutor(1, "teleop")
        heard = {"odom": keys.ODOM, "battery": keys.BATTERY, "state": keys.STATE, "lease": keys.LEASE_STATE}
        self._subscriptions = [self._hear(name, topic) for name, topic in heard.items()]
        self._requests.submit(self._read_lease)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._publish(0.0, 0.0)
        for executor in (self._stops, self._requests):
            executor.shutdown()
        for subscription in self._subscriptions:
            subscription.close()
        self._command.close()

    def press(self, key: str, now: float) -> bool:
        """Take one key; False when it asks to quit."""
        action = self._keyboard.press(key, now)
        if action is Action.QUIT:
            return False
        if action is not None:
            (self._requests if action is Action.ENABLE else self._stops).submit(self._request, action)
        elif key in MOVES:
            self.view.note = self.view.obstacle()
        else:
            self.view.note = "this key has no function" if key == SPECIAL else f"the key {key!r} has no function"
        return True

    def step(self, now: float) -> None:
        """Command what is due."""
        due = self._keyboard.due(now)
        if due is not None:
            self._publish(*due)

    def _hear(self, name: str, topic: "Topic") -> "Subscription":
        from bus.messages import decode, decode_json

        def hear(sample: "Sample") -> None:
            is_lease = name == "lease"
            setattr(
                self.view,
                name,
                decode_json(sample.payload) if is_lease else decode(topic.type_name, sample.payload),
            )

        return self._bus.subscribe(topic.key(self.robot), hear)

    def _read_lease(self) -> None:
        """Ask once who holds the robot: it is published on change only."""
        from bus import keys
        from bus.errors import BusError

        with suppress(BusError):  # a gateway that does not answer is shown as such
            answer = self._bus.query(keys.LEASE_STATE.key(self.robot), {}, ANSWER_TIMEOUT)[0].value
            self.view.lease = self.view.lease or answer

    def _publish(self, linear: float, angular: float) -> None:
        from bus.messages import twist

        self._command.put(twist(linear, angular))

    def _request(self, action: Action) -> None:
        """Ask the robot for something, and note the outcome for people."""
        from bus import keys
        from bus.errors import BusError

        state = self.view.state
        is_on = not (state and state.motors)
        is_free = state is not None and not state.estop
        released = "there was no e-stop to release" if is_free else "e-stop released; press e to switch the motors on"
        topic, arguments, done = {
            Action.STOP: (keys.STOP, {}, "stopped"),
            Action.ENABLE: (keys.ENABLE, {"on": is_on}, f"motors switched {'on' if is_on else 'off'}"),
            Action.ESTOP: (keys.ESTOP, {"on": True}, "e-stop latched; press c to release it, then e for the motors"),
            Action.CLEAR: (keys.ESTOP, {"on": False}, released),
        }[action]
        try:
            self._bus.query(topic.key(self.robot), arguments, ANSWER_TIMEOUT)
            self.view.note = done
        except BusError as err:
            self.view.note = f"{action}: {in_keys(str(err))}"


COMMAND = Subcommand(EPILOG, _add_arguments, _run)
