"""Robots, drivers and bus in one process under one virtual clock, as fast as the machine can.

The code is that of `p2os-emu` and `p2os-gateway`; only ports, threads and clocks are missing. So what is proved here
holds for the programs, and hundreds of missions can be scored in the time of one.
"""

import itertools
import random
from collections.abc import Callable, Mapping
from dataclasses import replace
from math import floor
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

import configs
from bus import Bus, MemoryBus, MemoryNetwork
from bus.bus import Closeable
from bus.messages import NS_PER_S
from gateway.bridge import LONGEST_WAIT
from gateway.cables.cable import ElementDriver, IsWanted, PublishEvents
from gateway.cables.cable_thread import SerialCable
from gateway.cables.camera_thread import CameraState
from gateway.driver import Driver
from gateway.elements.all_elements import cable_kinds
from gateway.events import PictureTaken
from gateway.robot_on_bus import RobotOnBus
from gateway.settings import CameraSettings, LaserSettings, Settings
from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.camera.cameras import PART as CAMERA
from p2os_emu.camera.cameras_in_step import CamerasInStep
from p2os_emu.emulator import STEP, Emulator
from p2os_emu.fault_spec import parse_fault
from p2os_emu.faults.board import FaultBoard
from p2os_emu.fit import read_fit
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.target_model import target_of, target_on
from p2os_emu.world import World, WorldError, WorldSpec
from p2os_emu.world.view import View

T = TypeVar("T")

SETTINGS = Settings(emulated=True, laser=LaserSettings(baud=38400))
NO_RATE = (0,)  # a line in memory has no baud rate to look for
ROUNDING = 1e-6  # of a camera's period; an exposure that falls on a step is made in that step


