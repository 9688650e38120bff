"""Simulator commands of MobileSim, which no real robot knows; clients send them to simulated robots.

A robot has a `Simulator` only with `--as-simulator`; without it these are unknown commands, as on a real robot. The old
numbers (35 to 38) mean something else on a real robot, and are a laser's here. Source: fact sheet section 7.
"""

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from math import pi, radians
from typing import Any

from geometry import Pose2D
from p2os.arguments import PacketRequest
from p2os.command_table import Command
from p2os.commands import ReceivedCommand
from p2os.errors import DecodeError
from p2os.packets import Packet, PacketType
from p2os.robot_model import RobotModel
from p2os.simulator_packets import (
    READINGS_EXTENDED,
    READINGS_PLAIN,
    REFLECTANCE,
    ExtendedLaser,
    MapChanged,
    SimulatedLaser,
    SimulatedLaserMode,
    SimulatedLaserReading,
    SimulatorControlData,
    SimulatorOperation,
    SimulatorState,
    read_simulator_pose,
)
from p2os_emu.body import Body, ScanBeams

LASER_HEIGHT = 0.2  # m, assumed
LASER_REACH = 32.0  # m; what MobileSim's laser saw
LASER_NOISE = 0.005  # m
FINEST = radians(0.25)  # between two beams, assumed
COMMANDS = frozenset(
    {
        Command.SIM_SET_POSE,
        Command.SIM_RESET,
        Command.SIM_LRF_ENABLE,
        Command.SIM_LRF_SET_FOV_START,
        Command.SIM_LRF_SET_FOV_END,
        Command.SIM_LRF_SET_RES,
        Command.SIM_STAT,
        Command.SIM_MESSAGE,
    }
)
"""What has an effect; the others are refused with a message."""
PACKETS = frozenset({PacketType.LASER, PacketType.LASER_EXTENDED, PacketType.SIMULATOR_STATE, PacketType.MAP_CHANGED})
MESSAGES_KEPT = 50
OLD_NUMBERS: Mapping[int, Command] = {
    Command.ADSEL: Command.SIM_LRF_ENABLE,
    Command.GRIPPERVAL: Command.SIM_LRF_SET_FOV_START,
    Command.GRIPREQUEST: Command.SIM_LRF_SET_FOV_END,
    Command.GYROCALCW: Command.SIM_LRF_SET_RES,
}
"""What a client of an old simulator sends, and what it means by it; angles in degrees, of 38 in hundredths."""


