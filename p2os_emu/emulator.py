"""Robots in a world, each with its own line. One step moves all of them. Opens no port and reads no clock."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf
from random import Random
from typing import Any

from geometry import Pose2D
from p2os import SIMULATOR_SERIAL, Command, RobotModel, encode_command
from p2os_emu.device import Cable
from p2os_emu.faulty_body import FaultyBody
from p2os_emu.fit import BARE, Fit
from p2os_emu.fitting import FittingContext, cabled, plug_in
from p2os_emu.links.line import EmulatedLine, LinkProfile
from p2os_emu.links.link import Link
from p2os_emu.microcontroller import Flash, Microcontroller
from p2os_emu.microcontroller.simulator import Simulator
from p2os_emu.surroundings import EmulatedSurroundings

STEP = 1 / 120  # s; the world moves in steps of this size and no other
FARTHEST = 1e5  # m from the origin for places that robots are put at; larger numbers are typing errors
_FAREWELL = encode_command(Command.CLOSE)


@dataclass(slots=True)
class EmulatedRobot:
    """One robot: controller, machine and line.

    fit: its accessories. cables: those of accessories with a port of their own, by part.
    start: where it was put down.
    is_frozen: the firmware hangs; the wheels keep the speed it commanded last, and bytes that come are lost.
    is_powered: whether controller and accessories have power.
    body: what the controller reaches, with its faults.
    sounds: its buzzer plays something.
    """

    name: str
    model: RobotModel
    microcontroller: Microcontroller
    body: FaultyBody
    line: EmulatedLine
    start: Pose2D
    fit: Fit = BARE
    cables: dict[str, Cable] = field(default_factory=dict)
    is_frozen: bool = False
    is_powered: bool = True
    was_attached: bool = False
    sounds: bool = False

    @property
    def silence(self) -> float:
        """Time in which nothing is sent unless something is received, s."""
        if not self.line.is_plain:
            return 0.0
        runs = self.is_powered and not self.is_frozen
        own = self.microcontroller.silence if runs else inf
        return min(own, *(cable.silence for cable in self.cables.values())) if self.cables else own

    def think(self, now: float) -> bytes:
        """Pass the received bytes to the firmware and advance it by a step; return the bytes that it sends."""
        controller = self.microcontroller
        line = self.line
        data = line.receive(now, controller.board.host_baud) if line.link.inbox or not line.is_plain else b""
        if self.is_frozen or not self.is_powered:
            return b""
        if data:
            controller.receive(data)
        return controller.step(STEP, self.body)

    def power_off(self) -> None:
        """Switch off controller and accessories; the wheels roll freely."""
        self.is_powered = False
        self.body.release()
        gripper, arm = self.body.gripper, self.body.arm
        if gripper is not None:
            gripper.drive(0.0, 0.0)
        if arm is not None:
            for joint in range(len(arm.positions)):
                arm.release(joint)
        for cable in self.cables.values():
            cable.is_powered = False

    def power_on(self) -> None:
        """Switch on again: everything starts as after the power switch."""
        self.is_powered = True
        self.microcontroller.power_cycle()
        self.microcontroller.power_cycle_aux()
        for cable in self.cables.values():
            cable.power_cycle()

    def close(self) -> None:
        """Close its ports."""
        self.line.link.close()
        for cable in self.cables.values():
            cable.line.link.close()


def _check_place(pose: Pose2D) -> None:
    if not max(abs(pose.x), abs(pose.y)) <= FARTHEST:
        raise ValueError(f"the place ({pose.x:g}, {pose.y:g}) m is too far away; choose one within {FARTHEST:g} m")


class Emulator:
    """Robots in a world.

    world: says where robots, people and doors truly are; nobody else may step it.
    robots: by name, in the order they came.
    before_step: called with emulated time, s, before every step: where faults come and go.
    """

    def __init__(
        self,
        world: EmulatedSurroundings,
        profile: LinkProfile,
        *,
        seed: int = 0,
        hangup_stops: bool = False,
        as_simulator: bool = False,
    ) -> None:
        """Take over a world.

        Args:
            world: Nobody else may step it.
            profile: What every line does to bytes.
            seed: Decides what chance would in firmware and lines; each robot draws by its own name.
            hangup_stops: Stop a robot whose client has closed the port, as a real robot never could.
            as_simulator: Robots execute the commands of MobileSim, and have the serial number by which clients
                recognise a simulator. Otherwise these are unknown commands, as on a real robot.
        """
        self.robots: dict[str, EmulatedRobot] = {}
        self.before_step: Callable[[float], None] = _nothing
        self.world = world
        self._profile = profile
        self._seed = seed
        self._hangup_stops = hangup_stops
        self._as_simulator = as_simulator

    @property
    def time(self) -> float:
        """Emulated time since the start, s."""
        return self.world.time

    @property
    def silence(self) -> float:
        """Time in which no robot sends anything unless something is received, s; inf for one that waits for clients."""
        if self._hangup_stops:
            return 0.0  # clients that leave are looked for at every step
        return min((robot.silence for robot in self.robots.values()), default=inf)

    def add(
        self,
        name: str,
        model: RobotModel,
        link: Link,
        *,
        pose: Pose2D | None = None,
        flash: Flash | None = None,
        fit: Fit = BARE,
        cables: Mapping[str, Link] | None = None,
        profile: LinkProfile | None = None,
    ) -> EmulatedRobot:
        """Add a robot to the world and connect its line to a link.

        Args:
            name: Not yet taken; at most 19 characters.
            model: What it is.
            link: Its port; closed with the robot.
            pose: In the world, m, m, rad; None leaves the choice to the world.
            flash: What its controller remembers; None for that of `flash`.
            fit: Its accessories.
            cables: A port for each of `fit.cables`; closed with the robot.
            profile: Of its lines, where it is not the emulator's.
        Raises:
            ValueError: The name does not fit, or there is no room.
        """
        if name in self.robots:
            raise ValueError(f"there is a robot {name!r} already; choose another name")
        if pose is not None:
            _check_place(pose)
        flash = flash or self.flash(model, name)
        controller = Microcontroller(model, name, flash=flash, seed=self._rng(name, "firmware"), fit=fit)
        body = FaultyBody(self.world.add_robot(name, model, pose, fit), Random(self._rng(name, "faults")))
        profile = profile or self._profile
        line = EmulatedLine(link, profile, self._rng(name, "line"))
        robot = EmulatedRobot(name, model, controller, body, line, self.world.truth(name).pose, fit)
        if self._as_simulator:
            controller.board.simulator = Simulator(
                model,
                body,
                pose=lambda: self.world.truth(name).pose,
                place=partial(self.place, name),
                restart=partial(self._put_back, robot),
            )
        self._fit_out(robot, cables or {}, profile)
        self.robots[name] = robot
        return robot

    def flash(self, model: RobotModel, name: str, changes: Mapping[str, Any] | None = None) -> Flash:
        """Return the FLASH of a robot; its serial number is derived from its name and the seed, or a simulator's.

        Args:
            model: What it is.
            name: What it is called.
            changes: Parameters that replace the factory's, as `Flash.to_table` names them.
        Raises:
            ValueError: A parameter is unknown, or has a value that it cannot have.
        """
        flash = Flash.of(model, name, self._seed).changed(changes or {})
        return replace(flash, serial=SIMULATOR_SERIAL) if self._as_simulator else flash

    def _fit_out(self, robot: EmulatedRobot, cables: Mapping[str, Link], profile: LinkProfile) -> None:
        for part in robot.fit.parts:
            rng = Random(self._rng(robot.name, part))
            bench = FittingContext(robot.model, robot.fit, robot.microcontroller, robot.body, rng)
            if part in robot.fit.cables:
                line = EmulatedLine(cables[part], profile.of_accessories, self._rng(robot.name, f"{part} line"))
                robot.cables[part] = Cable(partial(cabled, part, bench), line)
            else:
                plug_in(part, bench)

    def remove(self, name: str) -> None:
        """Take a robot out of the world and close its ports."""
        robot = self.robots.pop(name)
        robot.close()
        self.world.remove_robot(name)

    def place(self, name: str, pose: Pose2D) -> None:
        """Move a robot to another pose; its odometry does not change.

        Raises:
            ValueError: The place is not free, or farther away than `FARTHEST`.
        """
        _check_place(pose)
        self.world.place(name, pose)

    def restart(self, names: Iterable[str]) -> None:
        """Move robots back to their first poses and reset them: odometry zero, connection closed.

        Raises:
            ValueError: Something stands at a first pose; no robot is reset then.
        """
        robots = [self.robots[name] for name in names]
        self.world.place_all({robot.name: robot.start for robot in robots})
        for robot in robots:
            robot.microcontroller.power_cycle()

    def step(self) -> None:
        """Advance everything by `STEP`: lines, firmware, world, lines."""
        self.before_step(self.world.time)
        if self._hangup_stops:
            self._stop_deserted()
        robots = tuple(self.robots.values())
        now = self.world.time
        replies = [robot.think(now) for robot in robots]
        for robot in robots:
            if (sounds := robot.microcontroller.sounds) and not robot.sounds:
                self.world.sound(robot.name)
            robot.sounds = sounds
        self.world.step()
        now = self.world.time
        for robot, reply in zip(robots, replies, strict=True):
            if reply or not robot.line.is_plain:
                robot.line.send(reply, now, robot.microcontroller.board.host_baud)
        # After the robots, whose packets come by the clock: twenty scans take longer than all the rest.
        for robot in robots:
            for cable in robot.cables.values():
                report = cable.think(now, STEP)
                cable.line.send(report, now, cable.device.baud)

    def close(self) -> None:
        """Close every port; the caller closes the world."""
        for robot in self.robots.values():
            robot.close()

    def _put_back(self, robot: EmulatedRobot) -> None:
        """Move a robot back to its first pose, and set its odometry to zero."""
        with suppress(ValueError):  # something stands there now: only the odometry restarts
            self.place(robot.name, robot.start)
        robot.microcontroller.forget_travels()

    def _stop_deserted(self) -> None:
        for robot in self.robots.values():
            attached = robot.line.link.attached
            if robot.was_attached and not attached:
                robot.microcontroller.receive(_FAREWELL)
            robot.was_attached = attached

    def _rng(self, name: str, part: str) -> int:
        """A seed that stays the same whatever other robots there are."""
        return Random(f"{self._seed} {name} {part}").getrandbits(32)


def _nothing(now: float) -> None:
    """Before a step, when there are no faults."""