class Lockstep(Closeable):
    """A team of robots in a world, each with its driver, on a bus in memory.

    Everything happens in `run`; the same arguments and the same calls call the same bytes and messages. The pictures of
    a robot with a camera are drawn at the camera's rate while somebody subscribes to them.

    world: says what is true of robots, people and doors; nobody else may step it.
    """

    def __init__(
        self,
        world: WorldSpec,
        robots: Mapping[str, str],
        *,
        fits: Mapping[str, str] | None = None,
        poses: Mapping[str, Pose2D] | None = None,
        seed: int = 0,
        perfect: bool = False,
        settings: Settings = SETTINGS,
    ) -> None:
        """Place the robots and open the bus; their drivers connect within the first second of `run`.

        Args:
            world: From `load_world`.
            robots: Name to model, as `{"happy": "p3dx-sh"}`.
            fits: Name to accessories, as `{"happy": "gyro,laser"}`.
            poses: Name to where the robot begins; the world chooses for the others.
            seed: Of every imperfection and every chance.
            perfect: No imperfections of body and sensors.
            settings: Of every robot's driver. A camera that is on no head has its own field of view unless one is set.
        Raises:
            ConfigError: There is no such model.
            FitError: There is no such accessory, or it does not go onto this robot.
            WorldError: There is no room for a robot, or something stands where it is to begin.
        """
        self._network = MemoryNetwork()
        self.world = World(world, seed=seed, perfect=perfect)
        self._emulator = Emulator(self.world, LinkProfile("ideal"), seed=seed)
        self._faults = FaultBoard(self._emulator.robots)
        self._emulator.before_step = self._faults.advance
        self._cameras = CamerasInStep(self._emulator, self.world)
        self._hosts: dict[str, _Host] = {}
        for name, model_name in robots.items():
            parts = (fits or {}).get(name, "")
            model, fit = read_fit(filter(None, parts.split(",")), configs.load(RobotModel, "robots", model_name))
            link, cables = MemoryLink(), {part: MemoryLink() for part in fit.cables}
            self._emulator.add(name, model, link, pose=(poses or {}).get(name), fit=fit, cables=cables)
            camera, own = None, settings
            if fit.has(CAMERA):
                camera = _Camera(self._cameras, name, lambda: self.time)
                if not fit.has("ptz") and settings.camera.field_of_view_rad is None:
                    own = replace(settings, camera=CameraSettings(self._cameras.model.field_of_view))
            self._hosts[name] = _Host(name, model, link, cables, camera, self.bus(), lambda: self.time, seed, own)

    @property
    def time(self) -> float:
        """Virtual time since the start, s: the clock of everything here."""
        return self._emulator.time

    def bus(self) -> Bus:
        """A participant on the bus of this team; for the application under test."""
        return MemoryBus(self._network)

    def run(self, seconds: float) -> None:
        """Let virtual time pass."""
        for _ in range(round(seconds / STEP)):
            for host in self._hosts.values():
                host.step()
            self._emulator.step()

    def run_until(self, condition: Callable[[], bool], limit: float) -> None:
        """Let virtual time pass until a condition holds.

        Raises:
            TimeoutError: It did not within `limit` seconds of virtual time.
        """
        deadline = self.time + limit
        while not condition():
            if self.time >= deadline:
                raise TimeoutError(f"the condition did not come true within {limit} s of virtual time")
            self.run(STEP)

    def fault(self, spec: str) -> int:
        """Schedule a fault in the notation of `p2os-emu --fault`; its start counts from now.

        Returns:
            The number by which `clear` ends it.
        Raises:
            FaultError: There is no such fault, or none of these robots can suffer it.
        """
        return self._faults.schedule(parse_fault(spec), self.time).number

    def clear(self, number: int) -> None:
        """End a fault, or cancel one that has not begun.

        Raises:
            FaultError: There is no fault of this number, or it is over.
        """
        self._faults.clear(number)

    def truth(self, name: str) -> Pose2D:
        """Return the true pose of a robot."""
        return self.world.truth(name).pose

    def image(self, name: str) -> NDArray[np.uint8]:
        """Return what the camera of a robot sees now, whether or not somebody subscribes to it.

        Returns:
            Rows of pixels with red, green, blue, shape (height, width, 3), before the JPEG's losses.
        Raises:
            WorldError: There is no such robot, or it has no camera.
        """
        return self._cameras.draw(name)

    def view(self, name: str) -> View:
        """Return where the camera of a robot truly is and looks now, with its head's pan, tilt and zoom.

        Raises:
            WorldError: There is no such robot, or it has no camera.
        """
        return self._cameras.view(name)

    def target(self, name: str) -> Pose2D:
        """Return the true pose of the target that a robot carries: middle between the flanks, and the robot's heading.

        Raises:
            WorldError: There is no such robot, or it has no target.
        """
        robot = self._emulator.robots.get(name)
        target = None if robot is None else target_of(robot.fit)
        if robot is None or target is None:
            raise WorldError(f"there is no target on {name!r}; fit it with `target`")
        return self.truth(name).compose(target_on(robot.model, target))

    def wire(self, name: str) -> bytes:
        """Every byte the robot has sent so far."""
        return bytes(self._hosts[name].heard)

    def close(self) -> None:
        """End the world and the bus."""
        for host in self._hosts.values():
            host.close()
        self._cameras.close()
        self.world.close()


class _Element:
    """The host's end of the cable of an accessory that has one of its own; implements `ElementCable`."""

    def __init__(self, kind: SerialCable, link: MemoryLink, clock: Callable[[], float], settings: Settings) -> None:
        self.name = kind.name
        self.driver = kind.make_driver(False, settings)
        self.bridge = self
        self._link = link
        self._clock = clock
        self._publish: PublishEvents = lambda events, stamp_ns: None
        self._wakes_at = 0.0
        self.driver.port_opened(clock())

    def step(self, stamp_ns: int) -> None:
        """Do what the thread of this cable does when bytes have come or something is due."""
        data, now = self._link.client_read(), self._clock()
        if not data and now < self._wakes_at:
            return
        events = self.driver.receive(data, now)
        self._flush()
        self._publish(events, stamp_ns)
        self._wakes_at = min(self.driver.deadline, now + LONGEST_WAIT)

    def join(self, publish: PublishEvents, is_wanted: IsWanted) -> None:
        """Publish the driver's events from now on."""
        self._publish = publish

    def halt(self) -> None:
        """Stop everything that moves."""
        self.command(lambda driver, now: driver.halt(now))

    def command(self, call: Callable[[ElementDriver, float], T], patience: float = 0.0) -> T:
        """The way to the driver for what comes from the bus; it is never blocked, whatever the patience."""
        try:
            return call(self.driver, self._clock())
        finally:
            self._flush()
            self._wakes_at = 0.0

    def _flush(self) -> None:
        self._link.client_write(self.driver.bytes_due(self._clock()))