class Simulator:
    """One robot's simulator commands.

    messages: what clients wanted to be known, and what was refused them, the latest last.
    """

    def __init__(
        self,
        model: RobotModel,
        body: Body,
        *,
        pose: Callable[[], Pose2D],
        place: Callable[[Pose2D], None],
        restart: Callable[[], None],
    ) -> None:
        """Stand by.

        Args:
            model: What the robot is; its first laser says where the simulated one sits.
            body: Casts the beams.
            pose: Returns where the robot truly is, in the world.
            place: Moves it to a pose; raises ValueError, which says why, where that is refused.
            restart: Moves it back to its first pose, and sets its odometry to zero.
        """
        self.messages: deque[str] = deque(maxlen=MESSAGES_KEPT)
        self._true_pose = pose
        self._move_to = place
        self._body = body
        mount = next(iter(model.lasers), None)
        self._x, self._y = (mount.x, mount.y) if mount else (0.0, 0.0)
        self._answers: list[Packet] = []
        self._handlers: Mapping[int, Callable[[Any], None]] = {
            Command.SIM_SET_POSE: self._place,
            Command.SIM_RESET: lambda _: restart(),
            Command.SIM_LRF_ENABLE: self._switch_laser,
            Command.SIM_LRF_SET_FOV_START: self._set_first,
            Command.SIM_LRF_SET_FOV_END: self._set_last,
            Command.SIM_LRF_SET_RES: self._set_step,
            Command.SIM_STAT: self._ask_for_state,
            Command.SIM_CTRL: self._control,
            Command.SIM_MESSAGE: lambda text: self.messages.append(text.decode("latin-1")),
            Command.SIM_EXIT: lambda _: self.messages.append("SIM_EXIT was refused: end the emulator itself"),
            Command.SIM_MODEL_CONFIG: lambda _: self.messages.append("SIM_MODEL_CONFIG was refused: models are files"),
        }
        self.restore()

    def restore(self) -> None:
        """Handle the end of the connection: stop sending, restore the view."""
        self._laser = SimulatedLaserMode.OFF
        self._first, self._last, self._step = -pi / 2, pi / 2, radians(1.0)
        self._states = 0
        self._answers.clear()

    def obeys(self, received: ReceivedCommand) -> bool:
        """Carry out a command as a client sent it, if it is a simulator's."""
        number, value = received.number, received.value
        if number in OLD_NUMBERS:
            number, value = OLD_NUMBERS[number], _in_new_units(number, value)
        handler = self._handlers.get(number)
        if handler is None:
            return False
        handler(value)
        return True

    def packets(self, pose: Pose2D, cycle: float) -> Iterator[Packet]:
        """Yield the packets after the standard SIP of this cycle.

        Args:
            pose: By odometry.
            cycle: s.
        """
        yield from self._answers
        self._answers.clear()
        if self._states:
            self._states = self._states if self._states == PacketRequest.CONTINUOUS else 0
            yield self._state(cycle)
        if self._laser:
            yield from self._sweep(pose)

    def _switch_laser(self, mode: int) -> None:
        self._laser = SimulatedLaserMode(mode) if mode in set(SimulatedLaserMode) else SimulatedLaserMode.OFF

    def _set_first(self, bearing: float) -> None:
        self._first = max(-pi, min(pi, bearing))

    def _set_last(self, bearing: float) -> None:
        self._last = max(-pi, min(pi, bearing))

    def _set_step(self, step: float) -> None:
        self._step = max(FINEST, step)

    def _ask_for_state(self, count: int) -> None:
        self._states = min(max(0, count), PacketRequest.CONTINUOUS)

    def _place(self, data: bytes) -> None:
        try:
            pose = Pose2D(*read_simulator_pose(data))
        except DecodeError as error:
            self.messages.append(f"SIM_SET_POSE of {len(data)} bytes was refused: {error}")
            return
        try:
            self._move_to(pose)
        except ValueError as error:
            self.messages.append(f"SIM_SET_POSE was refused: {error}")

    def _control(self, data: bytes) -> None:
        operation, name = SimulatorControlData.read(data)
        if operation in set(SimulatorOperation):
            # Other robots would have to live with the map.
            self.messages.append(f"map {name!r} was not loaded: start the emulator with --world")
            self._answers.append(MapChanged(by_user=False, loaded=False, name=name))
        else:
            self.messages.append(f"SIM_CTRL {operation}: {name}")

    def _state(self, cycle: float) -> SimulatorState:
        pose = self._true_pose()
        return SimulatorState(
            interval=cycle, real_interval=cycle, last_interval=cycle, x=pose.x, y=pose.y, heading=pose.heading
        )

    def _sweep(self, pose: Pose2D) -> Iterator[Packet]:
        """One sweep, in as many packets as it takes."""
        span = self._last - self._first
        count = int(abs(span) / self._step + 1e-6) + 1
        step = self._step if span >= 0.0 else -self._step
        beams = ScanBeams(self._x, self._y, LASER_HEIGHT, self._first, step, count, LASER_REACH, LASER_NOISE)
        echoes = self._body.scan(beams)
        ranges = [min(LASER_REACH, float(distance)) for distance in echoes.ranges]
        if self._laser == SimulatedLaserMode.PLAIN:
            x, y, heading = SimulatedLaser.within_limits(pose.x, pose.y, pose.heading)
            for first in range(0, count, READINGS_PLAIN):
                yield SimulatedLaser(x, y, heading, count, first, tuple(ranges[first : first + READINGS_PLAIN]))
            return
        readings = [
            SimulatedLaserReading(distance, REFLECTANCE if reflects else 0)
            for distance, reflects in zip(ranges, echoes.reflects, strict=True)
        ]
        for first in range(0, count, READINGS_EXTENDED):
            yield ExtendedLaser(count, first, tuple(readings[first : first + READINGS_EXTENDED]))


def _in_new_units(number: int, value: Any) -> Any:
    """The value of an old command as its new one has it."""
    if number == Command.ADSEL:
        return value
    return radians(value / 100 if number == Command.GYROCALCW else value)
