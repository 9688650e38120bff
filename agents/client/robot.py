"""The client of one robot: its name and its elements."""

import math
import time
from collections.abc import Iterable
from contextlib import suppress
from typing import Any, TypeVar, cast

from agents.client.discovery import Discovery
from agents.client.element import ElementClient
from agents.client.errors import RobotError
from agents.client.loop_thread import LoopThread
from agents.client.movers import ArmClient, BaseClient, GripperClient, PtzClient
from agents.client.readings import Reading
from agents.client.sensors import (
    BatteryClient,
    BumpersClient,
    CameraClient,
    CompassClient,
    InfraredClient,
    Io,
    JoystickClient,
    LaserClient,
    SonarClient,
    SoundClient,
)
from agents.platform import AgentName, NameNotValid
from bus import BusError, keys
from bus.overlay import overlay
from geometry import Point

ELEMENTS: dict[str, type[ElementClient[Reading]]] = {
    name: cast(type[ElementClient[Reading]], kind)
    for name, kind in {
        "base": BaseClient,
        "sonar": SonarClient,
        "laser": LaserClient,
        "bumpers": BumpersClient,
        "ir": InfraredClient,
        "battery": BatteryClient,
        "io": Io,
        "gripper": GripperClient,
        "arm": ArmClient,
        "ptz": PtzClient,
        "camera": CameraClient,
        "sound": SoundClient,
        "joystick": JoystickClient,
        "compass": CompassClient,
    }.items()
}

_SHOWN_EVERY = 0.5  # s
E = TypeVar("E", bound=ElementClient[Any])


class Robot:
    """One robot. An element that it does not have raises `NotThere`, whose message lists its elements.

    name: on the bus.
    """

    def __init__(self, thread: LoopThread, discovery: Discovery, name: str) -> None:
        self.name = name
        self._thread = thread
        self._discovery = discovery
        self._elements: dict[str, ElementClient[Reading]] = {}
        self._shown: dict[str, float] = {}  # when, by application

    @property
    def elements(self) -> list[str]:
        """The names of its present elements."""
        return self._thread.call(self._discovery.elements(self.name))

    def has(self, element: str) -> bool:
        """Return whether it has an element now."""
        return element in self.elements

    def element(self, name: str) -> ElementClient[Reading]:
        """Return an element by its name, also one without a class of its own: `robot.element("gyro").read()`.

        Raises:
            NotThere: It has none; the message lists its elements.
        """
        if name not in self._elements:
            try:
                agent = AgentName(name, self.name)
            except NameNotValid as err:
                raise RobotError(str(err)) from err
            self._thread.call(self._discovery.element(agent))
            self._elements[name] = ELEMENTS.get(name, ElementClient)(self._thread, agent)
        return self._elements[name]

    def show(
        self,
        application: str,
        words: str = "",
        *,
        points: Iterable[Point] = (),
        lines: Iterable[tuple[Point, Point]] = (),
        frame: str = "base_link",
    ) -> None:
        """Show what an application does with the robot, on maps such as that of the console.

        It is published on `<robot>/overlay/<application>`, twice a second at most; what comes sooner is left out. A bus
        that does not let the program publish there shows nothing.

        Args:
            application: Its name.
            words: What it does, in a few words.
            points: x and y, m.
            lines: Ends of each, m.
            frame: Of the points and lines, `base_link` or `odom`.
        """
        now = time.monotonic()
        if now - self._shown.get(application, -math.inf) < _SHOWN_EVERY:
            return
        self._shown[application] = now
        with suppress(BusError):  # a picture is missing, and nothing else
            payload = overlay(words, points=points, lines=lines, frame=frame)
            self._thread.agent.bus.put(keys.OVERLAY.key(self.name, application), payload)

    def stop(self) -> None:
        """Stop the robot."""
        self.base.stop()

    @property
    def base(self) -> BaseClient:
        """Wheels and odometry."""
        return self._element("base", BaseClient)

    @property
    def sonar(self) -> SonarClient:
        """The ring of sonar discs."""
        return self._element("sonar", SonarClient)

    @property
    def laser(self) -> LaserClient:
        """The laser scanner."""
        return self._element("laser", LaserClient)

    @property
    def bumpers(self) -> BumpersClient:
        """The bumpers."""
        return self._element("bumpers", BumpersClient)

    @property
    def ir(self) -> InfraredClient:
        """Infrared range sensors."""
        return self._element("ir", InfraredClient)

    @property
    def battery(self) -> BatteryClient:
        """The battery."""
        return self._element("battery", BatteryClient)

    @property
    def io(self) -> Io:
        """The user's inputs and outputs."""
        return self._element("io", Io)

    @property
    def gripper(self) -> GripperClient:
        """The gripper: two paddles on a lift."""
        return self._element("gripper", GripperClient)

    @property
    def arm(self) -> ArmClient:
        """The arm."""
        return self._element("arm", ArmClient)

    @property
    def ptz(self) -> PtzClient:
        """The pan-tilt-zoom head."""
        return self._element("ptz", PtzClient)

    @property
    def camera(self) -> CameraClient:
        """The camera."""
        return self._element("camera", CameraClient)

    @property
    def sound(self) -> SoundClient:
        """The buzzer or loudspeaker."""
        return self._element("sound", SoundClient)

    @property
    def joystick(self) -> JoystickClient:
        """The joystick on the robot."""
        return self._element("joystick", JoystickClient)

    @property
    def compass(self) -> CompassClient:
        """The compass."""
        return self._element("compass", CompassClient)

    def __repr__(self) -> str:
        return f"<Robot {self.name}>"

    def _element(self, name: str, kind: type[E]) -> E:
        element = self.element(name)
        assert isinstance(element, kind)
        return element
