"""One robot in a world with its navigation, all under one virtual clock: what a mission is played on."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeVar

from acromovi.lockstep import SETTINGS, Lockstep
from acromovi.missions.navigated_robot import NavigatedRobot, Played, run_together
from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.component import Component
from bus.bus import Closeable
from gateway.settings import DriveLimits
from geometry import Point, Pose2D
from p2os_emu.emulator import STEP
from p2os_emu.world import WorldSpec

T = TypeVar("T")

# Brisker than what the robots leave the factory with, and well below what their controllers allow.
BRISK = DriveLimits(acceleration_m_s2=0.8, deceleration_m_s2=0.8)

ROBOT = "happy"
CONNECTING = 2.0  # s of virtual time in which a robot is connected and its sensors have been heard
LOOK = 12  # steps between two looks at how the mission stands: 10 Hz
SETTLE = 0.5  # s after the end, in which the robot comes to rest


class Course(Closeable):
    """A robot, its world and its navigation. Same arguments and same calls, same missions."""

    def __init__(
        self,
        world: WorldSpec,
        model: str,
        *,
        fit: str = "laser",
        start: Pose2D | None = None,
        seed: int = 0,
        perfect: bool = False,
        instead: Mapping[str, type[Component]] | None = None,
    ) -> None:
        """Put the robot on its place, connect it, and start all components.

        Args:
            world: Where.
            model: Of the robot.
            fit: Its accessories.
            start: Where the robot begins; by default at the first start of the world where it can turn.
            seed: Of every chance.
            perfect: No error of odometry, no noise of sensors.
            instead: Classes that take the place of components, by their names.
        Raises:
            WorldError, ConfigError, FitError: As `Lockstep`.
        """
        self.world = world
        self.lockstep = Lockstep(
            world,
            {ROBOT: model},
            fits={ROBOT: fit},
            poses={ROBOT: start} if start is not None else None,
            seed=seed,
            perfect=perfect,
            settings=replace(SETTINGS, limits=BRISK),
        )
        self.loop = VirtualTimeLoop()
        self.robot = NavigatedRobot(ROBOT, self.lockstep, self.loop, instead)
        self.run(1.0)
        self.robot.start_components()
        self.run(CONNECTING)

    @property
    def time(self) -> float:
        """Virtual time, s."""
        return self.lockstep.time

    @property
    def pose(self) -> Pose2D:
        """Where the robot truly is."""
        return self.robot.pose

    def run(self, seconds: float) -> None:
        """Let time pass."""
        run_together(self.lockstep, self.loop, [self.robot], seconds)

    def go(self, goal: Point, *, limit: float = 300.0, mission: str = "mission") -> Played:
        """Send the robot to a place of the world, and let time pass until it says that the mission has ended.

        Args:
            goal: m.
            limit: s after which it is late.
            mission: Its name.
        """
        self.tell(goal, mission=mission)
        return self.wait(limit, mission)

    def wait(self, limit: float = 300.0, mission: str = "mission") -> Played:
        """Let time pass until a mission that has been told has ended; what happened since it was told."""
        state = None
        while state is None and self.robot.seconds < limit:
            self.run(LOOK * STEP)
            state = self.robot.ended(mission)
        seconds = self.robot.seconds
        self.run(SETTLE)
        return self.robot.played(state or "late", seconds)

    def tell(self, goal: Point | None, *, mission: str = "mission") -> None:
        """Send the robot somewhere, or nowhere: that cancels the mission. What is noted begins anew."""
        self.robot.tell(goal, mission=mission)

    def ask(self, answerer: str, what: str) -> Mapping[str, Any]:
        """Ask a component; nothing where it does not answer."""
        return self.robot.ask(answerer, what)

    def close(self) -> None:
        """End everything."""
        self.robot.close()
        self.lockstep.close()
        self.loop.close()