class _Camera:
    """A camera in the place of the gateway's `CameraThread`; implements `ElementCable`.

    Exposures are at whole multiples of the camera's period, whoever subscribes and when. A picture arrives without
    delay.
    """

    name = CAMERA
    bridge = None

    def __init__(self, cameras: CamerasInStep, robot: str, clock: Callable[[], float]) -> None:
        self._cameras = cameras
        self._robot = robot
        self._clock = clock
        width, height, self._rate = cameras.image_format(robot)
        self.driver = CameraState(clock)
        self.driver.size = width, height
        self.driver.has_port = self.driver.is_resting = True
        self._publish: PublishEvents = lambda events, stamp_ns: None
        self._is_wanted: IsWanted = lambda: False

    def step(self, stamp_ns: int) -> None:
        """Draw and publish a picture if one is due and somebody subscribes."""
        now = self._clock()
        if floor(now * self._rate + ROUNDING) == floor((now - STEP) * self._rate + ROUNDING):
            return
        if not self._is_wanted():
            self.driver.rest()
            return
        size = self.driver.size
        assert size is not None  # set at the start
        self.driver.take(size)
        self._publish([PictureTaken(self._cameras.jpeg(self._robot), *size)], stamp_ns)

    def join(self, publish: PublishEvents, is_wanted: IsWanted) -> None:
        """Publish pictures from now on, while somebody subscribes to them."""
        self._publish, self._is_wanted = publish, is_wanted

    def halt(self) -> None:
        """Do nothing: a camera does not move."""


class _Host:
    """The host's end of one cable: does the work of the gateway's bridge without threads."""

    def __init__(
        self,
        name: str,
        model: RobotModel,
        link: MemoryLink,
        cables: Mapping[str, MemoryLink],
        camera: _Camera | None,
        bus: Bus,
        clock: Callable[[], float],
        seed: int,
        settings: Settings,
    ) -> None:
        self._name = name
        self._settings = settings
        self._elements: list[_Element | _Camera] = [
            _Element(kind, cables[kind.name], clock, settings)
            for kind in cable_kinds()
            if isinstance(kind, SerialCable) and kind.name in cables
        ]
        if camera is not None:
            self._elements.append(camera)
        self.heard = bytearray()
        self._link = link
        self._bus = bus
        self._clock = clock
        self._tokens = itertools.count(1)
        rng = random.Random(f"{seed} {name} driver")
        self._driver = Driver(lambda identity: model, NO_RATE, settings, rng)
        self._robot: RobotOnBus | None = None
        self._wakes_at = 0.0
        self._driver.port_opened(clock())
        self._flush()

    def step(self) -> None:
        """Do what the gateway's threads do when bytes have come, something is due or a command was given."""
        data, now = self._link.client_read(), self._clock()
        if data or now >= self._wakes_at:
            self._work(data, now)
        if self._robot is not None:
            for element in self._elements:
                element.step(self._stamp_ns())

    def _work(self, data: bytes, now: float) -> None:
        self.heard += data
        events = self._driver.receive(data, now)
        self._flush()
        if self._robot is None:
            if self._driver.model is None:
                return
            self._robot = RobotOnBus(
                self._name,
                self._bus,
                self._driver,
                self,
                self._settings,
                cables=self._elements,
                new_token=lambda: f"{self._name}-{next(self._tokens)}",
                wall_clock=self._stamp_ns,
            )
        self._robot.on_events(events, now, self._stamp_ns())
        self._wakes_at = min(self._driver.deadline, self._robot.deadline, now + LONGEST_WAIT)

    def command(self, call: Callable[[Driver, float], T]) -> T:
        """The way to the driver for what comes from the bus."""
        try:
            return call(self._driver, self._clock())
        finally:
            self._flush()
            self._wakes_at = 0.0

    def post(self, call: Callable[[Driver, float], object]) -> None:
        """Likewise, for who does not wait; the line never hangs."""
        self.command(call)

    def close(self) -> None:
        """Leave the bus."""
        if self._robot is not None:
            self._robot.close()
        self._bus.close()

    def _flush(self) -> None:
        self._link.client_write(self._driver.bytes_due(self._clock()))

    def _stamp_ns(self) -> int:
        return round(self._clock() * NS_PER_S)
